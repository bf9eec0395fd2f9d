//! How far a tone is to be trusted, by the noise next to its lines. The limits were chosen on other
//! seeds than those of docs/results/noise.md, and on recordings of touch without a grating: what those
//! recordings give is no independent figure.

use crate::fit::Status;
use crate::neighbourhood::Neighbourhood;

/// Most of the density at a line, over the power in the band about it.
const COLOUR_OVER_BAND: f32 = 2.0;
/// Standard deviations of as many independent residuals beyond which their autoregression's density
/// is not chance: it is twice as uncertain.
const COLOUR_SURE: f32 = 3.5;
/// The same of a ratio with few degrees of freedom, whose tail is long.
const SURE_TOGETHER: f32 = 4.0;
/// Slow power from which on it is not that of white noise: one in a hundred of such windows has
/// more.
const SLOW_POWER: f32 = 2.7;
/// Slow power, in units of the noise's density at the lines, from which on the tone itself has
/// moved.
const UNSTEADY_POWER: f32 = 4.0;
/// Slow power over the line's, and over that and the square of the cycles, below which a tone has
/// not moved: 0.003 of its amplitude, and what a frequency that moves by 0.1 % (rms) through the
/// window leaves, 0.66 (0.001 cycles)^2. Beside very little noise an onset is above it.
pub const STEADY_SHARE: f32 = 1e-5;
const STEADY_SHARE_PER_CYCLE: f32 = 6.6e-7;
/// From this coherence on the residuals have the channels' signs and amplitudes as the tone has
/// them.
const UNSTEADY_COHERENCE: f32 = 3.0;
/// The same with at least this slow power.
const UNSTEADY_SLOW_POWER: f32 = 1.5;
/// And with a line that stands out by no more than this.
const UNSTEADY_CONTRAST: f32 = 200.0;
/// A density of the noise at the lines from which on it counts as coloured.
const COLOURED: f32 = 1.5;
/// A coherence from which on the channels share their noise.
const SHARED: f32 = 2.0;
/// In noise that is not white and independent a line must stand out by this factor of power.
const CONTRAST: f32 = 10.0;
/// A line that stands out by this factor of the noise far from it is one, though it may not be
/// steady.
const LINE_CONTRAST: f32 = 30.0;
/// From this on it stands out clearly.
const CLEAR_CONTRAST: f32 = 400.0;
/// Fewer cycles are no period: a single bump looks like them.
const CYCLES: f32 = 1.4;
/// Unless the channels have it in different phases, which a bump has not: then from this spread and
/// this number of cycles on.
const SPREAD: f32 = 0.3;
const CYCLES_SPREAD: f32 = 1.15;
/// This share of the tone's power that is no noise takes the exception back: half a cycle of sharp
/// ridges looks like them, too.
const SPREAD_REMAINDER: f32 = 0.005;
/// As many cycles of a weak line, or of one that all channels have in phase, within this spread,
/// are no period either.
const CYCLES_DOUBTFUL: f32 = 2.7;
const COMMON_SPREAD: f32 = 0.1;
/// Nor where they leave this share of the tone's power that is no noise: a step that all channels
/// have looks like them.
const COMMON_REMAINDER: f32 = 0.02;
/// Nor are as many beside a curved baseline: the third harmonic of half a cycle looks like them.
const CYCLES_BENT: f32 = 2.0;
/// In fewer channels than this a part of a cycle with overtones may look like more cycles beside a
/// curved baseline: they need more cycles.
const CHANNELS_FEW: f32 = 8.0;
/// As many channels and fewer need more still.
const CHANNELS_PAIR: f32 = 2.0;
/// The least cycles in one channel or two.
const CYCLES_PAIR: f32 = 1.65;
/// In fewer cycles than this a change of amplitude looks like movement: the limit is twice as high.
const FEW_CYCLES: f32 = 2.5;
/// The same in noise that is surely not white and independent, for a line that does not stand out
/// clearly.
const CYCLES_COLOURED: f32 = 2.1;
/// And where it only may be.
const CYCLES_PERHAPS_COLOURED: f32 = 1.7;
/// Density and coherence of noise that surely is: white noise has more than [`COLOURED`] or
/// [`SHARED`] in one of forty windows of two cycles.
const SURELY_COLOURED: f32 = 2.0;
const SURELY_SHARED: f32 = 2.6;
/// Residuals of at least this share of the tone's power, and this multiple of the noise, have an
/// unknown cause.
const MISFIT_REMAINDER: f32 = 0.5;
const NOISE_RATIO: f32 = 3.0;
/// An autoregression of few blocks takes colour for a trend: its excess counts for more by this
/// number over the frames.
const FEW_FRAMES: f32 = 30.0;

