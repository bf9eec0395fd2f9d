//! Tests feeds from artificial sources, such as a board that obeys requests with the library's own
//! receiver.

use super::*;
use crate::ram_flash::RamFlash;
use crate::requests::receiver::Receiver;
use anyhow::Result;
use ridgetone_proto::command::{Command, Outcome};
use ridgetone_proto::settings::Settings;
use ridgetone_proto::telemetry::{Event, Hello, Release, WIRE_MAX, encode};
use ridgetone_proto::telemetry::{PROTOCOL, Packet};
use std::collections::VecDeque;
use std::io::Write;
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

/// A board that answers requests as the firmware does, and sends nothing else.
struct Obedient {
    board: Receiver<RamFlash>,
    outgoing: VecDeque<FeedEvent<Vec<u8>>>,
    sequence: u16,
    received: usize,
}

impl Obedient {
    fn new() -> Self {
        Self {
            board: Receiver::new(RamFlash::default()),
            outgoing: VecDeque::new(),
            sequence: 1,
            received: 0,
        }
    }

    fn emit(&mut self, event: Event) {
        let mut wire = [0; WIRE_MAX];
        let used = encode(
            &Packet {
                sequence: self.sequence,
                event,
            },
            &mut wire,
        )
        .unwrap();
        self.sequence += 1;
        self.outgoing
            .push_back(FeedEvent::Data(wire[..used].to_vec()));
    }
}

impl Source for Arc<Mutex<Obedient>> {
    fn name(&self) -> String {
        "an obedient board".into()
    }

    fn next(&mut self, _: Duration) -> Result<Option<FeedEvent<Vec<u8>>>> {
        Ok(self.lock().unwrap().outgoing.pop_front())
    }

    fn send(&mut self, bytes: &[u8]) -> Result<()> {
        let mut board = self.lock().unwrap();
        board.received += bytes.len();
        for reply in board.board.hear(bytes) {
            board.emit(Event::Reply(reply));
        }
        Ok(())
    }
}

fn packet(sequence: u16, t_us: u64) -> Packet {
    Packet {
        sequence,
        event: Event::Release(Release {
            t_us,
            reported_after_us: 0,
        }),
    }
}

#[test]
fn requests_are_sent_and_answered_and_raw_frames_requested_only_while_they_are_wanted() {
    let board = Arc::new(Mutex::new(Obedient::new()));
    let mut feed = Feed::new(Arc::clone(&board));
    let mut requester = Requester::default();
    let settings = Settings {
        window_s: 0.5,
        ..Settings::DEFAULT
    };
    requester.push(Command::Set {
        settings,
        keep: false,
    });
    requester.push(Command::Set {
        settings: Settings {
            window_s: 9.0,
            ..settings
        },
        keep: false,
    });
    requester.want_raw(true);
    let mut answers = Vec::new();
    let talk = |feed: &mut Feed, requester: &mut Requester, answers: &mut Vec<_>| {
        for _ in 0..10 {
            requester.tick(feed).unwrap();
            while let Some(FeedEvent::Data(packet)) = feed.next(Duration::ZERO).unwrap() {
                answers.extend(requester.answered(&packet));
            }
        }
    };
    talk(&mut feed, &mut requester, &mut answers);
    assert_eq!(board.lock().unwrap().board.in_force().0, settings);
    let outcomes: Vec<_> = answers.iter().map(|(_, outcome)| outcome).collect();
    assert!(
        matches!(
            outcomes[..],
            [Outcome::Done, Outcome::Setting(_), Outcome::Done]
        ),
        "{outcomes:?}"
    );
    assert!(
        matches!(answers[2].0, Command::Raw { frames } if frames > 241 * 10),
        "{answers:?}"
    );
    // Nothing more is sent until raw frames have to be requested again.
    let received = board.lock().unwrap().received;
    talk(&mut feed, &mut requester, &mut answers);
    assert_eq!(
        (board.lock().unwrap().received, answers.len()),
        (received, 3)
    );
    // A restarted board no longer sends raw frames.
    let (boot, source) = Default::default();
    let hello = Hello {
        protocol: PROTOCOL,
        version: [0, 1, 0],
        frame_rate_hz: 241.14,
        settings: Settings::DEFAULT,
        source,
        boot,
        t_us: 0,
    };
    for t_us in [9_000_000, 0] {
        requester.answered(&Packet {
            sequence: 0,
            event: Event::Hello(Hello {
                t_us,
                ..hello.clone()
            }),
        });
    }
    talk(&mut feed, &mut requester, &mut answers);
    assert!(
        matches!(answers[3].0, Command::Raw { frames } if frames > 0),
        "{answers:?}"
    );
    requester.want_raw(false);
    talk(&mut feed, &mut requester, &mut answers);
    assert!(
        answers.len() == 5 && answers[4] == (Command::Raw { frames: 0 }, Outcome::Done),
        "{answers:?}"
    );
}

