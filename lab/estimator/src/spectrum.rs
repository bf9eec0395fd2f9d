//! Transforms of channels, and Wilks' ratio of a line at each of their bins.

use crate::limits::POINTS_MAX;
use crate::phase::{cos_sin, from_turns};
use core::f32::consts::PI;

/// Shortest transform, points.
const POINTS_MIN: usize = 256;
/// Longest transform on the chip, points.
const POINTS_CHIP: usize = 2048;
/// Points of a transform for each piece, where there is room.
const OVERSAMPLING: usize = 4;
/// A cosine or a sine that level and slope explain all but this share of is no line.
const LEFT_MIN: f32 = 2e-3;
/// Above this many cycles a window level and slope are orthogonal to lines.
const CYCLES_FAR: f32 = 12.0;

/// Products of the channels with cosine and sine at each bin: squares and cross products, summed
/// over the channels.
pub struct Spectrum<'m> {
    transform: &'m mut [f32],
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
        // No longer on a PC than on the chip where the chip can do it at all: both give the same bits.
        let most = if count > POINTS_CHIP / OVERSAMPLING {
            POINTS_MAX
        } else {
            POINTS_CHIP
        };
        let mut points = POINTS_MIN;
        while points < OVERSAMPLING * count && points < most {
            // Each size of transform takes a kilobyte of flash.
            points *= if points == POINTS_MIN { 4 } else { 2 };
        }
        let (transform, rest) = memory.split_at_mut_checked(points)?;
        let (cos, rest) = rest.split_at_mut_checked(points / 2)?;
        let (sin, rest) = rest.split_at_mut_checked(points / 2)?;
        let (both, rest) = rest.split_at_mut_checked(points / 2)?;
        let (plain, _) = rest.split_at_mut_checked(points / 2)?;
        cos.fill(0.0);
        sin.fill(0.0);
        both.fill(0.0);
        plain.fill(0.0);
        Some(Self {
            transform,
            cos,
            sin,
            both,
            plain,
            count: count as f32,
        })
    }

    /// Memory for a channel, zeros behind it.
    pub fn channel(&mut self) -> &mut [f32] {
        self.transform.fill(0.0);
        self.transform
    }

    /// Transforms the channel and adds it, `weight` times.
    pub fn add(&mut self, weight: f32) {
        transform(self.transform);
        let bins = self.transform.as_chunks::<2>().0;
        for (k, [re, im]) in bins.iter().enumerate().skip(1) {
            self.cos[k] += weight * re * re;
            self.sin[k] += weight * im * im;
            // The transform's sine has the other sign.
            self.both[k] -= weight * re * im;
            self.plain[k] += re * re + im * im;
        }
    }

    /// Number of bins.
    pub fn bins(&self) -> usize {
        self.cos.len()
    }

    /// Cycles a window of a bin.
    pub fn cycles(&self, bin: f32) -> f32 {
        bin * self.count / self.transform.len() as f32
    }

    /// Bin of a number of cycles a window.
    pub fn bin(&self, cycles: f32) -> f32 {
        cycles / self.cycles(1.0)
    }

    /// Power of a bin of the channel that was added last.
    pub fn of_channel(&self, bin: usize) -> f32 {
        let bins = self.transform.as_chunks::<2>().0;
        let [re, im] = bins.get(bin).copied().unwrap_or([0.0; 2]);
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
        let sinc = |angle: f32| libm::sinf(angle) / angle;
        let level = sinc(angle);
        // The mean of u sin(angle u) over -1 to 1, against the mean square of u.
        let slope = (level - libm::cosf(angle)) / angle;
        let even = 0.5 + 0.5 * sinc(2.0 * angle) - level * level;
        let odd = 0.5 - 0.5 * sinc(2.0 * angle) - 3.0 * slope * slope;
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
    transform!(256 rfft_256, 1024 rfft_1024, 2048 rfft_2048);
    #[cfg(feature = "long-windows")]
    transform!(256 rfft_256, 1024 rfft_1024, 2048 rfft_2048, 4096 rfft_4096, 8192 rfft_8192,
        16384 rfft_16384, 32768 rfft_32768);
}
