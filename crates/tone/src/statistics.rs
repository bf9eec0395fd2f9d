//! The first pass: level, slope, power and noise of every channel, which of them can be used, and
//! the window in pieces, means of a few frames each.

use crate::fit::{Fit, Status};
use crate::frame_span::{BLOCK, Block, FrameSpan};
use crate::limits::{CHANNELS_MAX, CHANNELS_SEARCHED, PIECES_MAX};
use crate::source::{Overwritten, Values};

/// A channel without a valid value in more than this share of the frames is left out. Of the others
/// every frame must have one: all channels share one abscissa.
const INVALID_SHARE_MAX: f32 = 0.1;
/// A longer window is surveyed for its order of magnitude in blocks that are as many times farther
/// apart.
const SURVEY_FRAMES: u32 = 256;
/// Power about a channel's line, as a share of all, below which it is rounding.
const ROUNDING_SHARE: f32 = 1e-6;
/// Frames of a third difference, and the sum of its squared factors: 1 + 9 + 9 + 1.
const QUAD: usize = 4;
const THIRD_DIFFERENCE_SQUARES: f32 = 20.0;
/// From a channel's first value in a block to its last, both included.
const COLUMN: usize = (BLOCK - 1) * CHANNELS_MAX + 1;
/// A third difference of six times their mean magnitude is seldom noise: in white noise of 940
/// frames and sixteen channels in one window of a hundred.
const SPIKY: f32 = 6.0;

/// Level, slope, power and noise of every channel.
#[derive(Clone, Debug)]
pub struct Statistics {
    /// Frames that count.
    pub frames: u32,
    /// Channels that can be used: nearly all frames have a valid value of them, and they are
    /// neither constant nor a ramp.
    pub usable: u16,
    /// A straight line through each channel: its value at the centre, and its slope per unit of
    /// `u`.
    pub offset: Values,
    pub slope: Values,
    /// Sum of squares about that line, in units of `scale`.
    pub about_line: Values,
    /// A power of two by which values are multiplied, so that their squares can neither overflow
    /// nor vanish.
    pub scale: Values,
    /// Variance of a frame's noise by the third differences of consecutive frames, in units of
    /// `scale`: a tone below a tenth of the frame rate adds very little. 0 if it is not known.
    pub noise_variance: Values,
    /// The usable channels, those with the least share of noise first.
    pub order: Channels,
    /// Number of pieces, and from one to the next in `u`.
    pub pieces: usize,
    pub piece_step: f32,
    /// Step of quantization in the frames' unit; 0: none.
    pub quantization_step: f32,
    /// Whether a third difference is far above the others: there may be impulses.
    pub is_spiky: bool,
}

/// Channels as a pass uses them: their numbers, and how many.
#[derive(Clone, Copy, Debug)]
pub struct Channels {
    pub order: [u8; CHANNELS_MAX],
    pub width: usize,
}

impl Channels {
    /// The first of them, as many as `most`.
    pub fn first(self, most: usize) -> Self {
        Self {
            width: self.width.min(most),
            ..self
        }
    }

    pub fn list(&self) -> &[u8] {
        self.order.get(..self.width).unwrap_or_default()
    }
}

/// What the pass adds up, in units of `scale` and relative to the first frame that counts.
struct Sums<'p> {
    zero: Values,
    scale: Values,
    frames: u32,
    quads: u32,
    y: Values,
    squares: Values,
    third_squares: Values,
    /// Sum and most of the magnitudes of the third differences.
    third: Values,
    third_most: Values,
    pieces: &'p mut [Values],
    counts: [u16; PIECES_MAX],
    piece_frames: usize,
    in_time: bool,
    u: f32,
    uu: f32,
}

