//! A vibration in volts: how strongly does it make each kind of receptor fire?
//!
//! `cargo run -p ridgetone-feel --example intensities`

use ridgetone_feel::{Conversion, Firing, Receptor, Windows, amplitude_spectrum};

/// Samples a second.
pub const RATE_HZ: f32 = 2000.0;
/// Amplitude that the sensor gives for one micrometre from peak to peak, volts: from a surface that
/// is known (`ridgetone_feel::Reference`).
pub const VOLTS_PER_UM: f32 = 0.3;

/// The intensities of a window. None if its length is no power of two from 64 to 1024. The samples
/// are overwritten.
pub fn firing(volts: &mut [f32]) -> Option<Firing> {
    let windows = Windows::same(volts.len() as f32 / RATE_HZ);
    let conversion = Conversion {
        log_per_um: VOLTS_PER_UM.log10(),
        log_sigma: 0.0,
    };
    Some(Firing::new(
        amplitude_spectrum(volts)?,
        windows,
        &conversion,
    ))
}

fn main() {
    let sample = |i: usize| 0.3 * (core::f32::consts::TAU * 100.0 * i as f32 / RATE_HZ).sin();
    let mut volts: Vec<f32> = (0..1024).map(sample).collect();
    let firing = firing(&mut volts).expect("a power of two");
    for (receptor, intensity) in Receptor::ALL.into_iter().zip(firing.intensity) {
        match intensity {
            Some(intensity) => println!("{:<6} {intensity:.2}", receptor.name()),
            None => println!(
                "{:<6} absent: the rate is too low, or the window too short",
                receptor.name()
            ),
        }
    }
}
