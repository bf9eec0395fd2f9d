//! `calibrate`: the constants that turn phases into spatial periods, from recordings of gratings of
//! known period.
//!
//! The lag between the columns of units is modelled as a straight line over the grating's cycles
//! per millimetre ([`Array::edge_phase_rad`]); here the line is fitted to measured lags by least
//! squares. One or two gratings determine only its height; its slope is then the nominal pitch.

use crate::frames::Frames;
use crate::input::Input;
use crate::names::name as name_of;
use crate::replay;
use anyhow::{Context, Result, bail, ensure};
use ridgetone_proto::plan::Plan;
use ridgetone_proto::settings::{Array, Settings};
use ridgetone_proto::telemetry::{Event, Packet, Span, Status, TravelStatus};
use serde::Serialize;
use std::collections::BTreeMap;
use std::f64::consts::TAU;
use std::fmt;

/// Minimum number of gratings to fit the pitch: two define a line, a third shows how straight it
/// is.
const GRATINGS_FOR_A_PITCH: usize = 3;

/// Relative standard deviation of a pitch measured from phases. On the simulated finger, with
/// contacts of 7 to 30 mm, that pitch was 0.98 to 1.03 of the units' pitch
/// (`host/tests/calibrate.rs`).
const PITCH_SIGMA: f64 = 0.03;

/// Maximum relative difference between the supplied speed and that of the tone: a grating of a
/// different period, or a harmonic, differs by more.
const SPEED_OFF_MAX: f64 = 0.03;

/// Maximum ratio of the period computed with the nominal pitch to the true period: the contact's
/// ends then change the lag by a fifth.
const PULLED_MAX: f32 = 1.25;

/// Longest period, in nominal pitches of the array: at two, the directions cannot be told apart.
const PITCHES_MAX: f32 = 1.98;

pub struct Grating {
    pub name: String,
    pub period_mm: f64,
    pub source: Source,
}

pub enum Source {
    /// Scene to play to the simulated chip.
    Scene(Box<Input>),
    Recording(Frames),
}

#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Point {
    pub period_mm: f64,
    /// Lag between the columns, radians.
    pub lag_rad: f64,
    pub residual_rad: f64,
    /// Number of windows in the mean.
    pub windows: usize,
}

/// The fitted line, as constants of an [`Array`].
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Calibration {
    pub pitch_mm: f64,
    pub edge_phase_rad: f64,
    pub edge_phase_sigma_rad: f64,
    pub gratings: Vec<Point>,
}

/// Options for measuring the gratings.
#[derive(Clone, Copy, Debug)]
pub struct Measuring {
    /// Nominal pitch of the units.
    pub pitch_mm: f32,
    /// Speed of the gratings, if it is known.
    pub speed_mm_s: Option<f64>,
    /// Plan for scenes; recordings have their own.
    pub plan: Plan,
    /// True to use windows of any status, not only good ones.
    pub accepts_any: bool,
}

/// Measures gratings of known periods and fits the line.
pub fn run(gratings: Vec<Grating>, how: Measuring) -> Result<Calibration> {
    ensure!(
        !gratings.is_empty(),
        "no grating: one at least is needed, and {GRATINGS_FOR_A_PITCH} for the pitch"
    );
    let points = gratings
        .into_iter()
        .map(|grating| measure(grating, how))
        .collect::<Result<Vec<_>>>()?;
    if points.len() < GRATINGS_FOR_A_PITCH {
        Ok(height(points, how.pitch_mm.into()))
    } else {
        line(points)
    }
}

/// Refuses a plan unless it converts, in both columns, piezoresistors that respond alike.
fn refuse_without_pairs(plan: &Plan) -> Result<()> {
    let Array { front, alike, .. } = Array::DEFAULT;
    let has_pair = |mask: &u16| plan.inputs & mask & front != 0 && plan.inputs & mask & !front != 0;
    let name = plan.name().unwrap_or("of this recording");
    ensure!(
        alike.iter().any(has_pair),
        "the plan {name} converts no two alike inputs, one in each column: choose paper, hand, texture or vibration"
    );
    Ok(())
}

