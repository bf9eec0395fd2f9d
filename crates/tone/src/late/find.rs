//! Corrections for multiplexing delay, from a solution.

use super::{Delays, Late, Response};
use crate::domain::Domain;
use crate::limits::{CHANNELS_MAX, HARMONICS_MAX};
use crate::solve::Solution;
use crate::trajectory::Trajectory;
use crate::window_frames::WindowFrames;
use crate::workspace::Workspace;
use core::hint::black_box;

impl Late {
    /// Takes the waves from a solution. Returns `None` unless the fit is along a path of several
    /// frames.
    fn new(
        window: &WindowFrames,
        solution: &Solution,
        trajectory: &Trajectory,
        delays: &Delays,
    ) -> Option<Self> {
        let last = window.count().checked_sub(1)?;
        if matches!(window.domain, Domain::Time { .. }) || last == 0 {
            return None;
        }
        let mut frames = [0.0; CHANNELS_MAX];
        let order = window.statistics.order.iter().take(window.width());
        for (frames, channel) in frames.iter_mut().zip(order) {
            *frames = delays.frames[usize::from(*channel) % CHANNELS_MAX];
        }
        let mut waves = [[0.0; CHANNELS_MAX]; 2 * HARMONICS_MAX];
        let pairs = waves.iter_mut().zip(solution.lines());
        pairs.for_each(|(wave, line)| *wave = *line);
        let mut late = Self {
            frames,
            step: (window.domain.u(last) - window.domain.u(0)) / last as f32,
            last,
            low_pass: delays.low_pass,
            mean: [Response::default(); HARMONICS_MAX + 1],
            trajectory: *trajectory,
            lines: solution.shape.lines,
            waves,
            // `black_box`: otherwise the compiler would call, and so link, the only such function.
            subtract: black_box(Self::take_change),
        };
        late.mean = late.mean_response(&window.domain);
        Some(late)
    }

    /// Computes the effect of the delays from the latest solution; later visits subtract it.
    /// Returns false, and corrects nothing, if the effect is below the noise.
    #[inline(never)]
    pub fn take_out(
        window: &mut WindowFrames,
        workspace: &Workspace,
        trajectory: &Trajectory,
        delays: &Delays,
    ) -> bool {
        window.late = None;
        let Some(late) = Self::new(window, &workspace.solution, trajectory, delays) else {
            return false;
        };
        let (domain, mut squares) = (window.domain, 0.0);
        window.visit(|frame| {
            let change = late.change(&domain, frame);
            for (k, change) in change.iter().enumerate() {
                squares += workspace.weights[k][k] * change * change;
            }
        });
        window.late = (squares > 1.0).then_some(late);
        window.late.is_some()
    }
}
