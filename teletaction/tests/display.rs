//! The display against the paper's closed forms and tables, and within its limits whatever is
//! wanted.

#[path = "display/half_plane.rs"]
mod half_plane;
#[path = "display/kelvin.rs"]
mod kelvin;
#[path = "display/limits.rs"]
mod limits;
#[path = "display/matching.rs"]
mod matching;
