//! A speed profile: speeds over the surface at some device times, with straight lines in between.
//! A board gets it as the odometry of a robot that moves so.

use crate::odometry::{Robot, SPEED_COLUMN, check, message};
use anyhow::{Context, Result, bail, ensure};
use hal_mock::Table;
use ridgetone_proto::odometry::{FRAME_BYTES, Odometry};
use ridgetone_proto::telemetry::{Event, Packet};
use std::path::Path;
use std::time::Duration;

/// Time from one message to the next, microseconds: 250 a second, as often as a board takes them.
const STEP_US: u64 = 4000;

/// Time over which the quickest packet counts that says what time it is on the board. Clocks drift
/// apart by less than a millisecond meanwhile.
const CLOCK: Duration = Duration::from_secs(10);

/// A speed at a time, and the place where that leads.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Knot {
    t_s: f64,
    speed_mm_s: f64,
    place_mm: f64,
}

/// A speed profile.
#[derive(Clone, Debug, PartialEq)]
pub struct Profile {
    /// In the order of time; at least one.
    knots: Vec<Knot>,
    repeats: bool,
}

impl Profile {
    /// Reads a table with the columns `time_s` (device time) and `speed_mm_s`. The first speed
    /// holds before the first row. After the last row its speed goes on, or the profile repeats:
    /// then the last row is the first one of the next round.
    pub fn load(path: &Path, repeats: bool) -> Result<Self> {
        let table = Table::load(path)?;
        let file = table.file();
        let Some(column) = table.names().iter().position(|name| name == SPEED_COLUMN) else {
            bail!(
                "{file}: no column {SPEED_COLUMN}; there are: {}",
                table.names().join(", ")
            );
        };
        let Some(time_s) = table.time_s() else {
            bail!("{file}: no column time_s")
        };
        let mut speeds = Vec::new();
        for (t_s, row) in time_s.iter().zip(table.rows()) {
            ensure!(*t_s >= 0.0, "{file}: time_s {t_s}: choose 0 or later");
            ensure!(
                !row[column].is_nan(),
                "{file}: time_s {t_s}: no {SPEED_COLUMN}"
            );
            check(row[column], false, file, *t_s)?;
            speeds.push((*t_s, row[column]));
        }
        Self::new(&speeds, repeats).with_context(|| file.to_owned())
    }

    /// A profile of times, seconds, in their order, and speeds, millimetres per second.
    pub fn new(speeds: &[(f64, f64)], repeats: bool) -> Result<Self> {
        let least = if repeats { 2 } else { 1 };
        ensure!(
            speeds.len() >= least,
            "a speed profile needs a row, and two to repeat; there are {}",
            speeds.len()
        );
        let mut knots: Vec<Knot> = Vec::with_capacity(speeds.len());
        for (t_s, speed_mm_s) in speeds.iter().copied() {
            let place_mm = match knots.last() {
                None => 0.0,
                Some(last) => {
                    ensure!(t_s > last.t_s, "time_s {t_s} does not increase");
                    last.place_mm + 0.5 * (last.speed_mm_s + speed_mm_s) * (t_s - last.t_s)
                }
            };
            knots.push(Knot {
                t_s,
                speed_mm_s,
                place_mm,
            });
        }
        Ok(Self { knots, repeats })
    }

    /// Place at a device time, millimetres from that of the first row.
    pub fn place_mm(&self, t_s: f64) -> f64 {
        let (first, last) = (self.knots[0], self.knots[self.knots.len() - 1]);
        let (mut t_s, mut before_mm) = (t_s, 0.0);
        if self.repeats {
            let round_s = last.t_s - first.t_s;
            let rounds = ((t_s - first.t_s) / round_s).floor();
            t_s -= rounds * round_s;
            before_mm = rounds * last.place_mm;
        }
        let next = self.knots.partition_point(|knot| knot.t_s <= t_s);
        let from = self.knots[next.saturating_sub(1)];
        let since_s = t_s - from.t_s;
        let slope = match self.knots.get(next) {
            Some(to) if next > 0 => (to.speed_mm_s - from.speed_mm_s) / (to.t_s - from.t_s),
            _ => 0.0,
        };
        before_mm + from.place_mm + since_s * (from.speed_mm_s + 0.5 * slope * since_s)
    }

