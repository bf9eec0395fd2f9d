//! The figures of Okamoto et al. beside ours, as tables, and their picture.

use super::errors::Errors;
use super::motion::Motion;
use super::paper::{FITTED_MM, POLYNOMIAL, R2, SPEEDS_MM_S, WAVELENGTHS_MM};
use super::scan::Scan;
use super::skin::Skin;
use crate::page::{Table, Tables, figure, fixed};
use nalgebra::{DMatrix, DVector};
use ridgetone_host::chart::{Curve, Look, Panel, Scale, chart};
use serde_json::Value;

const SKINS: [(Skin, &str); 2] = [(Skin::Ridged, "ridged"), (Skin::Smooth, "smooth")];

/// Columns of the table of wavelengths that are drawn: FFT, bound and firmware in 32 ms, and
/// firmware in the longer window.
const DRAWN: [(usize, &str); 4] = [
    (3, "FFT of 32 ms"),
    (5, "firmware, 32 ms"),
    (11, "firmware, for 0.5 %"),
    (4, "bound of 32 ms"),
];

pub fn tables(scans: &[Scan]) -> Tables {
    Tables::from([
        ("okamoto_wavelengths".into(), wavelengths(scans)),
        ("okamoto_motions".into(), motions(scans)),
        ("okamoto_powers".into(), powers(scans)),
        ("okamoto_polynomials".into(), polynomials(scans)),
    ])
}

fn motion(scan: &Scan) -> String {
    match scan.motion {
        Motion::Steady(speed_mm_s) => format!("{speed_mm_s} mm/s"),
        Motion::Hand if scan.is_turning => "hand, turning".into(),
        Motion::Hand => "hand, one way".into(),
    }
}

/// Figures 8 and 9: every scale at every motion under both skins.
fn wavelengths(scans: &[Scan]) -> Table {
    let of = |window: &str| {
        format!("bound, {window}, %|firmware, {window}, %|good|windows|error / sigma|held, %")
    };
    let mut table = Table::new(&format!(
        "skin|motion|wavelength, mm|FFT of 32 ms, %|{}|{}|wrong but good",
        of("32 ms"),
        of("up to 128 ms")
    ));
    for (skin, name) in SKINS {
        for scan in scans.iter().filter(|scan| scan.skin == skin) {
            let percent = |share: Option<f64>| figure(share.map(|share| 100.0 * share), 2);
            let of = |errors: &Errors| {
                [
                    percent(errors.bound()),
                    percent(errors.rms()),
                    errors.good.into(),
                    errors.windows.into(),
                    fixed(errors.rms_over_sigma(), 2),
                    fixed(errors.held_share().map(|share| 100.0 * share), 1),
                ]
            };
            let first = [
                name.into(),
                motion(scan).into(),
                scan.wavelength_mm.into(),
                percent(scan.fft),
            ];
            let wrong = [Value::from(scan.short.wrong + scan.long.wrong)];
            let cells = first
                .into_iter()
                .chain(of(&scan.short))
                .chain(of(&scan.long));
            table.row(cells.chain(wrong));
        }
    }
    table
}

/// Figures 8 and 9 by skin and kind of motion, all scales together.
fn motions(scans: &[Scan]) -> Table {
    let mut table = Table::new(
        "skin|motion|FFT: greatest, %|firmware, 32 ms: greatest, %|good|windows|held, %|\
         firmware, up to 128 ms: greatest, %|good|windows|held, %|wrong but good",
    );
    for (skin, name) in SKINS {
        type IsOfKind = fn(&Scan) -> bool;
        let kinds: [(&str, IsOfKind); 3] = [
            ("steady", |scan| scan.motion != Motion::Hand),
            ("hand, one way", |scan| {
                scan.motion == Motion::Hand && !scan.is_turning
            }),
            ("hand, turning", |scan| scan.is_turning),
        ];
        for (kind, is_own) in kinds {
            let own: Vec<&Scan> = scans
                .iter()
                .filter(|scan| scan.skin == skin && is_own(scan))
                .collect();
            let greatest = |shares: &dyn Fn(&Scan) -> Option<f64>| {
                let all = own.iter().filter_map(|scan| shares(scan));
                figure(all.reduce(f64::max).map(|share| 100.0 * share), 2)
            };
            let sums = |of: fn(&Scan) -> &Errors| {
                let sum = |count: &dyn Fn(&Errors) -> f64| {
                    own.iter().map(|scan| count(of(scan))).sum::<f64>()
                };
                let good = sum(&|errors| errors.good as f64);
                let held = sum(&|errors| errors.held_share().unwrap_or(0.0) * errors.good as f64);
                let windows = sum(&|errors| errors.windows as f64);
                let held = (good > 0.0).then(|| 100.0 * held / good);
                [fixed(good, 0), fixed(windows, 0), fixed(held, 1)]
            };
            let wrong: usize = own
                .iter()
                .map(|scan| scan.short.wrong + scan.long.wrong)
                .sum();
            let first = [name.into(), kind.into(), greatest(&|scan| scan.fft)];
            let short = [greatest(&|scan| scan.short.rms())]
                .into_iter()
                .chain(sums(|scan| &scan.short));
            let long = [greatest(&|scan| scan.long.rms())]
                .into_iter()
                .chain(sums(|scan| &scan.long));
            table.row(
                first
                    .into_iter()
                    .chain(short)
                    .chain(long)
                    .chain([wrong.into()]),
            );
        }
    }
    table
}

