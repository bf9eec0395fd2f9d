//! Tests random settings. The fuzzer in `fuzz/` tests the same property; here the seed is fixed.

use crate::any_settings::try_settings;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use ridgetone_proto::settings::{Array, Settings, Slide, SlideRule};

/// Tries valid settings of every kind, some of them with flipped bits, and random bytes.
#[test]
fn any_settings_are_refused_or_run() {
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let mut valid = 0;
    for n in 0..300 {
        let mut between = |min: f32, max: f32| {
            // Includes both bounds.
            let fraction = (rng.next_u32() % 9) as f32 / 8.0;
            min + fraction * (max - min)
        };
        let protocol = Slide {
            rule: SlideRule::Protocol,
            delay_s: between(0.0, 1.0),
            speed_mm_s: between(0.1, 2000.0),
            length_mm: between(0.1, 2000.0),
        };
        let settings = Settings {
            window_s: between(0.1, 3.9),
            stride_s: between(0.02, 0.5),
            harmonics: between(1.0, 5.0) as u8,
            accuracy: if n % 5 < 3 { 0.0 } else { between(1e-6, 0.1) },
            interferer_hz: if n % 7 < 4 { 0.0 } else { between(5.0, 1000.0) },
            vref_v: between(0.5, 5.5),
            slide: if n % 2 == 0 { Slide::DEFAULT } else { protocol },
            array: Array {
                pitch_mm: between(0.1, 100.0),
                edge_phase_rad: between(-3.1, 3.1),
                edge_phase_sigma_rad: between(0.0, 3.1),
                period_min_mm: between(0.1, 4.0),
                period_max_mm: between(4.0, 100.0),
                may_go_forward: n % 3 > 0,
                may_go_backward: n % 3 < 2,
                alike: [0x1111, 0x2222, 0xcccc, 0],
                ..Array::DEFAULT
            },
            ..Settings::DEFAULT
        };
        let mut buffer = [0; 160];
        let bytes = postcard::to_slice(&settings, &mut buffer).unwrap();
        for _ in 0..n % 3 {
            let at = rng.next_u32() as usize % bytes.len();
            bytes[at] ^= 1 << (rng.next_u32() % 8);
        }
        valid += try_settings(bytes) as u32;
        rng.fill_bytes(bytes);
        valid += try_settings(bytes) as u32;
    }
    assert!((120..300).contains(&valid), "{valid}");
}
