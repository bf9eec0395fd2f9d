//! A texture under a person's hand. Instead of the vibration of a robot's finger, only a few
//! numbers are transmitted, the texture's spatial period and power, and the vibration is made from
//! the position of the person's own hand. The network's delay is then not felt: the vibration
//! follows the hand, and only a change of the texture is late. `no_std`, no allocation, `f32`.
//!
//! ```
//! use ridgetone_teletaction::stimulus::{Actuator, AmplitudeLaw, Encoder, Error, Stimulus, Texture};
//!
//! let mut stimulus = Stimulus::new(Actuator::PIEZO, Encoder::OKAMOTO, AmplitudeLaw::OKAMOTO)?;
//! stimulus.set_texture(&Texture::new(1.4))?;
//! stimulus.down();
//! // At 5 kHz, in an interrupt: the encoder's counts in, volts out. The hand moves at 100 mm/s, so
//! // the tone has 71 Hz.
//! let volts: Vec<f32> = (0..5000).map(|n| stimulus.next(4 * n)).collect();
//! let crossings = volts.windows(2).filter(|pair| pair[0] < 75.0 && pair[1] >= 75.0).count();
//! assert!((71..=72).contains(&crossings));
//! # Ok::<(), Error>(())
//! ```
//!
//! The method is that of Okamoto et al., *Transmission of Tactile Roughness through Master-slave
//! Systems* (equations 1 to 5), with one difference: the phase is position over period, not
//! frequency times time, so that a hand that stops or turns stays on the same surface.
//!
//! [`Stimulus`] takes an encoder's counts at a fixed rate, [`Vibration`] positions that arrive at
//! uneven times. For any input, each sample is within the voltage range and within the slew limit
//! of the previous one.

// A panic resets a board, so only tests may panic.
#![cfg_attr(
    not(test),
    deny(
        clippy::unwrap_used,
        clippy::expect_used,
        clippy::panic,
        clippy::unreachable,
        clippy::todo,
        clippy::unimplemented
    )
)]

mod actuator;
mod delay;
mod error;
mod hand;
mod law;
mod path;
mod texture;
mod vibration;
mod voltage;

pub use actuator::Actuator;
pub use delay::Delay;
pub use error::Error;
pub use hand::Encoder;
pub use law::AmplitudeLaw;
pub use path::Path;
pub use texture::{HARMONICS_MAX, Harmonic, Texture};
pub use vibration::Vibration;
pub use voltage::{Prepared, Stimulus};

#[cfg(not(target_arch = "wasm32"))]
pub(crate) use error::within;
