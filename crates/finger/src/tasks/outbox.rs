//! Queues of events that wait for the line, and of frames that wait behind them. If the line is too
//! slow for both, frames are thinned; if it is too slow for events, the oldest are dropped.

use super::shared::{FRAMES, PACKETS, Platform, Shared, Task};
use heapless::Deque;
use ridgetone_proto::framing::TooLong;
use ridgetone_proto::telemetry::{Event, Events, Headline, Packet, WIRE_MAX};

/// Both ends of the serial line as a task sees them: requests come in, packets go out.
pub struct Mail<'a, I, O> {
    /// Requests.
    pub inbox: &'a mut I,
    /// Packets that wait to be sent.
    pub outbox: &'a mut O,
}

/// Outcome of posting an event.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Posted {
    /// Queued without a loss.
    Queued,
    /// The oldest event was dropped.
    DroppedOldest,
    /// The frame was dropped: there was no room for it.
    Thinned,
}

/// Holds up to [`PACKETS`] events and [`FRAMES`] frames. Packets are numbered as they leave. A
/// dropped event uses up a number, so that a reader sees the loss; a thinned frame leaves a gap in
/// the frames' own numbers, and is counted.
#[derive(Debug)]
pub struct Outbox<E: Events = Event> {
    events: Deque<E, PACKETS>,
    frames: Deque<E::Bulk, FRAMES>,
    sequence: u16,
}

impl<E: Events> Default for Outbox<E> {
    fn default() -> Self {
        Self::new()
    }
}

impl<E: Events> Outbox<E> {
    /// Creates an empty outbox; `const`, so that it can live in a static.
    pub const fn new() -> Self {
        Self {
            events: Deque::new(),
            frames: Deque::new(),
            sequence: 0,
        }
    }

    /// Queues an event.
    pub fn post(&mut self, event: E) -> Posted {
        if let Some(frame) = event.bulk() {
            return match self.frames.push_back(frame) {
                Ok(()) => Posted::Queued,
                Err(_) => Posted::Thinned,
            };
        }
        let is_dropped = self.events.is_full() && self.events.pop_front().is_some();
        // Fails only with a capacity of zero.
        let is_dropped = self.events.push_back(event).is_err() || is_dropped;
        if is_dropped {
            self.sequence = self.sequence.wrapping_add(1);
            Posted::DroppedOldest
        } else {
            Posted::Queued
        }
    }

    /// Takes the oldest event, or the oldest frame if no event waits.
    pub fn take(&mut self) -> Option<Packet<E>> {
        let event = self
            .events
            .pop_front()
            .or_else(|| self.frames.pop_front().map(E::Bulk::into))?;
        let sequence = self.sequence;
        self.sequence = sequence.wrapping_add(1);
        Some(Packet { sequence, event })
    }

    /// Encodes and removes the packet that [`Self::take`] would return. Encodes an event in place,
    /// because a copy would need more stack.
    pub fn encode_next(&mut self, wire: &mut [u8; WIRE_MAX]) -> Option<Result<usize, TooLong>> {
        let sequence = self.sequence;
        let encoded = match self.events.front() {
            Some(event) => E::encode(&Packet { sequence, event }, wire),
            None => encode_frame::<E>(*self.frames.front()?, sequence, wire),
        };
        if self.events.pop_front().is_none() {
            self.frames.pop_front();
        }
        self.sequence = sequence.wrapping_add(1);
        Some(encoded)
    }

    /// Log entry of the event that is sent next, if it has one.
    pub fn headline(&self) -> Option<Headline> {
        self.events.front()?.headline()
    }

    /// True if nothing waits to be sent.
    pub fn is_empty(&self) -> bool {
        self.events.is_empty() && self.frames.is_empty()
    }

    /// Passes an event to `report`. Counts dropped events and thinned frames.
    pub fn send<P: Platform>(&mut self, event: E, shared: &Shared<P>) {
        match self.post(event) {
            Posted::Queued => {}
            Posted::DroppedOldest => shared.diagnostics.messages_dropped.add(1),
            Posted::Thinned => shared.diagnostics.frames_thinned.add(1),
        }
        P::pend(shared, Task::Report);
    }
}