/// Measures the lag of a grating, assuming an array of nominal pitch and no effect of the contact's
/// ends.
fn measure(
    Grating {
        name,
        period_mm,
        source,
    }: Grating,
    how: Measuring,
) -> Result<Point> {
    let Measuring {
        pitch_mm,
        plan,
        accepts_any,
        ..
    } = how;
    let near = period_mm as f32;
    let array = Array {
        pitch_mm,
        edge_phase_rad: 0.0,
        // Do not correct: the lag itself is to be measured.
        edge_phase_sigma_rad: 0.0,
        period_min_mm: 0.98 * near,
        period_max_mm: (PULLED_MAX * near).min(PITCHES_MAX * pitch_mm),
        ..Array::DEFAULT
    };
    let (plan, vref_v) = match &source {
        Source::Scene(_) => (plan, Settings::DEFAULT.vref_v),
        Source::Recording(frames) => (frames.plan(), frames.settings.vref_v),
    };
    refuse_without_pairs(&plan).with_context(|| name.clone())?;
    let settings = Settings {
        array,
        vref_v,
        ..Settings::DEFAULT.with_plan(plan)
    };
    settings.validate().with_context(|| name.clone())?;
    let (mut first, mut lags, mut doubtful) = (true, Vec::new(), 0);
    let mut speeds_mm_s = Vec::new();
    let mut left_out = BTreeMap::<String, u32>::new();
    let mut sink = |packet: &Packet| {
        let Event::Estimate(fit) = &packet.event else {
            first |= matches!(&packet.event, Event::Slide(slide) if slide.end_us.is_none());
            return Ok(());
        };
        // Skip a slide's first window and the whole slide: both contain the onset of friction.
        if fit.span == Span::Window && !std::mem::take(&mut first) {
            if fit.status != Status::Good && !accepts_any {
                *left_out.entry(name_of(fit.status).to_string()).or_default() += 1;
                return Ok(());
            }
            match fit.travel.status {
                TravelStatus::Unique => {
                    lags.push(TAU * f64::from(pitch_mm) / f64::from(fit.travel.spatial_period_mm));
                    speeds_mm_s.push(f64::from(fit.frequency) * period_mm);
                }
                _ => doubtful += 1,
            }
        }
        Ok(())
    };
    match &source {
        Source::Scene(input) => {
            let input = input.open_in(&plan)?;
            replay::run(input, settings, &mut sink, &mut |_, _| {})?;
        }
        Source::Recording(frames) => frames.run(&settings, false, &mut sink, &mut |_, _| {})?,
    }
    if lags.is_empty() && doubtful == 0 && !left_out.is_empty() {
        let statuses = left_out
            .iter()
            .map(|(status, count)| format!("{count} `{status}`"));
        let statuses = statuses.collect::<Vec<_>>().join(", ");
        bail!(
            "{name}: no window is good: {statuses}; slide more steadily, or take them as they are with --accept"
        );
    }
    ensure!(
        lags.len() + doubtful > 0,
        "{name}: no slide of two seconds: give the recording of a touch from before its contact on, in volts"
    );
    if lags.len() <= doubtful {
        bail!(
            "{name}: the phases of {doubtful} of {} windows do not fit a period of {period_mm} mm: gratings have to be between \
             one pitch and 1.75, and to slide over the whole array; a scene without a finger has random phases, use one such \
             as hal-mock/scenes/c1.toml",
            lags.len() + doubtful
        );
    }
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
    let (lag_rad, found_mm_s) = (mean(&lags), mean(&speeds_mm_s));
    if let Some(speed_mm_s) = how.speed_mm_s {
        ensure!(
            (found_mm_s / speed_mm_s - 1.0).abs() < SPEED_OFF_MAX,
            "{name}: by its tone a grating of {period_mm} mm moves at {found_mm_s:.2} mm/s, where --speed is {speed_mm_s}: \
             give the period of this grating, or its own speed"
        );
    }
    Ok(Point {
        period_mm,
        lag_rad,
        residual_rad: 0.0,
        windows: lags.len(),
    })
}