    /// Device time of the last row, unless the profile repeats or is a single steady speed.
    fn end_s(&self) -> Option<f64> {
        let last = self.knots.last()?;
        (!self.repeats && self.knots.len() > 1).then_some(last.t_s)
    }

    /// The messages of a robot that shares the board's clock: device time, microseconds, and the
    /// frame, stuffed and without its zero.
    pub fn messages(self) -> impl Iterator<Item = (u64, Vec<u8>)> {
        (0u64..)
            .step_by(STEP_US as usize)
            .enumerate()
            .map(move |(number, t_us)| {
                let t_s = t_us as f64 * 1e-6;
                (
                    t_us,
                    self.message(number, t_s, t_s).encode()[..FRAME_BYTES].to_vec(),
                )
            })
    }

    fn message(&self, number: usize, stamp_s: f64, t_s: f64) -> Odometry {
        message(number, stamp_s, self.place_mm(t_s), true)
    }
}

/// Plays a profile to a board as it is due. The board's packets say what time it is there, so places
/// are late by what the quickest packet takes, mostly a few milliseconds. That changes a period only
/// while the speed changes.
pub struct Player {
    profile: Profile,
    number: usize,
    due: Duration,
    /// Time at which the board's time was zero, by the quickest packets: in this [`CLOCK`] and in
    /// the one before it. Infinite without any.
    zeros_s: [f64; 2],
    clock_begun: Duration,
    has_ended: bool,
}

impl Player {
    pub fn new(profile: Profile) -> Self {
        Self {
            profile,
            number: 0,
            due: Duration::ZERO,
            zeros_s: [f64::INFINITY; 2],
            clock_begun: Duration::ZERO,
            has_ended: false,
        }
    }
}

impl Robot for Player {
    fn hear(&mut self, packet: &Packet, now: Duration) {
        if let Event::Hello(_) = packet.event {
            // The board may have started again.
            self.zeros_s = [f64::INFINITY; 2];
        }
        if now.saturating_sub(self.clock_begun) > CLOCK {
            self.zeros_s = [f64::INFINITY, self.zeros_s[0]];
            self.clock_begun = now;
        }
        if let Some(t_us) = packet.event.t_us() {
            let zero_s = now.as_secs_f64() - t_us as f64 * 1e-6;
            self.zeros_s[0] = self.zeros_s[0].min(zero_s);
        }
    }

    fn next(&mut self, now: Duration) -> Option<Vec<u8>> {
        let zero_s = self.zeros_s[0].min(self.zeros_s[1]);
        if now < self.due || zero_s.is_infinite() || self.has_ended {
            return None;
        }
        let now_s = now.as_secs_f64();
        let t_s = now_s - zero_s;
        if self.profile.end_s().is_some_and(|end_s| t_s > end_s) {
            self.has_ended = true;
            return None;
        }
        let message = self.profile.message(self.number, now_s, t_s);
        self.number += 1;
        self.due = now + Duration::from_micros(STEP_US);
        Some(message.encode().to_vec())
    }

