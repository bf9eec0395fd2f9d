//! Noise of sixteen channels, for the traces of touches.

pub(crate) mod process;
