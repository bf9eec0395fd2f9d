//! The jobs, one after the other.

use crate::files::Files;
use crate::machine::Counter;
use ridgetone_eval::baselines::{CHANNELS, Frame, Method, Scratch};
use ridgetone_eval::workload::{self, Job, Measured};

/// Most frames of a window: two seconds at 241 Hz.
const FRAMES: usize = 482;

/// Does all jobs and leaves the emulator.
#[cortex_m_rt::entry]
fn main() -> ! {
    static mut WINDOW: [Frame; FRAMES] = [[0.0; CHANNELS]; FRAMES];
    static mut SCRATCH: Scratch = Scratch::EMPTY;

    let counter = Counter::start();
    Files::run(|files| {
        loop {
            match files.read()? {
                Job::End => return Some(()),
                Job::Baseline {
                    method,
                    channels,
                    frames,
                } => {
                    let method = Method::from_number(method)?;
                    let window = WINDOW.get_mut(..frames as usize)?;
                    for frame in window.iter_mut() {
                        (*frame, _) = files.read::<workload::Frame>()?;
                    }
                    let (instructions, frequency) = counter
                        .measure(|| estimate(method, window, usize::from(channels), SCRATCH));
                    files.write(Measured::Baseline {
                        instructions,
                        frequency_bits: frequency.map(f32::to_bits),
                    })?;
                }
                // The fit's image does the others.
                _ => return None,
            }
        }
    })
}

/// What is measured, with nothing of the rest inlined into it.
#[inline(never)]
fn estimate(
    method: Method,
    window: &[Frame],
    channels: usize,
    scratch: &mut Scratch,
) -> Option<f32> {
    method.estimate(window, channels, scratch)
}