    fn has_ended(&self) -> bool {
        self.has_ended
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ridgetone_proto::telemetry::{Contact, Health};
    use std::f64::consts::TAU;

    /// Midpoint sums of the speed, which are exact for straight lines.
    #[test]
    fn between_the_rows_it_is_the_integral() {
        let profile = Profile::new(&[(0.001, 10.0), (0.501, 30.0), (1.501, -5.0)], false).unwrap();
        let speed_mm_s = |t_s: f64| match t_s {
            t if t < 0.001 => 10.0,
            t if t < 0.501 => 10.0 + 20.0 * (t - 0.001) / 0.5,
            t if t < 1.501 => 30.0 - 35.0 * (t - 0.501),
            _ => -5.0,
        };
        let mut place_mm = profile.place_mm(0.0);
        assert!((place_mm + 0.01).abs() < 1e-12);
        for ms in 0..2000 {
            place_mm += speed_mm_s((f64::from(ms) + 0.5) * 1e-3) * 1e-3;
            let off_mm = profile.place_mm(f64::from(ms + 1) * 1e-3) - place_mm;
            assert!(off_mm.abs() < 1e-9, "{ms}: {off_mm}");
        }
    }

    /// However late, places are as exact as in the first round, and so are those across the seam.
    #[test]
    fn rounds_follow_each_other_without_a_seam() {
        let profile = Profile::new(&[(0.5, 20.0), (1.5, 40.0)], true).unwrap();
        // 30 mm a round, by the closed form from the place of the first row.
        for t_s in [0.0, 0.499, 0.5, 1.0, 1.499_999, 1.5, 2.25, 3600.75, 1e6] {
            let since_s = t_s - 0.5;
            let (rounds, s) = (f64::floor(since_s), since_s - f64::floor(since_s));
            let expected_mm = 30.0 * rounds + 20.0 * s + 10.0 * s * s;
            let off_mm = profile.place_mm(t_s) - expected_mm;
            assert!(off_mm.abs() < 1e-6, "{t_s}: {off_mm}");
        }
    }

    /// One round of a hand that goes to and fro. The chords of a sine of n rows a turn lie below it
    /// by (2 pi / n)^2 / 12 on average.
    #[test]
    fn a_hands_place_is_the_closed_form_to_what_the_chords_leave() {
        const ROWS: u32 = 31;
        let rows: Vec<_> = (0..=ROWS)
            .map(|row| {
                let turns = f64::from(row) / f64::from(ROWS);
                (turns / 1.07, 197.0 * (TAU * turns).sin())
            })
            .collect();
        let profile = Profile::new(&rows, true).unwrap();
        let chord = (TAU / f64::from(ROWS)).powi(2) / 12.0;
        let reach_mm = 197.0 / (TAU * 1.07);
        let worst_mm = (0..5000).fold(0f64, |worst, ms| {
            let t_s = f64::from(ms) * 1e-3;
            let closed_mm = reach_mm * (1.0 - (TAU * 1.07 * t_s).cos());
            worst.max((profile.place_mm(t_s) - closed_mm).abs())
        });
        let most_mm = 2.0 * reach_mm * chord;
        assert!(
            (0.5 * most_mm..1.1 * most_mm).contains(&worst_mm),
            "{worst_mm} mm"
        );
    }

    #[test]
    fn one_row_is_a_steady_speed() {
        let profile = Profile::new(&[(0.007, 15.0)], false).unwrap();
        for t_s in [0.0, 0.007, 1.0, 3600.0] {
            assert!((profile.place_mm(t_s + 4.0) - profile.place_mm(t_s) - 60.0).abs() < 1e-8);
        }
        assert_eq!(profile.end_s(), None);
    }

    #[test]
    fn what_is_wrong_is_named() {
        for (speeds, repeats, why) in [
            (&[][..], false, "needs a row"),
            (&[(0.0, 1.0)][..], true, "two to repeat"),
            (
                &[(0.0, 1.0), (5.0, 1.0), (5.0, 1.0)][..],
                false,
                "time_s 5 does not increase",
            ),
        ] {
            let error = format!("{:#}", Profile::new(speeds, repeats).unwrap_err());
            assert!(error.contains(why), "{error}");
        }
    }

    /// Messages begin with the first packet that says the board's time, carry the places of that
    /// time, and end with the last row.
    #[test]
    fn a_player_keeps_the_boards_time_and_ends_with_the_file() {
        let profile = Profile::new(&[(0.0, 1000.0), (100.05, 1000.0)], false).unwrap();
        let mut player = Player::new(profile);
        let mut now = Duration::from_secs(7);
        assert_eq!(player.next(now), None);
        let packet = |event| Packet { sequence: 0, event };
        let contact = Contact {
            t_us: 90_000_000,
            taxel: 0,
            height_v: 0.0,
            onset_us: 0,
        };
        // A contact was ten seconds ago, as health says right after it.
        player.hear(&packet(Event::Contact(contact)), now);
        let health = packet(Event::Health(Health {
            t_us: 100_000_000,
            ..Health::default()
        }));
        player.hear(&health, now);
        let mut wire = player.next(now).expect("a message");
        assert_eq!(wire.pop(), Some(0));
        let message = Odometry::decode(&mut wire).expect("a message");
        let ridgetone_proto::odometry::Reading::Place(place) = message.reading else {
            panic!("{message:?}")
        };
        // One millimetre a millisecond.
        let t_s = f64::from(place) * 1e-4 / 1000.0;
        assert!((t_s - 100.0).abs() < 1e-6, "{t_s}");
        while !player.has_ended() {
            now += Duration::from_millis(1);
            player.next(now);
        }
        // The 50 ms that the file still has, in steps of 4 ms.
        assert_eq!(player.number, 13);
    }
}
