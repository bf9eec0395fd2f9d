//! Results of a window: the mean frequency, its uncertainty, and the status of a tested tone.

use crate::blocks::Blocks;
use crate::comb::CompetingComb;
use crate::covariance::ROUNDING;
use crate::fit::{Fit, Movement, Status, Tests};
use crate::frame_span::FrameSpan;
use crate::hypotheses::{Other, Tested, Z_BETWEEN, Z_LINE};
use crate::legendre::{legendre, slopes};
use crate::limits::{BLOCKS_MAX, CHANNELS_MAX, DEGREES_MAX, HARMONICS_MAX, OVERTONES};
use crate::matrix::Square;
use crate::mean::{Evidence, MeanPhase};
use crate::movement::Followed;
use crate::noise_bins::NoiseBins;
use crate::normal::MOVEMENT_MAX;
use crate::nyquist::Nyquist;
use crate::phase::{cos_sin, from_turns};
use crate::scene::Scene;
use crate::significance::Z_TEST;
use crate::solve::Solution;
use crate::source::Values;
use crate::statistics::Statistics;
use crate::workspace::Workspace;
use core::f32::consts::PI;

/// Minimum log odds against a different frequency: a thousand to one.
const ODDS: f32 = 6.9;
/// Minimum number of cycles needed to recognise a period.
pub const CYCLES: f32 = 1.15;
/// Minimum number of cycles if all channels have the same waveform, or if there are at most two
/// channels: any single bump could then pass for a period.
pub const CYCLES_ONE: f32 = 2.0;
/// Maximum RMS phase beyond the fitted degrees, radians. With more, a cycle may be lost.
const FOLLOWED: f32 = 0.2;
/// Minimum power of a second tone, as a fraction of the tone's.
const SECOND_TONE: f32 = 0.125;
/// Maximum RMS change of the amplitude, as a fraction.
const FADING: f32 = 0.7;
/// Maximum relative sigma of a frequency.
pub const SIGMA_MAX: f32 = 0.1;
/// Relative inflation of sigma for few samples, times the degrees of freedom.
const FEW_SAMPLES: f32 = 1.2;

/// The mean frequency, in cycles per window.
#[derive(Clone, Copy, Debug, Default)]
pub struct Mean {
    pub cycles: f32,
    pub sigma: f32,
    /// Estimate of the mean phase.
    pub phase: MeanPhase,
    /// Variance inflation of the phase modulation.
    pub scale: f32,
}

/// Returns the mean frequency and its uncertainty; `clipped` is the fraction of clipped frames in
/// each channel.
#[inline(never)]
pub fn mean(
    tested: &Tested,
    workspace: &Workspace,
    blocks: &Blocks,
    scene: &Scene,
    clipped: &Values,
) -> Mean {
    let followed = tested.followed;
    let mut scale = Scale::new(tested, &workspace.noise_bins, blocks);
    scale.factor *= noise_of_clipped(tested, &workspace.solution, clipped);
    let evidence = Evidence {
        phase: followed.phase(),
        covariance: &workspace.normal.matrix,
        scale: scale.factor,
        count: followed.degrees.phase,
        freedom: scale.freedom,
        steady: scene.steady(),
    };
    let phase = evidence.mean_phase();
    Mean {
        cycles: followed.trajectory.cycles + phase.mean / PI,
        sigma: crate::sqrt(phase.variance) / PI,
        phase,
        scale: scale.factor,
    }
}

/// Variance inflation for clipped channels, weighted by their information on the frequency. Clipped
/// frames carry neither noise nor information, so a channel's other frames have more noise than its
/// average.
fn noise_of_clipped(tested: &Tested, solution: &Solution, clipped: &Values) -> f32 {
    if clipped.iter().all(|clipped| *clipped <= 0.0) {
        return 1.0;
    }
    let (mut told, mut noise) = (0.0, 0.0);
    for (line, waves) in tested
        .shape
        .lines
        .iter()
        .zip(solution.lines().as_chunks::<2>().0)
    {
        for k in 0..tested.width.min(CHANNELS_MAX) {
            let [cos, sin] = waves.each_ref().map(|wave| line as f32 * wave[k]);
            let own = (cos * cos + sin * sin) / tested.followed.noise.variances[k];
            told += own;
            noise += own / (1.0 - clipped[k]);
        }
    }
    noise / told.max(f32::MIN_POSITIVE)
}

