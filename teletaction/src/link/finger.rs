//! The finger's end: sends the texture under the finger, and receives the position of the hand.

use super::message::{Body, Message, Receiver};
use super::wavelength::{HandPath, Length};
use crate::stimulus::Texture;
use ridgetone_proto::telemetry::Estimate;
use serde::Serialize;

/// Interval of messages while nothing changes, seconds: it soon repairs a loss and reveals a dead
/// link.
pub const REPEAT_S: f64 = 0.25;

/// Factor by which a new period's standard deviation must be smaller to replace an earlier period
/// that agrees with it.
const MORE_PRECISE: f64 = 0.7;

#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum PeriodBy {
    /// The finger's report: a known speed, or the lags between its channels.
    Finger,
    /// The path of the hand.
    Path,
}

#[derive(Clone, Debug, Default)]
pub struct FingerEnd {
    pub receiver: Receiver,
    run: u32,
    /// True if a robot moves the finger as the hand moves.
    follows: bool,
    /// Run of the stylus' end that the path's positions belong to.
    hand_run: u32,
    path: HandPath,
    reported: Option<Texture>,
    /// Period from the hand's path in a window, and the power in the window.
    by_path: Option<(Length, f32)>,
    number: u32,
    sent_s: Option<f64>,
    /// Latest position of the hand, millimetres.
    pub position_mm: Option<f64>,
}

impl FingerEnd {
    /// Creates a finger's end. `run` is a number that no earlier run used in its messages.
    /// `follows` is true if the finger moves as the hand does, so that [`Self::window`] returns
    /// periods.
    pub fn new(run: u32, follows: bool) -> Self {
        Self {
            run,
            follows,
            ..Self::default()
        }
    }

    pub fn texture(&self) -> Option<Texture> {
        let Some((period, power)) = self.by_path else {
            return self.reported;
        };
        let plain = Texture {
            power,
            ..Texture::new(period.mm as f32)
        };
        let texture = Texture {
            period_mm: period.mm as f32,
            period_sigma_mm: period.sigma_mm as f32,
            ..self.reported.unwrap_or(plain)
        };
        texture.check().is_ok().then_some(texture)
    }

    pub fn period_by(&self) -> Option<PeriodBy> {
        match (self.by_path, self.reported) {
            (Some(_), _) => Some(PeriodBy::Path),
            (None, Some(_)) => Some(PeriodBy::Finger),
            (None, None) => None,
        }
    }

    /// Takes a texture found by the finger; `None` if the finger is silent.
    pub fn found(&mut self, texture: Option<Texture>) {
        (self.reported, self.sent_s) = (texture, None);
        let reported = texture.map(|texture| Length {
            mm: texture.period_mm.into(),
            sigma_mm: texture.period_sigma_mm.into(),
        });
        self.by_path = self
            .by_path
            .filter(|(period, _)| reported.is_some_and(|reported| !period.differs(&reported)));
    }

    /// Takes the estimate of a window that ended at `end_s`. Returns the period from the path of
    /// the hand, if the path yields one.
    pub fn window(&mut self, end_s: f64, estimate: &Estimate) -> Option<Length> {
        let found = self
            .path
            .wavelength(end_s, estimate)
            .filter(|_| self.follows)?;
        let is_new = self.by_path.is_none_or(|(before, _)| {
            before.differs(&found) || found.sigma_mm < MORE_PRECISE * before.sigma_mm
        });
        if is_new {
            let squares = estimate
                .channels
                .iter()
                .map(|channel| channel.amplitude_v.powi(2));
            let power = 0.5 * squares.sum::<f32>() / estimate.channels.len().max(1) as f32;
            (self.by_path, self.sent_s) = (Some((found, power)), None);
        }
        Some(found)
    }

    pub fn due(&mut self, t_s: f64) -> Option<Message> {
        if self.sent_s.is_some_and(|sent_s| t_s - sent_s < REPEAT_S) {
            return None;
        }
        self.sent_s = Some(t_s);
        let number = self.number;
        self.number = number.wrapping_add(1);
        Some(Message {
            run: self.run,
            number,
            t_s,
            body: Body::Texture(self.texture()),
        })
    }

    /// Takes received bytes; returns true if they were used.
    pub fn take(&mut self, t_s: f64, bytes: &[u8]) -> bool {
        match self.receiver.take(bytes) {
            Some(Message {
                run,
                body: Body::Position(position_mm),
                ..
            }) => {
                if run != self.hand_run {
                    // A new run counts positions from a different origin.
                    (self.hand_run, self.path) = (run, HandPath::default());
                }
                self.position_mm = Some(position_mm);
                self.path.push(t_s, position_mm);
                true
            }
            _ => false,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ridgetone_proto::telemetry::{Event, Status, longest_packet};

    /// Estimate of a window with ten cycles in a second, which ends at 2 s.
    fn ten_cycles() -> Estimate {
        let Event::Estimate(mut estimate) = longest_packet().event else {
            panic!("an estimate")
        };
        (estimate.status, estimate.window_s) = (Status::Good, 1.0);
        (estimate.frequency, estimate.sigma) = (10.0, 0.01);
        estimate
    }

    /// Sends positions of a hand at 36 mm/s, starting at `from_s`.
    fn move_hand(end: &mut FingerEnd, run: u32, from_s: f64) {
        for number in 0..500 {
            let t_s = from_s + 0.004 * f64::from(number);
            let body = Body::Position(36.0 * (t_s - from_s));
            let message = Message {
                run,
                number,
                t_s,
                body,
            };
            end.take(t_s, &message.bytes());
        }
    }

    #[test]
    fn a_period_by_the_path_replaces_the_reported_one() {
        let mut end = FingerEnd::new(1, true);
        let reported = |period_mm| Texture {
            period_sigma_mm: 0.26,
            ..Texture::new(period_mm)
        };
        end.found(Some(reported(3.5)));
        assert_eq!(end.period_by(), Some(PeriodBy::Finger));
        move_hand(&mut end, 7, 0.5);
        let found = end.window(2.0, &ten_cycles()).expect("a period");
        assert!((found.mm - 3.6).abs() < 1e-6, "{found:?}");
        let texture = end.texture().expect("a texture");
        assert!((texture.period_mm - 3.6).abs() < 1e-5, "{texture:?}");
        assert_eq!(end.period_by(), Some(PeriodBy::Path));
        // A different texture, which contradicts the period; then silence.
        end.found(Some(reported(2.0)));
        assert_eq!(end.texture().map(|texture| texture.period_mm), Some(2.0));
        end.window(2.0, &ten_cycles());
        end.found(None);
        assert_eq!((end.texture(), end.period_by()), (None, None));
    }

    #[test]
    fn a_finger_that_follows_nobody_and_a_new_run_give_no_period() {
        let mut alone = FingerEnd::new(1, false);
        move_hand(&mut alone, 7, 0.5);
        let mut end = FingerEnd::new(1, true);
        move_hand(&mut end, 7, -0.5);
        // The stylus' end restarts in the middle of the window, and counts from 0.
        move_hand(&mut end, 8, 1.5);
        for mut end in [alone, end] {
            assert_eq!(end.window(2.0, &ten_cycles()), None);
        }
    }
}
