//! The latest estimates, for a chart of the frequency.

use super::bounded::Bounded;
use crate::digits::seconds;
use ridgetone_proto::telemetry::{Abscissa, Direction, Estimate, Span, Status, TravelStatus};
use serde::Serialize;

/// Estimates kept: eight minutes of sliding at the default hop.
pub const POINTS: usize = 2000;

/// An estimate, with the fields that a chart needs; unknown values are `None`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Point {
    /// Device time of the window's end, seconds.
    pub t_s: f64,
    pub window_s: f32,
    pub span: Span,
    pub abscissa: Abscissa,
    pub status: Status,
    /// Hertz, or by place cycles per millimetre.
    pub frequency: Option<f32>,
    /// Its standard deviation, in the same unit.
    pub sigma: Option<f32>,
    /// Whether period and speed are known, as with `--json`.
    pub travel: TravelStatus,
    pub direction: Option<Direction>,
    pub spatial_period_mm: Option<f32>,
    pub spatial_period_sigma_mm: Option<f32>,
    pub speed_mm_s: Option<f32>,
    pub speed_sigma_mm_s: Option<f32>,
    /// As `sigma`, against the plain mean of the frequency.
    pub sigma_mean: Option<f32>,
    pub wander_percent: Option<f32>,
    pub wander_sigma_percent: Option<f32>,
    /// Hertz per second, or by place cycles per millimetre, per millimetre.
    pub chirp: Option<f32>,
    pub chirp_sigma: Option<f32>,
    /// In the unit of `frequency`.
    pub other_tone: Option<f32>,
    pub other_tone_share: Option<f32>,
    pub interferer_hz: Option<f32>,
}

impl Point {
    pub fn new(estimate: &Estimate) -> Self {
        let tone = |value| estimate.status.has_tone().then_some(value);
        let known = |value| estimate.travel.is_known().then_some(value);
        Self {
            t_s: seconds(estimate.t_us),
            window_s: estimate.window_s,
            span: estimate.span,
            abscissa: estimate.abscissa,
            status: estimate.status,
            frequency: tone(estimate.frequency),
            sigma: tone(estimate.sigma),
            travel: estimate.travel.status,
            direction: estimate.travel.direction.known(),
            spatial_period_mm: known(estimate.travel.spatial_period_mm),
            spatial_period_sigma_mm: known(estimate.travel.spatial_period_sigma_mm),
            speed_mm_s: known(estimate.travel.speed_mm_s),
            speed_sigma_mm_s: known(estimate.travel.speed_sigma_mm_s),
            sigma_mean: tone(estimate.movement.sigma_mean),
            wander_percent: tone(100.0 * estimate.movement.wander),
            wander_sigma_percent: tone(100.0 * estimate.movement.wander_sigma),
            chirp: tone(estimate.movement.chirp),
            chirp_sigma: tone(estimate.movement.chirp_sigma),
            other_tone: estimate.other_tone.map(|other| other.frequency),
            other_tone_share: estimate.other_tone.map(|other| other.share),
            interferer_hz: estimate.interferer_hz,
        }
    }
}

pub type History = Bounded<Point, POINTS>;
