//! The jobs, one after the other.

use crate::intake;
use crate::machine::semihost::{self, Exit, File};
use crate::machine::{Counter, stack};
use core::fmt::Write;
use heapless::Vec;
use ridgetone::frame::{SLOTS, TimedConversion};
use ridgetone::moments::HARMONICS_MAX;
use ridgetone::pipeline::{Counters, Detector};
use ridgetone::settings::{RING_FRAMES, Settings};
use ridgetone::sine_fit::{Fit, Fitter};
use ridgetone::stretch::Stretch;
use ridgetone::telemetry::{Event, Packet, WIRE_MAX};
use ridgetone::window::Ring;
use ridgetone::workload::{
    CONVERSION_BYTES, FRAME_BYTES, JOB_BYTES, Job, LINE_MAX, Measured, Outcome, Wire, decode_conversion, decode_frame,
    longest_packet,
};

/// Most events of one scan: a slide's end with its windows, health and greeting.
const EVENTS_MAX: usize = 4;

/// Does all jobs and leaves the emulator.
#[cortex_m_rt::entry]
fn main() -> ! {
    static mut RING: Ring = Ring::new();
    static mut FITTER: Fitter = Fitter::new(1);
    static mut DETECTOR: Detector = Detector::new(Settings::DEFAULT);

    let (Some(workload), Some(results)) = (File::read_from(c"workload"), File::write_to(c"results")) else {
        semihost::say(format_args!("cannot open workload and results"));
        semihost::exit(Exit::Bridge)
    };
    let mut bench = Bench { workload, results, counter: Counter::start(), ring: RING };
    match bench.all(FITTER, DETECTOR) {
        Some(()) => semihost::exit(Exit::Done),
        None => {
            semihost::say(format_args!("the workload ends early or makes no sense, or results cannot be written"));
            semihost::exit(Exit::Bridge)
        }
    }
}

struct Bench {
    workload: File,
    results: File,
    counter: Counter,
    ring: &'static mut Ring,
}

impl Bench {
    fn all(&mut self, fitter: &mut Fitter, detector: &mut Detector) -> Option<()> {
        loop {
            match Job::decode(&self.read::<JOB_BYTES>()?)? {
                Job::End => return Some(()),
                Job::Fit { harmonics, frames } => {
                    renew(fitter, harmonics);
                    self.fit(fitter, frames)?;
                }
                Job::Detect { conversions } => {
                    *detector = Detector::new(Settings::DEFAULT);
                    self.detect(detector, conversions)?;
                }
                Job::Encode => self.encode(&longest_packet())?,
                Job::Intake => self.tell(Measured::Intake { instructions: intake::measure(&self.counter)? })?,
            }
        }
    }

    fn read<const N: usize>(&self) -> Option<[u8; N]> {
        let mut bytes = [0; N];
        self.workload.read_exact(&mut bytes).then_some(bytes)
    }

    fn tell(&self, measured: Measured) -> Option<()> {
        let mut line = heapless::String::<LINE_MAX>::new();
        writeln!(line, "{measured}").ok()?;
        self.results.write_all(line.as_bytes()).then_some(())
    }

    fn fit(&mut self, fitter: &mut Fitter, frames: u32) -> Option<()> {
        if frames as usize > RING_FRAMES {
            return None;
        }
        self.ring.restart(0);
        for _ in 0..frames {
            let (values, valid) = decode_frame(&self.read::<FRAME_BYTES>()?);
            self.ring.push(&values, valid, 0);
        }
        let from = stack::paint();
        let (instructions, fit) = self.counter.measure(|| fit(fitter, self.ring, frames));
        let stack_bytes = stack::deepest(from);
        self.tell(Measured::Fit { instructions, stack_bytes, outcome: Outcome::new(fit.as_ref()) })
    }

    fn detect(&mut self, detector: &mut Detector, conversions: u32) -> Option<()> {
        let mut sequence = 0;
        for _ in 0..conversions / SLOTS {
            let mut scan = Vec::<TimedConversion, { SLOTS as usize }>::new();
            for _ in 0..SLOTS {
                scan.push(decode_conversion(&self.read::<CONVERSION_BYTES>()?)).ok()?;
            }
            let mut events = Vec::<Event, EVENTS_MAX>::new();
            let mut windows = 0;
            let counters = Counters::default();
            let mut emit = |event| {
                let _ = events.push(event);
            };
            let mut due = |_| windows += 1;
            let (instructions, ()) = self.counter.measure(|| {
                for conversion in &scan {
                    detector.push(*conversion, self.ring, &counters, &mut emit, &mut due);
                }
            });
            for event in events {
                self.encode(&Packet { sequence, event })?;
                sequence = sequence.wrapping_add(1);
            }
            self.tell(Measured::Frame { instructions, windows })?;
        }
        Some(())
    }

    fn encode(&mut self, packet: &Packet) -> Option<()> {
        let mut wire = [0; WIRE_MAX];
        let (instructions, used) = self.counter.measure(|| Wire::write(packet, &mut wire));
        self.tell(Measured::Message { instructions, wire: Wire::new(wire.get(..used)?) })
    }
}

/// Sets the fitter to another number of harmonics. Apart, so that what it takes of the stack is given back.
#[inline(never)]
fn renew(fitter: &mut Fitter, harmonics: u8) {
    *fitter = Fitter::new(harmonics.min(HARMONICS_MAX as u8));
}

/// What is measured, with nothing of the rest inlined into it.
#[inline(never)]
fn fit(fitter: &mut Fitter, ring: &Ring, frames: u32) -> Option<Fit> {
    fitter.fit(&mut Stretch::new(&mut &*ring, 0, frames))
}
