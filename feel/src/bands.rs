//! A spectrum in thirds of an octave, small enough for a message.

/// Bands, from 0.5 Hz on; the last one ends at 813 Hz, just above what receptors respond to.
pub const BANDS: usize = 32;

/// Where the first band begins, hertz.
const FIRST_HZ: f32 = 0.5;

/// The middle of a band, hertz.
pub fn band_hz(band: usize) -> f32 {
    edge_hz(band as f32 + 0.5)
}

/// So many thirds of an octave above the first edge, hertz.
fn edge_hz(bands: f32) -> f32 {
    FIRST_HZ * libm::exp2f(bands / 3.0)
}

/// The power of the strongest line in each band, by the powers of the bins and their distance, hertz. None in a band without
/// a bin.
pub fn strongest_in_bands(powers: &[f32], bin_hz: f32) -> [Option<f32>; BANDS] {
    let (mut strongest, mut band, mut end_hz) = ([None; BANDS], 0, edge_hz(1.0));
    for (bin, power) in powers.iter().enumerate().skip(1) {
        let hz = bin as f32 * bin_hz;
        while hz >= end_hz {
            band += 1;
            end_hz = edge_hz(band as f32 + 1.0);
        }
        let Some(most) = strongest.get_mut(band) else { break };
        if hz >= FIRST_HZ {
            *most = Some(most.map_or(*power, |most: f32| most.max(*power)));
        }
    }
    strongest
}
