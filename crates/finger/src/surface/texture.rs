//! Texture under the finger, from its estimates: reported once per touch, and again when it has
//! changed.

use crate::window::Window;
use ridgetone_proto::telemetry::{Estimate, Image, Overtones, Status, Texture, TravelStatus};

/// Change, in standard deviations of the difference, above which a texture is reported again. Noise
/// alone exceeds one standard deviation in every third window, and three in one window of 370.
const CHANGED: f32 = 3.0;

/// A value with its standard deviation.
#[derive(Clone, Copy, Debug, Default)]
struct Measured {
    value: f32,
    sigma: f32,
}

/// Latest texture that was reported.
#[derive(Clone, Copy, Debug, Default)]
pub struct TextureReporter {
    /// First frame of the texture's touch; `None` if the next texture is reported in any case.
    touch_first: Option<u32>,
    /// Period and power, each with its standard deviation.
    latest: [Measured; 2],
}

impl TextureReporter {
    /// Starts without a reported texture.
    pub const fn new() -> Self {
        Self {
            touch_first: None,
            latest: [Measured {
                value: 0.0,
                sigma: 0.0,
            }; 2],
        }
    }

    /// Reports the next texture even if it is unchanged, because a PC may not have the latest one.
    pub fn forget(&mut self) {
        self.touch_first = None;
    }

    /// Returns the texture found by a window's estimate, if it is to be reported: the first one of
    /// a touch, or one that differs from the latest reported one by more than three standard
    /// deviations of the difference, in period or power. A different plan counts as a new touch.
    pub fn take(
        &mut self,
        estimate: &Estimate,
        overtones: &Overtones,
        window: &Window,
    ) -> Option<Texture> {
        let texture = texture(estimate, overtones, window)?;
        let found = [
            (texture.period_mm, texture.period_sigma_mm),
            (texture.power_v2, texture.power_sigma_v2),
        ]
        .map(|(value, sigma)| Measured { value, sigma });
        let is_same = found.iter().zip(&self.latest).all(|(found, latest)| {
            let difference = found.value - latest.value;
            difference * difference
                <= CHANGED * CHANGED * (found.sigma * found.sigma + latest.sigma * latest.sigma)
        });
        if is_same && self.touch_first == Some(window.touch_first) {
            return None;
        }
        (self.touch_first, self.latest) = (Some(window.touch_first), found);
        Some(texture)
    }
}

/// Texture that an estimate has found, if its tone can be trusted and the phases do not contradict
/// its period. Without a speed, known or found by the array, there is no period.
#[inline(always)]
fn texture(estimate: &Estimate, overtones: &Overtones, window: &Window) -> Option<Texture> {
    let travel = &estimate.travel;
    let is_sure = matches!(estimate.status, Status::Good | Status::Unsteady)
        && matches!(
            travel.status,
            TravelStatus::Unique | TravelStatus::Given | TravelStatus::Uncalibrated
        )
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
    // An amplitude fitted to N frames has 2 / N of the noise's variance.
    let frames = estimate.window_s * window.frame_rate_hz - f32::from(estimate.frames_missing);
    let per_channel = 1.0 / estimate.channels.len() as f32;
    let texture = Texture {
        t_us: estimate.t_us,
        plan: window.plan,
        period_mm: travel.spatial_period_mm,
        period_sigma_mm: travel.spatial_period_sigma_mm,
        power_v2: 0.5 * per_channel * squares,
        power_sigma_v2: per_channel * ridgetone_tone::sqrt(2.0 * products / frames),
        overtones: *overtones,
        level_v: Some(window.level_v).filter(|level_v| level_v.is_finite()),
    };
    // This excludes infinity and NaN.
    let is_known =
        texture.period_mm + texture.period_sigma_mm + texture.power_v2 + texture.power_sigma_v2
            < f32::INFINITY;
    is_known.then_some(texture)
}

