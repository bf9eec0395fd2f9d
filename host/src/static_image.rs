//! The static image as a map: the position of each taxel under the skin.
//!
//! The array has 2 x 2 units, and each unit four piezoresistors on a cross (Oddo et al. 2009,
//! section 2.1 and figure 1): AIN 4 u + k is piezoresistor k + 1 of unit u + 1. Units 1 and 3 come
//! before 2 and 4 along the sliding direction x, as does piezoresistor 1 of each unit before 3;
//! numbers go round the cross. With the crosses turned by 45 degrees, the map is a 4 x 4 square in
//! which x points to the right:
//!
//! ```text
//!  0  1 |  4  5
//!  3  2 |  7  6
//! ------+------
//!  8  9 | 12 13
//! 11 10 | 15 14
//! ```
//!
//! The paper does not say on which side of the array units 1 and 2 are, or on which side of a unit
//! piezoresistor 2 is; here both are on the upper side.

use ridgetone_proto::settings::TAXELS;
use ridgetone_proto::telemetry::{Image, Pressed};

/// Distance between the centres of two units, millimetres (Oddo et al. 2009, section 2.1).
pub const UNIT_PITCH_MM: f64 = 2.3;

/// Rows and columns of the map.
pub const SIDE: usize = 4;

/// Taxel at each position of the map: rows from the top, each along the sliding direction.
pub const PLACES: [[usize; SIDE]; SIDE] =
    [[0, 1, 4, 5], [3, 2, 7, 6], [8, 9, 12, 13], [11, 10, 15, 14]];

/// Arranges values of the taxels as a map.
///
/// ```
/// let taxels = std::array::from_fn(|taxel| taxel);
/// assert_eq!(ridgetone_host::static_image::map(&taxels)[1], [3, 2, 7, 6]);
/// ```
pub fn map<T: Copy>(by_taxel: &[T; TAXELS]) -> [[T; SIDE]; SIDE] {
    PLACES.map(|row| row.map(|taxel| by_taxel[taxel]))
}

/// Returns the levels of an image by taxel; `None` for a dead taxel.
pub fn by_taxel(image: &Image) -> [Option<Pressed>; TAXELS] {
    std::array::from_fn(|taxel| {
        image
            .taxels
            .iter()
            .find(|found| usize::from(found.taxel) == taxel)
            .copied()
    })
}

/// Returns the levels of an image as a map, in volts; `None` for a dead taxel.
pub fn map_v(image: &Image) -> [[Option<f32>; SIDE]; SIDE] {
    map(&by_taxel(image)).map(|row| row.map(|found| found.map(|pressed| pressed.level_v)))
}

/// Formats the rows of an image's map in millivolts, with the given width and decimals per value.
pub fn rows(image: &Image, width: usize, decimals: usize) -> [String; SIDE] {
    let value = |(column, found): (usize, Option<f32>)| {
        let gap = if column == SIDE / 2 { " |" } else { "" };
        match found {
            Some(level_v) => format!("{gap}{:>+width$.decimals$}", 1e3 * level_v),
            None => format!("{gap}{:>width$}", "dead"),
        }
    };
    map_v(image).map(|row| row.into_iter().enumerate().map(value).collect())
}

/// Formats the map of an image as four lines of text in millivolts, each indented by `indent`.
pub fn text(image: &Image, indent: &str) -> String {
    rows(image, 9, 3)
        .map(|row| format!("{indent}{row}\n"))
        .concat()
}

/// Returns the largest standard error of an image, in volts; `None` if all taxels are dead.
pub fn max_sigma_v(image: &Image) -> Option<f32> {
    image
        .taxels
        .iter()
        .map(|found| found.sigma_v)
        .max_by(f32::total_cmp)
}

#[cfg(test)]
mod tests {
    use super::*;
    use hal_mock::{Finger, Sliding, SlidingScene};
    use ridgetone_proto::telemetry::Hold;

    fn pressed(taxel: u8) -> Pressed {
        Pressed {
            taxel,
            level_v: 1e-3 * taxel as f32 - 5e-3,
            sigma_v: 1e-6 * (16 - taxel) as f32,
        }
    }

    fn image() -> Image {
        Image {
            start_us: 1_000_000,
            end_us: 1_600_000,
            frames: 145,
            hold: Hold::BeforeSlide,
            taxels: (0..16u8).filter(|taxel| *taxel != 6).map(pressed).collect(),
        }
    }

    #[test]
    fn every_taxel_has_one_place() {
        let mut taxels = PLACES.concat();
        taxels.sort();
        assert_eq!(taxels, (0..TAXELS).collect::<Vec<_>>());
    }

    /// Compares the positions of units with those in the scene: a ridge at rest presses on the half
    /// of the map above it.
    #[test]
    fn the_halves_of_the_map_are_the_scenes_columns_of_units() {
        let finger = Some(Finger {
            spread: 0.0,
            resistance_spread: 0.0,
            ..Finger::default()
        });
        let mean_of = |start_mm: f64| {
            // The grating is so coarse that a ridge is under one column only.
            let sliding = Sliding {
                start_mm,
                period_mm: 4.6,
                finger,
                ..Sliding::default()
            };
            let scene = SlidingScene::new(sliding).unwrap();
            let hold_s = scene.truth().slide_start_s - 0.1;
            let map = map(&std::array::from_fn(|c| {
                scene.clean_volts(c as u8, hold_s) - scene.clean_volts(c as u8, 0.0)
            }));
            let half = |columns: [usize; 2]| {
                map.iter()
                    .map(|row| columns.map(|c| row[c].abs()).iter().sum::<f64>())
                    .sum::<f64>()
            };
            (half([0, 1]), half([2, 3]))
        };
        let (behind, ahead) = (mean_of(-1.15), mean_of(1.15));
        assert!(
            behind.0 > 1.2 * behind.1 && ahead.1 > 1.2 * ahead.0,
            "{behind:?} {ahead:?}"
        );
    }

    #[test]
    fn a_map_in_text_has_a_row_a_line_and_marks_the_dead() {
        let expected = [
            "|   -5.000   -4.000 |   -1.000   +0.000",
            "|   -2.000   -3.000 |   +2.000     dead",
            "|   +3.000   +4.000 |   +7.000   +8.000",
            "|   +6.000   +5.000 |  +10.000   +9.000",
        ];
        let text = text(&image(), "|");
        assert_eq!(text.lines().collect::<Vec<_>>(), expected);
        assert_eq!(max_sigma_v(&image()), Some(16e-6));
        assert_eq!(
            max_sigma_v(&Image {
                taxels: Default::default(),
                ..image()
            }),
            None
        );
    }
}
