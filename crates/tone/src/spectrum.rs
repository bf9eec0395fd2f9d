//! Transforms of channels, and Wilks' ratio of a line at each of their bins.

use crate::limits::{CHANNELS_MAX, POINTS_MAX};
use crate::phase::{cos_sin, from_turns};
use crate::window_frames::WindowFrames;
use core::f32::consts::PI;
use core::num::NonZeroUsize;
use core::ops::Range;

/// Shortest transform, points.
const POINTS_MIN: usize = 128;
/// Zero padding: length of the transform relative to the data, up to the longest transform.
const OVERSAMPLING: usize = 2;
/// Minimum fraction of a line's energy that remains after projecting out level and slope.
const LEFT_MIN: f32 = 2e-3;
/// Above this many cycles per window, lines are assumed orthogonal to level and slope.
const CYCLES_FAR: f32 = 12.0;

/// Memory of a spectrum's sums.
pub struct Sums<'m> {
    /// Two sums of each bin.
    pub memory: &'m mut [f32],
    /// Third sum of each bin, if `memory` has no room for it; not needed for powers.
    pub more: &'m mut [f32],
}

/// For each bin, the squares and cross product of the channels' cosine and sine sums, added over
/// the channels; or only their power.
pub struct Spectrum<'m> {
    /// Transforms of some channels, one after the other.
    transforms: &'m mut [f32],
    points: NonZeroUsize,
    cos: &'m mut [f32],
    sin: &'m mut [f32],
    both: &'m mut [f32],
    /// Number of points in the window.
    count: f32,
    /// Points of the window that are transformed.
    transformed: Range<usize>,
    /// Number of frames that are transformed.
    frames: f32,
}

impl<'m> Spectrum<'m> {
    /// Creates an empty spectrum of a window with `each` frames per point. It covers only the
    /// middle of a window with more points than the longest transform. `None` if the memory is too
    /// small.
    pub fn new(
        window: &WindowFrames,
        each: u32,
        sums: Sums<'m>,
        transforms: &'m mut [f32],
    ) -> Option<Self> {
        let count = window.count().div_ceil(each) as usize;
        let transformed = if count > POINTS_MAX {
            let first = (count - POINTS_MAX / OVERSAMPLING) / 2;
            first..first + POINTS_MAX / OVERSAMPLING
        } else {
            0..count
        };
        let mut points = POINTS_MIN;
        while points < (OVERSAMPLING * count).min(POINTS_MAX) {
            points *= 2;
        }
        let (cos, rest) = sums.memory.split_at_mut_checked(points / 2)?;
        let (sin, rest) = rest.split_at_mut_checked(points / 2)?;
        let both = if rest.len() < points / 2 {
            sums.more.get_mut(..points / 2).unwrap_or_default()
        } else {
            &mut rest[..points / 2]
        };
        [&mut *cos, &mut *sin, &mut *both]
            .iter_mut()
            .for_each(|sums| sums.fill(0.0));
        (transforms.len() >= points).then_some(Self {
            transforms,
            points: NonZeroUsize::new(points)?,
            cos,
            sin,
            both,
            count: count as f32,
            frames: window.count().min(transformed.len() as u32 * each) as f32,
            transformed,
        })
    }

    /// Number of channels that are transformed at a time.
    pub fn channels(&self) -> usize {
        (self.transforms.len() / self.points).clamp(1, CHANNELS_MAX)
    }

    pub fn clear(&mut self, channels: usize) {
        let used = (channels * self.points.get()).min(self.transforms.len());
        self.transforms[..used].fill(0.0);
    }

    pub fn put(&mut self, channel: usize, point: usize, value: f32) {
        if self.transformed.contains(&point)
            && let place = channel * self.points.get() + point - self.transformed.start
            && let Some(place) = self.transforms.get_mut(place)
        {
            *place += value;
        }
    }

    /// Transforms a channel and adds `weight` times its products.
    pub fn add(&mut self, channel: usize, weight: f32) {
        let mut signals = self.transforms.chunks_exact_mut(self.points.get());
        let Some(signal) = signals.nth(channel) else {
            return;
        };
        transform(signal);
        let bins = signal.as_chunks::<2>().0;
        let sums = self.cos.iter_mut().zip(&mut *self.sin).zip(&mut *self.both);
        for (((cos, sin), both), [re, im]) in sums.zip(bins).skip(1) {
            let (x, y) = (weight * re, weight * im);
            *cos += x * re;
            *sin += y * im;
            // The transform's sine has the opposite sign.
            *both -= x * im;
        }
    }

    /// Transforms the first channels and adds their weighted powers, for [`Self::power`] and
    /// [`Self::plain`].
    pub fn add_powers(&mut self, weights: &[f32]) {
        let signals = self.transforms.chunks_exact_mut(self.points.get());
        signals.take(weights.len()).for_each(transform);
        for bin in 1..self.bins() {
            let geometry = self.geometry(bin);
            let (mut power, mut plain) = (0.0, 0.0);
            let signals = self.transforms.chunks_exact(self.points.get());
            for (signal, weight) in signals.zip(weights) {
                let [re, im] = entry(signal.as_chunks().0, bin);
                plain += re * re + im * im;
                if let Some(geometry) = &geometry {
                    let (cosine, sine) = geometry.centred(re, -im);
                    power +=
                        weight * (cosine * cosine / geometry.even + sine * sine / geometry.odd);
                }
            }
            if let (Some(cos), Some(sin)) = (self.cos.get_mut(bin), self.sin.get_mut(bin)) {
                (*cos, *sin) = (*cos + power, *sin + plain);
            }
        }
    }

