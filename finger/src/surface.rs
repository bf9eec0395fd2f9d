//! From phases and speeds to the surface: spatial period, speed, direction.

pub mod lag;
pub mod profile;
pub mod travel;
