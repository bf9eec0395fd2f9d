//! `touch`: a texture under a person's hand, on a page with sound or in a file. What makes the
//! vibration is `ridgetone-stimulus`; in the page it runs as WebAssembly.
//!
//! | step | file |
//! |---|---|
//! | what the texture becomes: an actuator, and how strongly | [`output`] |
//! | a hand that nobody moves | [`hand`] |
//! | samples for a file | [`render`](mod@render) |
//! | sound and haptic files | [`wav`], [`ahap`] |
//! | the page, and the textures of a finger for it | [`page`], [`live`] |

pub mod ahap;
pub mod hand;
pub mod live;
pub mod output;
pub mod page;
pub mod render;
pub mod wav;

pub use hand::Hand;
pub use live::serve;
pub use output::Output;
pub use render::{RATE_HZ, Rendered, Run, render};
