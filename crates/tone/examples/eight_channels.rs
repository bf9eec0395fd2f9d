//! Eight channels of any ADC at 500 Hz, in volts: what frequency do they share?

use ridgetone_tone::{Fit, Fitter, FrameSpan, Frames, Overwritten, Scene};

const CHANNELS: usize = 8;
const RATE_HZ: f32 = 500.0;

/// Fits all frames: the values of eight channels in volts, one frame after the other.
pub fn fit(volts: &[f32]) -> Result<Fit, Overwritten> {
    let mut frames = Frames::new(volts, CHANNELS).expect("1 to 16 channels");
    let count = frames.count();
    Fitter::new().fit(
        &mut FrameSpan::new(&mut frames, 0, count).with_frame_rate(RATE_HZ),
        &Scene::with_harmonics(3),
    )
}

fn main() -> Result<(), Overwritten> {
    let sample = |i: usize| {
        let (t_s, phase) = ((i / CHANNELS) as f32 / RATE_HZ, (i % CHANNELS) as f32);
        1.5 + 0.002 * (core::f32::consts::TAU * 23.4 * t_s + phase).sin()
            + 1e-4 * (i as f32 * i as f32 * 0.37).sin()
    };
    let volts: Vec<f32> = (0..400 * CHANNELS).map(sample).collect();
    let fit = fit(&volts)?;
    println!(
        "{:?}: {:.3} +- {:.3} Hz, {} harmonics",
        fit.status, fit.frequency, fit.sigma, fit.harmonics
    );
    Ok(())
}
