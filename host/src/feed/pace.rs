//! A recording at the speed at which it was made.

use crate::live::time_s;
use ridgetone_proto::telemetry::Packet;
use std::time::{Duration, Instant};

/// Longest pause between two packets, seconds: a board that is there says something every second.
const PAUSE_MAX_S: f64 = 2.0;

/// Tells when a packet is due by its device time.
#[derive(Clone, Copy, Debug)]
pub struct Pace {
    speed: f64,
    /// A device time, and when it was.
    mark: Option<(f64, Instant)>,
}

impl Pace {
    /// So many seconds of device time in a second.
    pub const fn new(speed: f64) -> Self {
        Self { speed, mark: None }
    }

    /// How long a packet has to wait. One without a time, or with an earlier one than those before it, does not; one behind a
    /// gap or after a restart of the board begins anew.
    pub fn wait(&mut self, packet: &Packet, now: Instant) -> Duration {
        let Some(t_s) = time_s(&packet.event) else { return Duration::ZERO };
        let Some((mark_s, mark)) = self.mark else {
            self.mark = Some((t_s, now));
            return Duration::ZERO;
        };
        let passed_s = mark_s + now.saturating_duration_since(mark).as_secs_f64() * self.speed;
        let ahead_s = t_s - passed_s;
        if !(-PAUSE_MAX_S..=PAUSE_MAX_S).contains(&ahead_s) {
            self.mark = Some((t_s, now));
            return Duration::ZERO;
        }
        Duration::try_from_secs_f64((ahead_s / self.speed).max(0.0)).unwrap_or_default()
    }
}
