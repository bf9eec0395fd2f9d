//! What the paper says, typed once: Oddo et al., "Artificial roughness encoding with a bio-inspired
//! MEMS-based tactile sensor array", Sensors 9 (2009), 3161-3183.

/// Combinations of speed and spatial period, C1 to C10.
pub const COMBINATIONS: usize = 10;

/// Runs of each combination (section 3.2).
pub const RUNS: u32 = 4;

/// Spatial periods of the four gratings, mm (Table 1).
pub const GRATINGS_MM: [f64; 4] = [2.6, 3.1, 3.6, 4.1];

/// Expected frequency of C1 to C10 in hertz, as printed: Table 2, and the top row of Table 3.
pub const FREQUENCY_HZ: [f64; COMBINATIONS] = [
    4.17, 8.33, 3.66, 7.32, 4.84, 9.68, 15.48, 5.77, 11.54, 18.46,
];

/// Combinations that the paper's Table 2 names and did not test: mm/s, mm, Hz.
pub const NOT_TESTED: [(f64, f64, f64); 2] = [(48.0, 4.1, 11.71), (48.0, 3.6, 13.33)];

/// A method's RMS errors in Table 3, C1 to C10.
#[derive(Clone, Copy, Debug)]
pub struct Errors {
    pub hz: [f64; COMBINATIONS],
    /// In percent of the nominal frequency.
    pub percent: [f64; COMBINATIONS],
}

/// Table 3 for one pair of channels.
#[derive(Clone, Copy, Debug)]
pub struct PairErrors {
    /// The two channels, taxels as AIN numbers: 4 (unit - 1) + piezoresistor - 1.
    pub taxels: [usize; 2],
    /// By the periodogram's highest line.
    pub fft: Errors,
    /// By least squares.
    pub least_squares: Errors,
}

/// Table 3: piezoresistor 1 of units 1 and 2, and of units 4 and 2.
pub const TABLE_3: [PairErrors; 2] = [
    PairErrors {
        taxels: [0, 4],
        fft: Errors {
            hz: [
                0.072, 0.135, 0.113, 0.182, 0.078, 0.168, 0.286, 0.033, 0.053, 0.063,
            ],
            percent: [1.72, 1.62, 3.1, 2.49, 1.62, 1.73, 1.85, 0.57, 0.46, 0.34],
        },
        least_squares: Errors {
            hz: [
                0.038, 0.105, 0.027, 0.058, 0.052, 0.123, 0.257, 0.053, 0.124, 0.272,
            ],
            percent: [0.91, 1.26, 0.73, 0.79, 1.08, 1.27, 1.66, 0.93, 1.07, 1.47],
        },
    },
    PairErrors {
        taxels: [12, 4],
        fft: Errors {
            hz: [
                0.072, 0.135, 0.1, 0.152, 0.075, 0.165, 0.257, 0.036, 0.059, 0.189,
            ],
            percent: [1.72, 1.61, 2.74, 2.08, 1.56, 1.7, 1.66, 0.62, 0.52, 1.03],
        },
        least_squares: Errors {
            hz: [
                0.04, 0.127, 0.029, 0.063, 0.06, 0.126, 0.262, 0.055, 0.123, 0.266,
            ],
            percent: [0.97, 1.52, 0.78, 0.87, 1.24, 1.31, 1.69, 0.95, 1.07, 1.44],
        },
    },
];

/// Average Pearson correlation of the runs of a combination, least and greatest over the
/// combinations: piezoresistor 1 of unit 1 and of unit 2 (section 4, "Repeatability").
pub const REPEATABILITY: [(f64, f64); 2] = [(0.87, 0.97), (0.80, 0.89)];

