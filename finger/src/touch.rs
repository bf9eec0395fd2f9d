//! Is anything moving; idle, contact spike, hold, slide, release; since when.

pub mod contact;
pub mod motion;
pub mod onset;
