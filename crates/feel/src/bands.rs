//! A spectrum in thirds of an octave, small enough for a message.

/// Bands, from 0.5 Hz on; the last one ends at 813 Hz, just above what receptors respond to.
pub const BANDS: usize = 32;

/// Where the first band begins, hertz.
const FIRST_HZ: f32 = 0.5;

/// A third of an octave: the cube root of two.
const THIRD: f32 = 1.259_921;

/// The middle of a band, hertz.
pub fn band_hz(band: usize) -> f32 {
    FIRST_HZ * libm::exp2f((band as f32 + 0.5) / 3.0)
}

/// The power of the strongest line in each band, by the powers of the bins and their distance,
/// hertz. None in a band without a bin.
pub fn strongest_in_bands(powers: &[f32], bin_hz: f32) -> [Option<f32>; BANDS] {
    // Multiplied up band by band: `exp2f` computes in doubles, which the chip lacks.
    let (mut strongest, mut band, mut end_hz) = ([None; BANDS], 0, THIRD * FIRST_HZ);
    for (bin, power) in powers.iter().enumerate().skip(1) {
        let hz = bin as f32 * bin_hz;
        while hz >= end_hz {
            band += 1;
            end_hz *= THIRD;
        }
        let Some(most) = strongest.get_mut(band) else {
            break;
        };
        if hz >= FIRST_HZ {
            *most = Some(most.map_or(*power, |most: f32| most.max(*power)));
        }
    }
    strongest
}
