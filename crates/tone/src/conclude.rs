//! Whether a solution is a tone, and with what uncertainty.

use crate::blocks::Blocks;
use crate::fit::{ChannelFit, Fit, OtherTone, Status};
use crate::frame_span::FrameSpan;
use crate::limits::{CHANNELS_MAX, HARMONICS_MAX, OVERTONES};
use crate::movement::movement;
use crate::neighbourhood::Neighbourhood;
use crate::other_lines::strongest_other_line;
use crate::refine::Summit;
use crate::significance::{ln, significant_search_gain};
use crate::solve::Solution;
use crate::source::Overwritten;
use crate::statistics::{Channels, Statistics};
use crate::trust::{Evidence, STEADY_SHARE, trust};

/// Cycles in the window below which its frequency cannot be estimated.
const CYCLES_MIN: f32 = 0.6;
/// A tone is its own mirror image within this distance of half the frame rate, cycles a window.
const IMAGE_CYCLES: f32 = 0.9;
/// Relative uncertainty above which a window is too short for a frequency.
const RELATIVE_SIGMA_MAX: f32 = 0.1;
/// Error of a frequency by f32, as a share of it: of its own last digit, and of the sums', below
/// the noise's at signal to noise ratios up to about 60 dB.
const ROUNDING_SHARE: f32 = 2e-7;

/// Power of a fundamental that is there, in units of the noise in each channel: noise has two.
const FUNDAMENTAL_POWER: f32 = 4.0;
/// Residuals over the noise, cycles in the window, of a tone that may be a part of a curved
/// baseline.
const CURVED_NOISE_RATIO: f32 = 3.0;
const CURVED_CYCLES: f32 = 6.0;
/// And power of the residuals over the tone's.
const CURVED_REMAINDER: f32 = 0.08;
/// Unknowns of harmonics and of a curved baseline over the values that are independent in a window
/// up to the highest harmonic. From this share on they describe nearly everything, and so say
/// nothing of a period.
const FULL_SHARE: f32 = 0.85;
/// A line that the solution leaves counts from this share of the tone's power on, and from this
/// contrast.
const OTHER_LINE_SHARE: f32 = 0.06;
const OTHER_LINE_CONTRAST: f32 = 6.0;
/// The same of one that stands out more, where residuals are at least this multiple of the noise.
const CLEAR_LINE_SHARE: f32 = 0.02;
const CLEAR_LINE_CONTRAST: f32 = 10.0;
const CLEAR_LINE_NOISE_RATIO: f32 = 3.0;
/// From this density on, and this multiple of the band's power, the residuals at a line are its
/// own: no noise is as narrow. Two tones less than a cycle a window apart beat, in each channel at
/// another time. Their density is 5 to 13 times the band's power, that of coloured noise less than
/// 3; of one window in a thousand it is 5. Chosen on other seeds than those of docs/results/noise.md.
const BEAT_DENSITY: f32 = 4.0;
const BEAT_OVER_BAND: f32 = 4.0;
/// Least share of the tone's power, and distance from its lines, cycles in the window, of a line
/// that is no part of a movement.
const APART_SHARE: f32 = 0.2;
const APART_CYCLES: f32 = 2.0;
/// Fewer cycles of a comb whose fundamental is not its strongest line are no period if they move,
/// or leave this multiple of the noise.
const COMB_CYCLES: f32 = 4.0;
const COMB_NOISE_RATIO: f32 = 3.0;
/// Along a path that turns back residuals are the noise's, to this factor, or the ways differ:
/// friction turns with the motion, and with it a channel's level, amplitude and phase, of which the
/// solution has one each.
const TURNED_NOISE_RATIO: f32 = 2.0;
/// So much of its range is a turn and no encoder's noise.
const TURNED_SHARE: f32 = 0.025;
/// A way back of this many cycles at an end of the path is a turn, too: its friction is a step in
/// the first frames or in the last.
const TURNED_CYCLES: f32 = 0.003;
/// Nearer than this many cycles a window to a multiple a line counts as one.
const MULTIPLE_CYCLES: f32 = 0.5;
/// Cycles from which such a line is a tone of its own.
const OTHER_TONE_CYCLES: f32 = 1.5;

