//! The queue in front of a sink. A full queue drops its oldest message, so that a board never
//! waits, and counts it; the loss is reported as soon as the sink takes messages again.
//!
//! `tokio::sync::broadcast` does not fit: in one ring, frames would push out events; two rings
//! would lose the order between frames and events. A lagging receiver could neither tell whose
//! messages it lost, nor put back messages that a broker has not acknowledged.

use super::message::{Lost, Message, lost};
use super::topic::{Names, Topic};
use anyhow::Result;
use std::collections::VecDeque;
use std::fmt;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};
use tokio::sync::Notify;

/// Maximum number of frames in the queue: 1.7 s of ten fingers, 3 MB.
const FRAMES_MAX: usize = 4096;

/// Maximum number of other messages in the queue: an hour and a half of ten untouched fingers,
/// 50 MB.
const EVENTS_MAX: usize = 1 << 16;

/// Minimum interval between two reports of losses to a sink.
const REPORT_EVERY: Duration = Duration::from_secs(1);

/// Delivers messages.
pub trait Sink: Send {
    /// Returns the sink's name, for people and in reports of losses.
    fn name(&self) -> &'static str;

    /// Delivers until the queue is closed and empty. Waits while there is no receiver. Fails if the
    /// sink can never deliver.
    fn run(self: Box<Self>, queue: &Queue, names: &Names) -> Result<()>;
}

pub struct Queue {
    pub sink: &'static str,
    state: Mutex<State>,
    changed: Notify,
}

/// A message and its position in the queue.
#[derive(Clone, Debug)]
pub struct Queued {
    order: u64,
    pub message: Arc<Message>,
}

/// Totals of a sink so far.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    pub delivered: u64,
    pub lost: Lost,
    /// Messages that are still waiting.
    pub left: u64,
}

impl fmt::Display for Counts {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            delivered,
            lost,
            left,
        } = self;
        write!(
            f,
            "{delivered} messages delivered, {} frames and {} events lost",
            lost.frames, lost.events
        )?;
        if lost.unconfirmed > 0 {
            write!(f, ", {} frames not confirmed", lost.unconfirmed)?;
        }
        if *left > 0 {
            write!(f, ", {left} left behind")?;
        }
        Ok(())
    }
}

#[derive(Default)]
struct State {
    frames: VecDeque<Queued>,
    events: VecDeque<Queued>,
    /// Number of the next message to be queued.
    order: u64,
    /// Losses by finger in total, and as last reported.
    lost: Vec<Lost>,
    known: Vec<Lost>,
    reported: Option<Instant>,
    delivered: u64,
    is_closed: bool,
    has_failed: bool,
}

impl Queue {
    pub fn new(sink: &'static str, fingers: usize) -> Self {
        let state = State {
            order: 1,
            lost: vec![Lost::default(); fingers],
            known: vec![Lost::default(); fingers],
            ..State::default()
        };
        Self {
            sink,
            state: Mutex::new(state),
            changed: Notify::new(),
        }
    }

    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Adds a message without waiting.
    pub fn push(&self, message: Arc<Message>) {
        let mut state = self.state();
        let queued = Queued {
            order: state.order,
            message,
        };
        state.order += 1;
        if state.has_failed {
            state.lose(&queued.message);
        } else {
            state.add(queued);
            self.changed.notify_one();
        }
    }

    /// Waits for the next message; `None` if the queue is closed and empty.
    pub async fn next(&self) -> Option<Queued> {
        loop {
            {
                let mut state = self.state();
                if let Some(queued) = state.report(self.sink).or_else(|| state.take()) {
                    state.delivered += 1;
                    return Some(queued);
                }
                if state.is_closed {
                    return None;
                }
            }
            self.changed.notified().await;
        }
    }

    /// Puts back messages that were taken but not delivered: events are queued again, frames count
    /// as not confirmed.
    pub fn put_back(&self, queued: impl DoubleEndedIterator<Item = Queued>) {
        let mut state = self.state();
        for queued in queued.rev() {
            state.delivered -= 1;
            if queued.message.topic == Topic::Frames {
                state.lost[queued.message.finger].unconfirmed += 1;
            } else {
                state.events.push_front(queued);
            }
        }
    }

    /// Closes the queue: no more messages will come.
    pub fn close(&self) {
        self.state().is_closed = true;
        self.changed.notify_one();
    }

    pub fn is_closed(&self) -> bool {
        self.state().is_closed
    }

    /// Counts all messages as lost from now on: the sink has failed.
    pub fn fail(&self) {
        self.state().has_failed = true;
    }

    pub fn has_failed(&self) -> bool {
        self.state().has_failed
    }

    #[cfg(any(feature = "mqtt", test))]
    pub fn losses(&self) -> Vec<Lost> {
        self.state().lost.clone()
    }

    pub fn counts(&self) -> Counts {
        let state = self.state();
        let mut lost = Lost::default();
        state.lost.iter().for_each(|finger| lost.add(*finger));
        Counts {
            delivered: state.delivered,
            lost,
            left: (state.frames.len() + state.events.len()) as u64,
        }
    }
}

impl State {
    fn add(&mut self, queued: Queued) {
        let (queue, max) = match queued.message.topic {
            Topic::Frames => (&mut self.frames, FRAMES_MAX),
            _ => (&mut self.events, EVENTS_MAX),
        };
        queue.push_back(queued);
        if queue.len() > max
            && let Some(oldest) = queue.pop_front()
        {
            self.lose(&oldest.message);
        }
    }

    fn lose(&mut self, message: &Message) {
        let lost = &mut self.lost[message.finger];
        match message.topic {
            Topic::Frames => lost.frames += 1,
            _ => lost.events += 1,
        }
    }

