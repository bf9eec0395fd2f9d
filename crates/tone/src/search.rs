//! Finds candidates for the frequency of a window's tone. From three cycles on they are lines of a
//! periodogram ([`lines`]); below four cycles they are maxima of a likelihood on a grid of
//! frequencies ([`slow`]).

use crate::blocks::Blocks;
use crate::frame_span::FrameSpan;
use crate::grid::{Grid, Point};
use crate::limits::CANDIDATES_MAX;
use crate::solve::Solution;
use crate::source::Overwritten;
use crate::spectrum::Periodogram;
use crate::statistics::{Channels, Statistics};
use crate::waves::Waves;
use heapless::Vec;

/// The periodogram is searched from this number of cycles on.
const PERIODOGRAM_CYCLES: f32 = 3.0;
/// A candidate of the periodogram with fewer cycles than this is refined only if the grid is
/// searched too, which then has a point there.
const GRID_CYCLES: f32 = 3.4;
/// Most candidates from the grid.
const OF_GRID: usize = 4;
/// A candidate of the grid is kept if its gain over a baseline is at least this share of the
/// greatest gain,
const GAIN_SHARE_MIN: f32 = 0.85;
/// or at most this much less than the greatest gain, in units of the score.
const SURE_GAIN: f32 = 25.0;
/// A line closer than this to half the frame rate, in cycles, may be at half the frame rate.
const NYQUIST_CYCLES: f32 = 2.0;
/// The strongest line may be a harmonic of up to this order; 1 is the fundamental.
const ORDERS: usize = 3;

/// Frequencies, cycles per half window. Those of one function are sorted, the likeliest first.
pub type Candidates = Vec<f32, CANDIDATES_MAX>;

/// The strongest line within `reach` of an interferer's frequency, both in cycles per half window.
#[inline(never)]
pub fn interferer(
    span: &mut FrameSpan,
    statistics: &Statistics,
    channels: &Channels,
    (nu, reach): (f32, f32),
    blocks: &mut Blocks,
) -> Result<f32, Overwritten> {
    let (power, points) = blocks.transform_memory();
    let periodogram = Periodogram::new(span, statistics, channels.list(), None, points, power)?;
    let from = (2.0 * (nu - reach)).max(1.0) * periodogram.bins_per_cycle;
    let to = 2.0 * (nu + reach) * periodogram.bins_per_cycle;
    periodogram
        .power
        .iter_mut()
        .take(from as usize)
        .for_each(|power| *power = 0.0);
    periodogram
        .power
        .iter_mut()
        .skip(to as usize + 2)
        .for_each(|power| *power = 0.0);
    let peak = periodogram
        .strongest(1.0)
        .map_or(nu, |peak| 0.5 * peak.cycles);
    Ok(peak.min(nu + reach).max(nu - reach))
}

/// Candidates of the periodogram, less an interferer as `equations` have it: the strongest line,
/// and the fundamentals of which it may be a harmonic.
#[inline(never)]
pub fn lines(
    span: &mut FrameSpan,
    statistics: &Statistics,
    channels: &Channels,
    harmonics: usize,
    interferer: Option<(f32, &Solution)>,
    blocks: &mut Blocks,
) -> Result<Candidates, Overwritten> {
    let mut candidates = Candidates::new();
    let (power, points) = blocks.transform_memory();
    let list = Periodogram::channels(span, channels);
    let mut waves =
        interferer.map(|(nu, solution)| Waves::new(span, statistics, solution, (nu, None)));
    let mut periodogram = Periodogram::new(span, statistics, list, waves.as_mut(), points, power)?;
    if let Some((nu, _)) = interferer {
        periodogram.blank(2.0 * nu);
    }
    let Some(peak) = periodogram.strongest(PERIODOGRAM_CYCLES) else {
        return Ok(candidates);
    };
    let cycles = (1..=harmonics.min(ORDERS)).map(|order| peak.cycles / order as f32);
    for cycles in cycles {
        let _ = candidates.push(0.5 * cycles);
    }
    // The periodogram has no bin at half the frame rate. A line there shows in the bin beside it.
    if 2.0 * span.nu_max() - peak.cycles < NYQUIST_CYCLES {
        let _ = candidates.push(span.nu_max());
    }
    Ok(candidates)
}

/// Whether a candidate of the periodogram is one of the grid.
pub fn is_slow(nu: f32) -> bool {
    2.0 * nu < GRID_CYCLES
}

/// Candidates below four cycles a window, from the window's pieces, which are in `blocks`. The grid
/// also gets a point at each candidate of the periodogram (`lines`): without it the grid would miss
/// a tone of many harmonics.
// Not inlined: the grid leaves the stack.
#[inline(never)]
pub fn slow(
    statistics: &Statistics,
    channels: &Channels,
    (harmonics, interferer, is_in_time): (usize, Option<f32>, bool),
    blocks: &mut Blocks,
    lines: &Candidates,
) -> Candidates {
    let (pieces, folded) = blocks.grid_memory(statistics.pieces);
    let mut grid = Grid::empty(folded);
    grid.fill(
        pieces,
        statistics,
        channels,
        (harmonics, interferer),
        is_in_time,
    );
    let points = grid.points(lines.iter().copied().filter(|nu| is_slow(*nu)));
    let mut found: Vec<Point, OF_GRID> = Vec::new();
    for i in 0..points.len() {
        let point = |i: usize| points.get(i).copied().unwrap_or_default();
        let (before, this, after) = (point(i.wrapping_sub(1)), point(i), point(i + 1));
        if !(this.score > before.score && this.score >= after.score && this.score > grid.baseline) {
            continue;
        }
        let mut next = grid.refine([before, this, after]);
        for other in &mut found {
            if other.score < next.score {
                core::mem::swap(other, &mut next);
            }
        }
        let _ = found.push(next);
    }
    let gained = |point: &Point| point.score - grid.baseline;
    let most = found.first().map_or(0.0, gained);
    let least = (GAIN_SHARE_MIN * most).min(most - SURE_GAIN);
    let mut candidates = Candidates::new();
    for point in found.iter().filter(|point| gained(point) >= least) {
        let _ = candidates.push(point.nu);
    }
    candidates
}
