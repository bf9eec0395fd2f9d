//! What is under the finger, from its estimates: a texture is reported once a touch, and again when it has changed.

use crate::window::Window;
use ridgetone_proto::telemetry::{Estimate, Image, Measured, Status, Texture, TravelStatus};

/// A texture has changed if it differs by more than so many standard deviations of the difference: by one, noise alone would
/// differ in every third window; by three, in one of 370.
const CHANGED: f32 = 3.0;

/// The latest texture that was reported.
#[derive(Clone, Copy, Debug)]
pub struct TextureReporter {
    /// First frame of its touch; none if the next texture is reported anyway.
    touch_first: Option<u32>,
    /// Period and power, each with its standard deviation.
    latest: [Measured; 2],
}

impl TextureReporter {
    /// Nothing reported.
    pub const fn new() -> Self {
        Self { touch_first: None, latest: [Measured { value: 0.0, sigma: 0.0 }; 2] }
    }

    /// The next texture is reported, even if it has not changed: a PC may not have the latest one.
    pub fn forget(&mut self) {
        self.touch_first = None;
    }

    /// The texture that a window's estimate has found, if it is to be reported: the first one since a touch began, and one that
    /// differs from that by more than [`CHANGED`] allows, in its period or in its power. Another plan begins another touch.
    #[inline(never)]
    pub fn take(&mut self, estimate: &Estimate, window: &Window) -> Option<Texture> {
        let texture = texture(estimate, window)?;
        let found = [(texture.period_mm, texture.period_sigma_mm), (texture.power_v2, texture.power_sigma_v2)]
            .map(|(value, sigma)| Measured { value, sigma });
        let is_same = found.iter().zip(&self.latest).all(|(found, latest)| {
            let difference = found.value - latest.value;
            difference * difference <= CHANGED * CHANGED * (found.sigma * found.sigma + latest.sigma * latest.sigma)
        });
        if is_same && self.touch_first == Some(window.touch_first) {
            return None;
        }
        (self.touch_first, self.latest) = (Some(window.touch_first), found);
        Some(texture)
    }
}

/// The texture that an estimate has found: a tone that can be trusted, and a period that the phases do not contradict. Without a
/// speed, which the array may find too, there is no period.
#[inline(always)]
fn texture(estimate: &Estimate, window: &Window) -> Option<Texture> {
    let travel = &estimate.travel;
    let is_sure = matches!(estimate.status, Status::Good | Status::Unsteady)
        && matches!(travel.status, TravelStatus::Unique | TravelStatus::Given)
        && travel.spatial_period_mm > 0.0;
    if !is_sure {
        return None;
    }
    let (mut squares, mut products) = (0.0, 0.0);
    for channel in &estimate.channels {
        let square = channel.amplitude_v * channel.amplitude_v;
        squares += square;
        products += square * (channel.residual_v * channel.residual_v);
    }
    // Of an amplitude that is fitted to N frames the variance is 2 / N of the noise's.
    let frames = estimate.window_s * window.frame_rate_hz - f32::from(estimate.frames_missing);
    let per_channel = 1.0 / estimate.channels.len() as f32;
    let texture = Texture {
        t_us: estimate.t_us,
        plan: window.plan,
        period_mm: travel.spatial_period_mm,
        period_sigma_mm: travel.spatial_period_sigma_mm,
        power_v2: 0.5 * per_channel * squares,
        power_sigma_v2: per_channel * libm::sqrtf(2.0 * products / frames),
        level_v: Some(window.level_v).filter(|level_v| level_v.is_finite()),
    };
    // Neither infinite nor NaN.
    let is_known = texture.period_mm + texture.period_sigma_mm + texture.power_v2 + texture.power_sigma_v2 < f32::INFINITY;
    is_known.then_some(texture)
}

/// Mean level of the alive taxels of a static image, volts; NaN without any.
pub fn image_level_v(image: &Image) -> f32 {
    let sum: f32 = image.taxels.iter().map(|taxel| taxel.level_v).sum();
    sum / image.taxels.len() as f32
}