/// Variance inflation: residual scatter relative to the line noise.
struct Scale {
    factor: f32,
    freedom: f32,
}

impl Scale {
    /// Noise at those offsets from the lines that affect the mean frequency, relative to the line
    /// noise, with a small-sample correction.
    fn new(tested: &Tested, noise_bins: &NoiseBins, blocks: &Blocks) -> Self {
        let (followed, lines) = (tested.followed, tested.shape.lines);
        let n = followed.fitted.phase;
        let at = |u: f32| {
            let p = legendre::<{ DEGREES_MAX + 1 }>(u);
            let seen = followed.seen.iter().zip(&p[1..]).take(n);
            seen.map(|(x, p)| x * p).sum::<f32>()
        };
        let mut places = [[0.0; 2]; BLOCKS_MAX];
        for (b, place) in places.iter_mut().enumerate().take(blocks.count()) {
            *place = [blocks.middle(b), at(blocks.middle(b))];
        }
        let places = places.get(..blocks.count()).unwrap_or_default();
        let level = places.iter().map(|[_, value]| value).sum::<f32>() / places.len() as f32;
        let (mut last, mut seen_there) = (f32::NAN, 0.0);
        // Cosine and sine of a bin are adjacent members: reuse the last result for the second.
        let mut sees = |distance: f32| {
            if distance != last {
                let (mut cos, mut sin) = (0.0, 0.0);
                for [u, value] in places {
                    let (c, s) = cos_sin(from_turns(0.5 * distance * u));
                    (cos, sin) = (cos + (value - level) * c, sin + (value - level) * s);
                }
                (last, seen_there) = (distance, cos * cos + sin * sin);
            }
            seen_there
        };
        let [mut seen, mut squares, mut power, mut weights, mut weighted] = [0.0; 5];
        for member in noise_bins.members() {
            let weight = followed.weights[lines.index(usize::from(member.line)) % HARMONICS_MAX];
            let fraction = weight * sees(noise_bins.distance(member));
            seen += fraction;
            squares += fraction * fraction;
            power += fraction * member.power;
            weights += weight;
            weighted += weight * member.power;
        }
        // Without noise bins, the noise is white: the same at all frequencies.
        let (mut local, mut equal) = (1.0, followed.count);
        if noise_bins.count() > 0 {
            local = power
                / seen.max(f32::MIN_POSITIVE)
                / (weighted / weights.max(f32::MIN_POSITIVE)).max(f32::MIN_POSITIVE);
            equal = seen * seen / squares.max(f32::MIN_POSITIVE);
        }
        let freedom = (followed.noise.channels * equal).min(followed.freedom());
        let few = 1.0 + FEW_SAMPLES / freedom;
        let correlated = 1.0 - followed.noise.shrinkage;
        let width = tested.width as f32;
        // Fraction of the noise that fitting the modulation absorbs.
        let (mut all, mut each) = (0.0, 0.0);
        for power in &tested.powers {
            all += power.all * power.all;
            each += power.squares;
        }
        let rank = followed.count * all / each.max(f32::MIN_POSITIVE);
        let left = (rank - followed.unknowns() as f32).max(0.25 * rank);
        Self {
            factor: local
                * few
                * few
                * (1.0 + correlated * width / followed.effective)
                * (1.0 + correlated * (rank / left.max(f32::MIN_POSITIVE) - 1.0)),
            freedom,
        }
    }
}

