//! A phase-locked loop that continues from a lean fit of one line, a frame at a time.
//!
//! All channels share the loop's phase; their levels, slopes, amplitudes and relative phases are
//! those of the fit. A frame's residuals, projected on the derivative by the phase and weighted,
//! give the phase error (maximum likelihood: S. M. Kay, "Fundamentals of Statistical Signal
//! Processing: Estimation Theory" (1993), 3.11), and a second-order loop follows it (F. M. Gardner,
//! "Phaselock Techniques" (2005), chapter 2).
//!
//! No parameter is free: for fits of `N` frames the gains of phase and frequency are `6 / N` and
//! `12 / N^2`, a natural frequency of `sqrt(12)` and a damping of `sqrt(3) / 2` over the window's
//! length. With these gains the loop's frequency is that of the fits:
//!
//! - White noise leaves phase and frequency with the covariances `4 / N`, `6 / N^2` and
//!   `12 / N^3`, as a line fitted to `N` phases does at its end. So the loop has no transient.
//! - With `x` for the Laplace variable times the window's length the response of the frequency,
//!   `1 / (1 + x / 2 + x^2 / 12)`, is a Padé approximant of `(1 - exp(-x)) / x`, the mean over the
//!   window, and differs from it by a term in `x^4` alone.

use super::solve::Solution;
use crate::fit::{Fit, Status};
use crate::frame_span::FrameSpan;
use crate::limits::CHANNELS_MAX;
use crate::phase::{cos_sin, from_turns};
use crate::significance::{Z_TEST, deviate, square_root};
use crate::source::{Overwritten, Values};
use core::f32::consts::TAU;

/// Variance of a channel's prediction at the window's end, relative to that of the noise, times
/// `N`: 4 from level and slope, and 2 from cosine and sine.
const PREDICTION: f32 = 6.0;
/// Unknowns of a channel: level, slope, cosine and sine.
const UNKNOWNS: f32 = 4.0;
/// Gain of the levels times `N`: with this gain they are as quiet as a mean over the window.
const LEVEL_GAIN: f32 = 2.0;
/// At most one frame in this many may be missing.
const GAP_FRAMES_MIN: f32 = 10.0;

/// Frequency of a loop after a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tracked {
    /// Mean frequency over a window as long as the fit's that ends there, cycles per frame.
    pub frequency: f32,
    /// Standard deviation of the frequency, cycles per frame.
    pub sigma: f32,
}

/// Memory of a loop; all zeros if there is none.
#[derive(Debug)]
pub struct Loop<'m> {
    rows: &'m mut [Values; ROWS],
}

/// Rows of a loop's memory: levels, slopes per frame, cosines, sines, weights, and [`State`].
pub const ROWS: usize = 6;

/// State common to all channels of a loop.
#[derive(Clone, Copy)]
struct State {
    /// Frames of the fit's window; zero without a loop.
    frames: f32,
    /// Mask of the channels, and their number (`width`).
    channels: u16,
    width: f32,
    /// Phase of the next frame, turns.
    phase: f32,
    /// Cycles per frame.
    frequency: f32,
    /// Standard deviation of the fit's frequency.
    sigma: f32,
    /// Information of a frame on the phase, averaged over a cycle, one over radians squared.
    information: f32,
    /// Frames since the fit, and the valid ones among them (`taken`).
    age: f32,
    taken: f32,
    /// Weighted sum of squared residuals since the fit.
    squares: f32,
}

impl State {
    fn from_row(row: &Values) -> Self {
        let [
            frames,
            channels,
            width,
            phase,
            frequency,
            sigma,
            information,
            age,
            taken,
            squares,
            ..,
        ] = *row;
        let channels = channels as u16;
        Self {
            frames,
            channels,
            width,
            phase,
            frequency,
            sigma,
            information,
            age,
            taken,
            squares,
        }
    }

    fn into_row(self) -> Values {
        let Self {
            frames,
            channels,
            width,
            phase,
            frequency,
            sigma,
            information,
            age,
            taken,
            squares,
        } = self;
        let channels = channels.into();
        let state = [
            frames,
            channels,
            width,
            phase,
            frequency,
            sigma,
            information,
            age,
            taken,
            squares,
        ];
        let mut row = [0.0; CHANNELS_MAX];
        row[..state.len()].copy_from_slice(&state);
        row
    }

    /// Advances by some frames.
    fn advance(&mut self, frames: f32) {
        let phase = self.phase + frames * self.frequency;
        // Wrap to half a turn to either side, so that the phase keeps its precision.
        self.phase = phase - (phase + 0.5f32.copysign(phase)) as i32 as f32;
        self.age += frames;
    }

    /// Sum of squared residuals, corrected for the prediction error after the window.
    fn squares_in_noise(&self) -> f32 {
        self.squares / (1.0 + PREDICTION / self.frames)
    }

    /// True unless the residuals since the fit are significantly larger than those of the fit (one
    /// false alarm in a thousand from noise alone).
    fn agrees(&self) -> bool {
        let (count, freedom) = (self.taken * self.width, self.frames - UNKNOWNS);
        let excess = self.squares_in_noise() - count;
        let variance = 2.0 * count * (1.0 + self.taken / freedom);
        // An F ratio has a heavier upper tail than a normal distribution, so what passes the second
        // test also passes the third.
        excess <= 0.0
            || excess * excess < Z_TEST * Z_TEST * variance
            || deviate(1.0 + excess / count, count, freedom * self.width) < Z_TEST
    }

