//! The strain that is left in the skin from what the display did before.

use crate::display::error::{Error, finite, length, within};
use crate::display::kelvin::Kelvin;

/// Strains that the skin keeps, at the places of the sensors; the memory is the caller's.
///
/// A force strains the skin at once, and by and by more: the part that comes by and by is the
/// afterimage. Where the display wants a strain, it has to add only what the afterimage lacks;
/// where the afterimage is more, no pressing pin can take it away.
#[derive(Debug)]
pub struct Afterimage<'a> {
    skin: Kelvin,
    kept: &'a mut [f32],
}

impl<'a> Afterimage<'a> {
    /// Afterimage of skin that was not touched. `kept` has a value for each sensor; all are set to 0.
    pub fn new(skin: Kelvin, kept: &'a mut [f32]) -> Self {
        kept.fill(0.0);
        Self { skin, kept }
    }

    /// What the skin keeps, in the unit of the strains.
    pub fn kept(&self) -> &[f32] {
        self.kept
    }

    /// Takes what the skin keeps off the wanted strains, in place.
    pub fn take_off(&self, wanted: &mut [f32]) -> Result<(), Error> {
        length("wanted strains", wanted.len(), self.kept.len())?;
        wanted
            .iter_mut()
            .zip(self.kept.iter())
            .for_each(|(wanted, kept)| *wanted -= kept);
        Ok(())
    }

    /// Lets `dt_s` seconds pass, 0 to 1000, in which the forces make these strains at once and do
    /// not change.
    pub fn advance(&mut self, dt_s: f64, at_once: &[f32]) -> Result<(), Error> {
        within("dt_s", dt_s, 0.0, 1e3)?;
        length("strains", at_once.len(), self.kept.len())?;
        finite("strain", at_once)?;
        let more = (self.skin.creep_s() / self.skin.relaxation_s() - 1.0) as f32;
        let stays = (-dt_s / self.skin.creep_s()).exp() as f32;
        for (kept, at_once) in self.kept.iter_mut().zip(at_once) {
            *kept = stays * *kept + (1.0 - stays) * more * at_once;
        }
        Ok(())
    }
}