/// Fits the height of a line to one or two lags, with the nominal pitch as its slope. The
/// uncertainty includes that of the pitch, evaluated at the end of the default range of periods
/// that is farther from the gratings.
fn height(mut points: Vec<Point>, pitch_mm: f64) -> Calibration {
    let count = points.len() as f64;
    let edge = |point: &Point| TAU * pitch_mm / point.period_mm - point.lag_rad;
    let edge_phase_rad = points.iter().map(edge).sum::<f64>() / count;
    let (mut squares, mut wave) = (0.0, 0.0);
    for point in &mut points {
        point.residual_rad = edge_phase_rad - edge(point);
        squares += point.residual_rad * point.residual_rad / count;
        wave += TAU / point.period_mm / count;
    }
    let Array {
        period_min_mm,
        period_max_mm,
        ..
    } = Array::DEFAULT;
    let from = |period_mm: f32| (TAU / f64::from(period_mm) - wave).abs();
    let furthest = from(period_min_mm).max(from(period_max_mm));
    Calibration {
        pitch_mm,
        edge_phase_rad,
        edge_phase_sigma_rad: (PITCH_SIGMA * pitch_mm * furthest).hypot(squares.sqrt()),
        gratings: points,
    }
}

/// Fits a straight line to the lags over the wave number by least squares.
fn line(mut points: Vec<Point>) -> Result<Calibration> {
    let count = points.len() as f64;
    let mean = |of: &dyn Fn(&Point) -> f64| points.iter().map(of).sum::<f64>() / count;
    let wave = |point: &Point| TAU / point.period_mm;
    let (middle, lag) = (mean(&wave), mean(&|point| point.lag_rad));
    let spread = mean(&|point| (wave(point) - middle).powi(2));
    ensure!(
        spread.sqrt() > 0.02 * middle,
        "the gratings' periods are too similar: choose for example 2.5, 3 and 4 mm"
    );
    let pitch_mm = mean(&|point| (wave(point) - middle) * (point.lag_rad - lag)) / spread;
    let edge_phase_rad = pitch_mm * middle - lag;
    let mut squares = 0.0;
    for point in &mut points {
        point.residual_rad = point.lag_rad - (pitch_mm * TAU / point.period_mm - edge_phase_rad);
        squares += point.residual_rad * point.residual_rad;
    }
    let edge_phase_sigma_rad = (squares / (count - 2.0)).sqrt();
    Ok(Calibration {
        pitch_mm,
        edge_phase_rad,
        edge_phase_sigma_rad,
        gratings: points,
    })
}