/// Mean level of the working taxels of a pressure map, volts; NaN without any.
pub fn image_level_v(image: &Image) -> f32 {
    let sum: f32 = image.taxels.iter().map(|taxel| taxel.level_v).sum();
    sum / image.taxels.len() as f32
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use crate::detector::Detector;
    use crate::estimator::Estimator;

    use crate::tasks::commands::CommandExecutor;
    use ridgetone_proto::command::Command;
    use ridgetone_proto::plan::Plan;
    use ridgetone_proto::settings::Settings;
    use ridgetone_proto::telemetry::{Event, Travel, longest_packet};
    use std::boxed::Box;

    const OVERTONES: Overtones = [[0.25, -0.5], [0.125, 0.0], [0.0, 0.0]];

    const TOUCH: Window = Window {
        frame_rate_hz: 241.0,
        end_us: 1_000_000,
        touch_first: 7,
        level_v: 0.25,
        ..Window::new(Plan::PAPER, 241)
    };

    /// Estimate of 3.6 mm by the phases alone, with a standard deviation of 1 um.
    fn found() -> Estimate {
        let Event::Estimate(mut estimate) = longest_packet().event else {
            panic!("an estimate")
        };
        estimate.travel.status = TravelStatus::Unique;
        (estimate.frames_missing, estimate.window_s) = (0, 1.0);
        estimate
    }

    fn with(change: impl Fn(&mut Estimate)) -> Estimate {
        let mut estimate = found();
        change(&mut estimate);
        estimate
    }

    #[test]
    fn it_comes_once_a_touch_and_again_when_it_has_changed() {
        let mut reporter = TextureReporter::new();
        let next_touch = Window {
            touch_first: 8,
            ..TOUCH
        };
        // The difference of two periods has a sigma of 1.41 um; three sigma are 4.24 um.
        for (by_mm, window, expected) in [
            (0.0, &TOUCH, true),
            (0.0, &TOUCH, false),
            (0.0041, &TOUCH, false),
            (0.0044, &TOUCH, true),
            (0.0044, &TOUCH, false),
            (0.0, &TOUCH, true),
            (0.0, &next_touch, true),
            (0.0, &next_touch, false),
        ] {
            let moved = with(|estimate| estimate.travel.spatial_period_mm += by_mm);
            let is_taken = reporter.take(&moved, &OVERTONES, window).is_some();
            assert_eq!(is_taken, expected, "{by_mm} mm, {}", window.touch_first);
        }
        reporter.forget();
        assert!(reporter.take(&found(), &OVERTONES, &next_touch).is_some());
    }

    /// Tests that a greeting repeats the texture, because the PC may have connected during a touch.
    #[test]
    fn a_greeting_brings_it_again() {
        let settings = Settings::DEFAULT;
        let mut detector = Box::new(Detector::new(settings));
        let mut estimator = Estimator::new(settings);
        let mut executor = CommandExecutor::new();
        let mut again = |command: Option<Command>| {
            if let Some(command) = command {
                executor.carry_out(&command, &mut detector, &mut estimator, &mut |_| {});
            }
            estimator
                .textures
                .take(&found(), &OVERTONES, &TOUCH)
                .is_some()
        };
        assert!(again(None) && !again(None));
        assert!(
            !again(Some(Command::Raw { frames: 0 })) && again(Some(Command::Greet)) && !again(None)
        );
    }

    /// Tests 16 channels of 1 mV in noise of 5 uV, 241 frames: an amplitude is known to 0.46 uV,
    /// the mean of the powers to 1.14e-10 V^2.
    #[test]
    fn its_power_counts_too_with_its_own_sigma() {
        let near = |found: f32, expected: f64| (f64::from(found) / expected - 1.0).abs();
        let first = |estimate: &Estimate, window: &Window| {
            TextureReporter::new()
                .take(estimate, &OVERTONES, window)
                .expect("a texture")
        };
        let texture = first(&found(), &TOUCH);
        let sigma_v2 = 1e-3 * 5e-6 * (2.0f64 / 241.0 / 16.0).sqrt();
        assert!(near(texture.power_v2, 5e-7) < 1e-5, "{texture:?}");
        assert!(near(texture.power_sigma_v2, sigma_v2) < 1e-5, "{texture:?}");
        let others = (texture.plan, texture.level_v, texture.overtones);
        assert_eq!(others, (Plan::PAPER, Some(0.25), OVERTONES));
        // 4.24 standard deviations are 9.7e-4 of the power, and half of that of the amplitude.
        let mut reporter = TextureReporter::new();
        for (by, expected) in [(1.0, true), (1.0004, false), (1.0006, true)] {
            let scaled = with(|e| e.channels.iter_mut().for_each(|c| c.amplitude_v *= by));
            let is_taken = reporter.take(&scaled, &OVERTONES, &TOUCH).is_some();
            assert_eq!(is_taken, expected, "{by}");
        }
        // Missing frames carry no information: with a quarter of the frames sigma is twice as
        // large.
        let texture = first(&with(|estimate| estimate.frames_missing = 241 - 60), &TOUCH);
        assert!(
            near(texture.power_sigma_v2, 2.0 * sigma_v2) < 0.005,
            "{texture:?}"
        );
        let without = Window {
            level_v: f32::NAN,
            ..TOUCH
        };
        assert_eq!(first(&found(), &without).level_v, None);
    }

    #[test]
    fn what_is_not_sure_or_no_number_is_no_texture() {
        use Status::{Ambiguous, Doubtful, NoTone, Nothing, TooShort, Unsteady};
        #[track_caller]
        fn assert_takes(expected: bool, change: impl Fn(&mut Estimate)) {
            let estimate = with(change);
            let texture = TextureReporter::new().take(&estimate, &OVERTONES, &TOUCH);
            assert_eq!(texture.is_some(), expected, "{estimate:?}");
        }
        assert_takes(true, |_| ());
        assert_takes(true, |estimate| estimate.status = Unsteady);
        for status in [NoTone, Doubtful, Ambiguous, TooShort, Nothing] {
            assert_takes(false, |estimate| estimate.status = status);
        }
        // No speed is known, and the phases do not show one.
        assert_takes(false, |estimate| estimate.travel = Travel::NONE);
        for (status, expected) in [
            (TravelStatus::Given, true),
            (TravelStatus::Uncalibrated, true),
            (TravelStatus::Ambiguous, false),
            (TravelStatus::OutOfRange, false),
            (TravelStatus::Contradicted, false),
        ] {
            assert_takes(expected, |estimate| estimate.travel.status = status);
        }
        for value in [f32::NAN, f32::INFINITY, 0.0, -1.0] {
            assert_takes(false, |estimate| estimate.travel.spatial_period_mm = value);
        }
        for value in [f32::NAN, f32::INFINITY] {
            assert_takes(false, |estimate| {
                estimate.travel.spatial_period_sigma_mm = value
            });
            assert_takes(false, |estimate| estimate.channels[3].amplitude_v = value);
            assert_takes(false, |estimate| estimate.channels[3].residual_v = value);
        }
        assert_takes(false, |estimate| estimate.channels.clear());
        assert_takes(false, |estimate| estimate.frames_missing = u16::MAX);
    }
}