/// Computes the frequency modulation from the coefficients of the phase.
pub fn movement(
    followed: &Followed,
    covariance: &Square<MOVEMENT_MAX>,
    mean: &Mean,
    span: &FrameSpan,
) -> Movement {
    // The first degree belongs to the mean frequency.
    let count = followed.degrees.phase.min(DEGREES_MAX);
    let variance = |weights: &[f32; DEGREES_MAX]| {
        let rows = covariance.iter().zip(weights).take(count).skip(1);
        let form = rows.map(|(row, weight)| {
            let products = row.iter().zip(weights).take(count).skip(1);
            weight * products.map(|(x, w)| x * w).sum::<f32>()
        });
        (mean.scale * form.sum::<f32>()).max(0.0)
    };
    let mut phase = followed.phase();
    phase[0] = 0.0;
    // Mean squares of the slope of the phase, and of the noise in the slope.
    let (mut square, mut noise) = (0.0, 0.0);
    const PLACES: usize = 32;
    for i in 0..PLACES {
        let slopes = slopes::<{ DEGREES_MAX + 1 }>((2 * i + 1) as f32 / PLACES as f32 - 1.0);
        let slope: f32 = slopes[1..].iter().zip(&phase).map(|(s, c)| s * c).sum();
        square += slope * slope / PLACES as f32;
        let of_degrees = core::array::from_fn(|i| slopes.get(i + 1).copied().unwrap_or_default());
        noise += variance(&of_degrees) / PLACES as f32;
    }
    let unit = PI * mean.cycles;
    let wander = crate::sqrt((square - noise).max(0.0)) / unit;
    // Least-squares slope of the frequency over `u`: three times the sum of the coefficients of
    // even degree.
    let even = core::array::from_fn(|i| if i % 2 == 1 { 1.0 } else { 0.0 });
    let chirp = 3.0 * phase.iter().zip(&even).map(|(x, w)| x * w).sum::<f32>() / PI;
    let chirp_sigma = 3.0 * crate::sqrt(variance(&even)) / PI;
    let per_unit = span.frequency(1.0) * span.per_u();
    Movement {
        wander,
        wander_sigma: crate::sqrt(noise) / unit,
        chirp: chirp * per_unit,
        chirp_sigma: chirp_sigma * per_unit,
    }
}

/// A competing frequency.
#[derive(Clone, Copy, Debug)]
pub struct Reading {
    /// Cycles per window.
    pub cycles: f32,
    /// Power relative to the reported tone.
    pub fraction: f32,
}

impl Reading {
    /// A frequency with the same power as the tone.
    fn of(cycles: f32) -> Self {
        Self {
            cycles,
            fraction: 1.0,
        }
    }
}

/// Figures that determine the status.
pub struct Figures<'v> {
    pub tests: &'v Tests,
    pub mean: &'v Mean,
    /// A line outside the comb.
    pub other: &'v Other,
    /// Best-scoring comb at a different frequency.
    pub competing: &'v CompetingComb,
    /// Number of the strongest line.
    pub strongest: usize,
    pub second: usize,
    /// Frequency of the loudest line, cycles per window, if above half the frame rate: its alias
    /// could equally be the tone.
    pub image: Option<f32>,
    /// Frequency of the strongest noise bin near a line, cycles per window.
    pub nearest: f32,
    /// Subharmonic of the tone that falls on the known interferer, cycles per window.
    pub hidden: Option<f32>,
    /// True if lines and baseline have more unknowns than the window has room for.
    pub is_crowded: bool,
    /// True if a channel stays at an end of its range.
    pub stay: bool,
    pub lines: usize,
    pub nyquist: Nyquist,
}

impl Figures<'_> {
    pub fn status(&self) -> Status {
        let (tests, mean) = (self.tests, self.mean);
        let is_lost = mean.phase.unfollowed > FOLLOWED * FOLLOWED;
        if tests.line < Z_LINE {
            Status::NoTone
        } else if self.other_reading().is_some() {
            Status::Ambiguous
        } else if is_lost
            || self.stay
            || tests.fading > FADING
            || mean.sigma > SIGMA_MAX * mean.cycles
        {
            Status::Unsteady
        } else {
            Status::Good
        }
    }

    fn is_faint(&self) -> bool {
        self.lines > 1 && self.tests.fundamental < Z_TEST
    }

    /// Competing frequency that makes a tone ambiguous; `None` if there is none.
    pub fn other_reading(&self) -> Option<Reading> {
        let (tests, cycles) = (self.tests, self.tests.cycles);
        let min = if tests.one_shape { CYCLES_ONE } else { CYCLES };
        if self.other.deviate > Z_TEST {
            let Other {
                cycles, fraction, ..
            } = *self.other;
            return Some(Reading { cycles, fraction });
        }
        let reading = if self.other.own > Z_LINE {
            self.other.own_cycles
        } else if let Some(image) = self.image {
            self.nyquist.seen(image)
        } else if let Some(hidden) = self.hidden {
            hidden
        } else if tests.between > Z_BETWEEN {
            0.5 * self.mean.cycles
        } else if self.is_faint() {
            // The strongest overtone could be a tone of its own.
            let line = if self.strongest > 1 {
                self.strongest
            } else {
                self.second
            };
            line as f32 * self.mean.cycles
        } else if cycles < CYCLES_ONE && self.strongest > 1 {
            self.strongest as f32 * self.mean.cycles
        } else if tests.beside > Z_TEST && tests.beside_fraction > SECOND_TONE {
            self.nearest
        } else if self.nyquist.max - cycles < min {
            2.0 * self.nyquist.max - self.mean.cycles
        } else if cycles < min || self.is_crowded || tests.margin < ODDS {
            // Without a competing comb, the alternative is a tone at half the frequency.
            if self.competing.cycles > 0.0 {
                self.competing.cycles
            } else {
                0.5 * self.mean.cycles
            }
        } else {
            return None;
        };
        Some(Reading::of(reading))
    }
}

