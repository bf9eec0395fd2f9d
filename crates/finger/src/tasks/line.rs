//! `line`: sends telemetry byte by byte, and receives requests.

use super::shared::{LOW_WATER, Platform, Shared, Task};
use core::sync::atomic::Ordering::Relaxed;
use heapless::spsc::Consumer;
use ridgetone_proto::command::REQUEST_WIRE_MAX;
use ridgetone_proto::framing::{Inbox, Pushed};
use rtic_core::Mutex;

/// Inbox for requests to `fit`.
pub type RequestInbox = Inbox<REQUEST_WIRE_MAX>;

/// Takes one received item. A complete request starts `fit`; damaged ones and lost bytes are
/// counted.
pub fn receive<P: Platform>(inbox: &mut RequestInbox, received: Received, shared: &Shared<P>) {
    let byte = match received {
        Received::Byte(byte) => byte,
        Received::Lost(bytes) => {
            shared.diagnostics.bytes_overrun.add(bytes);
            return inbox.spoil();
        }
    };
    match inbox.push(byte) {
        Pushed::More => {}
        Pushed::Whole => P::pend(shared, Task::Fit),
        Pushed::Damaged => shared.diagnostics.requests_damaged.add(1),
    }
}

/// Takes received bytes up to the end of a request; later bytes stay in the receiver until `fit`
/// has taken the request. Runs in the task `report`, which neither a fit nor a write to the flash
/// delays. Serves the receiver even if nothing is taken, or its interrupt would come again at once.
pub fn receive_all<P: Platform>(
    receiver: &mut impl Receiver,
    inbox: &mut impl Mutex<T = RequestInbox>,
    shared: &Shared<P>,
) {
    receiver.look();
    while inbox.lock(|inbox| inbox.whole().is_none())
        && let Some(received) = receiver.receive()
    {
        inbox.lock(|inbox| receive(inbox, received, shared));
    }
}

/// Next received item, in order of arrival.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Received {
    /// A byte. Noise on the line may have damaged it, which the request's checksum shows.
    Byte(u8),
    /// At least this many bytes were lost, because earlier ones had not been read.
    Lost(u32),
}

/// The line's receiving hardware. It starts the task `report` when half its buffer is full.
pub trait Receiver {
    /// Counts what has arrived, and acknowledges the interrupt.
    fn look(&mut self);

    /// Next byte or loss, if any.
    fn receive(&mut self) -> Option<Received>;
}

/// The line's sending hardware, with an interrupt for each byte sent, and one when reception
/// pauses.
pub trait SerialPort {
    /// True if reception has paused since the last call: bytes arrived, and the line is now idle.
    fn has_paused(&mut self) -> bool;

    /// True if [`Self::send`] can take a byte. False while the interrupt of the previous byte is
    /// outstanding.
    fn is_ready(&self) -> bool;

    /// Sends a byte. Its interrupt comes when the next byte can be taken.
    fn send(&mut self, byte: u8);

    /// Disables the transmitter's interrupts until the next byte, because there is nothing to send.
    fn stop_transmitting(&mut self);
}

/// State that only this task uses.
pub struct SerialLine<'a, PORT> {
    /// The hardware.
    pub port: PORT,
    /// Bytes from `report`.
    pub bytes: Consumer<'a, u8>,
}

impl<PORT: SerialPort> SerialLine<'_, PORT> {
    /// Runs when reception pauses, when the next byte can be sent, and when `report` has queued
    /// bytes.
    pub fn run<P: Platform>(&mut self, shared: &Shared<P>) {
        let Self { port, bytes } = self;
        if port.has_paused() {
            P::pend(shared, Task::Report);
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
    use rtic_core::Exclusive;
    use std::vec::Vec;
    extern crate std;

    /// Counts how often `fit` is pended.
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

    /// Returns the given items in order.
    struct Held(std::vec::IntoIter<Received>);

    impl Receiver for Held {
        fn look(&mut self) {}

        fn receive(&mut self) -> Option<Received> {
            self.0.next()
        }
    }

    #[test]
    fn a_request_waits_in_the_receiver_until_the_one_before_is_taken() {
        let mut wire = [0; 32];
        let used = framing::encode(&7u16, &mut wire).expect("it fits");
        let request = wire[..used].iter().map(|byte| Received::Byte(*byte));
        let requests: Vec<Received> = request.clone().chain(request).collect();
        let mut held = Held(requests.into_iter());
        let shared = Shared::new(Pended::default(), ridgetone_proto::plan::Plan::PAPER);
        let mut inbox = RequestInbox::new();
        for is_whole in [true, true, false] {
            receive_all(&mut held, &mut Exclusive(&mut inbox), &shared);
            assert_eq!(inbox.take().is_some(), is_whole);
        }
        assert_eq!(shared.diagnostics.requests_damaged.get(), 0);
    }

    #[test]
    fn lost_bytes_spoil_the_request_that_they_are_of_and_are_counted() {
        use Received::Lost;
        let mut wire = [0; 32];
        let used = framing::encode(&7u16, &mut wire).expect("it fits");
        let request = &wire[..used];
        let shared = Shared::new(Pended::default(), ridgetone_proto::plan::Plan::PAPER);
        let mut inbox = RequestInbox::new();
        // Bytes, and number of bytes lost after them; expected: complete request, `fit` pended,
        // bytes lost.
        for (bytes, lost, expected) in [
            (request, None, (true, 1, 0)),
            // The first byte of the next request is lost; the request after that is complete.
            (request, Some(1), (true, 2, 1)),
            (&request[1..], None, (false, 2, 1)),
            (request, None, (true, 3, 1)),
            // Bytes in the middle are lost.
            (&request[..2], Some(200), (false, 3, 201)),
            (&request[3..], None, (false, 3, 201)),
            (request, None, (true, 4, 201)),
        ] {
            let held = bytes.iter().map(|byte| Received::Byte(*byte));
            let held: Vec<Received> = held.chain(lost.map(Lost)).collect();
            let mut held = Held(held.into_iter());
            receive_all(&mut held, &mut Exclusive(&mut inbox), &shared);
            let is_whole = inbox.take().is_some();
            // Take the bytes that waited behind the request.
            receive_all(&mut held, &mut Exclusive(&mut inbox), &shared);
            let overrun = shared.diagnostics.bytes_overrun.get();
            assert_eq!((is_whole, shared.platform.0.get(), overrun), expected);
        }
    }
}
