//! `line`: one byte of telemetry out, one byte of a request in.

use super::shared::{LOW_WATER, Platform, Shared, Task};
use core::sync::atomic::Ordering::Relaxed;
use heapless::spsc::Consumer;
use ridgetone_proto::command::REQUEST_WIRE_MAX;
use ridgetone_proto::framing::{Inbox, Pushed};

/// Requests that arrive for `fit`.
pub type RequestInbox = Inbox<REQUEST_WIRE_MAX>;

/// Takes a byte that has arrived. A whole request starts `fit`; a damaged one and a lost byte are
/// counted.
pub fn receive<P: Platform>(inbox: &mut RequestInbox, received: Received, shared: &Shared<P>) {
    if let Received::Byte(byte) | Received::Overrun(byte) = received {
        match inbox.push(byte) {
            Pushed::More => {}
            Pushed::Whole => P::pend(shared, Task::Fit),
            Pushed::Damaged => shared.diagnostics.requests_damaged.add(1),
        }
    }
    if let Received::Overrun(_) = received {
        shared.diagnostics.bytes_overrun.add(1);
    }
    if !matches!(received, Received::Byte(_)) {
        inbox.spoil();
    }
}

/// What the receiver holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Received {
    /// A byte.
    Byte(u8),
    /// A byte, and the one after it is lost: it arrived before this one was read.
    Overrun(u8),
    /// A byte that noise on the line has damaged.
    Damaged,
}

/// The line's hardware, with an interrupt for each byte.
pub trait SerialPort {
    /// What has arrived, if something has.
    fn receive(&mut self) -> Option<Received>;

    /// Whether [`Self::send`] can take a byte. False while the interrupt of the byte before it is
    /// still to come.
    fn is_ready(&self) -> bool;

    /// Sends a byte. Its interrupt comes when the next byte can be taken.
    fn send(&mut self, byte: u8);

    /// There is nothing to send: no more interrupts of the transmitter until the next byte.
    fn stop_transmitting(&mut self);
}

/// What the task owns.
pub struct SerialLine<'a, PORT> {
    /// The hardware.
    pub port: PORT,
    /// From `report`.
    pub bytes: Consumer<'a, u8>,
}

impl<PORT: SerialPort> SerialLine<'_, PORT> {
    /// Runs when a byte has arrived, when the next can be sent, and when `report` has queued some.
    pub fn run<P: Platform>(&mut self, inbox: &mut RequestInbox, shared: &Shared<P>) {
        let Self { port, bytes } = self;
        if let Some(received) = port.receive() {
            receive(inbox, received, shared);
        }
        if !port.is_ready() {
            return;
        }
        match bytes.dequeue() {
            Some(byte) => port.send(byte),
            None => {
                port.stop_transmitting();
                shared.sending.store(false, Relaxed);
            }
        }
        if bytes.len() == LOW_WATER {
            P::pend(shared, Task::Report);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::cell::Cell;
    use ridgetone_proto::framing;

    /// Counts how often the fit was pended.
    #[derive(Default)]
    struct Pended(Cell<u32>);

    impl Platform for Pended {
        fn pend(shared: &Shared<Self>, task: Task) {
            assert_eq!(task, Task::Fit);
            shared.platform.0.set(shared.platform.0.get() + 1);
        }

        fn now_us(&self) -> u32 {
            0
        }
    }

    /// The receiver's data register holds the byte before the one that is lost.
    #[test]
    fn an_overrun_spoils_the_request_after_the_good_byte_and_is_counted() {
        let mut wire = [0; 32];
        let used = framing::encode(&7u16, &mut wire).expect("it fits");
        let (request, shared) = (
            &wire[..used],
            Shared::new(Pended::default(), ridgetone_proto::plan::Plan::PAPER),
        );
        let mut inbox = RequestInbox::new();
        let mut send = |bytes: &[u8], last: fn(u8) -> Received| {
            let (last_byte, others) = bytes.split_last().expect("bytes");
            others
                .iter()
                .for_each(|byte| receive(&mut inbox, Received::Byte(*byte), &shared));
            receive(&mut inbox, last(*last_byte), &shared);
            let whole = inbox.take().is_some();
            (
                whole,
                shared.platform.0.get(),
                shared.diagnostics.bytes_overrun.get(),
            )
        };
        assert_eq!(send(request, Received::Byte), (true, 1, 0));
        assert_eq!(
            send(request, Received::Overrun),
            (true, 2, 1),
            "the first byte of the next one is lost"
        );
        assert_eq!(send(&request[1..], Received::Byte), (false, 2, 1));
        assert_eq!(
            send(request, Received::Byte),
            (true, 3, 1),
            "the one after it is whole"
        );
        assert_eq!(
            send(&request[..2], Received::Overrun),
            (false, 3, 2),
            "a byte in the middle is lost"
        );
        assert_eq!(send(&request[3..], Received::Byte), (false, 3, 2));
        assert_eq!(send(&request[..2], |_| Received::Damaged), (false, 3, 2));
        assert_eq!(send(&request[2..], Received::Byte), (false, 3, 2));
        assert_eq!(send(request, Received::Byte), (true, 4, 2));
    }
}
