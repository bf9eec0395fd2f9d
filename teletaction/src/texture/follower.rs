//! Follows the textures and windows that a finger reports, and notices its silence.

use super::found;
use crate::stimulus::Texture;
use anyhow::Result;
use ridgetone_host::feed::{Feed, Requester, new_requests};
use ridgetone_host::listen::{Heard, Listener, SILENT};
use ridgetone_proto::command::Command;
use ridgetone_proto::telemetry::{Estimate, Event, Events, Starts};
use std::time::{Duration, Instant};

#[derive(Clone, Debug, PartialEq)]
pub enum News {
    /// A new texture is under the finger, which also ends a silence.
    Texture(Texture),
    /// An estimate, and the time since its window ended.
    Window(Box<Estimate>, Duration),
    /// A silence is over. A texture follows as soon as the finger finds one.
    Back,
    /// The finger has been silent for [`SILENT`].
    Silent,
    /// The named board is disconnected, for the given reason; the follower waits for it.
    Disconnected(String, String),
    Over,
}

pub struct Follower {
    listener: Listener,
    heard_at: Instant,
    is_silent: bool,
    is_over: bool,
    clock: Clock,
}

/// Length of the blocks in which the smallest packet delay is sought, seconds: crystals drift apart
/// by less than 1 ms in this time.
const BLOCK_S: f64 = 10.0;

/// Compares the board's clock with this computer's, by the packets with the smallest delay.
struct Clock {
    starts: Starts,
    begun: Instant,
    /// Smallest difference of arrival and device time in this block and in the previous one,
    /// seconds.
    offsets_s: [f64; 2],
    block_ends_s: f64,
}

impl Clock {
    fn new() -> Self {
        Self {
            starts: Starts::new(),
            begun: Instant::now(),
            offsets_s: [f64::INFINITY; 2],
            block_ends_s: BLOCK_S,
        }
    }

    /// Returns the age of an event that arrives now: the time since its device time.
    fn age(&mut self, event: &Event) -> Duration {
        if self.starts.take(event) {
            self.offsets_s = [f64::INFINITY; 2];
        }
        let Some(device_us) = event.dated_us() else {
            return Duration::ZERO;
        };
        let now_s = self.begun.elapsed().as_secs_f64();
        if now_s > self.block_ends_s {
            self.offsets_s = [self.offsets_s[1], f64::INFINITY];
            self.block_ends_s = now_s + BLOCK_S;
        }
        let offset_s = now_s - device_us as f64 * 1e-6;
        self.offsets_s[1] = self.offsets_s[1].min(offset_s);
        let min_s = self.offsets_s[0].min(self.offsets_s[1]);
        Duration::from_secs_f64(offset_s - min_s)
    }
}

impl Follower {
    pub fn new(feed: Feed) -> Self {
        let listener = Listener::new(feed, Requester::default());
        Self {
            listener,
            heard_at: Instant::now(),
            is_silent: false,
            is_over: false,
            clock: Clock::new(),
        }
    }

    /// Greets the board, which then reports its texture even if unchanged. The board need not
    /// answer: a finger wired to send only reports a texture when it changes.
    fn greet(&mut self) {
        let (feed, mut requests) = (&mut self.listener.feed, new_requests());
        requests.push(Command::Greet);
        if let Ok(bytes) = requests.due(feed.elapsed())
            && feed.has_board()
        {
            let _ = feed.send(&bytes);
        }
    }

    pub fn into_feed(self) -> Feed {
        self.listener.feed
    }

    /// Pauses the source while nobody watches, or resumes it; a paused emulated board counts as
    /// heard.
    pub fn idle(&mut self, idle: bool) {
        if self.listener.feed.idle(idle) || idle {
            self.heard_at = Instant::now();
        }
    }