    pub fn bins(&self) -> usize {
        self.cos.len()
    }

    /// Frequency of a bin, cycles per window.
    pub fn cycles(&self, bin: f32) -> f32 {
        bin * self.count / self.points.get() as f32
    }

    /// Bin at a frequency in cycles per window.
    pub fn bin(&self, cycles: f32) -> f32 {
        cycles / self.cycles(1.0)
    }

    /// Power of a bin of a channel that was transformed.
    pub fn of_channel(&self, channel: usize, bin: usize) -> f32 {
        let bins = self.transforms.as_chunks().0;
        let [re, im] = entry(bins, channel * self.points.get() / 2 + bin);
        2.0 / self.frames * (re * re + im * im)
    }

    /// Unweighted power of a bin.
    pub fn plain(&self, bin: usize) -> f32 {
        2.0 / self.frames * entry(self.sin, bin)
    }

    /// Unweighted power of the strongest bin.
    pub fn strongest_plain(&self) -> f32 {
        2.0 / self.frames * self.sin.iter().copied().fold(0.0, f32::max)
    }

    /// Power of a bin over all weighted channels, after projecting out level and slope.
    pub fn power(&self, bin: usize) -> f32 {
        entry(self.cos, bin)
    }

    pub fn last(&self) -> usize {
        self.bins() - 1
    }

    /// Squares and cross product of the channels' products with orthonormal cosine and sine, after
    /// projecting out level and slope; zeros if the bin's frequency is too low.
    pub fn line(&self, bin: usize) -> [f32; 3] {
        let [cos, sin, both] = [&*self.cos, &*self.sin, &*self.both].map(|sums| entry(sums, bin));
        let Some(Geometry { c, s, even, odd }) = self.geometry(bin) else {
            return [0.0; 3];
        };
        [
            (c * c * cos + 2.0 * c * s * both + s * s * sin) / even,
            (c * c * both - s * s * both + c * s * (sin - cos)) / crate::sqrt(even * odd),
            (c * c * sin - 2.0 * c * s * both + s * s * cos) / odd,
        ]
    }

    /// Cosine and sine of a bin after projecting out level and slope; `None` if too little is left.
    fn geometry(&self, bin: usize) -> Option<Geometry> {
        let (n, x) = (self.frames, self.cycles(bin as f32));
        if x > CYCLES_FAR {
            return Some(Geometry {
                c: 1.0,
                s: 0.0,
                even: 0.5 * n,
                odd: 0.5 * n,
            });
        }
        // Phase from the first point to the window's centre, about which cosines are even.
        let (c, s) = cos_sin(from_turns(0.5 * x * (1.0 - 1.0 / self.count)));
        let angle = PI * x;
        let (cosine, sine) = cos_sin(from_turns(0.5 * x));
        let level = sine / angle;
        // Mean of u sin(angle u) over -1 to 1. The mean square of u is one third.
        let slope = (level - cosine) / angle;
        let even = 0.5 + 0.5 * level * cosine - level * level;
        let odd = 0.5 - 0.5 * level * cosine - 3.0 * slope * slope;
        (even >= LEFT_MIN && odd >= LEFT_MIN).then_some(Geometry {
            c,
            s,
            even: n * even,
            odd: n * odd,
        })
    }
}

/// Entry of a list; zero beyond the end.
fn entry<T: Copy + Default>(list: &[T], at: usize) -> T {
    list.get(at).copied().unwrap_or_default()
}

/// Cosine and sine of a bin about the window's centre.
struct Geometry {
    /// Cosine of the phase at the centre.
    c: f32,
    /// Sine of the phase at the centre.
    s: f32,
    /// Energy of the centred cosine after projecting out level and slope.
    even: f32,
    /// Energy of the centred sine after projecting out the slope.
    odd: f32,
}

impl Geometry {
    /// Converts products with cosine and sine: moves zero phase from the first point to the centre.
    fn centred(&self, cosine: f32, sine: f32) -> (f32, f32) {
        (
            self.c * cosine + self.s * sine,
            self.c * sine - self.s * cosine,
        )
    }
}

/// In-place transform of a real signal, to real and imaginary parts; the first two values are bin 0
/// and the Nyquist bin. Does nothing for unsupported lengths.
pub fn transform(signal: &mut [f32]) {
    macro_rules! transform {
        ($($points:literal $name:ident),*) => {
            match signal.len() {
                $($points => if let Ok(signal) = <&mut [f32; $points]>::try_from(signal) {
                    let _ = microfft::real::$name(signal);
                },)*
                _ => {}
            }
        };
    }
    #[cfg(not(feature = "long-windows"))]
    transform!(128 rfft_128, 256 rfft_256, 512 rfft_512, 1024 rfft_1024);
    #[cfg(feature = "long-windows")]
    transform!(128 rfft_128, 256 rfft_256, 512 rfft_512, 1024 rfft_1024, 2048 rfft_2048,
        4096 rfft_4096, 8192 rfft_8192, 16384 rfft_16384, 32768 rfft_32768);
}