/// What is known of a tone.
#[derive(Clone, Copy, Debug)]
pub struct Evidence {
    pub cycles: f32,
    pub frames: f32,
    pub channels: f32,
    /// Power of the strongest line in a channel over that of as wide a part of white noise.
    pub contrast: f32,
    /// How far the channels' phases are apart: 0 if all channels have one shape in time, 1 if there
    /// is every phase.
    pub spread: f32,
    /// Whether the baseline is curved: it may have taken a part of the tone.
    pub is_curved: bool,
    /// Power of the residuals over the tone's.
    pub remainder: f32,
    /// Power of the residuals over that of the frames' third differences.
    pub noise_ratio: f32,
}

/// The status, and the factor of sigma.
pub fn trust(of: &Neighbourhood, evidence: &Evidence) -> (Status, f32) {
    let Evidence {
        cycles,
        frames,
        channels,
        ..
    } = *evidence;
    let deviation = |samples: f32| libm::sqrtf(2.0 / samples);
    // A density far above the band's is what an autoregression makes of a trend.
    let density = of.colour.min(COLOUR_OVER_BAND * of.band);
    let colour = if density > 1.0 + COLOUR_SURE * deviation(16.0 * channels) {
        1.0 + (density - 1.0) * (1.0 + FEW_FRAMES / frames)
    } else {
        1.0
    };
    let contrast = evidence.contrast / colour;
    let shared = of.coherence > 1.0 + SURE_TOGETHER * deviation(16.0);
    let together = colour * if shared { of.coherence } else { 1.0 };
    let is_slow = of.slow_power > SLOW_POWER;
    let is_plain = !is_slow && colour <= COLOURED && of.coherence <= SHARED;
    let is_surely_other = is_slow || colour > SURELY_COLOURED || of.coherence > SURELY_SHARED;
    let mut variance = colour;
    if together > COLOURED {
        variance = variance.max(together);
    }
    if is_slow {
        variance = variance.max(of.slow_power);
    }
    let moving = if cycles < FEW_CYCLES && contrast > CLEAR_CONTRAST {
        2.0 * UNSTEADY_POWER
    } else {
        UNSTEADY_POWER
    };
    let steady = STEADY_SHARE.min(STEADY_SHARE_PER_CYCLE * cycles * cycles) * evidence.contrast;
    let moves = of.slow_power > steady.max(moving * colour)
        || of.coherence > UNSTEADY_COHERENCE
            && of.slow_power > UNSTEADY_SLOW_POWER
            && contrast < UNSTEADY_CONTRAST;
    // One shape in time in all channels, or a weak one, may be a few swings of anything.
    let leaves = |share: f32| evidence.noise_ratio > NOISE_RATIO && evidence.remainder > share;
    let is_common =
        evidence.spread < COMMON_SPREAD && (contrast < CLEAR_CONTRAST || leaves(COMMON_REMAINDER));
    let (is_few, is_pair) = (channels < CHANNELS_FEW, channels <= CHANNELS_PAIR);
    let bent_cycles = match () {
        () if is_pair => CYCLES_DOUBTFUL,
        () if is_few || contrast < CLEAR_CONTRAST => CYCLES_BENT,
        () => 0.0,
    };
    let is_bent = evidence.is_curved && cycles < bent_cycles;
    let is_doubtful =
        cycles < CYCLES_DOUBTFUL && (is_common || contrast < LINE_CONTRAST) || is_bent;
    let is_short = is_doubtful
        || cycles
            < if !is_plain && contrast < UNSTEADY_CONTRAST {
                if is_surely_other {
                    CYCLES_COLOURED
                } else {
                    CYCLES_PERHAPS_COLOURED
                }
            } else if is_pair {
                CYCLES_PAIR
            } else if evidence.spread > SPREAD
                && !evidence.is_curved
                && !is_few
                && !leaves(SPREAD_REMAINDER)
            {
                CYCLES_SPREAD
            } else {
                CYCLES
            };
    let status = match () {
        () if !is_plain && contrast < CONTRAST && evidence.contrast < LINE_CONTRAST => {
            Status::NoTone
        }
        () if !is_plain && contrast < CONTRAST => Status::Unsteady,
        () if cycles < CYCLES && is_short => Status::Ambiguous,
        () if moves => Status::Unsteady,
        () if is_short || leaves(MISFIT_REMAINDER) => Status::Ambiguous,
        () => Status::Good,
    };
    (status, libm::sqrtf(variance))
}
