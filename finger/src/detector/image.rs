//! The static image, made some taxels at a time, so that no frame has much of it to do.

use super::Detector;
use crate::ring::Ring;
use heapless::Vec;
use ridgetone_proto::settings::TAXELS;
use ridgetone_proto::telemetry::{Event, Hold, Image, Pressed};

/// Frames that the level before a touch is the mean of, as its variance tells: it follows each block of four by a
/// sixteenth, so its variance is (1/16) / (2 - 1/16) of a block's.
const IDLE_FRAMES: f32 = 4.0 * 31.0;
/// A taxel whose frames vary by less than this has no noise, squared codes: a tenth more than rounding makes of any
/// (1/12), which is the least that [`crate::touch::motion`] takes for noise.
const DEAD_VARIANCE: f32 = 1.1 / 12.0;

/// Taxels that one step deals with: two would be too much for one frame.
const STEP_TAXELS: usize = 1;

/// An image in the making.
#[derive(Clone, Debug)]
pub(super) struct Imaging {
    image: Image,
    /// First frame of the hold.
    from: u32,
    /// Steps taken.
    step: usize,
}

impl Imaging {
    /// None.
    pub const fn new() -> Self {
        let image = Image { start_us: 0, end_us: 0, frames: 0, hold: Hold::BeforeSlide, taxels: Vec::new() };
        Self { image, from: 0, step: 0 }
    }
}

impl Detector {
    /// Takes the next step towards the image that is due: [`STEP_TAXELS`], its times, and telling it. False if there is
    /// none to be taken now.
    #[inline(never)]
    pub(super) fn picture(&mut self, ring: &Ring, emit: &mut dyn FnMut(Event)) -> bool {
        let Self { tracker: rest, imaging, .. } = self;
        let Some(imprint) = rest.contact.imprint() else { return false };
        let (held, image) = (imprint.held, &mut imaging.image);
        if imaging.from != held.from {
            // What was begun before was never told: another hold came too soon.
            (imaging.from, imaging.step) = (held.from, 0);
        }
        if imaging.step == 0 {
            image.taxels.clear();
        }
        let step = imaging.step;
        imaging.step += 1;
        if step < TAXELS / STEP_TAXELS {
            let of_mean = 1.0 / held.frames() as f32 + 1.0 / IDLE_FRAMES;
            for taxel in STEP_TAXELS * step..STEP_TAXELS * (step + 1) {
                let taxel = taxel % TAXELS;
                let pressed = imprint.level[taxel] - imprint.idle[taxel];
                let variance = 1.0 / imprint.weights[taxel];
                if held.good >> taxel & 1 == 0 || pressed.abs() < 1.0 && variance < DEAD_VARIANCE {
                    continue;
                }
                let volts = rest.events.volts_per_code;
                let sigma_v = libm::sqrtf(variance * of_mean) * volts;
                // There is room for every taxel.
                let _ = image.taxels.push(Pressed { taxel: taxel as u8, level_v: pressed * volts, sigma_v });
            }
        } else if step == TAXELS / STEP_TAXELS {
            image.start_us = rest.clock.time_us(held.from, ring);
            image.end_us = rest.clock.time_us(held.until, ring);
            image.frames = held.frames();
            image.hold = if held.after_slide { Hold::AfterSlide } else { Hold::BeforeSlide };
        } else {
            emit(Event::Image(image.clone()));
            imaging.step = 0;
            rest.contact.image_told();
        }
        true
    }
}
