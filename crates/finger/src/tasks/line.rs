//! `line`: one byte of telemetry out, one byte of a request or of a robot's odometry in.

use super::shared::{LOW_WATER, Platform, Shared, Task};
use core::sync::atomic::Ordering::Relaxed;
use heapless::spsc::Consumer;
use ridgetone_proto::command::REQUEST_WIRE_MAX;
use ridgetone_proto::framing::{Inbox, Pushed};
use ridgetone_proto::odometry::{self, Odometry};

/// Time of a byte on the line, nanoseconds: ten bits at 921,600 a second.
const BYTE_NS: u32 = 10_851;

/// Time of a robot's message on the line, microseconds.
pub const ODOMETRY_US: u32 = odometry::WIRE_BYTES as u32 * BYTE_NS / 1000;

/// What has arrived: a request may wait for a fit to end while messages of a robot come and go.
#[derive(Debug, Default)]
pub struct Inboxes {
    /// For `fit`.
    pub requests: Inbox<REQUEST_WIRE_MAX>,
    /// A robot's message, for `detect`. The next one may follow at once: `detect` has the time of a
    /// message to take this one.
    pub odometry: Option<[u8; odometry::FRAME_BYTES]>,
    arriving: Inbox<{ odometry::FRAME_BYTES }>,
}

impl Inboxes {
    /// Nothing has arrived.
    pub const fn new() -> Self {
        Self {
            requests: Inbox::new(),
            odometry: None,
            arriving: Inbox::new(),
        }
    }

    /// Takes a byte; gives the state of the frame, and whether it is a robot's.
    fn push(&mut self, byte: u8) -> (Pushed, bool) {
        let request = self.requests.push(byte);
        if self.arriving.push(byte) != Pushed::Whole {
            return (request, false);
        }
        let frame = self
            .arriving
            .whole()
            .filter(|frame| Odometry::claims(frame));
        let frame: Option<[u8; odometry::FRAME_BYTES]> =
            frame.and_then(|frame| frame.try_into().ok());
        self.arriving.drop_whole();
        if frame.is_none() {
            return (request, false);
        }
        if request == Pushed::Whole {
            self.requests.drop_whole();
        }
        if self.odometry.is_some() {
            return (Pushed::Damaged, true);
        }
        self.odometry = frame;
        (Pushed::Whole, true)
    }

    /// Takes a byte that has arrived at a board time, microseconds. A whole request starts `fit`, a
    /// robot's message `detect`; a damaged one and a lost byte are counted.
    pub fn receive<P: Platform>(&mut self, received: Received, now_us: u32, shared: &Shared<P>) {
        if let Received::Byte(byte) | Received::Overrun(byte) = received {
            match self.push(byte) {
                (Pushed::More, _) => {}
                (Pushed::Whole, false) => P::pend(shared, Task::Fit),
                (Pushed::Whole, true) => {
                    shared.odometry_us.store(now_us, Relaxed);
                    shared.has_odometry.store(true, Relaxed);
                    P::pend(shared, Task::Detect);
                }
                (Pushed::Damaged, _) => shared.diagnostics.requests_damaged.add(1),
            }
        }
        if let Received::Overrun(_) = received {
            shared.diagnostics.bytes_overrun.add(1);
        }
        if !matches!(received, Received::Byte(_)) {
            self.spoil();
        }
    }

    /// A byte of the current frame was lost.
    fn spoil(&mut self) {
        self.requests.spoil();
        self.arriving.spoil();
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

    /// Board time of the byte that was received last, microseconds, where it is not now.
    fn received_us(&self) -> Option<u32> {
        None
    }

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
    pub fn run<P: Platform>(&mut self, inbox: &mut Inboxes, shared: &Shared<P>) {
        let Self { port, bytes } = self;
        if let Some(received) = port.receive() {
            let received_us = port
                .received_us()
                .unwrap_or_else(|| shared.platform.now_us());
            inbox.receive(received, received_us, shared);
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

    /// A request waits for a fit; messages of a robot come and go meanwhile, each with its own
    /// time.
    #[test]
    fn a_robot_is_heard_while_a_request_waits() {
        use ridgetone_proto::odometry::Reading;
        #[derive(Default)]
        struct Detect(Cell<u32>);
        impl Platform for Detect {
            fn pend(shared: &Shared<Self>, task: Task) {
                shared
                    .platform
                    .0
                    .set(shared.platform.0.get() + u32::from(task == Task::Detect));
            }

            fn now_us(&self) -> u32 {
                0
            }
        }
        let shared = Shared::new(Detect::default(), ridgetone_proto::plan::Plan::PAPER);
        let mut inbox = Inboxes::new();
        let push = |bytes: &[u8], at_us, inbox: &mut Inboxes| {
            bytes
                .iter()
                .for_each(|byte| inbox.receive(Received::Byte(*byte), at_us, &shared));
            (
                shared.platform.0.get(),
                shared.diagnostics.requests_damaged.get(),
                shared.odometry_us.load(Relaxed),
            )
        };
        let mut wire = [0; 32];
        let used = framing::encode(&7u16, &mut wire).expect("it fits");
        let message = |number| Odometry {
            number,
            t_us: 5,
            reading: Reading::Place(0),
        };
        assert_eq!(push(&wire[..used], 10, &mut inbox), (0, 0, 0));
        for number in 1..=3 {
            assert_eq!(
                push(
                    &message(number).encode(),
                    10 * u32::from(number),
                    &mut inbox
                ),
                (number.into(), 0, 10 * u32::from(number))
            );
            let mut frame = inbox.odometry.take().expect("a message");
            assert_eq!(Odometry::decode(&mut frame), Some(message(number)));
        }
        // Nobody takes the fourth before the fifth is complete, which is dropped and counted.
        assert_eq!(push(&message(4).encode(), 40, &mut inbox), (4, 0, 40));
        assert_eq!(push(&message(5).encode(), 50, &mut inbox), (4, 1, 40));
        assert_eq!(
            inbox
                .odometry
                .take()
                .and_then(|mut frame| Odometry::decode(&mut frame)),
            Some(message(4))
        );
        assert!(inbox.requests.take().is_some());
        // A message is no request, and a request no message.
        assert_eq!(push(&message(6).encode(), 60, &mut inbox), (5, 1, 60));
        assert!(inbox.requests.take().is_none() && inbox.odometry.take().is_some());
        push(&wire[..used], 70, &mut inbox);
        assert!(inbox.requests.take().is_some() && inbox.odometry.is_none());
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
        let mut inbox = Inboxes::new();
        let mut send = |bytes: &[u8], last: fn(u8) -> Received| {
            let (last_byte, others) = bytes.split_last().expect("bytes");
            others
                .iter()
                .for_each(|byte| inbox.receive(Received::Byte(*byte), 0, &shared));
            inbox.receive(last(*last_byte), 0, &shared);
            let whole = inbox.requests.take().is_some();
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
