//! Phases of a touch, frame by frame, and their times: in the air, contact, hold, slide, hold,
//! release.

pub mod averages;
pub(crate) mod block;
pub mod change;
mod chi_square;
pub(crate) mod condition;
pub mod contact;
mod held;
mod idle;
pub(crate) mod image;
mod loaded;
pub(crate) mod motion;
mod noise;
mod onset;
mod past;
mod slide;
mod spike;
mod values;
