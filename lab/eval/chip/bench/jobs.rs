//! The jobs, one after the other.

use crate::files::Files;
use crate::intake;
use crate::machine::{Counter, stack};
use heapless::Vec;
use ridgetone_eval::workload::{Frame, Job, Measured, Outcome, Wire, conversion, longest_packet};
use ridgetone_finger::Diagnostics;
use ridgetone_finger::Ring;
use ridgetone_finger::SLOTS;
use ridgetone_finger::TimedConversion;
use ridgetone_finger::{Detector, Outputs};
use ridgetone_proto::settings::{RING_FRAMES, Settings};
use ridgetone_proto::telemetry::{Event, Packet, WIRE_MAX};
use ridgetone_tone::{Fit, Fitter, FrameSpan, Scene, Status};

/// Most events of one scan: a slide's end with its windows, health and greeting.
const EVENTS_MAX: usize = 4;

/// Does all jobs and leaves the emulator.
#[cortex_m_rt::entry]
fn main() -> ! {
    static mut RING: Ring = Ring::new();
    static mut FITTER: Fitter = Fitter::new();
    static mut DETECTOR: Detector = Detector::new(Settings::DEFAULT);

    Files::run(|files| {
        Bench {
            files,
            counter: Counter::start(),
            ring: RING,
        }
        .all(FITTER, DETECTOR)
    })
}

/// Apart: what it is copied from is off the stack when a fit is measured.
#[inline(never)]
fn anew(detector: &mut Detector) {
    *detector = Detector::new(Settings::DEFAULT);
}

struct Bench<'a> {
    files: &'a Files,
    counter: Counter,
    ring: &'static mut Ring,
}

impl Bench<'_> {
    fn all(&mut self, fitter: &mut Fitter, detector: &mut Detector) -> Option<()> {
        loop {
            match self.files.read()? {
                Job::End => return Some(()),
                Job::Fit {
                    declared,
                    harmonics,
                    frames,
                } => {
                    let scene = ridgetone_finger::scene(&declared, harmonics);
                    self.fit(fitter, &scene, frames)?;
                }
                Job::Detect { conversions } => {
                    anew(detector);
                    self.detect(detector, conversions)?;
                }
                Job::Encode => self.encode(&longest_packet())?,
                Job::Intake => {
                    let instructions = intake::measure(&self.counter)?;
                    self.files.write(Measured::Intake { instructions })?;
                }
                // The baselines and the pins have images of their own.
                Job::Baseline { .. } => return None,
            }
        }
    }

    // Each job apart: together their variables, with the events of a touch, overflow the stack.
    #[inline(never)]
    fn fit(&mut self, fitter: &mut Fitter, scene: &Scene, frames: u32) -> Option<()> {
        if frames as usize > RING_FRAMES {
            return None;
        }
        self.ring.restart(0);
        for _ in 0..frames {
            let (values, valid): Frame = self.files.read()?;
            self.ring.push(&values, valid, 0);
        }
        let from = stack::paint();
        let (instructions, fit) = self
            .counter
            .measure(|| fit_window(fitter, scene, self.ring, Part::of(frames)));
        let stack_bytes = stack::deepest(from);
        let good = fit.as_ref().filter(|fit| fit.status == Status::Good);
        let tracked = good.map_or(0, |good| {
            let expected = Some(good.frequency);
            let run = || fit_window(fitter, scene, self.ring, Part { frames, expected });
            self.counter.measure(run).0
        });
        self.files.write(Measured::Fit {
            instructions,
            tracked,
            stack_bytes,
            outcome: Outcome::new(fit.as_ref()),
        })
    }

    #[inline(never)]
    fn detect(&mut self, detector: &mut Detector, conversions: u32) -> Option<()> {
        let mut sequence = 0;
        for _ in 0..conversions / SLOTS {
            let mut scan = Vec::<TimedConversion, { SLOTS as usize }>::new();
            for _ in 0..SLOTS {
                let (t_us, bytes) = self.files.read()?;
                scan.push(conversion(t_us, bytes)).ok()?;
            }
            let mut events = Vec::<Event, EVENTS_MAX>::new();
            let mut windows = 0;
            let outputs = &mut Outputs {
                emit: &mut |event| drop(events.push(event)),
                due: &mut |_| windows += 1,
            };
            let (instructions, ()) = self
                .counter
                .measure(|| detect(detector, &scan, self.ring, outputs));
            for event in events {
                self.encode(&Packet { sequence, event })?;
                sequence = sequence.wrapping_add(1);
            }
            self.files.write(Measured::Frame {
                instructions,
                windows,
            })?;
        }
        Some(())
    }

    fn encode(&mut self, packet: &Packet) -> Option<()> {
        let mut wire = [0; WIRE_MAX];
        let (instructions, used) = self.counter.measure(|| Wire::write(packet, &mut wire));
        self.files.write(Measured::Message {
            instructions,
            wire: Wire::new(wire.get(..used)?),
        })
    }
}

/// The first frames of the ring, and the frequency that is expected in them.
#[derive(Clone, Copy)]
struct Part {
    frames: u32,
    expected: Option<f32>,
}

impl Part {
    fn of(frames: u32) -> Self {
        Self {
            frames,
            expected: None,
        }
    }
}

/// What is measured, with nothing of the rest inlined into it.
#[inline(never)]
fn fit_window(fitter: &mut Fitter, scene: &Scene, ring: &Ring, part: Part) -> Option<Fit> {
    let source = &mut &*ring;
    let mut span = FrameSpan::new(source, 0, part.frames).with_quantization(1.0);
    if let Some(frequency) = part.expected {
        span = span.expecting(frequency);
    }
    fitter.fit(&mut span, scene).ok()
}

/// As [`fit_window`].
#[inline(never)]
fn detect(
    detector: &mut Detector,
    scan: &[TimedConversion],
    ring: &mut Ring,
    outputs: &mut Outputs<'_>,
) {
    static DIAGNOSTICS: Diagnostics = Diagnostics::new();
    for conversion in scan {
        detector.push(*conversion, ring, &DIAGNOSTICS, outputs);
    }
}
