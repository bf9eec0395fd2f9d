//! The cost of frame assembly, contact and window, frame by frame through a touch.

use super::emulated::{Jobs, next};
use crate::workload::{Job, Measured, Wire, conversion_record};
use anyhow::{Context, Result, ensure};
use hal_mock::Truth;
use ridgetone_finger::Diagnostics;
use ridgetone_finger::Ring;
use ridgetone_finger::SLOTS;
use ridgetone_finger::TimedConversion;
use ridgetone_finger::{Detector, Outputs};
use ridgetone_host::input::{Input, frame_rate_hz};
use ridgetone_host::replay;
use ridgetone_proto::settings::Settings;
use ridgetone_proto::telemetry::{Packet, WIRE_MAX};
use serde::Serialize;

/// The cost of the frames of one phase.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Phase {
    /// `idle`, `hold`, `slide`, or `all` of the touch.
    pub name: &'static str,
    pub frames: u32,
    pub instructions_mean: f64,
    pub instructions_worst: u32,
}

pub struct Frames {
    truth: Truth,
    conversions: Vec<TimedConversion>,
}

impl Frames {
    pub fn new() -> Result<Self> {
        let input = Input::default().open()?;
        let truth = input.truth.context("a scene has a truth")?;
        let mut conversions = Vec::new();
        replay::conversions(input, &mut |conversion| {
            conversions.push(conversion);
            Ok(())
        })?;
        // Whole scans only; the first begins with the first slot.
        conversions.truncate(conversions.len() - conversions.len() % SLOTS as usize);
        Ok(Self { truth, conversions })
    }

    pub fn write(&self, jobs: &mut Jobs) {
        let job = Job::Detect {
            conversions: self.conversions.len() as u32,
        };
        jobs.add(job, self.conversions.iter().map(conversion_record));
    }

    pub fn read(&self, measured: &mut dyn Iterator<Item = Measured>) -> Result<Vec<Phase>> {
        let mut frames = Vec::new();
        let (mut ring, mut detector) = (Box::new(Ring::new()), Detector::new(Settings::DEFAULT));
        let (mut sequence, diagnostics) = (0u16, Diagnostics::new());
        for scan in self.conversions.chunks(SLOTS as usize) {
            let (mut events, mut due) = (Vec::new(), 0);
            for conversion in scan {
                let outputs = &mut Outputs {
                    emit: &mut |event| events.push(event),
                    due: &mut |_| due += 1,
                };
                detector.push(*conversion, &mut ring, &diagnostics, outputs);
            }
            for event in events {
                let (_, wire) = next!(measured, Message { instructions, wire });
                let mut bytes = [0; WIRE_MAX];
                let packet = Packet { sequence, event };
                let used = Wire::write(&packet, &mut bytes);
                ensure!(
                    wire == Wire::new(&bytes[..used]),
                    "the chip did not send {packet:?}"
                );
                sequence = sequence.wrapping_add(1);
            }
            let (instructions, windows) = next!(
                measured,
                Frame {
                    instructions,
                    windows
                }
            );
            let number = frames.len();
            ensure!(
                windows == due,
                "frame {number}: {windows} windows are due on the chip, {due} here"
            );
            frames.push(instructions);
        }
        let Truth {
            contact_s,
            slide_start_s,
            slide_end_s,
            ..
        } = self.truth;
        // Well within each phase: after the learning at its start.
        [
            ("idle", 0.2, contact_s - 0.05),
            ("hold", contact_s + 0.4, slide_start_s - 0.05),
            ("slide", slide_start_s + 0.3, slide_end_s - 0.05),
            ("all", 0.0, f64::INFINITY),
        ]
        .into_iter()
        .map(|(name, from_s, to_s)| phase(name, from_s, to_s, &frames))
        .collect()
    }
}

/// Sums up the frames of a span of time.
fn phase(name: &'static str, from_s: f64, to_s: f64, frames: &[u32]) -> Result<Phase> {
    let within = |number: usize| (from_s..to_s).contains(&(number as f64 / frame_rate_hz()));
    let costs: Vec<u32> = frames
        .iter()
        .enumerate()
        .filter(|(number, _)| within(*number))
        .map(|(_, cost)| *cost)
        .collect();
    let sum: f64 = costs.iter().map(|cost| f64::from(*cost)).sum();
    let worst = costs
        .iter()
        .max()
        .with_context(|| format!("no frame is {name}"))?;
    Ok(Phase {
        name,
        frames: costs.len() as u32,
        instructions_mean: sum / costs.len() as f64,
        instructions_worst: *worst,
    })
}
