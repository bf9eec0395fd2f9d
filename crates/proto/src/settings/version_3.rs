//! Settings as firmware up to protocol 10 kept them: all of them in one piece of postcard.
//!
//! A struct here describes bytes in somebody's flash, and never changes.

use super::old_plan::Registers;
use super::record::Kept;
use super::{Settings, SlideRule};
use crate::plan::Plan;
use serde::Deserialize;

#[derive(Deserialize)]
struct Old {
    window_s: f32,
    stride_s: f32,
    harmonics: u8,
    accuracy: f32,
    interferer_hz: f32,
    vref_v: f32,
    slide: OldSlide,
    array: OldArray,
    feel: OldFeeling,
    _pins: OldPins,
    plan: Registers,
}

#[derive(Deserialize)]
enum OldSlide {
    Found,
    Protocol {
        delay_s: f32,
        speed_mm_s: f32,
        length_mm: f32,
    },
}

#[derive(Deserialize)]
struct OldArray {
    pitch_mm: f32,
    edge_phase_rad: f32,
    edge_phase_sigma_rad: f32,
    period_min_mm: f32,
    period_max_mm: f32,
    may_go_forward: bool,
    may_go_backward: bool,
    front: u16,
    alike: [u16; 4],
}

#[derive(Deserialize)]
struct OldFeeling {
    volts_per_um: f32,
    sigma_fraction: f32,
    force_ratio: f32,
}

/// A display of pins, which a PC computes today.
#[derive(Deserialize)]
struct OldPins {
    _rate_side_levels: [u8; 3],
    _lengths_and_forces: [f32; 6],
}

impl OldArray {
    /// Whether pitch and edge phase are version 3's defaults.
    fn is_as_it_was(&self) -> bool {
        self.pitch_mm == 2.364 && self.edge_phase_rad == 0.41 && self.edge_phase_sigma_rad == 0.01
    }
}

/// Reads what a record of version 3 holds. None if it is damaged or out of today's bounds.
pub fn read(content: &[u8]) -> Option<Kept> {
    let (old, _) = postcard::take_from_bytes::<Option<Old>>(content).ok()?;
    let Some(old) = old else {
        return Some(Kept::Defaults);
    };
    let settings = old.settings();
    settings.validate().ok()?;
    Some(Kept::Migrated(settings))
}

impl Old {
    // Field by field: a setting that is added later has its default here.
    fn settings(self) -> Settings {
        let mut new = Settings::DEFAULT;
        new.plan = self.plan.plan(Plan::PAPER.adc_clock_hz);
        new.window_s = self.window_s;
        new.stride_s = self.stride_s;
        new.harmonics = self.harmonics;
        new.accuracy = self.accuracy;
        new.interferer_hz = self.interferer_hz;
        new.vref_v = self.vref_v;
        if let OldSlide::Protocol {
            delay_s,
            speed_mm_s,
            length_mm,
        } = self.slide
        {
            new.slide.rule = SlideRule::Protocol;
            new.slide.delay_s = delay_s;
            new.slide.speed_mm_s = speed_mm_s;
            new.slide.length_mm = length_mm;
        }
        new.array.pitch_mm = self.array.pitch_mm;
        new.array.edge_phase_rad = self.array.edge_phase_rad;
        // Version 3 stored the uncertainty of the simulated finger where nobody had measured one.
        if !self.array.is_as_it_was() {
            new.array.edge_phase_sigma_rad = self.array.edge_phase_sigma_rad;
        }
        new.array.period_min_mm = self.array.period_min_mm;
        new.array.period_max_mm = self.array.period_max_mm;
        new.array.may_go_forward = self.array.may_go_forward;
        new.array.may_go_backward = self.array.may_go_backward;
        new.array.front = self.array.front;
        new.array.alike = self.array.alike;
        new.feel.volts_per_um = self.feel.volts_per_um;
        new.feel.sigma_fraction = self.feel.sigma_fraction;
        new.feel.force_ratio = self.feel.force_ratio;
        new
    }
}