#[inline(never)]
pub fn channels(followed: &Followed, solution: &Solution, statistics: &Statistics, fit: &mut Fit) {
    let first = solution.shape.first_line();
    let inverse = solution.inverse();
    let rows = inverse.iter().enumerate();
    let diagonal = rows.filter_map(|(i, row)| row.get(i));
    let variance = 0.5 * diagonal.skip(first).take(2).sum::<f32>();
    let has_fundamental = solution.shape.lines.has(1);
    let fundamental = solution.lines().first_chunk::<2>();
    let fundamental = fundamental.filter(|_| has_fundamental);
    let center = legendre::<5>(0.0);
    for k in 0..statistics.width.min(CHANNELS_MAX) {
        let c = usize::from(statistics.order[k]) % CHANNELS_MAX;
        let scale = statistics.scale[k];
        let levels = solution.rows.iter().zip(&center).take(first);
        let offset: f32 = levels.map(|(row, p)| row[k] * p).sum();
        let channel = &mut fit.channels[c];
        channel.offset = statistics.level[k] + scale * offset;
        channel.residual = scale * crate::sqrt((followed.variances[k] - ROUNDING).max(0.0));
        if let Some([cos, sin]) = fundamental {
            let (cos, sin) = (cos[k], sin[k]);
            channel.amplitude = scale * libm::hypotf(cos, sin);
            channel.phase_rad = libm::atan2f(-sin, cos);
            channel.phase_variance =
                variance * followed.noise.variances[k] / (cos * cos + sin * sin);
        }
        fit.usable |= 1 << c;
    }
}

/// Complex ratios of the overtones to the fundamental, common to all channels whatever their
/// delays.
pub fn overtones(solution: &Solution, variances: &Values, width: usize) -> [[f32; 2]; OVERTONES] {
    let mut ratios = [[0.0; 2]; OVERTONES];
    let numbers = solution.shape.lines;
    let Some((first, others)) = solution.lines().as_chunks::<2>().0.split_first() else {
        return ratios;
    };
    if !numbers.has(1) {
        return ratios;
    }
    for (line, wave) in numbers.iter().skip(1).zip(others) {
        if let Some(ratio) = ratios.get_mut(line - 2) {
            *ratio = overtone(line, wave, first, variances, width);
        }
    }
    ratios
}

/// Complex ratio of an overtone to the fundamental, from cosine and sine of both in the first
/// `width` channels.
pub fn overtone(
    line: usize,
    [cos, sin]: &[Values; 2],
    first: &[Values; 2],
    variances: &Values,
    width: usize,
) -> [f32; 2] {
    let (mut real, mut imaginary, mut all) = (0.0, 0.0, 0.0);
    for k in 0..width.min(CHANNELS_MAX) {
        let (x, y) = (first[0][k], -first[1][k]);
        let power = x * x + y * y;
        if power <= 0.0 {
            continue;
        }
        // Conjugate of the fundamental, scaled to unit length, to the power `line`.
        let (mut c, mut s) = (1.0, 0.0);
        let size = crate::sqrt(power);
        for _ in 0..line {
            (c, s) = ((c * x + s * y) / size, (s * x - c * y) / size);
        }
        let (a, b) = (cos[k], -sin[k]);
        let weight = size / variances[k];
        real += weight * (a * c - b * s);
        imaginary += weight * (a * s + b * c);
        all += weight * size;
    }
    [real / all, imaginary / all]
}
