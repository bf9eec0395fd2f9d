//! Both ends of a link, with one report per second.

use super::board::{BoardEnd, Doing};
use super::finger::{FingerEnd, PeriodBy};
use super::message::Counts;
use super::network::Network;
use super::socket::Socket;
use crate::stimulus::Delay;
use crate::texture::{Follower, News};
use anyhow::Result;
use ridgetone_host::digits::plus_minus;
use ridgetone_host::names::name;
use ridgetone_host::note;
use ridgetone_host::{output, stop};
use serde::Serialize;
use std::time::{Duration, Instant};

const STEP: Duration = Duration::from_millis(1);

const REPORT_S: f64 = 1.0;

/// Maximum time to wait for a stylus' board to rest at the end.
const REST: Duration = Duration::from_millis(500);

pub enum Ends {
    /// Both ends here, with the simulated network between them.
    Here,
    /// The stylus is on a different computer.
    Finger(Socket),
    /// The finger is on a different computer.
    Stylus(Socket),
}

/// Settings of the network, per direction.
#[derive(Clone, Copy, Debug)]
pub struct Options {
    /// Mean delay, milliseconds.
    pub delay_ms: f64,
    /// Standard deviation of the delay, milliseconds.
    pub jitter_ms: f64,
    /// Fraction of messages lost, 0 to 1.
    pub loss: f64,
    pub seed: u64,
    /// A number that no earlier run used in its messages.
    pub run: u32,
    /// True if a robot moves the finger as the hand moves.
    pub follows: bool,
}

/// A finger's end, a stylus' end, and a network in each direction.
pub struct Link {
    pub finger: FingerEnd,
    /// `None` if the finger is on another computer.
    pub stylus: Option<BoardEnd>,
    pub to_finger: Network,
    pub to_stylus: Network,
    ends: Ends,
    t_s: f64,
}

/// Report on one second: counts since the start, and errors in this second.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(tag = "type", rename = "link")]
pub struct Report {
    pub t_s: f64,
    /// Position messages sent here, and received here.
    pub positions_sent: u64,
    pub positions: Counts,
    /// Texture messages sent here, and received here.
    pub textures_sent: u64,
    pub textures: Counts,
    pub is_felt: bool,
    /// `None` if the finger is on another computer.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stylus: Option<Doing>,
    /// Period of the felt texture.
    pub period_mm: Option<f32>,
    pub period_sigma_mm: Option<f32>,
    /// Origin of the period; `None` if the finger is on another computer.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub period_by: Option<PeriodBy>,
    /// Distance between the hand and the position known to the finger.
    pub behind_mm: Option<f64>,
    /// Error of the stimulus against the texture under the finger at the hand's position, RMS
    /// relative to the amplitude.
    pub error_percent: Option<f64>,
    /// Error that a transmitted vibration would have.
    pub as_vibration_percent: Option<f64>,
}

impl Link {
    /// Creates a link; `stylus` is the local stylus, if any.
    pub fn new(options: &Options, ends: Ends, stylus: Option<BoardEnd>) -> Result<Self> {
        let [mean_s, sigma_s] = [options.delay_ms, options.jitter_ms].map(|ms| (ms / 1e3) as f32);
        let delay = |seed: u64| Delay::new(mean_s, sigma_s, seed as u32);
        let network = |seed: u64| anyhow::Ok(Network::new(delay(seed)?, options.loss, seed));
        Ok(Self {
            finger: FingerEnd::new(options.run, options.follows),
            stylus,
            to_finger: network(2 * options.seed)?,
            to_stylus: network(2 * options.seed + 1)?,
            ends,
            t_s: 0.0,
        })
    }

    /// Sends and receives all messages up to `t_s`, seconds. Times must not decrease.
    pub fn step(&mut self, t_s: f64) -> Result<()> {
        self.t_s = t_s;
        let Self {
            finger,
            stylus,
            to_finger,
            to_stylus,
            ends,
            ..
        } = self;
        if let Some(stylus) = stylus {
            // The state of a remote finger is unknown.
            let found = match ends {
                Ends::Here => finger.texture(),
                _ => stylus.texture(),
            };
            stylus.step(t_s, found)?;
            while let Some(message) = stylus.due() {
                to_finger.send(message.t_s, message.bytes());
            }
        }
        let mut felt = |bytes: &[u8]| {
            if let Some(stylus) = stylus {
                stylus.take(t_s, bytes);
            }
        };
        if !matches!(ends, Ends::Stylus(_))
            && let Some(message) = finger.due(t_s)
        {
            to_stylus.send(t_s, message.bytes());
        }
        while let Some(bytes) = to_finger.arrived(t_s) {
            match ends {
                Ends::Stylus(socket) => socket.send(&bytes),
                _ => drop(finger.take(t_s, &bytes)),
            }
        }
        while let Some(bytes) = to_stylus.arrived(t_s) {
            match ends {
                Ends::Finger(socket) => socket.send(&bytes),
                _ => felt(&bytes),
            }
        }
        match ends {
            Ends::Here => {}
            Ends::Finger(socket) => {
                while let Some((bytes, from)) = socket.receive()? {
                    if finger.take(t_s, &bytes) {
                        socket.answer(from);
                    }
                }
            }
            Ends::Stylus(socket) => {
                while let Some((bytes, _)) = socket.receive()? {
                    felt(&bytes);
                }
            }
        }
        Ok(())
    }

