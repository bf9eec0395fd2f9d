//! The queue in front of a sink. A board never waits: a full queue drops its oldest message, counts
//! it, and reports it as soon as the sink takes messages again.

use super::message::{Lost, Message, lost};
use super::topic::Topic;
use std::collections::VecDeque;
use std::fmt;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};
use tokio::sync::Notify;

/// Frames that the queue holds: 1.7 s of ten fingers, 3 MB.
const FRAMES_MAX: usize = 4096;

/// Other messages that the queue holds: an hour and a half of ten fingers that nothing touches, 50
/// MB.
const EVENTS_MAX: usize = 1 << 16;

/// Time between two reports of losses to a sink that loses all the time.
const REPORT_EVERY: Duration = Duration::from_secs(1);

pub struct Queue {
    /// Name of the sink.
    pub sink: &'static str,
    state: Mutex<State>,
    changed: Notify,
}

/// A message, and its place in the queue.
#[derive(Clone, Debug)]
pub struct Queued {
    order: u64,
    pub message: Arc<Message>,
}

/// What a sink has done so far.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    pub delivered: u64,
    pub lost: Lost,
    /// Messages that wait.
    pub left: u64,
}

impl fmt::Display for Counts {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            delivered,
            lost:
                Lost {
                    frames,
                    events,
                    unconfirmed,
                },
            left,
        } = self;
        write!(
            f,
            "{delivered} messages delivered, {frames} frames and {events} events lost"
        )?;
        match unconfirmed {
            0 => {}
            _ => write!(f, ", {unconfirmed} frames not confirmed")?,
        }
        if *left > 0 {
            write!(f, ", {left} left behind")
        } else {
            Ok(())
        }
    }
}

#[derive(Default)]
struct State {
    frames: VecDeque<Queued>,
    events: VecDeque<Queued>,
    /// Number of the next message.
    order: u64,
    /// Losses by finger, and which of them are reported.
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

    /// Adds a message. It never waits.
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

    /// Waits for the next message; none: the queue is closed and empty.
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

    /// Puts back messages that were taken out and not delivered: events wait again, frames count as not
    /// confirmed.
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

    /// The sink has failed: all messages are lost from now on.
    pub fn fail(&self) {
        self.state().has_failed = true;
    }

    pub fn has_failed(&self) -> bool {
        self.state().has_failed
    }

    /// What each finger has lost here.
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
        let (queue, most) = match queued.message.topic {
            Topic::Frames => (&mut self.frames, FRAMES_MAX),
            _ => (&mut self.events, EVENTS_MAX),
        };
        queue.push_back(queued);
        if queue.len() > most
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

    /// A message about what a finger has lost here, if it is time for one.
    fn report(&mut self, sink: &str) -> Option<Queued> {
        let is_due = self.is_closed || self.reported.is_none_or(|at| at.elapsed() >= REPORT_EVERY);
        let mut unknown = (0..self.lost.len()).filter(|n| self.lost[*n] != self.known[*n]);
        let Some(finger) = unknown.next().filter(|_| is_due) else {
            // Every finger's losses are reported at the same time.
            self.reported = self.reported.filter(|_| !is_due);
            return None;
        };
        if unknown.next().is_none() {
            self.reported = Some(Instant::now());
        }
        self.known[finger] = self.lost[finger];
        let message = lost(finger, sink, self.lost[finger]);
        Some(Queued {
            order: 0,
            message: Arc::new(message),
        })
    }

    /// The oldest message.
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

    fn message(finger: usize, topic: Topic, number: usize) -> Arc<Message> {
        Arc::new(Message {
            finger,
            topic,
            json: number.to_string(),
            time_ns: 0,
            index: None,
            is_state: false,
        })
    }

    fn drain(queue: &Queue) -> Vec<Queued> {
        queue.close();
        let runtime = tokio::runtime::Builder::new_current_thread()
            .build()
            .unwrap();
        let mut all = Vec::new();
        while let Some(queued) = runtime.block_on(queue.next()) {
            all.push(queued);
        }
        all
    }