/// Readings of each channel a second (section 2.3).
#[cfg(test)]
const FRAME_RATE_HZ: f64 = 241.0;
/// Time before which the contact spike is looked for, seconds: t_init (equation 2).
pub const SPIKE_BEFORE_S: f64 = 0.8;
/// From the spike to the slide, seconds: delta t (equation 4).
pub const DELAY_S: f64 = 1.0;
/// Part of the 60 mm that is used, mm: L_eff (equation 5).
pub const LENGTH_MM: f64 = 55.0;
/// Steps of a window's start in Figure 7, seconds (section 3.2, "Least squares fitting").
pub const STEP_S: f64 = 0.05;
/// Shortest and longest window of Figure 7, seconds.
pub const WINDOWS_S: (f64, f64) = (0.2, 1.0);

/// Number of a data series as the paper counts them, 1 to 40: combination and run from 0 on.
pub const fn series(combination: usize, run: u32) -> usize {
    combination * RUNS as usize + run as usize + 1
}

#[cfg(test)]
mod tests {
    use super::*;
    use hal_mock::TABLE_2;

    #[test]
    fn the_table_agrees_with_itself() {
        for (c, (speed_mm_s, period_mm)) in TABLE_2.into_iter().enumerate() {
            assert!(
                (speed_mm_s / period_mm - FREQUENCY_HZ[c]).abs() < 0.006,
                "C{}",
                c + 1
            );
            for pair in TABLE_3 {
                for errors in [pair.fft, pair.least_squares] {
                    // Both columns are rounded: hertz to a thousandth, percent to a hundredth.
                    let percent = 100.0 * errors.hz[c] / FREQUENCY_HZ[c];
                    let rounding = 0.0051 + 100.0 * 0.00051 / FREQUENCY_HZ[c];
                    assert!(
                        (percent - errors.percent[c]).abs() < rounding,
                        "C{} {:?}: {percent}",
                        c + 1,
                        pair.taxels
                    );
                }
            }
        }
    }

    #[test]
    fn series_are_counted_as_in_the_paper() {
        // Table 3: runs 17-20 are C5, 25-28 are C7.
        assert_eq!((series(0, 0), series(4, 3), series(6, 0)), (1, 20, 25));
    }

    /// The page's figure of 45 %: by how much more amplitude unit 1 would have than unit 2 if the
    /// same noise on both made the paper's correlations. A correlation of r is a noise of (1 - r) /
    /// r of the signal's power.
    #[test]
    fn the_papers_repeatability_needs_an_edge_stronger_by_45_percent() {
        let [one, two] = REPEATABILITY.map(|(least, most)| 0.5 * (least + most));
        let noise = |r: f64| (1.0 - r) / r;
        assert!((100.0 * ((noise(two) / noise(one)).sqrt() - 1.0) - 45.0).abs() < 0.5);
    }

    /// The page's figures of f_C / N and f_C / (N - 1).
    #[test]
    fn the_papers_lines_are_those_of_one_sample_less() {
        // C3 and C4 are close to the middle between two lines: their errors are of both.
        let off_hz = |samples_less: f64| {
            let tested = TABLE_2
                .into_iter()
                .zip(TABLE_3[0].fft.hz)
                .enumerate()
                .filter(|(c, _)| ![2, 3].contains(c));
            let squares = tested.map(|(_, ((speed_mm_s, period_mm), error_hz))| {
                let nominal_hz = speed_mm_s / period_mm;
                let line_hz = 1.0 / (LENGTH_MM / speed_mm_s - samples_less / FRAME_RATE_HZ);
                let nearest_hz = (nominal_hz / line_hz).round() * line_hz;
                ((nearest_hz - nominal_hz).abs() - error_hz).powi(2)
            });
            (squares.sum::<f64>() / 8.0).sqrt()
        };
        // C10 by hand: 55 mm at 48 mm/s are 276 samples, and 21 * 241 / 275 is 0.058 Hz below 18.46
        // Hz; the paper errs by 0.063 Hz. 21 * 48 / 55 is 0.134 Hz below it.
        assert!((off_hz(1.0) - 0.004).abs() < 0.0005 && (off_hz(0.0) - 0.037).abs() < 0.0005);
        assert!(off_hz(1.0) < off_hz(0.5) && off_hz(1.0) < off_hz(1.5));
    }
}
