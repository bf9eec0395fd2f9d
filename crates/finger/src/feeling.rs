//! What a finger would feel in a window: its spectrum, how receptors fire, and what people would
//! say.

use crate::window::Window;
use ads1258::reading;
use core::f32::consts::LN_10;
use ridgetone_feel::{
    Conversion, Firing, Indices, MeanFiring, PAPER_WINDOW_S, ROUGH, Receptor, SOFT, Score, Windows,
    amplitude_spectrum, force_ratio, points, strongest_in_bands,
};
use ridgetone_proto::fault::FaultSet;
use ridgetone_proto::settings::{Settings, TAXELS};
use ridgetone_proto::telemetry::{BANDS, Feel, Image, Measured, NO_LEVEL, RECEPTORS};
use ridgetone_tone::phase::{cos_sin, from_turns};
use ridgetone_tone::{FrameSource, Overwritten};

/// Most values of a transform. A PC has tables for more, but gives the chip's numbers.
pub const POINTS: usize = 1024;
/// Memory that [`feel`] needs, values: the powers of a transform's bins, and its points.
#[cfg(feature = "internals")]
pub const MEMORY: usize = POINTS / 2 + POINTS;

/// Values a second that are enough: four times the 800 Hz that receptors respond to. From twice as
/// many frames on, means of several frames make a longer window, and what they fold onto 800 Hz
/// they weaken by 10 dB and more.
const RATE_ENOUGH_HZ: f32 = 3200.0;
/// Least time of a window, seconds, where the frames are fast: so much of 1024 values of that rate.
const WINDOW_LEAST_S: f32 = 0.31;
/// Frames that are read at a time, so that higher tasks wait for microseconds only.
const READ_FRAMES: usize = 16;

const _: () = assert!(RECEPTORS == ridgetone_feel::RECEPTORS && BANDS == ridgetone_feel::BANDS);

/// What a finger would feel in the latest part of a slide, at the end of a window: as much of the
/// settings' window as a transform can hold, and always the same length, for that is what a
/// conversion belongs to. `settings.feel` must be on. None if the slide is not as long yet, or no
/// taxel is alive. Fails if frames were overwritten.
pub fn feel(
    window: &Window,
    source: &mut dyn FrameSource,
    memory: &mut [f32],
    settings: &Settings,
) -> Result<Option<Feel>, Overwritten> {
    let stride = ((window.plan.frame_rate_hz() / RATE_ENOUGH_HZ) as u32).max(1);
    let end = window.first.wrapping_add(window.frames);
    let wanted = settings.window_s.max(WINDOW_LEAST_S) * window.plan.frame_rate_hz() + 0.5;
    let Some(count) = points((wanted as usize / stride as usize).min(POINTS)) else {
        return Ok(None);
    };
    if end.wrapping_sub(window.slide_first) < count as u32 * stride {
        return Ok(None);
    }
    let Some((powers, samples)) = memory.split_at_mut_checked(count / 2) else {
        return Ok(None);
    };
    let Some(samples) = samples.get_mut(..count) else {
        return Ok(None);
    };
    let part = Part {
        first: end.wrapping_sub(count as u32 * stride),
        stride,
        scale: reading::volts(1, settings.vref_v) / stride as f32,
    };
    let rate_hz = window.frame_rate_hz / stride as f32;
    let windows = Windows {
        measured_s: count as f32 / rate_hz,
        wanted_s: PAPER_WINDOW_S,
    };
    let known = &settings.feel;
    let conversion = Conversion {
        log_per_um: libm::log10f(known.volts_per_um),
        log_sigma: known.sigma_fraction / LN_10,
    };
    let (mut firing, mut taxels) = (Firing::default(), 0u16);
    powers.fill(0.0);
    for taxel in 0..TAXELS {
        let is_converted = window.plan.inputs >> taxel & 1 != 0;
        if !is_converted || !part.read(taxel, source, samples)? {
            continue;
        }
        let Some(amplitudes) = amplitude_spectrum(samples) else {
            continue;
        };
        if amplitudes.iter().all(|amplitude| *amplitude == 0.0) {
            continue;
        }
        for (bin, (amplitude, power)) in amplitudes.iter_mut().zip(&mut *powers).enumerate() {
            *amplitude *= part.gain(bin as f32 / count as f32);
            *power += *amplitude * *amplitude;
        }
        firing.average(
            &Firing::new(amplitudes, windows, &conversion),
            taxels.count_ones() as usize,
        );
        taxels |= 1 << taxel;
    }
    if taxels == 0 {
        return Ok(None);
    }
    let per_square_um = known.volts_per_um * known.volts_per_um * taxels.count_ones() as f32;
    let ratio = Measured {
        value: known.force_ratio,
        sigma: 0.0,
    };
    let mut feel = Feel {
        t_us: window.end_us,
        window_s: windows.measured_s,
        rate_hz,
        taxels,
        faults: FaultSet::NONE,
        per_hz: [None; RECEPTORS],
        force_ratio: if ratio.value > 0.0 {
            Some(ratio)
        } else {
            window.force_ratio
        },
        soft: None,
        rough: None,
        levels_db: strongest_in_bands(powers, windows.bin_hz())
            .map(|power| power.map_or(NO_LEVEL, |p| decibels(p / per_square_um))),
    };
    score(&mut feel, &firing, &conversion);
    Ok(Some(feel))
}

