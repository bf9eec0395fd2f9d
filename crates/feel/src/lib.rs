#![doc = include_str!("../README.md")]
#![no_std]
// A panic resets a board: only tests may.
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
#![forbid(unsafe_code)]
// Receptors and indices are numbered; loops over several arrays at once read better by number.
#![allow(clippy::needless_range_loop)]

mod bands;
mod firing;
mod force;
mod mean;
mod receptor;
mod reference;
mod score;
mod spectrum;
mod windows;

pub use bands::{BANDS, band_hz, strongest_in_bands};
pub use firing::{Absent, Firing};
pub use force::force_ratio;
pub use mean::MeanFiring;
pub use receptor::{RECEPTORS, Receptor};
pub use reference::{Conversion, NoAmplitude, Reference, SpectralLine};
pub use score::{INDICES, Indices, PAPER_WINDOW_S, ROUGH, SOFT, Score};
pub use spectrum::{POINTS_MAX, amplitude_at, amplitude_spectrum, points};
pub use windows::Windows;