#[test]
fn settings_are_put_into_force_and_refused_with_their_bounds_over_any_line() {
    let board = Arc::new(Mutex::new(Obedient::new()));
    let mut feed = Feed::new(Arc::clone(&board));
    let mut client = crate::client::Client::new(&mut feed);
    let mut set = |settings| {
        client.request(Command::Set {
            settings,
            keep: true,
        })
    };
    assert!(
        !set(Settings {
            stride_s: 0.5,
            ..Settings::DEFAULT
        })
        .unwrap()
    );
    let refused = set(Settings {
        harmonics: 9,
        ..Settings::DEFAULT
    })
    .unwrap_err();
    assert!(refused.is::<crate::usage::UsageError>());
    assert!(
        refused.to_string().contains("harmonics = 9")
            && refused.to_string().contains("from 1 to 5"),
        "{refused}"
    );
    assert!(!client.request(Command::Forget).unwrap());
    assert_eq!(board.lock().unwrap().board.in_force().0, Settings::DEFAULT);
}

#[test]
fn bytes_are_recorded_as_they_arrive_and_a_cut_off_frame_is_ended() {
    #[derive(Clone, Default)]
    struct Kept(Arc<Mutex<Vec<u8>>>);
    impl Write for Kept {
        fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
            self.0.lock().unwrap().extend_from_slice(bytes);
            Ok(bytes.len())
        }

        fn flush(&mut self) -> std::io::Result<()> {
            Ok(())
        }
    }
    let mut board = Obedient::new();
    board.emit(packet(0, 5).event);
    let Some(FeedEvent::Data(frame)) = board.outgoing.pop_front() else {
        panic!("no bytes")
    };
    let disconnected = FeedEvent::Disconnected("here".into(), "unplugged".into());
    board.outgoing.extend([
        FeedEvent::Data(frame.clone()),
        FeedEvent::Data(frame[..4].to_vec()),
        disconnected,
        FeedEvent::Over,
    ]);
    let kept = Kept::default();
    let mut feed = Feed::new(Arc::new(Mutex::new(board))).recorded(Box::new(kept.clone()));
    let mut events = Vec::new();
    while events.last() != Some(&FeedEvent::Over) {
        events.extend(feed.next(Duration::ZERO).unwrap());
    }
    let expected = [
        FeedEvent::Data(packet(1, 5)),
        FeedEvent::Disconnected("here".into(), "unplugged".into()),
        FeedEvent::Over,
    ];
    assert_eq!(events, expected);
    assert_eq!(
        *kept.0.lock().unwrap(),
        [&frame[..], &frame[..4], &[0]].concat()
    );
    assert_eq!((feed.counts().received, feed.counts().damaged), (1, 1));
    assert_eq!(feed.next(Duration::ZERO).unwrap(), None);
}

#[test]
fn packets_come_at_their_time_and_pauses_are_not_waited_out() {
    let begun = Instant::now();
    let after = |ms| begun + Duration::from_millis(ms);
    let mut pace = Pace::new(2.0);
    let mut wait_ms = |t_ms: u64, now_ms: u64| {
        pace.wait(&packet(0, t_ms * 1000), after(now_ms))
            .as_millis()
    };
    assert_eq!(wait_ms(10_000, 0), 0);
    // Half a second of device time takes 250 ms at twice the speed; 100 ms have passed.
    assert_eq!(wait_ms(10_500, 100), 150);
    // A packet that is already late does not wait.
    assert_eq!(wait_ms(10_400, 300), 0);
    // A gap and a restarted board each set a new mark.
    assert_eq!(wait_ms(60_000, 300), 0);
    assert_eq!(wait_ms(61_000, 300), 500);
    assert_eq!(wait_ms(0, 800), 0);
    assert_eq!(wait_ms(200, 800), 100);
}

#[test]
fn another_protocol_is_an_error_that_says_what_to_do() {
    let mut board = Obedient::new();
    let (boot, source) = Default::default();
    let settings = Settings::DEFAULT;
    let hello = Hello {
        protocol: PROTOCOL + 1,
        version: [9, 0, 0],
        frame_rate_hz: 241.14,
        settings,
        source,
        boot,
        t_us: 0,
    };
    board.emit(Event::Hello(hello));
    let error = Feed::new(Arc::new(Mutex::new(board)))
        .next(Duration::ZERO)
        .unwrap_err()
        .to_string();
    assert!(
        error.contains("an obedient board") && error.contains("build both from one version"),
        "{error}"
    );
}
