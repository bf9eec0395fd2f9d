//! Plays a recording at the speed at which it was made.

use crate::digits::seconds;
use ridgetone_proto::telemetry::{Events, Packet};
use std::time::{Duration, Instant};

/// Longest pause between two packets in seconds: a connected board sends something every second.
const PAUSE_MAX_S: f64 = 2.0;

/// Delays packets by their device time.
#[derive(Clone, Copy, Debug)]
pub struct Pace {
    speed: f64,
    /// A device time, and the corresponding wall time.
    mark: Option<(f64, Instant)>,
}

impl Pace {
    /// Plays `speed` seconds of device time per second.
    pub const fn new(speed: f64) -> Self {
        Self { speed, mark: None }
    }

    /// Returns how long a packet must wait: zero if it has no device time, or an earlier one than
    /// previous packets. A gap or a restart of the board sets a new mark.
    pub fn wait(&mut self, packet: &Packet, now: Instant) -> Duration {
        let event = &packet.event;
        // Use the time of greetings too: a touch may come half a second after the start.
        let Some(t_s) = event.dated_us().or(event.made_us()).map(seconds) else {
            return Duration::ZERO;
        };
        let (mark_s, mark) = *self.mark.get_or_insert((t_s, now));
        let passed_s = mark_s + now.saturating_duration_since(mark).as_secs_f64() * self.speed;
        let ahead_s = t_s - passed_s;
        if !(-PAUSE_MAX_S..=PAUSE_MAX_S).contains(&ahead_s) {
            self.mark = Some((t_s, now));
            return Duration::ZERO;
        }
        Duration::try_from_secs_f64((ahead_s / self.speed).max(0.0)).unwrap_or_default()
    }
}