// Not inlined: it builds an event on the stack, and inlining would add that to the stack depth of
// encoding every other event.
#[inline(never)]
fn encode_frame<E: Events>(
    frame: E::Bulk,
    sequence: u16,
    wire: &mut [u8; WIRE_MAX],
) -> Result<usize, TooLong> {
    let event = &frame.into();
    E::encode(&Packet { sequence, event }, wire)
}

#[cfg(test)]
mod tests {
    use super::*;
    use ridgetone_proto::telemetry::{Decoder, Health, Raw};
    extern crate std;
    use std::vec::Vec;

    fn event(frames: u32) -> Event {
        Event::Health(Health {
            frames,
            ..Health::default()
        })
    }

    #[test]
    fn packets_leave_in_order_and_numbered() {
        let mut outbox = Outbox::new();
        assert!(outbox.is_empty());
        assert_eq!(outbox.post(event(10)), Posted::Queued);
        assert_eq!(outbox.post(event(11)), Posted::Queued);
        for (sequence, frames) in [(0, 10), (1, 11)] {
            let event = event(frames);
            assert_eq!(outbox.take(), Some(Packet { sequence, event }));
        }
        assert_eq!(outbox.take(), None);
    }

    #[test]
    fn the_oldest_makes_room_and_leaves_a_gap_in_the_numbers() {
        let mut outbox = Outbox::new();
        for number in 0..PACKETS as u32 {
            assert_eq!(outbox.post(event(number)), Posted::Queued);
        }
        assert_eq!(outbox.post(event(12)), Posted::DroppedOldest);
        assert_eq!(outbox.take().map(|packet| packet.sequence), Some(1));
        assert_eq!(outbox.take().map(|packet| packet.sequence), Some(2));
    }

    #[test]
    fn events_go_before_frames_and_frames_that_do_not_fit_are_thinned() {
        let raw = |number| {
            Event::Raw(Raw {
                t_us: 0,
                number,
                present: 0,
                good: 0,
                codes: [0; 16],
            })
        };
        let mut outbox = Outbox::new();
        for number in 0..FRAMES as u32 {
            assert_eq!(outbox.post(raw(number)), Posted::Queued);
        }
        assert_eq!(outbox.post(raw(99)), Posted::Thinned);
        assert_eq!(outbox.post(event(10)), Posted::Queued);
        assert_eq!(outbox.post(event(11)), Posted::Queued);
        let (mut decoder, mut taken) = (Decoder::new(), Vec::new());
        let mut wire = [0; WIRE_MAX];
        while let Some(length) = outbox.encode_next(&mut wire) {
            let wire = &wire[..length.expect("every event fits")];
            taken.extend(wire.iter().filter_map(|byte| decoder.push(*byte)));
        }
        let events = [event(10), event(11)];
        let frames = (0..FRAMES as u32).map(raw);
        let expected: Vec<_> = (0..)
            .zip(events.into_iter().chain(frames))
            .map(|(sequence, event)| Packet { sequence, event })
            .collect();
        assert_eq!(taken, expected);
        assert!(outbox.is_empty());
    }

    #[derive(Debug)]
    struct Still;

    impl Platform for Still {
        fn pend(_: &Shared<Self>, task: Task) {
            assert_eq!(task, Task::Report);
        }

        fn now_us(&self) -> u32 {
            0
        }
    }

    #[test]
    fn each_event_that_is_dropped_is_counted() {
        let shared = Shared::new(Still, ridgetone_proto::plan::Plan::PAPER);
        let mut outbox = Outbox::new();
        for number in 0..PACKETS as u32 + 5 {
            outbox.send(event(number), &shared);
            let dropped = (number + 1).saturating_sub(PACKETS as u32);
            assert_eq!(shared.diagnostics.messages_dropped.get(), dropped);
        }
    }
}
