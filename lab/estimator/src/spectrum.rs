//! Transforms of channels, and Wilks' ratio of a line at each of their bins.

use crate::limits::CHANNELS_MAX;
use crate::phase::{cos_sin, from_turns};
use core::f32::consts::PI;

/// Shortest transform, points.
const POINTS_MIN: usize = 128;
/// Points of a transform for each piece.
const OVERSAMPLING: usize = 2;
/// A cosine or a sine that level and slope explain all but this share of is no line.
const LEFT_MIN: f32 = 2e-3;
/// Above this many cycles a window level and slope are orthogonal to lines.
const CYCLES_FAR: f32 = 12.0;

/// Products of the channels with cosine and sine at each bin: squares and cross products, summed
/// over the channels.
pub struct Spectrum<'m> {
    /// Transforms of some channels, one after the other.
    transforms: &'m mut [f32],
    points: usize,
    cos: &'m mut [f32],
    sin: &'m mut [f32],
    both: &'m mut [f32],
    plain: &'m mut [f32],
    /// Pieces of the window.
    count: f32,
}

impl<'m> Spectrum<'m> {
    /// An empty one of a window of `count` pieces in `memory`. None if it does not fit.
    pub fn new(memory: &'m mut [f32], count: usize) -> Option<Self> {
        let mut points = POINTS_MIN;
        while points < OVERSAMPLING * count {
            points *= 2;
        }
        let (sums, transforms) = memory.split_at_mut_checked(2 * points)?;
        sums.fill(0.0);
        let (cos, rest) = sums.split_at_mut(points / 2);
        let (sin, rest) = rest.split_at_mut(points / 2);
        let (both, plain) = rest.split_at_mut(points / 2);
        (transforms.len() >= points).then_some(Self {
            transforms,
            points,
            cos,
            sin,
            both,
            plain,
            count: count as f32,
        })
    }

    /// How many channels are transformed at a time.
    pub fn channels(&self) -> usize {
        (self.transforms.len() / self.points).min(CHANNELS_MAX)
    }

    /// Makes room for some channels.
    pub fn clear(&mut self, channels: usize) {
        let used = (channels * self.points).min(self.transforms.len());
        self.transforms[..used].fill(0.0);
    }

    /// Adds to a point of a channel that is to be transformed.
    pub fn put(&mut self, channel: usize, point: usize, value: f32) {
        if point < self.points
            && let Some(place) = self.transforms.get_mut(channel * self.points + point)
        {
            *place += value;
        }
    }

    /// Transforms a channel and adds it, `weight` times.
    pub fn add(&mut self, channel: usize, weight: f32) {
        let from = channel * self.points;
        let Some(signal) = self.transforms.get_mut(from..from + self.points) else {
            return;
        };
        transform(signal);
        let bins = signal.as_chunks::<2>().0;
        let sums = self.cos.iter_mut().zip(&mut *self.sin);
        let sums = sums.zip(self.both.iter_mut().zip(&mut *self.plain));
        for (((cos, sin), (both, plain)), [re, im]) in sums.zip(bins).skip(1) {
            let (x, y) = (weight * re, weight * im);
            *cos += x * re;
            *sin += y * im;
            // The transform's sine has the other sign.
            *both -= x * im;
            *plain += re * re + im * im;
        }
    }

    /// Number of bins.
    pub fn bins(&self) -> usize {
        self.cos.len()
    }

    /// Cycles a window of a bin.
    pub fn cycles(&self, bin: f32) -> f32 {
        bin * self.count / self.points as f32
    }

    /// Bin of a number of cycles a window.
    pub fn bin(&self, cycles: f32) -> f32 {
        cycles / self.cycles(1.0)
    }

    /// Power of a bin of the first channel that was added.
    pub fn of_channel(&self, bin: usize) -> f32 {
        let [re, im] =
            [2 * bin, 2 * bin + 1].map(|i| self.transforms.get(i).copied().unwrap_or_default());
        2.0 / self.count * (re * re + im * im)
    }

    /// Power of a bin without weights.
    pub fn plain(&self, bin: usize) -> f32 {
        2.0 / self.count * self.plain[bin]
    }

    /// Highest bin: one channel's half of the rate.
    pub fn last(&self) -> usize {
        self.bins() - 1
    }

    /// Has the power of each bin for [`Self::power`]; the transforms are gone.
    pub fn finish(&mut self) {
        for bin in 1..self.bins() {
            let [cos, _, sin] = self.line(bin);
            self.transforms[bin] = cos + sin;
        }
    }

    /// Power of a bin, all channels with their weights.
    pub fn power(&self, bin: usize) -> f32 {
        self.transforms.get(bin).copied().unwrap_or_default()
    }

    /// Squares of the products with orthonormal cosine and sine beside level and slope, and their
    /// cross product; zeros where there is no line.
    pub fn line(&self, bin: usize) -> [f32; 3] {
        let (cos, sin, both) = (self.cos[bin], self.sin[bin], self.both[bin]);
        let (n, x) = (self.count, self.cycles(bin as f32));
        if x > CYCLES_FAR {
            return [cos, both, sin].map(|product| 2.0 / n * product);
        }
        // From the first piece to the window's centre, about which cosines are even.
        let (c, s) = cos_sin(from_turns(0.5 * x * (1.0 - 1.0 / n)));
        let centred = [
            c * c * cos + 2.0 * c * s * both + s * s * sin,
            c * c * both - s * s * both + c * s * (sin - cos),
            c * c * sin - 2.0 * c * s * both + s * s * cos,
        ];
        let angle = PI * x;
        let (cosine, sine) = cos_sin(from_turns(0.5 * x));
        let level = sine / angle;
        // The mean of u sin(angle u) over -1 to 1, against the mean square of u.
        let slope = (level - cosine) / angle;
        let even = 0.5 + 0.5 * level * cosine - level * level;
        let odd = 0.5 - 0.5 * level * cosine - 3.0 * slope * slope;
        if even < LEFT_MIN || odd < LEFT_MIN {
            return [0.0; 3];
        }
        [
            centred[0] / (n * even),
            centred[1] / (n * libm::sqrtf(even * odd)),
            centred[2] / (n * odd),
        ]
    }
}

/// The transform of a real signal in its place, as real and imaginary parts; the first two are bin
/// 0 and the Nyquist bin. Nothing is done if the length is none of the transform's own.
fn transform(signal: &mut [f32]) {
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
