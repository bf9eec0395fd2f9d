//! Taxels to strains under the skin, place by place.
//!
//! The array has 2 x 2 units, and each unit four piezoresistors on a cross (Oddo et al. 2009,
//! section 2.1 and figure 1): AIN 4 u + k is piezoresistor k + 1 of unit u + 1. Units 1 and 3 come
//! before 2 and 4 along the sliding direction x, and so does piezoresistor 1 of each unit before 3;
//! numbers go round the cross. Turned by an eighth the crosses make a square of 4 x 4, in which x
//! goes to the right:
//!
//! ```text
//!  0  1 |  4  5
//!  3  2 |  7  6
//! ------+------
//!  8  9 | 12 13
//! 11 10 | 15 14
//! ```
//!
//! The paper does not say on which side of the array units 1 and 2 are, nor piezoresistor 2 of
//! each; here it is the upper side.
//!
//! Pressure strains all four piezoresistors of a unit alike. Shear tilts its mesa, which stretches
//! piezoresistor 1 as much as it compresses 3 (section 2.1): their mean is free of it. So a unit
//! has three values: that mean for both, and those of 2 and 4.

use ridgetone_proto::settings::TAXELS;
use ridgetone_tone::Values;

/// Distance between the centres of two units, millimetres (Oddo et al. 2009, section 2.1).
pub const UNIT_PITCH_MM: f64 = 2.3;

/// Rows and columns of the map.
pub const SIDE: usize = 4;

/// The taxel at each place of the map, row by row from the top, in a row along the sliding
/// direction.
pub const PLACES: [[usize; SIDE]; SIDE] =
    [[0, 1, 4, 5], [3, 2, 7, 6], [8, 9, 12, 13], [11, 10, 15, 14]];

/// What pressure does to each taxel, by its values above the level without touch; `usable` has a
/// bit for each taxel. One that is not usable has the mean of its unit, and a unit without any has
/// none.
pub fn of_pressure(values: &Values, usable: u16) -> Values {
    let mut pressed = *values;
    for (unit, values) in pressed.as_chunks_mut::<4>().0.iter_mut().enumerate() {
        of_unit(values, usable >> (4 * unit));
    }
    pressed
}

/// The same for one unit.
// Not inlined: unrolled it would be four times as large.
#[inline(never)]
fn of_unit(values: &mut [f32; 4], usable: u16) {
    let is_usable = |k: usize| usable >> k & 1 != 0;
    let pair = (is_usable(0) && is_usable(2), 0.5 * (values[0] + values[2]));
    let three = [pair, (is_usable(1), values[1]), (is_usable(3), values[3])];
    let there = three.iter().filter(|(is_there, _)| *is_there);
    let (sum, count) = there.fold((0.0, 0.0), |(sum, count), (_, value)| {
        (sum + value, count + 1.0)
    });
    let mean = if count > 0.0 { sum / count } else { 0.0 };
    let [pair, second, fourth] = three.map(|(is_there, value)| if is_there { value } else { mean });
    *values = [pair, second, pair, fourth];
}

/// Values of the taxels as a map, row by row.
pub fn by_place(values: &Values) -> [f32; TAXELS] {
    let mut map = [0.0; TAXELS];
    map.iter_mut()
        .zip(PLACES.as_flattened())
        .for_each(|(value, taxel)| *value = values[*taxel % TAXELS]);
    map
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_taxel_has_one_place() {
        let found = by_place(&core::array::from_fn(|taxel| taxel as f32));
        assert_eq!(
            found,
            [0, 1, 4, 5, 3, 2, 7, 6, 8, 9, 12, 13, 11, 10, 15, 14].map(|taxel| taxel as f32)
        );
        assert!((0..TAXELS).all(|taxel| found.contains(&(taxel as f32))));
    }

    #[test]
    fn shear_is_cancelled_and_the_dead_are_replaced() {
        // A pressure of 0.01 and a shear that tilts each unit.
        let mut values: Values =
            core::array::from_fn(|taxel| 0.01 + [0.05, 0.0, -0.05, 0.0][taxel % 4]);
        let is_even = |values: &Values| values.iter().all(|value| (value - 0.01).abs() < 1e-6);
        assert!(is_even(&of_pressure(&values, u16::MAX)));
        // Without its pair piezoresistor 1 says nothing.
        (values[2], values[5]) = (f32::NAN, f32::NAN);
        assert!(is_even(&of_pressure(&values, !(1 << 2 | 1 << 5))));
        let dead = of_pressure(&values, !(1 << 2 | 1 << 5 | 0xf00));
        assert!(dead.iter().filter(|value| **value == 0.0).count() == 4 && dead[8..12] == [0.0; 4]);
    }
}