impl Statistics {
    /// Collects them. Fills `pieces`, at least [`PIECES_MAX`], with the means less the line; only
    /// of the channels with the least noise, which the grid takes.
    pub fn collect(span: &mut FrameSpan, pieces: &mut [Values]) -> Result<Self, Overwritten> {
        let survey = survey(span)?;
        span.channels = survey.reliable;
        let mut piece_frames = 1;
        while span.frames as usize > PIECES_MAX * piece_frames {
            piece_frames *= 2;
        }
        let count = match span.is_in_time() {
            true => span.frames as usize / piece_frames.max(1),
            false => (span.frames as usize).min(PIECES_MAX) / 2,
        };
        let pieces = pieces.get_mut(..count).unwrap_or_default();
        pieces.fill([0.0; CHANNELS_MAX]);
        let zeros = [0.0; CHANNELS_MAX];
        let mut sums = Sums {
            zero: survey.first,
            scale: survey.scale,
            frames: 0,
            quads: 0,
            y: zeros,
            squares: zeros,
            third_squares: zeros,
            third: zeros,
            third_most: zeros,
            pieces,
            counts: [0; PIECES_MAX],
            piece_frames,
            in_time: span.is_in_time(),
            u: 0.0,
            uu: 0.0,
        };
        let (abscissa, frames) = (span.abscissa(), span.frames);
        span.blocks(&survey.first, &mut |block| {
            let u = abscissa.block(block.first, frames);
            sums.add(&block, &u);
        })?;
        let step = match abscissa.step() {
            Some(step) => step * piece_frames as f32,
            None => 2.0 / count.max(1) as f32,
        };
        let first = abscissa.step().map_or(-1.0 + 0.5 * step, |one| {
            -1.0 + 0.5 * one * piece_frames as f32
        });
        Ok(sums.end(span, first, step))
    }

    /// The usable channels, those with the least share of noise first.
    #[inline(never)]
    fn by_noise(&self) -> Channels {
        let shares: Values = core::array::from_fn(|c| self.noise_variance[c] / self.about_line[c]);
        let (mut order, mut count) = ([0; CHANNELS_MAX], 0);
        for c in (0..CHANNELS_MAX as u8).filter(|c| self.usable & 1 << c != 0) {
            let share = |c: u8| shares[c as usize % CHANNELS_MAX];
            let (mut moving, mut is_found) = (c, false);
            for place in order.iter_mut().take(count) {
                is_found |= share(*place) > share(c);
                if is_found {
                    core::mem::swap(place, &mut moving);
                }
            }
            order[count % CHANNELS_MAX] = moving;
            count += 1;
        }
        Channels {
            order,
            width: count,
        }
    }

    /// Of a window without a tone: offsets and residuals about a straight line.
    pub fn without_tone(&self, status: Status, fit: &mut Fit) {
        *fit = Fit::at_rest(self.frames);
        (fit.status, fit.usable) = (status, self.usable);
        for c in (0..CHANNELS_MAX).filter(|c| self.usable & 1 << c != 0) {
            let c = c % CHANNELS_MAX;
            let channel = &mut fit.channels[c];
            channel.offset = self.offset[c];
            channel.residual =
                libm::sqrtf(self.about_line[c] / (self.frames as f32 - 2.0)) / self.scale[c];
        }
    }
}

/// What is known before the pass.
struct Survey {
    reliable: u16,
    first: Values,
    scale: Values,
}

/// Which channels have valid values in nearly all frames that have any; values of the first frame
/// that counts; and how large the channels' changes are.
// Not inlined: what it takes of the stack is given back.
#[inline(never)]
fn survey(span: &mut FrameSpan) -> Result<Survey, Overwritten> {
    let (mut frames, mut invalid) = (0u32, [0u32; CHANNELS_MAX]);
    let (mut least, mut most) = (
        [f32::INFINITY; CHANNELS_MAX],
        [f32::NEG_INFINITY; CHANNELS_MAX],
    );
    let stride = (span.frames / SURVEY_FRAMES).max(1);
    span.channels = 0;
    span.blocks(&[0.0; CHANNELS_MAX], &mut |block| {
        // One frame of every block, or of some in a long window, is enough for the order of
        // magnitude.
        let is_seen = (block.first / BLOCK as u32).is_multiple_of(stride);
        if is_seen
            && let Some((values, valid)) = block
                .values
                .iter()
                .zip(block.valid)
                .find(|(_, valid)| **valid != 0)
        {
            for (c, ((value, least), most)) in
                values.iter().zip(&mut least).zip(&mut most).enumerate()
            {
                if valid & 1 << c != 0 {
                    // Not `f32::min`, which is a call.
                    *least = if value < least { *value } else { *least };
                    *most = if value > most { *value } else { *most };
                }
            }
        }
        if block.complete && block.valid.iter().all(|valid| *valid == u16::MAX) {
            frames += BLOCK as u32;
            return;
        }
        for valid in block.valid.iter().filter(|valid| **valid != 0) {
            frames += 1;
            for (c, invalid) in invalid.iter_mut().enumerate() {
                *invalid += (valid & 1 << c == 0) as u32;
            }
        }
    })?;
    let (mut reliable, mut scale) = (0, [1.0; CHANNELS_MAX]);
    for c in 0..CHANNELS_MAX {
        reliable |= ((invalid[c] as f32 <= INVALID_SHARE_MAX * frames as f32) as u16) << c;
        let range = most[c] - least[c];
        if range > 0.0 && range.is_finite() {
            // The exponent alone: a product with a power of two is exact.
            let exponent = (range.to_bits() >> 23).clamp(1, 253);
            scale[c] = f32::from_bits((254 - exponent) << 23);
        }
    }
    span.channels = reliable;
    let first = span.first_counted()?.unwrap_or_default();
    Ok(Survey {
        reliable,
        first,
        scale,
    })
}