    #[test]
    fn a_full_queue_loses_the_oldest_frames_and_says_how_many_of_whom() {
        let queue = Queue::new("test", 2);
        for number in 0..FRAMES_MAX + 10 {
            queue.push(message(number % 2, Topic::Frames, number));
        }
        queue.push(message(0, Topic::Tone, 7));
        let all = drain(&queue);
        for (finger, queued) in all[..2].iter().enumerate() {
            let json: serde_json::Value = serde_json::from_str(&queued.message.json).unwrap();
            assert_eq!(
                (queued.message.finger, queued.message.topic),
                (finger, Topic::Diagnostics)
            );
            let count = |name: &str| json[name].as_u64().unwrap();
            assert_eq!(
                (
                    count("frames"),
                    count("events"),
                    count("frames_unconfirmed")
                ),
                (5, 0, 0)
            );
            assert_eq!(
                (json["type"].as_str(), json["at"].as_str()),
                (Some("lost"), Some("test"))
            );
        }
        let numbers: Vec<usize> = all[2..]
            .iter()
            .map(|queued| queued.message.json.parse().unwrap())
            .collect();
        assert_eq!(
            numbers,
            (10..FRAMES_MAX + 10).chain([7]).collect::<Vec<_>>()
        );
        let counts = queue.counts();
        assert_eq!(counts.delivered, 2 + FRAMES_MAX as u64 + 1);
        assert_eq!(
            (counts.lost, counts.left),
            (
                Lost {
                    frames: 10,
                    ..Lost::default()
                },
                0
            )
        );
    }

    #[test]
    fn events_do_not_suffer_from_frames_and_are_counted_too() {
        let queue = Queue::new("test", 1);
        for number in 0..EVENTS_MAX + 3 {
            queue.push(message(0, Topic::Contact, number));
        }
        for number in 0..2 * FRAMES_MAX {
            queue.push(message(0, Topic::Frames, number));
        }
        assert_eq!(
            queue.counts().lost,
            Lost {
                frames: FRAMES_MAX as u64,
                events: 3,
                unconfirmed: 0
            }
        );
        assert_eq!(queue.counts().left, (FRAMES_MAX + EVENTS_MAX) as u64);
    }

    #[test]
    fn what_is_put_back_comes_again_in_its_order_but_frames_do_not() {
        let queue = Queue::new("test", 1);
        let topics = [Topic::Tone, Topic::Frames, Topic::Contact, Topic::Health];
        topics
            .iter()
            .enumerate()
            .for_each(|(number, topic)| queue.push(message(0, *topic, number)));
        let runtime = tokio::runtime::Builder::new_current_thread()
            .build()
            .unwrap();
        let queued: Vec<Queued> = (0..3)
            .map(|_| runtime.block_on(queue.next()).unwrap())
            .collect();
        queue.put_back(queued.into_iter());
        let all = drain(&queue);
        assert!(
            all[0].message.json.contains(r#""frames_unconfirmed":1"#),
            "{:?}",
            all[0]
        );
        let rest: Vec<&str> = all[1..]
            .iter()
            .map(|queued| queued.message.json.as_str())
            .collect();
        assert_eq!(rest, ["0", "2", "3"]);
        assert_eq!(queue.counts().delivered, 4);
    }

    /// A receiver that misses a report learns from the next one what it missed.
    #[test]
    fn reports_give_totals() {
        let queue = Queue::new("test", 1);
        for lost in [1, 3] {
            for number in 0..FRAMES_MAX as u64 + lost {
                queue.push(message(0, Topic::Frames, number as usize));
            }
        }
        let all = drain(&queue);
        queue.push(message(0, Topic::Frames, 0));
        queue.put_back(drain(&queue).into_iter());
        let again = drain(&queue);
        let counts = |queued: &Queued| -> (u64, u64) {
            let json: serde_json::Value = serde_json::from_str(&queued.message.json).unwrap();
            let count = |name: &str| json[name].as_u64().unwrap();
            (count("frames"), count("frames_unconfirmed"))
        };
        let frames = FRAMES_MAX as u64 + 4;
        assert_eq!(counts(&all[0]), (frames, 0));
        assert_eq!((again.len(), counts(&again[0])), (1, (frames, 1)));
        assert_eq!(queue.losses()[0], queue.counts().lost);
    }
}
