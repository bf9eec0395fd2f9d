//! `touch`: a texture under a person's hand, on a page with sound. [`crate::stimulus`] makes the
//! vibration, as WebAssembly in the page.

pub mod live;
pub mod output;
pub mod page;

pub use live::serve;
pub use output::Output;
