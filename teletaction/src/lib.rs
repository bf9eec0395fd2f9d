//! Remote touch, based on a finger's messages: the library of the command `ridgetone-teletaction`,
//! which `ridgetone` runs, of the stylus's image, and of the WebAssembly in the page of `touch`.
//!
//! | concept | where |
//! |---|---|
//! | a texture under a hand: voltage from the hand's position (`no_std`) | [`stimulus`] |
//! | decisions of a stylus with an encoder and an actuator (`no_std`) | `stylus` |
//! | the stimulus as WebAssembly | `worklet` |
//! | textures reported by a finger | `texture` |
//! | a texture under a pointer: a page with sound | `touch` |
//! | textures to a stylus and positions to a finger, over a network | `link` |
//! | forces of a pin display that can only press | `pins` |
//! | the command line | `cli` |
#![cfg_attr(target_os = "none", no_std)]
#![deny(unsafe_code)]
// Messages quote text from files, boards and peers; `note!` escapes and truncates it.
#![deny(clippy::print_stderr)]
// Not published, so a field whose name and unit are clear needs no doc.
#![allow(missing_docs)]
// `!(a > b)` is intended: it is also true for NaN.
#![allow(clippy::neg_cmp_op_on_partial_ord)]

pub mod stimulus;
#[cfg(not(target_arch = "wasm32"))]
pub mod stylus;

#[cfg(target_arch = "wasm32")]
mod worklet;

#[cfg(not(any(target_os = "none", target_arch = "wasm32")))]
pub mod cli;
#[cfg(not(any(target_os = "none", target_arch = "wasm32")))]
pub mod link;
#[cfg(not(any(target_os = "none", target_arch = "wasm32")))]
pub mod pins;
#[cfg(not(any(target_os = "none", target_arch = "wasm32")))]
pub mod texture;
#[cfg(not(any(target_os = "none", target_arch = "wasm32")))]
pub mod touch;
