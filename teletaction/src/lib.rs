//! What a robot's finger touches, felt by a person at a distance, on top of the finger's messages:
//! the library of the command `ridgetone-teletaction`, which `ridgetone` runs.
//!
//! | concept | where |
//! |---|---|
//! | what a texture is, learned from recordings or reported by a finger | [`texture`] |
//! | a texture under a person's hand: a page with sound, files | [`touch`] |
//! | textures to a stylus and places to a finger, over a network | [`link`] |
//! | strains to forces of a pin display that only presses | [`display`] |
//! | a pin display on a screen or a page, and what it must be able to do | [`pins`] |
//! | the relaxation of a person's skin, for the afterimages of a display | [`skin`] |
//! | the one state of the pages of `touch` and `pins` | `latest` |
//! | the command line | [`cli`] |
//!
//! The vibration under a hand is made by the crate `ridgetone-stimulus`: here, as WebAssembly in
//! the page of `touch`, and on a stylus (crate `ridgetone-stylus`).
#![forbid(unsafe_code)]
// Messages quote files, boards and peers: `note!` escapes and cuts them.
#![deny(clippy::print_stderr)]
// Nobody publishes it: a field whose name and unit say all has no doc.
#![allow(missing_docs)]

pub mod cli;
pub mod display;
mod latest;
pub mod link;
pub mod pins;
pub mod skin;
pub mod texture;
pub mod touch;
