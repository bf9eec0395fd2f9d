//! The finger's end: sends the texture under the finger, and takes the position of the hand.

use super::message::{Body, Message, Receiver};
use super::wavelength::{HandPath, Length};
use crate::stimulus::Texture;
use ridgetone_proto::telemetry::Estimate;
use serde::Serialize;

/// Time between two messages if nothing changes, seconds: a loss is soon made up for, and a dead
/// link is noticed.
pub const REPEAT_S: f64 = 0.25;

/// A new window replaces the period of an earlier one if its standard deviation is smaller by this
/// factor, even if the periods agree.
const MORE_PRECISE: f64 = 0.7;

/// Origin of the period.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum PeriodBy {
    /// The finger's own report: a known speed, or the lags between its channels.
    Finger,
    /// The path of the hand.
    Path,
}

#[derive(Clone, Debug, Default)]
pub struct FingerEnd {
    pub receiver: Receiver,
    run: u32,
    /// A robot moves the finger as the hand moves.
    follows: bool,
    path: HandPath,
    /// Latest texture that the finger has reported.
    reported: Option<Texture>,
    /// Period by the path of the hand, and the power of that window.
    by_path: Option<(Length, f32)>,
    number: u32,
    sent_s: Option<f64>,
    /// Latest position of the hand, millimetres.
    pub position_mm: Option<f64>,
}

impl FingerEnd {
    /// `run`: a number that the messages of an earlier run do not have. `follows`: the finger moves
    /// as the hand does, so that [`Self::window`] gives periods.
    pub fn new(run: u32, follows: bool) -> Self {
        Self {
            run,
            follows,
            ..Self::default()
        }
    }

    /// The texture under the finger.
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

    /// The finger has found a texture, or is silent.
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

    /// A window has ended at `end_s`. Gives the period by the path of the hand, if it has one.
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

    /// The message that is due.
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

    /// Takes bytes that have arrived; gives whether they were used.
    pub fn take(&mut self, t_s: f64, bytes: &[u8]) -> bool {
        match self.receiver.take(bytes) {
            Some(Message {
                body: Body::Position(position_mm),
                ..
            }) => {
                self.position_mm = Some(position_mm);
                self.path.push(t_s, position_mm);
                true
            }
            _ => false,
        }
    }
}