impl Sums<'_> {
    #[inline(never)]
    fn add(&mut self, block: &Block, u: &[f32; BLOCK]) {
        let in_time = self.in_time;
        let quads = block.valid.as_chunks::<QUAD>().0;
        let full: [f32; BLOCK / QUAD] = core::array::from_fn(|q| {
            quads.get(q).is_some_and(|quad| !quad.contains(&0)) as u8 as f32
        });
        self.quads += full.iter().sum::<f32>() as u32;
        if block.complete && in_time {
            self.frames += BLOCK as u32;
            let middle = 0.5 * (u[0] + u[BLOCK - 1]);
            let step = u[1] - u[0];
            self.u += BLOCK as f32 * middle;
            self.uu += BLOCK as f32
                * (middle * middle + step * step * ((BLOCK * BLOCK - 1) as f32 / 12.0));
            let within = self.piece_frames.clamp(1, BLOCK);
            let first = block.first as usize / self.piece_frames.max(1);
            let counts = self.counts.get_mut(first..).unwrap_or_default();
            counts
                .iter_mut()
                .take(BLOCK / within)
                .for_each(|count| *count += within as u16);
            return self.add_values(block, &full);
        }
        for (i, ((u, values), valid)) in u.iter().zip(block.values).zip(block.valid).enumerate() {
            if *valid == 0 {
                continue;
            }
            self.frames += 1;
            self.u += u;
            self.uu += u * u;
            let place = match in_time {
                true => (block.first as usize + i) / self.piece_frames.max(1),
                false => ((0.5 * (u + 1.0) * self.pieces.len() as f32) as usize)
                    .min(self.pieces.len().saturating_sub(1)),
            };
            if let Some(count) = self.counts.get_mut(place) {
                *count += 1;
            }
            if let (Some(piece), false) = (self.pieces.get_mut(place), in_time) {
                for c in 0..CHANNELS_MAX {
                    piece[c] += (values[c] - self.zero[c]) * self.scale[c];
                }
            }
        }
        self.add_values(block, &full);
    }

    /// Adds a block's values. A frame that does not count has those of the first one: they add
    /// nothing. Third differences count where a quad is full, and pieces are taken in time alone.
    fn add_values(&mut self, block: &Block, full: &[f32; BLOCK / QUAD]) {
        let first = block.first as usize / self.piece_frames.max(1);
        let pieces = if self.in_time {
            self.pieces.get_mut(first..).unwrap_or_default()
        } else {
            &mut []
        };
        let within = self.piece_frames.clamp(1, BLOCK);
        for c in 0..CHANNELS_MAX {
            let (zero, scale) = (self.zero[c], self.scale[c]);
            let (mut sum, mut squares, mut third_squares) = (0.0, 0.0, 0.0);
            let (mut thirds, mut most) = (0.0, self.third_most[c]);
            let mut quads = [0.0; BLOCK / QUAD];
            // The channel's values from one address on: each frame's has a constant distance from
            // it.
            let values = block
                .values
                .as_flattened()
                .get(c..)
                .and_then(|values| values.first_chunk::<COLUMN>());
            let Some(values) = values else { continue };
            for (q, (quad, full)) in quads.iter_mut().zip(full).enumerate() {
                let [a, b, c, d] = [0, 1, 2, 3]
                    .map(|i: usize| (values[(QUAD * q + i) % BLOCK * CHANNELS_MAX] - zero) * scale);
                *quad = (a + b) + (c + d);
                sum += *quad;
                squares = squares + a * a + b * b + c * c + d * d;
                let third = full * ((d - a) - 3.0 * (c - b));
                third_squares += third * third;
                let third = third.abs();
                thirds += third;
                most = if third > most { third } else { most };
            }
            self.y[c] += sum;
            self.squares[c] += squares;
            self.third_squares[c] += third_squares;
            self.third[c] += thirds;
            self.third_most[c] = most;
            match within {
                QUAD => pieces
                    .iter_mut()
                    .zip(quads)
                    .for_each(|(piece, quad)| piece[c] = quad),
                BLOCK => pieces.iter_mut().take(1).for_each(|piece| piece[c] += sum),
                _ => {
                    for (piece, frames) in pieces
                        .iter_mut()
                        .zip(block.values.chunks_exact(within.max(1)))
                    {
                        piece[c] = frames.iter().map(|frame| (frame[c] - zero) * scale).sum();
                    }
                }
            }
        }
    }

    /// The line of each channel from its pieces, and the pieces less their lines.
    #[inline(never)]
    fn end(&mut self, span: &FrameSpan, first: f32, step: f32) -> Statistics {
        let zeros = [0.0; CHANNELS_MAX];
        let mut out = Statistics {
            frames: self.frames,
            usable: 0,
            offset: zeros,
            slope: zeros,
            about_line: zeros,
            scale: self.scale,
            noise_variance: zeros,
            order: Channels {
                order: [0; CHANNELS_MAX],
                width: 0,
            },
            pieces: self.pieces.len(),
            piece_step: step,
            quantization_step: span.quantization_step,
            is_spiky: false,
        };
        let count = self.frames as f32;
        if self.frames < QUAD as u32 {
            return out;
        }
        let (mut weight, mut along, mut spread, mut uy) = (0.0, 0.0, 0.0, zeros);
        for (p, (piece, frames)) in self.pieces.iter().zip(self.counts).enumerate() {
            let (u, frames) = (first + step * p as f32, frames as f32);
            weight += frames;
            along += frames * u;
            spread += frames * u * u;
            uy.iter_mut()
                .zip(piece.iter())
                .for_each(|(uy, sum)| *uy += u * sum);
        }
        let spread = spread - along * along / weight;
        let all_spread = self.uu - self.u * self.u / count;
        for c in (0..CHANNELS_MAX).filter(|c| span.channels & 1 << c != 0) {
            let c = c % CHANNELS_MAX;
            let slope = (uy[c] - along * self.y[c] / weight) / spread;
            let mean = self.y[c] / count;
            let about = self.squares[c] - self.y[c] * mean - slope * slope * all_spread;
            // Below this the sum is rounding: the channel is constant, or a ramp. A NaN is not
            // above it.
            if !(about > ROUNDING_SHARE * self.squares[c] && about > 0.0 && about.is_finite()) {
                continue;
            }
            out.usable |= 1 << c;
            let middle = mean - slope * self.u / count;
            out.offset[c] = self.zero[c] + middle / self.scale[c];
            out.slope[c] = slope / self.scale[c];
            out.about_line[c] = about;
            out.is_spiky |= self.third_most[c] * self.quads as f32 > SPIKY * self.third[c];
            out.noise_variance[c] =
                self.third_squares[c] / (THIRD_DIFFERENCE_SQUARES * self.quads.max(1) as f32);
        }
        let levels: Values =
            core::array::from_fn(|c| (out.offset[c] - self.zero[c]) * self.scale[c]);
        let slopes: Values = core::array::from_fn(|c| out.slope[c] * self.scale[c]);
        out.order = out.by_noise();
        // Of the few channels that a grid takes.
        let few = out.order.first(CHANNELS_SEARCHED);
        let mut before = zeros;
        for (p, (piece, frames)) in self.pieces.iter_mut().zip(self.counts).enumerate() {
            let u = first + step * p as f32;
            if frames == 0 {
                // Not seen: as the one before it.
                *piece = before;
                continue;
            }
            let share = 1.0 / frames as f32;
            for c in few.list().iter().map(|c| *c as usize % CHANNELS_MAX) {
                piece[c] = piece[c] * share - (levels[c] + slopes[c] * u);
            }
            before = *piece;
        }
        out
    }
}
