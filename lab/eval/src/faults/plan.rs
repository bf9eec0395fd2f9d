//! One run: a touch and the faults injected into it.

use super::family::Family;
use crate::draw::Draw;
use anyhow::{Context, Result};
use hal_mock::{Fault, Injection, Sliding, Truth};
use ridgetone_host::input::{Input, Opened};
use ridgetone_proto::boot::{Boot, Oscillator};
use ridgetone_proto::plan::Plan as Scan;
use ridgetone_proto::settings::{Settings, TRACK_STRIDE_S};

/// Minimum scene time of the first injection, seconds: the chip runs, and the idle level is known.
const FIRST_S: f64 = 0.35;
/// Minimum time from the end of the last fault to the end of the injection period, seconds, so that
/// the fault's episode ends and is reported.
const LAST_S: f64 = 0.5;
/// Time after a fault's end within which the chip must be set up again, seconds. Each run lasts
/// this long after its last fault.
pub const RECOVERY_S: f64 = 5.0;
/// Range of the time from the end of an injection to the next, seconds. An episode ends when its
/// kind of fault has not occurred for a second.
const APART_S: (f64, f64) = (1.25, 1.6);
/// Range of the time between the injections of a mixed run, seconds.
const MIXED_APART_S: (f64, f64) = (0.03, 0.3);
/// Time after the touch in which faults are still injected, seconds.
const RELEASE_IDLE_S: f64 = 0.8;
const MIXED: usize = 6;

#[derive(Clone, Debug)]
pub struct Plan {
    pub family: Family,
    /// Seed of the scene, the noise and the injections.
    pub seed: u64,
    pub sliding: Sliding,
    /// Injections in the order of scene time.
    pub injections: Vec<Injection>,
    pub scan: Scan,
}

impl Plan {
    /// Plans a run with a slide of `slide_s` seconds. The number of periods per window does not
    /// depend on the scan.
    pub fn new(family: Family, seed: u64, slide_s: f64, scan: Scan) -> Self {
        let mut draw = Draw::new(seed);
        let (speed_mm_s, period_mm) = (
            draw.even(25.0, 50.0),
            draw.even(2.6, 4.1) * window_fraction(&scan),
        );
        let sliding = Sliding {
            speed_mm_s,
            period_mm,
            slide_mm: speed_mm_s * slide_s,
            idle_s: 0.5,
            hold_before_s: draw.even(0.4, 0.6),
            hold_after_s: 0.4,
            release_idle_s: RELEASE_IDLE_S + RECOVERY_S,
            snr_db: Some(draw.even(20.0, 40.0)),
            seed,
            ..Sliding::default()
        };
        // All injections end before this. The time to recover follows.
        let end_s = sliding.idle_s
            + sliding.hold_before_s
            + slide_s
            + sliding.hold_after_s
            + RELEASE_IDLE_S;
        let mut injections = Vec::new();
        let mixed = family == Family::Mixed;
        let mut at_s = FIRST_S + draw.even(0.0, APART_S.0);
        while family != Family::None && !(mixed && injections.len() == MIXED) {
            let (fault, lasts_s) = family.draw(&mut draw);
            let fault = converted(fault, &scan);
            if at_s + lasts_s > end_s - LAST_S {
                break;
            }
            injections.push(Injection {
                at_s,
                lasts_s,
                fault,
            });
            let (min_s, max_s) = if mixed { MIXED_APART_S } else { APART_S };
            at_s += lasts_s + draw.even(min_s, max_s);
        }
        Self {
            family,
            seed,
            sliding,
            injections,
            scan,
        }
    }

    pub fn open(&self) -> Result<(Opened, Truth)> {
        let mut input = Input {
            scene: self.sliding.clone(),
            seed: self.seed,
        }
        .open_in(&self.scan)?;
        input.options.injections = self.injections.clone();
        let truth = input.truth.context("a scene without its truth")?;
        Ok((input, truth))
    }

    pub fn boot(&self) -> Boot {
        let oscillator = match self.family {
            Family::Oscillator => Oscillator::Internal,
            _ => Oscillator::External,
        };
        Boot {
            oscillator,
            ..Boot::UNKNOWN
        }
    }

    /// Settings of the run on the PC. Windows are so short that a slide has several.
    pub fn settings(&self) -> Settings {
        let fraction = window_fraction(&self.scan) as f32;
        let (window_s, stride_s) = (
            WINDOW_S * fraction,
            (STRIDE_S * fraction).max(TRACK_STRIDE_S),
        );
        Settings {
            window_s,
            stride_s,
            plan: self.scan,
            ..Settings::DEFAULT
        }
    }
}

/// Moves an input fault to one of the inputs that the scan converts.
fn converted(fault: Fault, scan: &Scan) -> Fault {
    let Fault::Input { input, volts } = fault else {
        return fault;
    };
    let mut inputs = (0..16).filter(|input| scan.inputs >> input & 1 == 1);
    Fault::Input {
        input: inputs
            .nth(usize::from(input) % scan.channels())
            .unwrap_or(input),
        volts,
    }
}

/// Ratio of the scan's window to [`WINDOW_S`].
fn window_fraction(scan: &Scan) -> f64 {
    f64::from(scan.window_max_s().min(WINDOW_S) / WINDOW_S)
}

/// Window length in runs on the PC, if the scan allows it, and stride, seconds.
const WINDOW_S: f32 = 0.3;
const STRIDE_S: f32 = 0.1;
