//! The example runs, and the receptor with the lowest threshold fires alone.

#[path = "../examples/intensities.rs"]
#[allow(dead_code, reason = "its main is for cargo run --example")]
mod intensities;

use intensities::{RATE_HZ, VOLTS_PER_UM, firing};
use ridgetone_feel::Receptor;

#[test]
fn a_faint_vibration_at_250_hz_fires_only_fa_2() {
    // 128 of 1024 bins: the window holds a whole number of cycles, so the spectrum has no leakage
    // but Hamming's next bins.
    let hz = 250.0;
    let threshold_um = |receptor: Receptor| receptor.threshold_um(hz);
    let fa2_um = threshold_um(Receptor::Fa2).expect("in its range");
    let others = Receptor::ALL
        .into_iter()
        .filter(|receptor| *receptor != Receptor::Fa2);
    let next_um = others
        .clone()
        .filter_map(threshold_um)
        .fold(f32::INFINITY, f32::min);
    assert!(next_um > 4.0 * fa2_um);
    // Hamming's next bins have 0.43 of the peak: below the threshold at 1.5 times it.
    let volts = 1.5 * fa2_um * VOLTS_PER_UM;
    let mut samples: Vec<f32> = (0..1024)
        .map(|i| volts * (core::f32::consts::TAU * hz * i as f32 / RATE_HZ).sin())
        .collect();
    let firing = firing(&mut samples).expect("a power of two");
    let fa2 = firing.intensity[Receptor::Fa2 as usize].expect("in its range");
    assert!((fa2 - 1.5f32.log10()).abs() < 1e-3, "{fa2}");
    for receptor in others {
        assert!(
            firing.intensity[receptor as usize].is_none_or(|intensity| intensity == 0.0),
            "{}",
            receptor.name()
        );
    }
}