    /// Stops a local board softly, instead of leaving it to its silence timeout.
    pub fn stop_softly(&mut self) {
        let (begun, Some(stylus)) = (Instant::now(), &mut self.stylus) else {
            return;
        };
        while !stylus.stop_softly() && begun.elapsed() < REST {
            std::thread::sleep(STEP);
            let t_s = self.t_s + begun.elapsed().as_secs_f64();
            if stylus.step(t_s, None).is_err() {
                break;
            }
        }
    }

    /// Reports on the time since the previous report.
    pub fn report(&mut self, t_s: f64) -> Report {
        let mut stylus = self.stylus.as_mut();
        let simulated = stylus.as_mut().and_then(|stylus| stylus.simulated());
        let error = simulated.and_then(|stylus| std::mem::take(&mut stylus.error).percent());
        let stylus = stylus.as_deref();
        let texture = stylus.map_or_else(|| self.finger.texture(), BoardEnd::texture);
        let behind = self
            .finger
            .position_mm
            .zip(stylus.and_then(BoardEnd::position_mm));
        Report {
            t_s,
            positions_sent: self.to_finger.sent,
            positions: self.finger.receiver.counts,
            textures_sent: self.to_stylus.sent,
            textures: stylus.map_or_else(Counts::default, |stylus| stylus.receiver.counts),
            is_felt: stylus.is_some_and(BoardEnd::is_felt),
            period_mm: texture.map(|texture| texture.period_mm),
            period_sigma_mm: texture.map(|texture| texture.period_sigma_mm),
            period_by: self.finger.period_by().filter(|_| texture.is_some()),
            behind_mm: behind.map(|(mm, hand_mm)| (mm - hand_mm).abs()),
            stylus: stylus.map(BoardEnd::doing),
            error_percent: error.map(|(percent, _)| percent),
            as_vibration_percent: error.map(|(_, percent)| percent),
        }
    }
}

impl Report {
    pub fn text(&self) -> String {
        let way = |way: &str, sent: u64, counts: &Counts| {
            format!(
                "{way} {sent} sent, {} received, {} lost, {} late, {} duplicated, {} damaged",
                counts.received, counts.lost, counts.late, counts.doubled, counts.damaged
            )
        };
        let texture = match self.period_mm.zip(self.period_sigma_mm) {
            Some((period, sigma)) => {
                let by = match self.period_by {
                    Some(PeriodBy::Path) => " mm by the hand's path",
                    _ => " mm",
                };
                plus_minus(period.into(), sigma.into()) + by
            }
            None => "no texture yet".into(),
        };
        let error = match (self.error_percent, self.as_vibration_percent) {
            (Some(percent), Some(late)) => format!(
                "stimulus error: {percent:.2} % of amplitude (a transmitted vibration: {late:.0} %)"
            ),
            _ if self.is_felt => "vibration on".into(),
            _ => "no vibration".into(),
        };
        let stylus = self.stylus.map_or(String::new(), |stylus| {
            format!(
                "\n           stylus {}; {} samples late, {} packets lost, {} damaged, silent {} times",
                stylus.state.map_or("silent", name),
                stylus.deadlines_missed,
                stylus.packets_lost,
                stylus.packets_damaged,
                stylus.silences
            )
        });
        let behind = self.behind_mm.map_or(String::new(), |mm| {
            format!("; hand position at the finger: {mm:.1} mm error")
        });
        format!(
            "{:7.1} s  {}{behind}\n           {}\n           {texture}; {error}{stylus}",
            self.t_s,
            way("positions  ", self.positions_sent, &self.positions),
            way("textures", self.textures_sent, &self.textures),
        )
    }
}

/// Waits up to one step for news of the finger. Returns true if its feed continues.
fn take(finger: &mut Follower, end: &mut FingerEnd, begun: Instant) -> Result<bool> {
    match finger.next(STEP)? {
        Some(News::Texture(texture)) => end.found(Some(texture)),
        Some(News::Disconnected(name, why)) => {
            note!("{name}: {why}; waiting for the board");
            end.found(None);
        }
        Some(News::Window(estimate, age)) => {
            let end_s = begun.elapsed().saturating_sub(age).as_secs_f64();
            end.window(end_s, &estimate);
        }
        Some(News::Silent) => end.found(None),
        Some(News::Over) => return Ok(false),
        Some(News::Back) | None => {}
    }
    Ok(true)
}

/// Runs the link in real time for `seconds`, or until the local finger's recording ends or the
/// process is interrupted.
pub fn run(
    finger: &mut Option<Follower>,
    link: &mut Link,
    json: bool,
    seconds: Option<f64>,
) -> Result<()> {
    let (begun, mut reported_s) = (Instant::now(), 0.0);
    let mut goes_on = true;
    while goes_on && !stop::is_requested() {
        match finger {
            None => std::thread::sleep(STEP),
            Some(finger) => match take(finger, &mut link.finger, begun) {
                // Ctrl-C also reaches the emulator, which may end first.
                Err(_) if stop::is_requested() => break,
                stepped => goes_on = stepped?,
            },
        }
        let t_s = begun.elapsed().as_secs_f64();
        link.step(t_s)?;
        goes_on &= seconds.is_none_or(|seconds| t_s < seconds);
        if t_s - reported_s >= REPORT_S || !goes_on {
            reported_s = t_s;
            let report = link.report(t_s);
            output::line(&if json {
                serde_json::to_string(&report)?
            } else {
                report.text()
            })?;
        }
    }
    Ok(())
}
