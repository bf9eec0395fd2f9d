//! Corrections for multiplexing delay, from a solution.

use super::{Delays, Late, Response};
use crate::data::Data;
use crate::domain::Domain;
use crate::limits::{CHANNELS_MAX, HARMONICS_MAX};
use crate::solve::Solution;
use crate::trajectory::Trajectory;
use crate::work::Work;
use core::hint::black_box;

impl Late {
    /// The waves of a solution, where channels are late along a path.
    fn new(
        data: &Data,
        solution: &Solution,
        trajectory: &Trajectory,
        delays: &Delays,
    ) -> Option<Self> {
        let last = data.count().checked_sub(1)?;
        if matches!(data.domain, Domain::Time { .. }) || last == 0 {
            return None;
        }
        let mut frames = [0.0; CHANNELS_MAX];
        let order = data.statistics.order.iter().take(data.width());
        for (frames, channel) in frames.iter_mut().zip(order) {
            *frames = delays.frames[usize::from(*channel) % CHANNELS_MAX];
        }
        let mut waves = [[0.0; CHANNELS_MAX]; 2 * HARMONICS_MAX];
        let pairs = waves.iter_mut().zip(solution.lines());
        pairs.for_each(|(wave, line)| *wave = *line);
        let mut late = Self {
            frames,
            step: (data.domain.u(last) - data.domain.u(0)) / last as f32,
            last,
            low_pass: delays.low_pass,
            mean: [Response::default(); HARMONICS_MAX + 1],
            trajectory: *trajectory,
            lines: solution.shape.lines,
            waves,
            // Opaque: the compiler would else call the only such function directly.
            subtract: black_box(Self::take_change),
        };
        late.mean = late.mean_response(&data.domain);
        Some(late)
    }

    /// Finds what lateness changes, by the latest solution. From then on each visit takes it out of
    /// the frames; false if it is less than the noise, and stays.
    #[inline(never)]
    pub fn take_out(
        data: &mut Data,
        work: &Work,
        trajectory: &Trajectory,
        delays: &Delays,
    ) -> bool {
        data.late = None;
        let Some(late) = Self::new(data, &work.solution, trajectory, delays) else {
            return false;
        };
        let (domain, mut squares) = (data.domain, 0.0);
        data.visit(|frame| {
            let change = late.change(&domain, frame);
            for (k, change) in change.iter().enumerate() {
                squares += work.weights[k][k] * change * change;
            }
        });
        data.late = (squares > 1.0).then_some(late);
        data.late.is_some()
    }
}
