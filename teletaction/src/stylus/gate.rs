//! Decides when the stylus may vibrate: it has a texture, it is enabled, the line is alive, and the
//! hand moves.

use serde::{Deserialize, Serialize};

/// Minimum movement of the hand, counts: an encoder that rests on an edge jitters by one count.
const MOVED_COUNTS: u32 = 2;

/// State of the stylus, including the reason why it is idle.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum State {
    /// Idle: not enabled since start-up, or disabled.
    #[default]
    Disabled,
    /// Idle: the line was silent. The stylus must be enabled again.
    LineSilent,
    /// Enabled, but idle: there is no texture.
    NoTexture,
    /// Enabled, but idle: the hand has left or does not move.
    HandStill,
    Vibrating,
}

/// Decides sample by sample.
#[derive(Clone, Copy, Debug)]
pub struct Gate {
    /// Samples without movement, and without a request, after which the stylus stops.
    still: u32,
    silence: u32,
    /// Samples left until the stylus stops: first if the hand is still, second if the line is
    /// silent.
    still_left: u32,
    silence_left: u32,
    /// Counts at the last movement; `None` before the first sample.
    anchor: Option<i32>,
    has_texture: bool,
    is_enabled: bool,
    was_silenced: bool,
}

impl Gate {
    /// Creates a gate that is disabled and has no texture. The stylus stops after `still` samples
    /// without movement, or `silence` samples without a request.
    pub const fn new(still: u32, silence: u32) -> Self {
        Self {
            still,
            silence,
            still_left: 0,
            silence_left: 0,
            anchor: None,
            has_texture: false,
            is_enabled: false,
            was_silenced: false,
        }
    }

    /// Takes note of a complete request.
    pub fn heard(&mut self) {
        self.silence_left = self.silence;
    }

    pub fn textured(&mut self) {
        self.has_texture = true;
    }

    /// Enables or disables vibration on request, which also shows that the line is alive.
    pub fn enable(&mut self, is_enabled: bool) {
        (self.is_enabled, self.was_silenced) = (is_enabled, false);
        self.heard();
    }

    pub fn step(&mut self, counts: i32) {
        let anchor = *self.anchor.get_or_insert(counts);
        if counts.wrapping_sub(anchor).unsigned_abs() >= MOVED_COUNTS {
            (self.anchor, self.still_left) = (Some(counts), self.still);
        } else {
            self.still_left = self.still_left.saturating_sub(1);
        }
        self.silence_left = self.silence_left.saturating_sub(1);
        if self.silence_left == 0 && self.is_enabled {
            (self.is_enabled, self.was_silenced) = (false, true);
        }
    }

    pub const fn state(&self) -> State {
        match (self.is_enabled, self.was_silenced) {
            (false, true) => State::LineSilent,
            (false, false) => State::Disabled,
            _ if !self.has_texture => State::NoTexture,
            _ if self.still_left == 0 => State::HandStill,
            _ => State::Vibrating,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Tests that the gate opens only if all conditions are met, that a still hand closes it, and
    /// that a silent line closes it until it is enabled again.
    #[test]
    fn it_vibrates_only_when_all_is_there() {
        // 100 samples without movement, 300 without a request.
        let mut gate = Gate::new(100, 300);
        gate.step(0);
        assert_eq!(gate.state(), State::Disabled);
        gate.enable(true);
        gate.step(5);
        assert_eq!(gate.state(), State::NoTexture);
        gate.textured();
        gate.enable(false);
        assert_eq!(gate.state(), State::Disabled);
        gate.enable(true);
        gate.step(10);
        // Jitter on an edge is not a movement.
        for n in 0..100 {
            assert_eq!(gate.state(), State::Vibrating, "{n}");
            gate.step(10 + n % 2);
        }
        assert_eq!(gate.state(), State::HandStill);
        gate.heard();
        for n in 0..300 {
            gate.step(-5 * n);
            let state = if n < 299 {
                State::Vibrating
            } else {
                State::LineSilent
            };
            assert_eq!(gate.state(), state, "{n}");
        }
        gate.heard();
        gate.step(0);
        assert_eq!(gate.state(), State::LineSilent, "until it is enabled");
        gate.enable(true);
        gate.step(5);
        assert_eq!(gate.state(), State::Vibrating);
    }
}
