//! Candidate frequencies: the highest peaks of Wilks' ratio for a single line in whitened channels.
//!
//! S. S. Wilks, "Certain generalizations in the analysis of variance", Biometrika 24 (1932),
//! 471-494.

use crate::blocks::Blocks;
use crate::limits::CHANNELS_MAX;
use crate::matrix::{Factor, invert_lower};
use crate::scene::Scene;
use crate::spectrum::{Spectrum, Sums};
use crate::statistics::Products;
use crate::window_frames::WindowFrames;
use crate::workspace::Workspace;
use core::f32::consts::FRAC_1_SQRT_2 as ROOT_HALF;
use core::ops::Range;

pub const PEAKS: usize = 2;
/// With more frames and more channels than this, pairs of channels are mixed before the transform.
const FRAMES_FEW: u32 = 128;
const CHANNELS_FEW: usize = 8;
/// Minimum number of cycles of a peak.
const CYCLES_PEAK: f32 = 0.5;
/// Minimum noise assumed, as a fraction of a channel's variance: with less, a faint overtone would
/// stand out as much as the tone.
const CLEAR: f32 = 1e-4;
/// Lower limit of Wilks' ratio.
const LEFT_MIN: f32 = 1e-7;

/// Peak of the log ratio.
#[derive(Clone, Copy, Default)]
struct Peak {
    cycles: f32,
    height: f32,
}

/// Returns the peaks to try in cycles per window, likeliest first, padded with zeros; `all` holds
/// the products of the channels.
#[inline(never)]
pub fn candidates(
    window: &mut WindowFrames,
    blocks: &mut Blocks,
    workspace: &mut Workspace,
    all: &Products,
    scene: &Scene,
) -> [f32; PEAKS] {
    let unit = window.span.frequency(1.0);
    let mut end = window.cycles_max() - 0.25;
    if scene.band.max > 0.0 {
        // A peak may be an overtone of a fundamental within the band.
        end = end.min(scene.band.max / unit * f32::from(scene.harmonics()));
    }
    let (mut found, mut from) = ([Peak::default(); PEAKS], scene.band.min / unit);
    let mut each = window.frames_each();
    // A long window takes several passes: each halves the frames per point, which doubles the band
    // at half the resolution.
    while each > 0 {
        let reached = end.min(window.cycles_max() / each as f32 - 0.25);
        let sums = workspace.sums();
        if let Some(spectrum) = whitened(window, each, sums, blocks.scratch(), all) {
            peaks(&spectrum, from, reached, &mut found);
        }
        if reached >= end {
            break;
        }
        (from, each) = (reached, each / 2);
    }
    found.map(|peak| peak.cycles)
}

/// Most likely line in a band of cycles per window, if it passes the Bayesian information
/// criterion.
pub fn strongest(
    window: &mut WindowFrames,
    sums: Sums,
    transforms: &mut [f32],
    all: &Products,
    band: Range<f32>,
) -> Option<f32> {
    let frames = window.count() as f32;
    let price = 2.0 * window.width() as f32 * libm::logf(frames) / frames;
    let spectrum = whitened(window, window.frames_each(), sums, transforms, all)?;
    let mut found = [Peak::default(); PEAKS];
    peaks(&spectrum, band.start, band.end, &mut found);
    (found[0].height > price).then_some(found[0].cycles)
}