/// The result of a window's solution, into `fit`.
#[inline(never)]
pub fn conclude(
    span: &mut FrameSpan,
    statistics: &Statistics,
    channels: &Channels,
    blocks: &mut Blocks,
    best: &Solution,
    (summit, around, evidence): (&Summit, &Neighbourhood, &Evidence),
    fit: &mut Fit,
) -> Result<(), Overwritten> {
    let sigma_nu = white_sigma(best);
    let (model, baseline) = (summit.model, summit.baseline);
    let unknowns =
        (model.shape.unknowns() as f32 - baseline.shape.unknowns() as f32) * channels.width as f32;
    let gained = model.score - baseline.score + 0.5 * ln(best.frames) * unknowns;
    let waves = 2.0 * model.shape.harmonics as f32 * channels.width as f32;
    let threshold = significant_search_gain(waves, statistics.frames);
    let is_too_short = !(2.0 * best.nu >= CYCLES_MIN)
        || 2.0 * (span.nu_max() - best.nu) < IMAGE_CYCLES
        || !(sigma_nu <= RELATIVE_SIGMA_MAX * best.nu);
    let status = match () {
        () if !(gained > threshold) => Status::NoTone,
        () if is_too_short => Status::TooShort,
        () => Status::Good,
    };
    if !status.has_tone() {
        statistics.without_tone(status, fit);
        return Ok(());
    }
    let (status, factor) = trust(around, evidence);
    if !status.has_tone() {
        statistics.without_tone(status, fit);
        return Ok(());
    }
    let sigma_nu = factor * sigma_nu;
    // Of a comb whose fundamental is not there the lines may as well be tones of their own.
    let is_seen = best.power[0] > FUNDAMENTAL_POWER * best.width as f32;
    // Beside a baseline that is curved and not described a tone may be a part of it, or its weaker
    // first harmonics.
    let is_part = best.shape.curves > 0
        && evidence.cycles < CURVED_CYCLES
        && (evidence.noise_ratio > CURVED_NOISE_RATIO && evidence.remainder > CURVED_REMAINDER
            || summit.strongest > 1);
    // What channels that are late leave in the blocks looks like a beat, too.
    let is_beat = !span.is_staggered()
        && around.colour > BEAT_DENSITY
        && around.colour > BEAT_OVER_BAND * around.band
        && evidence.remainder > STEADY_SHARE;
    let is_full = is_full(best, evidence.cycles);
    let is_ambiguous =
        !is_seen || is_part || is_beat || is_full || is_image_strong(best, span.nu_max());
    // A comb that moves or leaves more than noise, whose fundamental is weak, may be several tones.
    let is_comb = summit.strongest > 1 && evidence.cycles < COMB_CYCLES;
    let is_ambiguous = match status {
        Status::Good => is_ambiguous || is_comb && evidence.noise_ratio > COMB_NOISE_RATIO,
        _ => is_comb && status == Status::Unsteady,
    };
    let status = if is_ambiguous {
        Status::Ambiguous
    } else {
        status
    };
    let (path, turned) = (span.abscissa(), TURNED_CYCLES / evidence.cycles);
    let are_unlike = (path.turns(TURNED_SHARE) || path.turns_at_an_end(turned))
        && evidence.noise_ratio > TURNED_NOISE_RATIO;
    let status = if status == Status::Good && are_unlike {
        Status::Unsteady
    } else {
        status
    };
    let movement = movement(span, around, factor * factor, best.nu, sigma_nu);
    let (mut status, mut other_tone) = (status, None);
    if !summit.leaves_noise()
        && let Some(line) = strongest_other_line(span, statistics, channels, best, blocks)?
    {
        let times = line.cycles / evidence.cycles;
        let is_multiple_of = |share: f32| is_multiple(times, share, evidence.cycles);
        // Overtones fall as their number's square, or faster; stronger, the line is the tone and
        // the rest a part of it.
        let is_overtone = times > 1.5 && is_multiple_of(1.0) && line.share * times * times < 1.0;
        let is_strong = line.share > OTHER_LINE_SHARE && line.contrast > OTHER_LINE_CONTRAST;
        let is_clear = line.share > CLEAR_LINE_SHARE
            && line.contrast > CLEAR_LINE_CONTRAST
            && evidence.noise_ratio > CLEAR_LINE_NOISE_RATIO
            && evidence.cycles < CURVED_CYCLES;
        if (is_strong || is_clear) && !is_overtone {
            // A tone that moves has lines beside its own, but none as strong and as far away.
            let (nearest, most) = (libm::roundf(times), best.shape.harmonics as f32);
            let nearest = if nearest > most {
                most
            } else {
                nearest.max(1.0)
            };
            let is_apart = line.share > APART_SHARE
                && (times - nearest).abs() * evidence.cycles > APART_CYCLES;
            if status == Status::Good || status == Status::Unsteady && is_apart {
                status = Status::Ambiguous;
            }
            // A line between those of the tone says that its fundamental is lower.
            let is_tone = line.cycles > OTHER_TONE_CYCLES
                && !(is_multiple_of(0.5) || is_multiple_of(1.0 / 3.0));
            other_tone = is_tone.then(|| OtherTone {
                frequency: span.frequency(0.5 * line.cycles),
                share: line.share,
            });
        }
    }
    fit.status = status;
    (fit.frequency, fit.sigma) = (span.frequency(best.nu), span.frequency(sigma_nu));
    (fit.movement, fit.other_tone, fit.interferer) = (movement, other_tone, None);
    fit.harmonics = best.shape.harmonics as u8;
    (fit.frames, fit.usable) = (statistics.frames, statistics.usable);
    of_channels(best, statistics, channels, fit);
    Ok(())
}

