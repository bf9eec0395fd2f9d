//! Cosine and sine of a phase in turns.
//!
//! `libm::sinf` computes in f64, which a Cortex-M4F has to emulate (about 1,950 instructions); this
//! pair of polynomials costs about 65 and is the same on every machine to the last bit. The phase
//! is a 32-bit fraction of a turn, so that advancing it wraps exactly, however long the window.

/// Units of a phase per turn: 2^32.
pub(crate) const TURN: f32 = 4_294_967_296.0;

/// A cosine and a sine, or sums of them.
pub(crate) type Wave = [f32; 2];

/// Converts turns (any sign, magnitude below 2^31) to a phase: the fraction of a turn in units of
/// 2^-32.
pub fn from_turns(turns: f32) -> u32 {
    // Subtracting the nearest whole number of turns is exact, so the fraction keeps all its bits.
    // Half a turn to either side fits into 32 bits, so the FPU can convert it.
    let fraction = turns - (turns + 0.5f32.copysign(turns)) as i32 as f32;
    (fraction * TURN) as i32 as u32
}

/// Cosine and sine of `phase` (a 32-bit fraction of a turn). Absolute error below 1.5e-7.
///
/// Cephes' single-precision minimax polynomials on plus or minus an eighth of a turn.
pub fn cos_sin(phase: u32) -> (f32, f32) {
    let quadrant = phase.wrapping_add(1 << 29) >> 30;
    let within = phase.wrapping_sub(quadrant << 30) as i32;
    // 2 pi / 2^32 radians per unit.
    let x = within as f32 * 1.462_918_1e-9;
    let z = x * x;
    let sin = x + x * z * (-1.666_665_5e-1 + z * (8.332_161e-3 + z * -1.951_529_6e-4));
    let cos = 1.0 - 0.5 * z + z * z * (4.166_664_6e-2 + z * (-1.388_731_6e-3 + z * 2.443_315_7e-5));
    match quadrant & 3 {
        0 => (cos, sin),
        1 => (-sin, cos),
        2 => (-cos, -sin),
        _ => (sin, -cos),
    }
}

/// Product of two complex numbers.
pub(crate) fn times(a: Wave, b: Wave) -> Wave {
    [a[0] * b[0] - a[1] * b[1], a[0] * b[1] + a[1] * b[0]]
}

/// Products of two lines, cosine and sine of one with cosine and sine of the other, from the
/// multiples of their phase.
pub(crate) fn line_products<const N: usize>(
    waves: &[Wave; N],
    one: usize,
    other: usize,
) -> [Wave; 2] {
    let [cos, sin] = waves[one.abs_diff(other) % N];
    let difference = [cos, if one < other { -sin } else { sin }];
    let sum = waves[(one + other) % N];
    [
        [
            0.5 * (difference[0] + sum[0]),
            0.5 * (sum[1] - difference[1]),
        ],
        [
            0.5 * (sum[1] + difference[1]),
            0.5 * (difference[0] - sum[0]),
        ],
    ]
}

/// Cosine and sine of the multiples 0, 1, 2... of a phase.
pub(crate) fn powers(phase: u32) -> impl Iterator<Item = Wave> {
    let (cos, sin) = cos_sin(phase);
    core::iter::successors(Some([1.0, 0.0]), move |wave| Some(times(*wave, [cos, sin])))
}

/// Cosine and sine of the multiples of a phase up to `max`, then zeros.
pub(crate) fn first_powers<const N: usize>(phase: u32, max: usize) -> [Wave; N] {
    let mut first = [[0.0; 2]; N];
    let places = first.iter_mut().take(max + 1);
    places
        .zip(powers(phase))
        .for_each(|(place, power)| *place = power);
    first
}

#[cfg(test)]
mod tests {
    use super::*;
    extern crate std;

    #[test]
    fn agrees_with_f64_over_the_whole_turn() {
        let mut worst = 0f64;
        for i in 0..200_000u32 {
            let phase = i.wrapping_mul(21_474_837);
            let (c, s) = cos_sin(phase);
            let angle = phase as f64 * std::f64::consts::TAU / 4_294_967_296.0;
            worst = worst
                .max((c as f64 - angle.cos()).abs())
                .max((s as f64 - angle.sin()).abs());
        }
        assert!(worst < 1.5e-7, "{worst:e}");
    }

    #[test]
    fn turns_wrap_at_any_size_and_sign() {
        assert_eq!(from_turns(0.25), 1 << 30);
        assert_eq!(from_turns(-0.25), 3 << 30);
        assert_eq!(from_turns(1000.5), 1 << 31);
        assert_eq!(from_turns(-7.0), 0);
    }
}
