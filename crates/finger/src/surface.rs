//! Derives spatial period, speed and direction on the surface from the channels' phases and the
//! speed.

pub mod lag;
pub mod texture;
pub mod travel;