    /// Waits for news, for at most `max`.
    pub fn next(&mut self, max: Duration) -> Result<Option<News>> {
        match self.listener.next(max)? {
            Some(Heard::Packet(packet, _)) => {
                self.heard_at = Instant::now();
                let age = self.clock.age(&packet.event);
                let is_back = std::mem::take(&mut self.is_silent);
                if is_back {
                    // The surface may have changed; if not, the board would not report the texture
                    // again.
                    self.greet();
                }
                Ok(match (found(&packet), packet.event) {
                    (Some(texture), _) => Some(News::Texture(texture)),
                    (None, Event::Estimate(estimate)) if !is_back => {
                        Some(News::Window(Box::new(estimate), age))
                    }
                    _ => is_back.then_some(News::Back),
                })
            }
            // The listener greets the board.
            Some(Heard::Connected(_)) => Ok(None),
            Some(Heard::Over) => {
                self.is_over = true;
                Ok(Some(News::Over))
            }
            Some(Heard::Disconnected(name, why)) => {
                self.is_silent = true;
                Ok(Some(News::Disconnected(name, why)))
            }
            _ if !self.is_over && !self.is_silent && self.heard_at.elapsed() > SILENT => {
                self.is_silent = true;
                Ok(Some(News::Silent))
            }
            _ => Ok(None),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ridgetone_host::feed::{FeedEvent, Source};
    use ridgetone_proto::boot::{Boot, SettingsSource};
    use ridgetone_proto::command::Request;
    use ridgetone_proto::framing;
    use ridgetone_proto::plan::Plan;
    use ridgetone_proto::settings::Settings;
    use ridgetone_proto::telemetry::{
        Hello, PROTOCOL, Packet, Release, Texture as Reported, WIRE_MAX, encode,
    };
    use std::collections::VecDeque;
    use std::sync::{Arc, Mutex};

    /// Returns scripted events, and keeps the bytes that it is sent.
    struct Script(VecDeque<FeedEvent<Vec<u8>>>, Arc<Mutex<Vec<u8>>>);

    impl Source for Script {
        fn name(&self) -> String {
            "a script".into()
        }

        fn next(&mut self, _: Duration) -> Result<Option<FeedEvent<Vec<u8>>>> {
            Ok(self.0.pop_front())
        }

        fn send(&mut self, bytes: &[u8]) -> Result<()> {
            self.1.lock().expect("alone").extend(bytes);
            Ok(())
        }
    }

    fn data(sequence: u16, event: Event) -> FeedEvent<Vec<u8>> {
        let mut wire = [0; WIRE_MAX];
        let used = encode(&Packet { sequence, event }, &mut wire).expect("it fits");
        FeedEvent::Data(wire[..used].to_vec())
    }

    /// Decodes the commands in the bytes sent.
    fn commands(sent: &Mutex<Vec<u8>>) -> Vec<Command> {
        let sent = std::mem::take(&mut *sent.lock().expect("alone"));
        let frames = sent
            .split(|byte| *byte == 0)
            .filter(|frame| !frame.is_empty());
        frames
            .map(|frame| {
                framing::decode::<Request>(&mut frame.to_vec())
                    .expect("a request")
                    .command
            })
            .collect()
    }

    #[test]
    fn a_finger_is_greeted_when_it_comes_and_when_it_is_back() {
        let sent = Arc::new(Mutex::new(Vec::new()));
        let texture = |period_mm| {
            Event::Texture(Reported {
                t_us: 5,
                plan: Plan::PAPER,
                period_mm,
                period_sigma_mm: 0.01,
                power_v2: 1e-6,
                power_sigma_v2: 1e-8,
                overtones: [[0.0; 2]; 3],
                level_v: None,
            })
        };
        let released = Event::Release(Release {
            t_us: 4,
            reported_after_us: 0,
        });
        let greeting = Event::Hello(Hello {
            protocol: PROTOCOL,
            version: [0, 1, 0],
            frame_rate_hz: 241.14,
            settings: Settings::DEFAULT,
            source: SettingsSource::Default,
            boot: Boot::default(),
            t_us: 3,
        });
        let script = [
            FeedEvent::Connected("a".into()),
            data(0, texture(3.6)),
            data(1, greeting.clone()),
            data(2, released.clone()),
            FeedEvent::Disconnected("a".into(), "gone".into()),
            data(3, released),
            data(4, greeting),
            data(5, texture(2.5)),
            FeedEvent::Over,
        ];
        let mut follower = Follower::new(Feed::new(Script(script.into(), Arc::clone(&sent))));
        let mut next = || follower.next(Duration::ZERO).expect("a step");
        let period_mm = |news: Option<News>| match news {
            Some(News::Texture(texture)) => texture.period_mm,
            news => panic!("{news:?}"),
        };
        assert_eq!((next(), commands(&sent)), (None, vec![]));
        // The board sends nothing until it is greeted.
        assert_eq!((next(), commands(&sent)), (None, vec![Command::Greet]));
        assert_eq!(period_mm(next()), 3.6);
        assert_eq!((next(), next()), (None, None));
        assert_eq!(next(), Some(News::Disconnected("a".into(), "gone".into())));
        assert_eq!(commands(&sent), []);
        assert_eq!((next(), commands(&sent)), (None, vec![Command::Greet]));
        assert_eq!(next(), Some(News::Back));
        assert_eq!(next(), None);
        assert_eq!(period_mm(next()), 2.5);
        assert_eq!(next(), Some(News::Over));
    }
}
