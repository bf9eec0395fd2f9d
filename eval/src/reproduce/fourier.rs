//! Naive Fourier analysis over 55 mm: how far its errors are from the paper's, and what lines the paper's are of.

use super::charts::number;
use super::paper::{FRAME_RATE_HZ, LENGTH_MM, TABLE_3};
use super::results::{Combination, rms};
use hal_mock::TABLE_2;

/// A combination's errors on a pair of channels.
#[derive(Clone, Copy, Debug)]
pub struct Errors<'a> {
    /// The combination.
    pub combination: &'a Combination,
    /// Here, hertz.
    pub here_hz: f64,
    /// In the paper, hertz.
    pub paper_hz: f64,
}

impl Errors<'_> {
    /// How far they are apart, as a part of the distance of two lines.
    pub fn apart_lines(&self) -> f64 {
        (self.here_hz - self.paper_hz).abs() * LENGTH_MM / self.combination.speed_mm_s
    }
}

/// Errors of all combinations on a pair of channels, 0 or 1 in the order of Table 3.
pub fn errors(combinations: &[Combination], pair: usize) -> impl Iterator<Item = Errors<'_>> {
    combinations.iter().filter_map(move |combination| {
        let here_hz = combination.rms_hz(|run| run.pairs.get(pair)?.fft_hz)?;
        let paper_hz = *TABLE_3.get(pair)?.fft.hz.get(number(combination)?)?;
        Some(Errors { combination, here_hz, paper_hz })
    })
}

/// The combinations whose tone is close to the middle between two lines of the paper's, whose errors are of both.
const BETWEEN_LINES: [usize; 2] = [2, 3];

/// By how much the paper's errors on units 1 and 2 differ, RMS in hertz, from those of the lines nearest to the nominal
/// frequencies, where a periodogram's axis is that of so many samples less than there are in 55 mm.
pub fn off_lines_hz(samples_less: f64) -> Option<f64> {
    let tested = TABLE_2.into_iter().zip(TABLE_3[0].fft.hz).enumerate().filter(|(c, _)| !BETWEEN_LINES.contains(c));
    rms(tested.map(|(_, ((speed_mm_s, period_mm), error_hz))| {
        let nominal_hz = speed_mm_s / period_mm;
        let line_hz = 1.0 / (LENGTH_MM / speed_mm_s - samples_less / FRAME_RATE_HZ);
        let nearest_hz = (nominal_hz / line_hz).round() * line_hz;
        Some((nearest_hz - nominal_hz).abs() - error_hz)
    }))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_papers_lines_are_those_of_one_sample_less() {
        // C10 by hand: 55 mm at 48 mm/s are 276 samples, and 21 * 241 / 275 is 0.058 Hz below 18.46 Hz; the paper errs by
        // 0.063 Hz. 21 * 48 / 55 is 0.134 Hz below it.
        let off_hz = |samples_less| off_lines_hz(samples_less).expect("eight combinations");
        assert!(off_hz(1.0) < 0.005 && off_hz(0.0) > 0.03, "{} {}", off_hz(1.0), off_hz(0.0));
        assert!(off_hz(1.0) < off_hz(0.5) && off_hz(1.0) < off_hz(1.5));
    }
}
