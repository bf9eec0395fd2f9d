//! Events that wait for the line. A slow line costs the oldest, never the newest.

use super::shared::{PACKETS, Platform, Shared, Task};
use heapless::Deque;
use ridgetone_proto::telemetry::{Event, Packet};

/// Both ends of the serial line as a task sees them: requests come in, packets go out.
pub struct Mail<'a, I, O> {
    /// Requests and messages of a robot.
    pub inbox: &'a mut I,
    /// Packets that wait to be sent.
    pub outbox: &'a mut O,
}

/// At most `N` packets. They are numbered before any is dropped, so that a reader sees the loss.
#[derive(Debug, Default)]
pub struct Outbox<const N: usize, E = Event> {
    waiting: Deque<Packet<E>, N>,
    sequence: u16,
}

impl<const N: usize, E> Outbox<N, E> {
    /// An empty outbox; `const`, so that it can live in a static.
    pub const fn new() -> Self {
        Self {
            waiting: Deque::new(),
            sequence: 0,
        }
    }

    /// Numbers an event and queues it. Returns whether an event was dropped for it.
    pub fn post(&mut self, event: E) -> bool {
        let dropped = self.waiting.is_full() && self.waiting.pop_front().is_some();
        let packet = Packet {
            sequence: self.sequence,
            event,
        };
        self.sequence = self.sequence.wrapping_add(1);
        // Fails only with a capacity of zero.
        self.waiting.push_back(packet).is_err() || dropped
    }

    /// The oldest packet.
    pub fn take(&mut self) -> Option<Packet<E>> {
        self.waiting.pop_front()
    }

    /// Whether nothing waits.
    pub fn is_empty(&self) -> bool {
        self.waiting.is_empty()
    }
}

impl<E> Outbox<PACKETS, E> {
    /// Hands an event to `report`. A dropped event is counted.
    pub fn send<P: Platform>(&mut self, event: E, shared: &Shared<P>) {
        if self.post(event) {
            shared.diagnostics.messages_dropped.add(1);
        }
        P::pend(shared, Task::Report);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ridgetone_proto::telemetry::Health;

    fn event(frames: u32) -> Event {
        Event::Health(Health {
            frames,
            ..Health::default()
        })
    }

    #[test]
    fn packets_leave_in_order_and_numbered() {
        let mut outbox = Outbox::<2>::new();
        assert!(outbox.is_empty());
        assert!(!outbox.post(event(10)));
        assert!(!outbox.post(event(11)));
        assert_eq!(
            outbox.take(),
            Some(Packet {
                sequence: 0,
                event: event(10)
            })
        );
        assert_eq!(
            outbox.take(),
            Some(Packet {
                sequence: 1,
                event: event(11)
            })
        );
        assert_eq!(outbox.take(), None);
    }

    #[test]
    fn the_oldest_makes_room_and_leaves_a_gap_in_the_numbers() {
        let mut outbox = Outbox::<2>::new();
        outbox.post(event(10));
        outbox.post(event(11));
        assert!(outbox.post(event(12)));
        assert_eq!(outbox.take().map(|packet| packet.sequence), Some(1));
        assert_eq!(outbox.take().map(|packet| packet.sequence), Some(2));
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
        let mut outbox = Outbox::<PACKETS>::new();
        for number in 0..PACKETS as u32 + 5 {
            outbox.send(event(number), &shared);
            let dropped = (number + 1).saturating_sub(PACKETS as u32);
            assert_eq!(shared.diagnostics.messages_dropped.get(), dropped);
        }
    }
}