    /// Returns a report of a finger's losses, if one is due.
    fn report(&mut self, sink: &str) -> Option<Queued> {
        let is_due = self.is_closed || self.reported.is_none_or(|at| at.elapsed() >= REPORT_EVERY);
        let mut unknown = (0..self.lost.len()).filter(|n| self.lost[*n] != self.known[*n]);
        let Some(finger) = unknown.next().filter(|_| is_due) else {
            // The losses of all fingers are reported at the same time.
            self.reported = self.reported.filter(|_| !is_due);
            return None;
        };
        if unknown.next().is_none() {
            self.reported = Some(Instant::now());
        }
        self.known[finger] = self.lost[finger];
        Some(Queued {
            order: 0,
            message: Arc::new(lost(finger, sink, self.lost[finger])),
        })
    }

    /// Removes and returns the oldest message.
    fn take(&mut self) -> Option<Queued> {
        match (self.frames.front(), self.events.front()) {
            (Some(frame), Some(event)) if frame.order < event.order => self.frames.pop_front(),
            (Some(_), None) => self.frames.pop_front(),
            _ => self.events.pop_front(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn push(queue: &Queue, finger: usize, topic: Topic, number: usize) {
        queue.push(Arc::new(Message {
            finger,
            topic,
            json: number.to_string(),
            time_ns: 0,
            index: None,
            is_state: false,
        }));
    }

    /// Takes `count` messages; the queue must have them, or be closed.
    fn take(queue: &Queue, count: usize) -> Vec<Queued> {
        let runtime = tokio::runtime::Builder::new_current_thread()
            .build()
            .unwrap();
        let next = || runtime.block_on(queue.next());
        std::iter::from_fn(next).take(count).collect()
    }

    fn drain(queue: &Queue) -> Vec<Queued> {
        queue.close();
        take(queue, usize::MAX)
    }

    /// Returns the numbers of frames, events and unconfirmed frames in a report of losses at the
    /// sink `test`.
    fn reported(queued: &Queued) -> (u64, u64, u64) {
        let json: serde_json::Value = serde_json::from_str(&queued.message.json).unwrap();
        assert_eq!(
            (&json["type"], &json["at"]),
            (&"lost".into(), &"test".into())
        );
        assert_eq!(queued.message.topic, Topic::Diagnostics);
        let count = |name: &str| json[name].as_u64().unwrap();
        (
            count("frames"),
            count("events"),
            count("frames_unconfirmed"),
        )
    }

    fn numbers(all: &[Queued]) -> Vec<usize> {
        all.iter()
            .map(|queued| queued.message.json.parse().unwrap())
            .collect()
    }

    #[test]
    fn a_full_queue_loses_the_oldest_frames_and_reports_each_fingers_losses() {
        let queue = Queue::new("test", 2);
        for number in 0..FRAMES_MAX + 10 {
            push(&queue, number % 2, Topic::Frames, number);
        }
        push(&queue, 0, Topic::Tone, 7);
        let all = drain(&queue);
        for (finger, queued) in all[..2].iter().enumerate() {
            assert_eq!(queued.message.finger, finger);
            assert_eq!(reported(queued), (5, 0, 0));
        }
        let expected: Vec<usize> = (10..FRAMES_MAX + 10).chain([7]).collect();
        assert_eq!(numbers(&all[2..]), expected);
        let counts = queue.counts();
        assert_eq!(counts.delivered, 2 + FRAMES_MAX as u64 + 1);
        assert_eq!((counts.lost.frames, counts.left), (10, 0));
    }

    #[test]
    fn events_do_not_suffer_from_frames_and_are_counted_too() {
        let queue = Queue::new("test", 1);
        for number in 0..EVENTS_MAX + 3 {
            push(&queue, 0, Topic::Contact, number);
        }
        for number in 0..2 * FRAMES_MAX {
            push(&queue, 0, Topic::Frames, number);
        }
        let Counts { lost, left, .. } = queue.counts();
        assert_eq!(
            (lost.frames, lost.events, lost.unconfirmed),
            (FRAMES_MAX as u64, 3, 0)
        );
        assert_eq!(left, (FRAMES_MAX + EVENTS_MAX) as u64);
    }

    #[test]
    fn events_that_are_put_back_come_again_in_their_order_but_frames_do_not() {
        let queue = Queue::new("test", 1);
        let topics = [Topic::Tone, Topic::Frames, Topic::Contact, Topic::Health];
        for (number, topic) in topics.into_iter().enumerate() {
            push(&queue, 0, topic, number);
        }
        queue.put_back(take(&queue, 3).into_iter());
        let all = drain(&queue);
        assert_eq!(reported(&all[0]), (0, 0, 1));
        assert_eq!(numbers(&all[1..]), [0, 2, 3]);
        assert_eq!(queue.counts().delivered, 4);
    }

    /// Asserts that reports have totals, so that a receiver may miss a report.
    #[test]
    fn reports_give_totals() {
        let queue = Queue::new("test", 1);
        for lost in [1, 3] {
            for number in 0..FRAMES_MAX + lost {
                push(&queue, 0, Topic::Frames, number);
            }
        }
        let frames = FRAMES_MAX as u64 + 4;
        assert_eq!(reported(&drain(&queue)[0]), (frames, 0, 0));
        push(&queue, 0, Topic::Frames, 0);
        queue.put_back(drain(&queue).into_iter());
        let again = drain(&queue);
        assert_eq!((again.len(), reported(&again[0])), (1, (frames, 0, 1)));
        assert_eq!(queue.losses()[0], queue.counts().lost);
    }
}