    /// The frequency, if the loop is locked.
    fn tracked(&self) -> Option<Tracked> {
        let is_whole = (self.age - self.taken) * GAP_FRAMES_MIN < self.frames;
        let is_in_band = self.frequency > 0.0 && self.frequency < 0.5;
        if !(is_whole && is_in_band && self.agrees()) {
            return None;
        }
        // Mean square of the residuals in the fit's window and after it.
        let freedom = self.frames - UNKNOWNS;
        let residual = (freedom * self.width + self.squares_in_noise())
            / ((freedom + self.taken) * self.width);
        let (alpha, beta) = gains(self.frames);
        // Variance of the velocity of an alpha-beta filter (E. Brookner, "Tracking and Kalman
        // Filtering Made Easy" (1998), 1.2).
        let ratio = 2.0 * beta * beta / (alpha * (4.0 - 2.0 * alpha - beta));
        let sigma = square_root(ratio * residual / self.information) / TAU;
        // The levels' errors, with the variance 4 / N at the end of a fitted line, look like a sine
        // at the tone's frequency. The loop attenuates it to 12 / N^2 over that frequency, which
        // adds to the 12 / N^3 of white noise.
        let cycles = self.frames * self.frequency;
        let levels = 48.0 / (TAU * TAU * cycles * cycles);
        let sigma = sigma.max(self.sigma) * square_root(1.0 + levels);
        Some(Tracked {
            frequency: self.frequency,
            sigma,
        })
    }
}

/// Gains of the phase and of the frequency, for windows of some frames.
fn gains(frames: f32) -> (f32, f32) {
    (6.0 / frames, 12.0 / (frames * frames))
}

impl<'m> Loop<'m> {
    /// A loop in the supplied memory.
    pub fn new(rows: &'m mut [Values; ROWS]) -> Self {
        Self { rows }
    }

    pub fn end(&mut self) {
        self.rows[ROWS - 1] = [0.0; CHANNELS_MAX];
    }

    /// Starts at the end of a window with a good fit of one line; otherwise ends the loop.
    pub fn start(&mut self, span: &FrameSpan, solution: &Solution, fit: &Fit) {
        self.end();
        if fit.status != Status::Good || solution.orders() != [1] {
            return;
        }
        let frames = span.frames as f32;
        let per_frame = 1.0 / (frames * span.frequency(1.0));
        let [_, slope, cosines, sines, ..] = &solution.coefficients;
        let [levels, slopes, first, second, weights, state] = &mut *self.rows;
        // `u` of the next frame; the window spans -1 to 1.
        let next = 1.0 + 1.0 / frames;
        let mut information = 0.0;
        for c in 0..CHANNELS_MAX {
            let is_used = fit.usable >> c & 1 == 1;
            weights[c] = if is_used { solution.weights[c] } else { 0.0 };
            levels[c] = fit.channels[c].offset + next * slope[c];
            slopes[c] = 2.0 / frames * slope[c];
            (first[c], second[c]) = (cosines[c], sines[c]);
            let square = cosines[c] * cosines[c] + sines[c] * sines[c];
            information += 0.5 * weights[c] * square;
        }
        let frequency = fit.frequency * per_frame;
        let mut start = State {
            frames,
            channels: fit.usable,
            width: fit.usable.count_ones() as f32,
            phase: 0.0,
            frequency,
            sigma: fit.sigma * per_frame,
            information,
            age: 0.0,
            taken: 0.0,
            squares: 0.0,
        };
        start.advance(0.5 * (frames + 1.0));
        start.age = 0.0;
        *state = start.into_row();
    }

    /// Follows the line through the frames of a span, which must begin at the loop's next frame.
    /// `None` if there is no loop, or if the loop has lost the line and ends.
    pub fn follow(&mut self, span: &mut FrameSpan) -> Result<Option<Tracked>, Overwritten> {
        let mut state = State::from_row(&self.rows[ROWS - 1]);
        if state.frames <= 0.0 {
            return Ok(None);
        }
        let mut next = 0;
        let visited = span.visit(state.channels, &mut |number, values| {
            state.advance((number - next) as f32);
            self.take(&mut state, values);
            next = number + 1;
        });
        state.advance((span.frames - next) as f32);
        self.end();
        visited?;
        let tracked = state.tracked();
        if tracked.is_some() {
            self.rows[ROWS - 1] = state.into_row();
        }
        Ok(tracked)
    }

    /// Processes the next frame.
    #[inline(always)]
    fn take(&mut self, state: &mut State, values: &Values) {
        let (cos, sin) = cos_sin(from_turns(state.phase));
        let [levels, slopes, cosines, sines, weights, _] = &mut *self.rows;
        let of_level = LEVEL_GAIN / state.frames;
        let (mut score, mut squares) = (0.0, 0.0);
        for c in 0..CHANNELS_MAX {
            let residual = values[c] - levels[c] - (cosines[c] * cos + sines[c] * sin);
            let weighted = weights[c] * residual;
            score += weighted * (sines[c] * cos - cosines[c] * sin);
            squares += weighted * residual;
            levels[c] += slopes[c] + of_level * residual;
        }
        let (alpha, beta) = gains(state.frames);
        let error = score / (TAU * state.information);
        state.frequency += beta * error;
        state.phase += alpha * error;
        state.advance(1.0);
        state.squares += squares;
        state.taken += 1.0;
    }
}
