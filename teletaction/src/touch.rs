//! `touch`: a texture under a person's hand, on a page with sound. The vibration is made by
//! [`crate::stimulus`], in the page as WebAssembly.

pub mod live;
pub mod output;
pub mod page;

pub use live::serve;
pub use output::Output;
