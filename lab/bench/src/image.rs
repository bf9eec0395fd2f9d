//! The bench image: fits its built-in windows and leaves the results in memory. The emulator counts
//! the instructions between two calls of [`mark`].
#![no_std]
#![no_main]

mod layout;
mod rivals;

use core::hint::black_box;
use core::sync::atomic::{AtomicU32, Ordering::Relaxed};
use layout::{FRAMES, ROOTS, ROWS, SCENES, WORDS};
use ridgetone_proto::settings::Declared;
use ridgetone_tone::{Fit, Fitter, FrameSpan, Scene, Table, Values};
use rivals::Scratch;

const LONGEST: usize = FRAMES[FRAMES.len() - 1];

/// A pure tone, and one with overtones; see `windows.py`.
// SAFETY: `transmute` checks that both have the same size, and every bit pattern is valid.
#[allow(unsafe_code, reason = "bytes of a file as numbers")]
static WINDOWS: [[Values; LONGEST]; 2] =
    unsafe { core::mem::transmute(*include_bytes!("../windows.bin")) };

static VALID: [u16; LONGEST] = [u16::MAX; LONGEST];

/// Results, row after row.
static RESULTS: [AtomicU32; ROWS * WORDS] = [const { AtomicU32::new(0) }; ROWS * WORDS];

static DONE: AtomicU32 = AtomicU32::new(0);

#[inline(never)]
fn mark() {
    DONE.store(black_box(DONE.load(Relaxed)), Relaxed);
}

#[cortex_m_rt::entry]
fn main() -> ! {
    static mut FITTER: Fitter = Fitter::new();
    static mut SCRATCH: Scratch = Scratch::EMPTY;

    for (_, differs) in SCENES {
        for frames in FRAMES {
            fits(FITTER, differs, frames);
        }
    }
    for method in [rivals::hann, rivals::ieee1057] {
        for frames in FRAMES {
            let window = &WINDOWS[1][..frames];
            mark();
            let frequency = method(black_box(window), SCRATCH);
            mark();
            keep([0, frequency.unwrap_or(f32::NAN).to_bits(), 0]);
        }
    }
    roots(ridgetone_tone::sqrt);
    roots(libm::sqrtf);
    // Keep the results in memory, where the host reads them.
    black_box(&RESULTS);
    loop {
        cortex_m::asm::wfi();
    }
}

/// Fits a window twice: without an expected frequency, then with the frequency found.
fn fits(fitter: &mut Fitter, differs: u8, frames: usize) {
    let (scene, overtones) = scene_of(differs);
    let window = &WINDOWS[usize::from(overtones)][..frames];
    let mut expected = None;
    for _ in 0..2 {
        mark();
        let fit = fit(fitter, &scene, window, expected);
        mark();
        match fit {
            Some(fit) => {
                expected = Some(fit.frequency);
                keep([
                    fit.status as u32,
                    fit.frequency.to_bits(),
                    fit.sigma.to_bits(),
                ]);
            }
            None => keep([u32::MAX, 0, 0]),
        }
    }
}

/// Computes square roots from zero to infinity and keeps a hash of their bits.
fn roots(root: fn(f32) -> f32) {
    const STEP: u32 = f32::INFINITY.to_bits() / (ROOTS - 1);
    let mut sum = 0u32;
    mark();
    for x in (0..ROOTS).map(|number| f32::from_bits(black_box(number * STEP))) {
        sum = sum.rotate_left(1) ^ root(x).to_bits();
    }
    mark();
    keep([0, sum, 0]);
}

#[inline(never)]
fn fit(
    fitter: &mut Fitter,
    scene: &Scene,
    values: &[Values],
    expected: Option<f32>,
) -> Option<Fit> {
    let valid = &VALID[..values.len()];
    let source = &mut Table { values, valid };
    let span = FrameSpan::new(source, 0, values.len() as u32).with_quantization(1.0);
    let mut span = match expected {
        Some(frequency) => span.expecting(frequency),
        None => span,
    };
    fitter.fit(&mut span, scene).ok()
}

/// Returns the scene that differs from the default in these parts, and true if its tone has
/// overtones.
fn scene_of(differs: u8) -> (Scene, bool) {
    let default = Declared::DEFAULT;
    let has = |bit: u8, usual: bool| usual != (differs & bit != 0);
    let overtones = has(32, true);
    let declared = Declared {
        overtones,
        curved_baseline: has(1, default.curved_baseline),
        coloured_noise: has(2, default.coloured_noise),
        shared_noise: has(4, default.shared_noise),
        impulses: has(8, default.impulses),
        moving_speed: has(16, default.moving_speed),
    };
    (ridgetone_finger::scene(&declared, 4), overtones)
}

fn keep(words: [u32; WORDS]) {
    let done = DONE.load(Relaxed);
    let place = &RESULTS[done as usize * WORDS..];
    for (place, word) in place.iter().zip(words) {
        place.store(word, Relaxed);
    }
    DONE.store(done + 1, Relaxed);
}

#[panic_handler]
fn panic(_: &core::panic::PanicInfo) -> ! {
    cortex_m::asm::udf()
}
