//! The finger's end: sends the texture under it, and takes the place of the hand.

use super::message::{Body, Message, Receiver};
use ridgetone_stimulus::Texture;

/// Time between two messages if nothing changes, seconds: what is lost is soon made up for, and a
/// dead link is known.
pub const REPEAT_S: f64 = 0.25;

#[derive(Clone, Debug, Default)]
pub struct FingerEnd {
    pub receiver: Receiver,
    run: u32,
    texture: Option<Texture>,
    number: u32,
    sent_s: Option<f64>,
    /// Latest place of the hand, millimetres.
    pub place_mm: Option<f64>,
}

impl FingerEnd {
    /// `run`: a number that the messages of an earlier run do not have.
    pub fn new(run: u32) -> Self {
        Self {
            run,
            ..Self::default()
        }
    }

    pub fn texture(&self) -> Option<Texture> {
        self.texture
    }

    /// The finger has found a texture, or is silent.
    pub fn found(&mut self, texture: Option<Texture>) {
        (self.texture, self.sent_s) = (texture, None);
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
            body: Body::Texture(self.texture),
        })
    }

    /// Takes what has arrived; gives whether it was used.
    pub fn take(&mut self, bytes: &[u8]) -> bool {
        match self.receiver.take(bytes) {
            Some(Message {
                body: Body::Place(place_mm),
                ..
            }) => {
                self.place_mm = Some(place_mm);
                true
            }
            _ => false,
        }
    }
}
