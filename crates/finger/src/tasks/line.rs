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
    if let Received::Overrun(_) | Received::Lost = received {
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
    /// Nothing good, and a byte is lost: it arrived while the one before it was being read, or that
    /// one is damaged.
    Lost,
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

    #[test]
    fn an_overrun_spoils_the_request_after_the_good_byte_and_is_counted() {
        use Received::{Byte, Overrun};
        let mut wire = [0; 32];
        let used = framing::encode(&7u16, &mut wire).expect("it fits");
        let request = &wire[..used];
        let shared = Shared::new(Pended::default(), ridgetone_proto::plan::Plan::PAPER);
        let mut inbox = RequestInbox::new();
        let damaged: fn(u8) -> Received = |_| Received::Damaged;
        let lost: fn(u8) -> Received = |_| Received::Lost;
        // Bytes, how the last one arrives, and then: a whole request, fits pended, bytes overrun.
        for (bytes, last, expected) in [
            (request, Byte as fn(u8) -> Received, (true, 1, 0)),
            // The first byte of the next one is lost, and the one after it is whole.
            (request, Overrun, (true, 2, 1)),
            (&request[1..], Byte, (false, 2, 1)),
            (request, Byte, (true, 3, 1)),
            // A byte in the middle is lost.
            (&request[..2], Overrun, (false, 3, 2)),
            (&request[3..], Byte, (false, 3, 2)),
            (&request[..2], damaged, (false, 3, 2)),
            (&request[2..], Byte, (false, 3, 2)),
            (request, Byte, (true, 4, 2)),
            (&request[..2], lost, (false, 4, 3)),
            (&request[2..], Byte, (false, 4, 3)),
            (request, Byte, (true, 5, 3)),
        ] {
            let (last_byte, others) = bytes.split_last().expect("bytes");
            others
                .iter()
                .for_each(|byte| receive(&mut inbox, Byte(*byte), &shared));
            receive(&mut inbox, last(*last_byte), &shared);
            let is_whole = inbox.take().is_some();
            let overrun = shared.diagnostics.bytes_overrun.get();
            assert_eq!((is_whole, shared.platform.0.get(), overrun), expected);
        }
    }
}