/// Equation 2 at a wavelength, in the paper's unit.
fn of_the_paper(wavelength_mm: f64) -> Option<f64> {
    let power = POLYNOMIAL
        .iter()
        .rev()
        .fold(0.0, |sum, factor| sum * wavelength_mm + factor);
    FITTED_MM.contains(&wavelength_mm).then_some(power)
}

/// Figures 10 and 11.
fn powers(scans: &[Scan]) -> Table {
    let speeds = SPEEDS_MM_S
        .map(|speed| format!("{speed} mm/s, mV^2"))
        .join("|");
    let mut table = Table::new(&format!(
        "skin|wavelength, mm|{speeds}|most over least|the paper's equation 2"
    ));
    for (skin, name) in SKINS {
        for wavelength_mm in WAVELENGTHS_MM {
            let of = |speed_mm_s| {
                let wanted = (wavelength_mm, Motion::Steady(speed_mm_s), skin);
                let is_own = |scan: &&Scan| (scan.wavelength_mm, scan.motion, scan.skin) == wanted;
                scans.iter().find(is_own).and_then(|scan| scan.power_mv2)
            };
            let powers = SPEEDS_MM_S.map(of);
            let known = powers.iter().flatten().copied();
            let (least, most) = known.fold((f64::MAX, 0.0), |(a, b): (f64, f64), power| {
                (a.min(power), b.max(power))
            });
            let spread = powers.iter().all(Option::is_some).then(|| most / least);
            let first = [Value::from(name), wavelength_mm.into()];
            let paper = [fixed(spread, 2), fixed(of_the_paper(wavelength_mm), 0)];
            table.row(
                first
                    .into_iter()
                    .chain(powers.map(|power| fixed(power, 5)))
                    .chain(paper),
            );
        }
    }
    table
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
fn polynomials(scans: &[Scan]) -> Table {
    let mut table = Table::new("power|1|lambda|lambda^2|lambda^3|lambda^4|R^2");
    let mut row = |name: String, factors: [f64; 5], r2: f64| {
        let figures = factors.map(|factor| fixed(factor, 4));
        table.row(
            [Value::from(name)]
                .into_iter()
                .chain(figures)
                .chain([fixed(r2, 4)]),
        );
    };
    row("the paper's equation 2, its unit".into(), POLYNOMIAL, R2);
    for (skin, name) in SKINS {
        if let Some((factors, r2)) = polynomial(scans, skin) {
            row(format!("{name} skin, mV^2"), factors, r2);
        }
    }
    table
}

/// Figures 8 and 9 with the ridged skin, from the table of wavelengths: a panel for the fastest
/// steady motion and one for the hand.
pub fn picture(wavelengths: &Table) -> String {
    let panel = |motion: &str, title: &str| {
        let own = || {
            wavelengths
                .rows
                .iter()
                .filter(|row| row[0] == "ridged" && row[1] == motion)
        };
        let curve = |(number, (column, name)): (usize, (usize, &str))| {
            let point = |row: &Vec<Value>| Some((row[2].as_f64()?, row[column].as_f64()?));
            let is_bound = number == DRAWN.len() - 1;
            let look = if is_bound {
                Look::Reference
            } else {
                Look::Marked(number)
            };
            Curve {
                name: name.into(),
                look,
                points: own().filter_map(point).collect(),
            }
        };
        Panel {
            title: title.into(),
            x: Scale {
                label: "wavelength, mm".into(),
                range: Some((0.4, 3.1)),
                ..Scale::default()
            },
            y: Scale {
                label: "RMS error, %".into(),
                is_log: true,
                range: Some((1e-3, 1e2)),
                ..Scale::default()
            },
            curves: DRAWN.into_iter().enumerate().map(curve).collect(),
        }
    };
    let panels = [
        panel("125.4 mm/s", "Figure 8: at 125.4 mm/s"),
        panel(
            "hand, one way",
            "Figure 9: by a hand, 197 sin(2 pi 1.07 t) mm/s, one way",
        ),
    ];
    chart("Errors of wavelengths: theirs, ours and the bound", &panels)
}
