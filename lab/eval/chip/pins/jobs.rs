//! The jobs, one after the other.

use crate::files::Files;
use crate::machine::Counter;
use ridgetone::pins::{Driver, MEMORY as UPDATE_FLOATS};
use ridgetone_display::Matching;
use ridgetone_eval::moving_bump::{FLOATS, matching, settings, settings_in, step, summary};

use ridgetone_eval::workload::{Job, Measured};

const _: () = assert!(UPDATE_FLOATS <= FLOATS);

/// Does all jobs and leaves the emulator.
#[cortex_m_rt::entry]
fn main() -> ! {
    static mut MEMORY: [f32; FLOATS] = [0.0; FLOATS];

    let counter = Counter::start();
    Files::run(|files| {
        loop {
            match files.read()? {
                Job::End => return Some(()),
                Job::Pins { side, frames } => {
                    let mut matching = matching(MEMORY, side.into()).ok()?;
                    for frame in 0..frames {
                        let (instructions, done) =
                            counter.measure(|| measured(&mut matching, frame));
                        let (multiply_adds, bits) = done?;
                        files.write(Measured::Pins {
                            instructions,
                            multiply_adds,
                            bits,
                        })?;
                    }
                }
                Job::Update { side, load, frames } => {
                    let (settings, mut driver) = (settings(side), Driver::new());
                    for frame in 0..frames {
                        let (due, settings) =
                            (load.due(frame), settings_in(&settings, load, frame));
                        let (instructions, pins) =
                            counter.measure(|| driver.update(&due, MEMORY, &settings));
                        let (multiply_adds, bits) = summary(&pins);
                        files.write(Measured::Pins {
                            instructions,
                            multiply_adds,
                            bits,
                        })?;
                    }
                }
                // Other images do the others.
                _ => return None,
            }
        }
    })
}

/// What is measured, with nothing of the rest inlined into it.
#[inline(never)]
fn measured(matching: &mut Matching<'_>, frame: u32) -> Option<(u32, u32)> {
    step(matching, frame)
}
