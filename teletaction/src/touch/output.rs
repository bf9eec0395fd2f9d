//! An actuator with its limits, and the amplitude law.

use crate::stimulus::{Actuator, AmplitudeLaw, Encoder, Error, Stimulus, Texture};

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Output {
    pub actuator: Actuator,
    law: AmplitudeLaw,
    /// True if the law uses the unit of the textures' power.
    uses_power: bool,
}

impl Output {
    /// With a law measured on one's own finger, a texture's power determines the amplitude.
    /// Otherwise it follows the paper's law over the period, whose power is in the unit of the
    /// paper's sensor.
    pub fn new(actuator: Actuator, own: Option<AmplitudeLaw>) -> Result<Self, Error> {
        let law = own.unwrap_or(AmplitudeLaw::OKAMOTO);
        Stimulus::new(actuator, Encoder::OKAMOTO, law)?;
        Ok(Self {
            actuator,
            law,
            uses_power: own.is_some(),
        })
    }

    /// Returns a texture with its power only if the law uses it.
    pub fn counted(&self, texture: &Texture) -> Texture {
        Texture {
            power: if self.uses_power { texture.power } else { 0.0 },
            ..*texture
        }
    }

    /// Amplitude of a texture, as a fraction of the actuator's maximum.
    pub fn fraction(&self, texture: &Texture) -> f32 {
        self.law
            .fraction(texture.period_mm, self.counted(texture).power)
    }

    pub fn law(&self) -> AmplitudeLaw {
        self.law
    }
}
