//! The static image, made a share of the taxels a frame, so that no frame has much of it to do.

use super::Detector;
use crate::contact::Imprint;
use crate::motion::{SHARE, SHARES, share, share_mut};
use crate::settings::TAXELS;
use crate::telemetry::{Hold, Image, News};
use crate::window::Ring;

/// Frames that the level before a touch is the mean of, as its variance tells: it follows each block of four by a
/// sixteenth, so its variance is (1/16) / (2 - 1/16) of a block's.
const IDLE_FRAMES: f32 = 4.0 * 31.0;
/// A taxel whose frames vary by less than this has no noise, squared codes: a tenth more than rounding makes of any
/// (1/12), which is the least that [`crate::motion`] takes for noise.
const DEAD_VARIANCE: f32 = 1.1 / 12.0;

/// An image in the making.
#[derive(Clone, Debug)]
pub(super) struct Imaging {
    image: Image,
    /// First frame of the hold.
    from: u32,
    /// Shares that are done.
    step: usize,
}

impl Imaging {
    /// None.
    pub const fn new() -> Self {
        let (level_v, sigma_v) = ([0.0; TAXELS], [0.0; TAXELS]);
        let image = Image { start_us: 0, end_us: 0, frames: 0, hold: Hold::BeforeSlide, alive: 0, level_v, sigma_v };
        Self { image, from: 0, step: 0 }
    }

    /// Deals with the next share.
    #[inline(never)]
    fn advance(&mut self, imprint: &Imprint, volts_per_code: f32) {
        let Imprint { held, level, idle, weights } = imprint;
        let turn = self.step;
        let (level, idle, weights) = (share(level, turn), share(idle, turn), share(weights, turn));
        if turn == 0 {
            self.image.alive = held.good;
        }
        let frames = 1.0 / held.frames() as f32 + 1.0 / IDLE_FRAMES;
        let (level_v, sigma_v) = (share_mut(&mut self.image.level_v, turn), share_mut(&mut self.image.sigma_v, turn));
        for c in 0..SHARE {
            let (pressed, variance) = (level[c] - idle[c], 1.0 / weights[c]);
            let taxel = 1 << (SHARE * turn + c);
            if pressed.abs() < 1.0 && variance < DEAD_VARIANCE {
                self.image.alive &= !taxel;
            }
            (level_v[c], sigma_v[c]) = match self.image.alive & taxel {
                0 => (0.0, 0.0),
                _ => (pressed * volts_per_code, libm::sqrtf(variance * frames) * volts_per_code),
            };
        }
        self.step += 1;
    }
}

impl Detector {
    /// Goes on with the image that is due, or tells it.
    #[inline(never)]
    pub(super) fn picture(&mut self, ring: &Ring, emit: &mut dyn FnMut(News)) {
        let Self { rest, imaging, .. } = self;
        let Some(imprint) = rest.contact.imprint() else { return };
        if imaging.from != imprint.held.from {
            (imaging.from, imaging.step) = (imprint.held.from, 0);
        }
        if imaging.step < SHARES {
            imaging.advance(&imprint, rest.teller.volts_per_code);
            return;
        }
        let held = imprint.held;
        imaging.step = 0;
        emit(News::Image(Image {
            start_us: rest.teller.time_us(held.from, ring),
            end_us: rest.teller.time_us(held.until, ring),
            frames: held.frames(),
            hold: if held.after_slide { Hold::AfterSlide } else { Hold::BeforeSlide },
            ..imaging.image
        }));
        rest.contact.image_told();
    }
}
