//! From the channels' phases and the speed to the surface: spatial period, speed, direction.

pub mod lag;
pub mod texture;
pub mod travel;
