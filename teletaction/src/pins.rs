//! `pins`: strains under a sensor's skin as forces of a pin display, and what such a display must
//! be able to do.

mod design;
mod grating;
mod page;
mod player;
mod run;
mod screen;
mod skin;
#[cfg(test)]
mod tests;

pub use design::{Design, NOTICEABLE, Perception};
pub use grating::{CELL_MM, Pressure, pins_with_errors, ridges};
pub use player::{Memory, Player, Setup, Update};
pub use run::{Show, run};
pub use skin::volts_per_strain;