/// The result of mixtures of channels that share no noise, in place of the channels' own: what
/// noise that is taken out has hidden says less than what is seen with it, so that a status is no
/// better for it.
#[inline(never)]
pub fn conclude_mixtures(
    fit: &mut Fit,
    span: &FrameSpan,
    best: &Solution,
    around: &Neighbourhood,
    evidence: &Evidence,
) {
    let (status, factor) = trust(
        around,
        &Evidence {
            contrast: contrast(best),
            ..*evidence
        },
    );
    if !status.has_tone() {
        return;
    }
    if fit.status == Status::Good {
        fit.status = status;
    }
    let sigma = span.frequency(factor * white_sigma(best));
    let apart = fit.movement.sigma_of_mean * fit.movement.sigma_of_mean - fit.sigma * fit.sigma;
    fit.movement.sigma_of_mean = libm::sqrtf(sigma * sigma + apart.max(0.0));
    (fit.frequency, fit.sigma) = (span.frequency(best.nu), sigma);
}

/// Whether a line at `times` the frequency of a tone of so many cycles is within half a cycle of a
/// multiple of this share of it.
// Not inlined: it is called three times.
#[inline(never)]
fn is_multiple(times: f32, share: f32, cycles: f32) -> bool {
    (times - share * libm::roundf(times / share)).abs() * cycles < MULTIPLE_CYCLES
}

/// Whether several harmonics and a curved baseline describe nearly everything that a window of
/// `cycles` cycles can hold.
fn is_full(best: &Solution, cycles: f32) -> bool {
    let harmonics = best.shape.harmonics as f32;
    // Two a cycle of the highest harmonic, and a level.
    let independent = 2.0 * harmonics * cycles + 1.0;
    let unknowns = (2 + 2 * best.shape.harmonics + best.shape.curves) as f32;
    best.shape.curves > 0 && best.shape.harmonics > 1 && unknowns > FULL_SHARE * independent
}

/// Whether a harmonic above half the frame rate falls less than as its number's square: another
/// tone may be where its image is.
fn is_image_strong(best: &Solution, nu_max: f32) -> bool {
    let (mut below, mut above) = (0.0f32, 0.0f32);
    for (h, power) in best.power.iter().enumerate().take(best.shape.harmonics) {
        let number = (h + 1) as f32;
        let most = if number * best.nu < nu_max {
            &mut below
        } else {
            &mut above
        };
        *most = most.max(number * number * power);
    }
    above > below
}

/// Standard deviation of a solution's `nu` in noise that is white.
fn white_sigma(best: &Solution) -> f32 {
    let (information, rounding) = (
        best.information * real_information_share(best),
        ROUNDING_SHARE * best.nu,
    );
    libm::sqrtf(1.0 / information + rounding * rounding)
}

/// What is known of the tone.
pub fn evidence(statistics: &Statistics, channels: &Channels, best: &Solution) -> Evidence {
    let count = channels.width as f32;
    // Of the fundamental's factors as vectors, one a channel: the lesser of their two moments over
    // the greater.
    let (cos, sin) = best.harmonic(0);
    let (mut xx, mut yy, mut xy) = (0.0, 0.0, 0.0);
    for ((x, y), weight) in cos.iter().zip(sin).zip(&best.weights).take(channels.width) {
        (xx, yy, xy) = (
            xx + weight * x * x,
            yy + weight * y * y,
            xy + weight * x * y,
        );
    }
    let apart = libm::sqrtf((xx - yy) * (xx - yy) + 4.0 * xy * xy);
    Evidence {
        spread: (xx + yy - apart) / (xx + yy + apart).max(f32::MIN_POSITIVE),
        is_curved: best.shape.curves > 0,
        cycles: 2.0 * best.nu,
        frames: best.frames,
        channels: count,
        contrast: contrast(best),
        remainder: best.remainder(),
        noise_ratio: best.noise_ratio(statistics, channels).0,
    }
}