/// Spectrum of the whitened channels, with `each` frames per point. `None` if the window is too
/// long.
fn whitened<'m>(
    window: &mut WindowFrames,
    each: u32,
    sums: Sums<'m>,
    transforms: &'m mut [f32],
    all: &Products,
) -> Option<Spectrum<'m>> {
    let (width, may_share) = (window.width(), all.may_share);
    let domain = window.domain;
    let frames = window.count();
    let mut spectrum = Spectrum::new(window, each, sums, transforms)?;
    // Rows of the inverse factor whiten the channels. In a long window half as many mixtures
    // suffice: sums or differences of two rows.
    let mut mixtures = [[0.0; CHANNELS_MAX]; CHANNELS_MAX];
    if may_share {
        let rows = mixtures.iter_mut().zip(&all.matrix).enumerate();
        for (k, (mixture, row)) in rows.take(width) {
            let pairs = mixture.iter_mut().zip(row).take(k + 1);
            pairs.for_each(|(to, from)| *to = *from);
            mixture[k] += all.squares_min[k].max(CLEAR * mixture[k]);
        }
        Factor::new(&mut mixtures, width);
        invert_lower(&mut mixtures, width);
    } else {
        for (k, mixture) in mixtures.iter_mut().enumerate().take(width) {
            mixture[k] =
                1.0 / crate::sqrt((all.matrix[k][k] + all.squares_min[k]).max(f32::MIN_POSITIVE));
        }
    }
    let (mut width, mut per_mixture) = (width, 1);
    if frames > FRAMES_FEW && width > CHANNELS_FEW {
        (width, per_mixture) = (width.div_ceil(2), 2);
        for k in 0..width {
            let [one, other] = [2 * k, 2 * k + 1].map(|k| mixtures[k % CHANNELS_MAX]);
            let sign = if k % 2 == 0 { ROOT_HALF } else { -ROOT_HALF };
            mixtures[k] = core::array::from_fn(|i| ROOT_HALF * one[i] + sign * other[i]);
        }
    }
    let weight = if may_share { 1.0 } else { 1.0 / width as f32 };
    let mut first = 0;
    while first < width {
        let end = (first + spectrum.channels()).min(width);
        spectrum.clear(end - first);
        let together = mixtures.get(first..end).unwrap_or_default();
        // With independent channels, a mixture needs only its own; otherwise also all before them.
        let channels = if may_share { 0 } else { per_mixture * first }..per_mixture * end;
        window.visit_channels(channels, &mut |frame| {
            let point = frame.point(&domain, frames, each);
            for (k, mixture) in together.iter().enumerate() {
                let groups = mixture.as_chunks::<4>().0.iter();
                let pairs = groups.zip(frame.values.as_chunks::<4>().0);
                let from = if may_share {
                    0
                } else {
                    per_mixture * (first + k) / 4
                };
                let reached = (per_mixture * (first + k + 1)).div_ceil(4);
                let value = pairs
                    .take(reached)
                    .skip(from)
                    .map(|(m, v)| m[0] * v[0] + m[1] * v[1] + m[2] * v[2] + m[3] * v[3])
                    .sum();
                spectrum.put(k, point, value);
            }
        });
        for k in first..end {
            spectrum.add(k - first, weight);
        }
        first = end;
    }
    Some(spectrum)
}

/// Inserts peaks between `min` and `max` cycles that are higher than those found so far.
fn peaks(spectrum: &Spectrum, min: f32, max: f32, peaks: &mut [Peak; PEAKS]) {
    let first = spectrum.bin(CYCLES_PEAK.max(min)) as usize + 1;
    let last = (spectrum.bin(max) as usize).min(spectrum.last());
    let ratio = |bin: usize| {
        let [cos, both, sin] = spectrum.line(bin);
        let left = (1.0 - cos) * (1.0 - sin) - both * both;
        -libm::logf(left.max(LEFT_MIN))
    };
    let (mut before, mut at) = (f32::NEG_INFINITY, ratio(first.min(last)));
    for bin in first..=last {
        let after = if bin < last {
            ratio(bin + 1)
        } else {
            f32::NEG_INFINITY
        };
        if at > before && at >= after && at > peaks[PEAKS - 1].height {
            let bend = 2.0 * at - before - after;
            let vertex = if bend.is_finite() && bend > 0.0 {
                0.5 * (after - before) / bend
            } else {
                0.0
            };
            let mut peak = Peak {
                cycles: spectrum.cycles(bin as f32 + vertex),
                height: at,
            };
            for place in &mut *peaks {
                if peak.height > place.height {
                    core::mem::swap(place, &mut peak);
                }
            }
        }
        (before, at) = (at, after);
    }
}
