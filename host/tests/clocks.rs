//! Two simulated boards whose clocks run differently, in real time on one computer, recorded and exported: their messages agree in
//! UTC.

mod common;

use anyhow::Result;
use common::{directory, run, stderr, text};
use ridgetone_host::feed::{Feed, FeedEvent, Source};
use ridgetone_host::input::Input;
use ridgetone_host::{recording, replay};
use ridgetone_proto::settings::Settings;
use ridgetone_proto::telemetry::{Event, Packet, WIRE_MAX, encode};
use std::collections::VecDeque;
use std::path::Path;
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

/// What a board sends in one touch, with every frame; each with the board's time at which it sends it, seconds.
fn telemetry() -> VecDeque<(f64, Vec<u8>)> {
    let mut pipeline = Box::new(ridgetone::pipeline::Pipeline::new(Settings::DEFAULT));
    pipeline.report_raw(u32::MAX);
    let (mut sent, mut first_us, mut sequence) = (VecDeque::new(), None, 0);
    let mut send = |now_s: f64, event: Event| {
        let mut wire = [0; WIRE_MAX];
        let used = encode(&Packet { sequence, event }, &mut wire).expect("it fits");
        sequence = sequence.wrapping_add(1);
        sent.push_back((now_s, wire[..used].to_vec()));
    };
    send(0.0, pipeline.hello());
    let mut take = |timed: ridgetone::frame::TimedConversion| {
        let now_s = f64::from(timed.t_us - *first_us.get_or_insert(timed.t_us)) * 1e-6;
        pipeline.push(timed, &mut |event| send(now_s, event));
        Ok(())
    };
    replay::conversions(Input::default().open().expect("a scene"), &mut take).expect("a run");
    sent
}

/// A board whose clock runs at `pace` and was 0 at `begun`.
struct Board {
    pace: f64,
    begun: Instant,
    sent: VecDeque<(f64, Vec<u8>)>,
}

impl Source for Board {
    fn name(&self) -> String {
        format!("a board at {}", self.pace)
    }

    fn next(&mut self, most: Duration) -> Result<Option<FeedEvent<Vec<u8>>>> {
        let Some((due_s, _)) = self.sent.front() else { return Ok(Some(FeedEvent::Over)) };
        let wait = (self.begun + Duration::from_secs_f64(due_s / self.pace)).saturating_duration_since(Instant::now());
        std::thread::sleep(wait.min(most));
        Ok((wait <= most).then(|| self.sent.pop_front()).flatten().map(|(_, bytes)| FeedEvent::Data(bytes)))
    }

    fn send(&mut self, _: &[u8]) -> Result<()> {
        Ok(())
    }
}

/// Records a board, and gives for each contact, slide and release of the export its time after UTC, by the board's own pace.
fn off_s(folder: &Path, pace: f64) -> Vec<f64> {
    let path = folder.join(format!("{pace}.rec"));
    let (begun, zero) = (Instant::now(), SystemTime::now().duration_since(UNIX_EPOCH).expect("a clock"));
    let file = recording::create(&path, "a test", 0.0).expect("a file");
    let mut feed = Feed::new(Board { pace, begun, sent: telemetry() }).recorded(Box::new(file));
    while feed.next(Duration::from_secs(1)).expect("a packet") != Some(FeedEvent::Over) {}
    drop(feed);
    let mcap = path.with_extension("mcap");
    let exported = run(&["export", text(&path), "-o", text(&mcap)]);
    assert!(exported.status.success() && stderr(&exported).contains("0 lost, 0 damaged"), "{}", stderr(&exported));
    let bytes = std::fs::read(&mcap).expect("a file");
    let mut off_s = Vec::new();
    for message in mcap::MessageStream::new(&bytes).expect("MCAP") {
        let message = message.expect("a message");
        let object: serde_json::Value = serde_json::from_slice(&message.data).expect("JSON");
        if ["contact", "slide", "release"].map(|kind| format!("/ridgetone/{kind}")).contains(&message.channel.topic) {
            let t_s = object["t_s"].as_f64().expect("a time");
            let late_s = (message.log_time as i128 - zero.as_nanos() as i128) as f64 * 1e-9 - t_s / pace;
            assert!(message.publish_time >= message.log_time);
            let sigma_s = object["utc_sigma_s"].as_f64().expect("its uncertainty");
            assert!(late_s.abs() < 1e-3 && sigma_s < 2e-3, "{pace}: {late_s} +- {sigma_s} s");
            off_s.push(late_s);
        }
        let utc_s = object["utc_s"].as_f64();
        assert!(utc_s.is_none_or(|utc_s| (utc_s - message.log_time as f64 * 1e-9).abs() < 1e-6), "{object}");
    }
    off_s
}

#[test]
fn two_boards_of_skewed_clocks_agree_within_a_millisecond() {
    let folder = directory();
    // 200 ppm fast and slow: at the end of a touch they would be 2 ms apart.
    let boards = std::thread::scope(|scope| {
        let board = |pace| {
            scope.spawn({
                let folder = folder.path();
                move || off_s(folder, pace)
            })
        };
        [1.0002, 0.9998].map(board).map(|board| board.join().expect("a board"))
    });
    assert_eq!(boards[0].len(), 4);
    for (one, other) in boards[0].iter().zip(&boards[1]) {
        println!("{one:.6} and {other:.6} s after UTC");
        assert!((one - other).abs() < 1e-3, "{one} and {other} s");
    }
}