/// Power of the strongest line in a channel over that of as wide a part of white noise.
fn contrast(best: &Solution) -> f32 {
    0.5 * best
        .power
        .iter()
        .fold(0.0f32, |most, power| most.max(*power))
        / best.width as f32
}

/// The channels' part of the result, and what they have in common of the overtones.
///
/// A channel's harmonic k has the phasor Z_k = cosine's factor - i sine's. A gain g and a delay
/// that turns the fundamental by d make it g exp(i k d) Z_k: so Z_k = r_k B_k with B_k = Z_1^k /
/// |Z_1|^(k - 1), |B_k| = |Z_1|, and the same r_k in all channels. By least squares over the
/// channels (S. M. Kay, "Fundamentals of Statistical Signal Processing: Estimation Theory" (1993),
/// section 4.3) r_k is the sum of Z_k conj(B_k) over that of |Z_1|^2. Channels are not weighted by
/// their noise: where they differ in more than gain and delay, the few with the least noise would
/// say it all.
fn of_channels(best: &Solution, statistics: &Statistics, channels: &Channels, fit: &mut Fit) {
    let (cos, sin) = best.harmonic(0);
    let [of_cos, of_sin, of_both] = best.fundamental;
    let freedom = (best.frames - best.shape.unknowns() as f32).max(1.0);
    // One channel's unit, so that squares stay within f32 in any.
    let one = channels
        .list()
        .first()
        .map_or(1.0, |c| statistics.scale[*c as usize % CHANNELS_MAX]);
    let mut squares = 0.0;
    fit.channels = [ChannelFit::default(); CHANNELS_MAX];
    fit.overtones = [[0.0; 2]; OVERTONES];
    for (k, c) in channels.list().iter().enumerate() {
        let c = *c as usize % CHANNELS_MAX;
        let power = cos[k] * cos[k] + sin[k] * sin[k];
        // Across the fundamental's phasor.
        let across =
            of_cos * sin[k] * sin[k] + of_sin * cos[k] * cos[k] - 2.0 * of_both * cos[k] * sin[k];
        let noise = best.residual_squares[k] / freedom;
        let (size, unit) = (libm::sqrtf(power), 1.0 / statistics.scale[c]);
        fit.channels[c] = ChannelFit {
            offset: statistics.offset[c] + best.unknowns[0][k] * unit,
            amplitude: size * unit,
            phase_rad: libm::atan2f(-sin[k], cos[k]),
            phase_variance: noise * (across / power) / power,
            residual: libm::sqrtf(noise) * unit,
        };
        if !(power > 0.0) {
            continue;
        }
        // Of the fundamental's phasor x - i y the conjugate is x + i y.
        let (x, y) = (cos[k] / size, sin[k] / size);
        let weight = (one * unit) * (one * unit);
        let (mut re, mut im) = (weight * cos[k], weight * sin[k]);
        squares += weight * power;
        for (h, overtone) in (1..best.shape.harmonics).zip(&mut fit.overtones) {
            (re, im) = (re * x - im * y, re * y + im * x);
            let (cos, sin) = best.harmonic(h);
            overtone[0] += cos[k] * re + sin[k] * im;
            overtone[1] += cos[k] * im - sin[k] * re;
        }
    }
    if squares > 0.0 {
        fit.overtones
            .as_flattened_mut()
            .iter_mut()
            .for_each(|part| *part /= squares);
    }
}

/// The share of a solution's information that is real. Its weights are estimates with few degrees
/// of freedom (their mean is too large by two, and their variance costs two more), and the noise in
/// a harmonic's two amplitudes counts as its power.
fn real_information_share(best: &Solution) -> f32 {
    let freedom = (best.frames - best.shape.unknowns() as f32).max(5.0);
    let mut real = best.information;
    for h in 0..best.shape.harmonics.min(HARMONICS_MAX) {
        if best.power[h] > 0.0 && best.line_information[h] > 0.0 {
            real -= best.line_information[h] * (2.0 * best.width as f32 / best.power[h]).min(1.0);
        }
    }
    (real / best.information).max(0.1) * (freedom - 4.0) / freedom
}