/// Fills in what follows from how the receptors fire.
fn score(feel: &mut Feel, firing: &Firing, conversion: &Conversion) {
    let mut mean = MeanFiring::default();
    mean.push(firing);
    let forces = feel.force_ratio.map(|ratio| (ratio.value, ratio.sigma));
    let indices = Indices::new(&mean, conversion.log_sigma, forces);
    let measured = |(value, sigma)| Measured { value, sigma };
    let per_hz = |(value, sigma)| measured((value / PAPER_WINDOW_S, sigma / PAPER_WINDOW_S));
    feel.per_hz = Receptor::ALL.map(|receptor| indices.get(receptor as usize).map(per_hz));
    let of = |score: &Score| score.of(&indices).map(measured);
    (feel.soft, feel.rough) = (of(&SOFT), of(&ROUGH));
}

/// A level in whole decibels, of a power over that of a micrometre.
fn decibels(power: f32) -> i8 {
    // The cast saturates, and gives 0 for a NaN; the least value stands for no level.
    (libm::roundf(10.0 * libm::log10f(power)) as i8).max(NO_LEVEL + 1)
}

/// Tangential over normal force by a static image; none if no unit is alive, or nothing presses.
pub fn image_ratio(image: &Image) -> Option<Measured> {
    let (mut levels, mut sigmas) = ([[f32::NAN; 4]; TAXELS / 4], [[0.0; 4]; TAXELS / 4]);
    for pressed in &image.taxels {
        let (unit, place) = (
            pressed.taxel as usize / 4 % levels.len(),
            pressed.taxel as usize % 4,
        );
        (levels[unit][place], sigmas[unit][place]) = (pressed.level_v, pressed.sigma_v);
    }
    force_ratio(&levels, &sigmas, 1.0).map(|(value, sigma)| Measured { value, sigma })
}

/// The frames of a transform: `stride` frames are averaged into one value.
struct Part {
    first: u32,
    stride: u32,
    /// Volts of one code, over the stride.
    scale: f32,
}

impl Part {
    /// Reads a taxel in volts. Readings that are missing are as the one before, and the first ones
    /// as the first that is there; false if more than half are missing.
    fn read(
        &self,
        taxel: usize,
        source: &mut dyn FrameSource,
        samples: &mut [f32],
    ) -> Result<bool, Overwritten> {
        let frames = samples.len() as u32 * self.stride;
        let (mut latest, mut missing) = (None, 0);
        let (mut done, mut at, mut sum, mut summed) = (0, 0, 0.0, 0);
        while done < frames {
            let most = ((frames - done) as usize).min(READ_FRAMES);
            let before = done;
            source.read(self.first.wrapping_add(done), most, &mut |values, valid| {
                for (values, valid) in values.iter().zip(valid) {
                    done += 1;
                    match values.get(taxel) {
                        Some(value) if valid >> taxel & 1 == 1 => {
                            if latest.is_none() {
                                samples.iter_mut().take(at).for_each(|sample| {
                                    *sample = self.scale * self.stride as f32 * value
                                });
                                sum = summed as f32 * value;
                            }
                            latest = Some(*value);
                        }
                        _ => missing += 1,
                    }
                    sum += latest.unwrap_or(0.0);
                    summed += 1;
                    if summed == self.stride {
                        if let Some(sample) = samples.get_mut(at) {
                            *sample = self.scale * sum;
                        }
                        (at, sum, summed) = (at + 1, 0.0, 0);
                    }
                }
            })?;
            if done == before {
                return Err(Overwritten);
            }
        }
        Ok(2 * missing <= frames)
    }

    /// The factor that makes up for the mean of several frames, at `cycles` cycles a value: one
    /// over Dirichlet's kernel.
    fn gain(&self, cycles: f32) -> f32 {
        if self.stride == 1 || !(cycles > 0.0) {
            return 1.0;
        }
        let stride = self.stride as f32;
        let sin_of_half = |turns: f32| cos_sin(from_turns(0.5 * turns)).1;
        stride * sin_of_half(cycles / stride) / sin_of_half(cycles)
    }
}
