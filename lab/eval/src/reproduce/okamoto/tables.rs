//! The tables of the other paper's figures.

use super::errors::Errors;
use super::motion::Motion;
use super::paper::{FITTED_MM, POLYNOMIAL, R2, SPEEDS_MM_S, WAVELENGTHS_MM};
use super::scan::Scan;
use super::skin::Skin;
use crate::page::{Table, figure};
use nalgebra::{DMatrix, DVector};
use ridgetone_host::digits::significant;

fn percent(share: Option<f64>) -> String {
    share.map_or_else(|| "-".into(), |share| significant(100.0 * share, 2))
}

/// Figures 8 and 9, with a skin.
pub fn wavelengths(scans: &[Scan], skin: Skin) -> String {
    let headings = "speed, mm/s|wavelength, mm|FFT of 32 ms, %|bound of 32 ms, %|firmware, 32 ms, %|good|error / sigma|held, %|\
                    bound, up to 128 ms, %|firmware, %|good|error / sigma|held, %|wrong but good";
    let mut table = Table::new(1, headings);
    for scan in scans.iter().filter(|scan| scan.skin == skin) {
        let speed = match scan.motion {
            Motion::Steady(speed_mm_s) => speed_mm_s.to_string(),
            Motion::Hand if scan.is_turning => "197 sin(2 pi 1.07 t), turning".into(),
            Motion::Hand => "197 sin(2 pi 1.07 t), one way".into(),
        };
        let of = |errors: &Errors| {
            [
                percent(errors.bound()),
                percent(errors.rms()),
                format!("{} of {}", errors.good, errors.windows),
                figure(errors.rms_over_sigma(), 2),
                figure(errors.held_share().map(|share| 100.0 * share), 0),
            ]
        };
        let mut row = vec![speed, scan.wavelength_mm.to_string(), percent(scan.fft)];
        row.extend(of(&scan.short).into_iter().chain(of(&scan.long)));
        row.push((scan.short.wrong + scan.long.wrong).to_string());
        table.row(&row);
    }
    table.end()
}

/// Figures 10 and 11, with a skin.
pub fn powers(scans: &[Scan], skin: Skin) -> String {
    let mut table = Table::new(
        0,
        "wavelength, mm|73.5 mm/s, mV^2|125.4 mm/s|177.4 mm/s|most over least|the paper's equation 2",
    );
    for wavelength_mm in WAVELENGTHS_MM {
        let of = |speed_mm_s| {
            let wanted = (wavelength_mm, Motion::Steady(speed_mm_s), skin);
            scans
                .iter()
                .find(|scan| (scan.wavelength_mm, scan.motion, scan.skin) == wanted)
        };
        let powers: Vec<Option<f64>> = SPEEDS_MM_S
            .iter()
            .map(|speed_mm_s| of(*speed_mm_s).and_then(|scan| scan.power_mv2))
            .collect();
        let known: Vec<f64> = powers.iter().flatten().copied().collect();
        let spread = (known.len() == powers.len()).then(|| {
            known.iter().fold(0.0, |most: f64, one| most.max(*one))
                / known
                    .iter()
                    .fold(f64::MAX, |least: f64, one| least.min(*one))
        });
        let paper = POLYNOMIAL
            .iter()
            .rev()
            .fold(0.0, |sum, factor| sum * wavelength_mm + factor);
        let mut row = vec![wavelength_mm.to_string()];
        row.extend(powers.iter().map(|power| figure(*power, 5)));
        row.extend([
            figure(spread, 2),
            figure(FITTED_MM.contains(&wavelength_mm).then_some(paper), 0),
        ]);
        table.row(&row);
    }
    table.end()
}

/// The polynomial of fourth order through the powers of [`FITTED_MM`], at all speeds, from the
/// constant on; and its coefficient of determination.
pub fn polynomial(scans: &[Scan], skin: Skin) -> Option<([f64; 5], f64)> {
    let is_steady = |scan: &&Scan| {
        scan.skin == skin && scan.motion != Motion::Hand && FITTED_MM.contains(&scan.wavelength_mm)
    };
    let points: Vec<(f64, f64)> = scans
        .iter()
        .filter(is_steady)
        .filter_map(|scan| Some((scan.wavelength_mm, scan.power_mv2?)))
        .collect();
    if points.len() < POLYNOMIAL.len() {
        return None;
    }
    let powers = DVector::from_iterator(points.len(), points.iter().map(|point| point.1));
    let terms = DMatrix::from_fn(points.len(), POLYNOMIAL.len(), |row, order| {
        points[row].0.powi(order as i32)
    });
    let factors = terms.clone().svd(true, true).solve(&powers, 1e-12).ok()?;
    let (left, mean) = (&terms * &factors - &powers, powers.mean());
    let r2 = 1.0 - left.norm_squared() / powers.map(|power| power - mean).norm_squared();
    Some((std::array::from_fn(|order| factors[order]), r2))
}

/// Equation 2, and those of both skins.
pub fn polynomials(scans: &[Scan]) -> String {
    let mut table = Table::new(1, "power|lambda^4|lambda^3|lambda^2|lambda|1|R^2");
    let mut row = |name: &str, factors: [f64; 5], r2: f64, decimals| {
        let factors = factors
            .iter()
            .rev()
            .map(|factor| figure(Some(*factor), decimals));
        table.row(
            &[
                vec![name.into()],
                factors.collect(),
                vec![figure(Some(r2), 4)],
            ]
            .concat(),
        );
    };
    row("the paper's equation 2, its unit", POLYNOMIAL, R2, 0);
    for (skin, name) in [
        (Skin::Ridged, "ridged skin, mV^2"),
        (Skin::Smooth, "smooth skin, mV^2"),
    ] {
        if let Some((factors, r2)) = polynomial(scans, skin) {
            row(name, factors, r2, 4);
        }
    }
    table.end()
}
