//! `feel`: what the receptors of a finger would fire over a recording, and what people would say of
//! the surface.

mod coefficients;
mod cut;
pub(crate) mod event;
mod forces;
mod known;
mod loaded;
mod measure;
mod picture;
mod report;
mod spectrum;
mod stepwise;
mod train;
mod words;

pub use coefficients::Coefficients;
pub use forces::ForceColumns;
pub use measure::{KnownSurface, Options, measure};
pub use picture::draw;
pub use report::{json, text};
pub use stepwise::Criteria;
pub use train::train;
