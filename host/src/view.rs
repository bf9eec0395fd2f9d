//! `view`: what a board does, live on one page in a browser. The page shows [`crate::live`], as the terminal does; here is
//! what brings it there.
//!
//! | what | where |
//! |---|---|
//! | what the page is told, and when | [`hub`] |
//! | where it is fetched from: this computer only | [`server`] |
//! | why there is nothing to see, in words | [`words`] |
//!
//! The page itself is in `host/assets`, inside the binary with the plotting library ([uPlot](https://github.com/leeoniya/uPlot),
//! MIT). Nothing is fetched from anywhere else.

pub mod hub;
pub mod server;
pub mod words;
