//! How many places the queues between the firmware's tasks have. Those of samples and windows hold one less.

/// Conversions between `drdy` and `detect`: 25 ms of them at 5064 a second.
pub const SAMPLES: usize = 128;

/// Windows between `detect` and `fit`: one hop may wait, the other places are for whole slides.
pub const WINDOWS: usize = 4;

/// Packets between `detect`, `fit` and `report`.
pub const PACKETS: usize = 8;
