//! What a texture becomes: an actuator's limits, and the law of the amplitude.

use anyhow::Result;
use ridgetone_stimulus::{Actuator, AmplitudeLaw, Texture, Vibration};

/// Places of a hand that are kept.
const PLACES: usize = 1024;

/// An actuator and a law.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Output {
    pub actuator: Actuator,
    law: AmplitudeLaw,
    /// Whether the law is in the unit of the textures' power.
    uses_power: bool,
}

impl Output {
    /// With a law of one's own finger a texture's power counts. Without one the amplitude follows
    /// the paper's law over the period: its power has the unit of the paper's sensor.
    pub fn new(actuator: Actuator, own: Option<AmplitudeLaw>) -> Result<Self> {
        let output = Self {
            actuator,
            law: own.unwrap_or(AmplitudeLaw::OKAMOTO),
            uses_power: own.is_some(),
        };
        output.vibration(48_000.0)?;
        Ok(output)
    }

    pub fn vibration(&self, rate_hz: f32) -> Result<Box<Vibration<PLACES>>> {
        Ok(Box::new(Vibration::new(self.actuator, self.law, rate_hz)?))
    }

    /// A texture as the law counts it.
    pub fn counted(&self, texture: &Texture) -> Texture {
        Texture {
            power: if self.uses_power { texture.power } else { 0.0 },
            ..*texture
        }
    }

    /// Its amplitude over the actuator's greatest, 0 to 1.
    pub fn share(&self, texture: &Texture) -> f32 {
        self.law
            .share(texture.period_mm, self.counted(texture).power)
    }

    pub fn law(&self) -> AmplitudeLaw {
        self.law
    }
}