impl fmt::Display for Calibration {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "period       lag          residual  windows")?;
        for Point {
            period_mm,
            lag_rad,
            residual_rad,
            windows,
        } in &self.gratings
        {
            writeln!(
                f,
                "{period_mm:>6.3} mm {lag_rad:>7.4} rad {residual_rad:>12.4} rad {windows:>8}"
            )?;
        }
        writeln!(
            f,
            "ridgetone settings set --keep array.pitch_mm={:.4} array.edge_phase_rad={:.4} array.edge_phase_sigma_rad={:.4}",
            self.pitch_mm, self.edge_phase_rad, self.edge_phase_sigma_rad
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ridgetone_finger::converter::Ads1258Plan;

    fn points(of: &[(f64, f64)]) -> Vec<Point> {
        of.iter()
            .map(|&(period_mm, lag_rad)| Point {
                period_mm,
                lag_rad,
                residual_rad: 0.0,
                windows: 1,
            })
            .collect()
    }

    #[test]
    fn a_straight_line_comes_back() {
        let lags: Vec<_> = [2.5, 3.0, 4.0]
            .map(|period_mm| (period_mm, TAU * 2.3 / period_mm - 0.3))
            .into();
        let found = line(points(&lags)).expect("a line");
        assert!(
            (found.pitch_mm - 2.3).abs() < 1e-12 && (found.edge_phase_rad - 0.3).abs() < 1e-12,
            "{found:?}"
        );
        assert!(found.edge_phase_sigma_rad < 1e-12);
        assert!(
            found
                .gratings
                .iter()
                .all(|point| point.residual_rad.abs() < 1e-12)
        );
    }

    #[test]
    fn residuals_of_lags_that_are_not_straight() {
        // Wave numbers 1, 2, 3 with lags 0, 3, 0: the line is level at 1, with residuals -1, 2, -1.
        let found =
            line(points(&[(TAU, 0.0), (TAU / 2.0, 3.0), (TAU / 3.0, 0.0)])).expect("a line");
        assert!(
            found.pitch_mm.abs() < 1e-12 && (found.edge_phase_rad + 1.0).abs() < 1e-12,
            "{found:?}"
        );
        assert!((found.edge_phase_sigma_rad - 6f64.sqrt()).abs() < 1e-12);
    }

    /// Calculated by hand: edge phases of 0.3 and 0.4 rad average 0.35 rad. The pitch's uncertainty
    /// of 3 % is multiplied by the difference between the mean wave number of the gratings and that
    /// of 2.3 mm.
    #[test]
    fn one_or_two_gratings_give_the_height() {
        let lag = |period_mm: f64, edge_rad| (period_mm, TAU * 2.3 / period_mm - edge_rad);
        let one = height(points(&[lag(3.0, 0.3)]), 2.3);
        assert!((one.edge_phase_rad - 0.3).abs() < 1e-12 && one.pitch_mm == 2.3);
        let sigma_rad = 0.03 * TAU * 2.3 * (1.0 / 2.3 - 1.0 / 3.0);
        assert!(
            (one.edge_phase_sigma_rad - sigma_rad).abs() < 1e-6,
            "{one:?}"
        );
        let two = height(points(&[lag(2.5, 0.3), lag(4.0, 0.4)]), 2.3);
        assert!((two.edge_phase_rad - 0.35).abs() < 1e-12, "{two:?}");
        assert!(
            (two.gratings[0].residual_rad - 0.05).abs() < 1e-12,
            "{two:?}"
        );
        let sigma_rad = (0.03 * TAU * 2.3 * (1.0 / 2.3 - 0.325)).hypot(0.05);
        assert!(
            (two.edge_phase_sigma_rad - sigma_rad).abs() < 1e-6,
            "{two:?}"
        );
    }

    #[test]
    fn lags_that_cannot_be_calibrated_are_refused() {
        let error = line(points(&[(3.0, 4.0), (3.0, 4.0), (3.01, 4.0)])).expect_err("no line");
        assert!(error.to_string().contains("too similar"), "{error}");
        let how = Measuring {
            pitch_mm: 2.3,
            speed_mm_s: None,
            plan: Plan::PAPER,
            accepts_any: false,
        };
        let error = run(Vec::new(), how).expect_err("no line");
        assert!(
            error.to_string().contains("no grating: one at least"),
            "{error}"
        );
        // A single input has no lag; AIN0 and AIN1 are in the same column.
        for plan in [
            Plan::SINGLE,
            Ads1258Plan {
                inputs: 3,
                ..Ads1258Plan::HAND
            }
            .plan(),
        ] {
            let error = refuse_without_pairs(&plan).expect_err("no pair");
            assert!(
                error.to_string().contains("converts no two alike inputs"),
                "{error}"
            );
        }
    }
}
