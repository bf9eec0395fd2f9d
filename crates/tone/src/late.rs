//! Channels that are read one after the other: along a path each is at a position of its own. At the
//! mean speed that is a phase, and stays in it; what it is beside the mean is subtracted from the
//! frames, by the waves that were fitted.

use crate::data::{Data, Frame};
use crate::domain::Domain;
use crate::limits::{CHANNELS_MAX, HARMONICS_MAX};
use crate::lines::Lines;
use crate::phase::first_powers;
use crate::phase_course::Course;
use crate::solve::Solution;
use crate::source::Values;
use crate::work::Work;
use core::f32::consts::PI;

/// The waves of a tone in channels that are read late.
#[derive(Clone, Debug)]
pub struct Late {
    /// Frames by which each channel is late, by place in the order of the channels.
    frames: Values,
    /// From one frame to the next, in the mean.
    step: f32,
    /// Number of the last frame.
    last: u32,
    course: Course,
    lines: Lines,
    /// Cosine and sine of each line.
    waves: [Values; 2 * HARMONICS_MAX],
}

impl Late {
    /// The waves of a solution, where channels are late along a path.
    fn new(data: &Data, solution: &Solution, course: &Course) -> Option<Self> {
        let (late, last) = (data.span.late?, data.count().checked_sub(1)?);
        if matches!(data.domain, Domain::Time { .. }) || last == 0 {
            return None;
        }
        let mut frames = [0.0; CHANNELS_MAX];
        let order = data.statistics.order.iter().take(data.width());
        for (frames, channel) in frames.iter_mut().zip(order) {
            *frames = late[usize::from(*channel) % CHANNELS_MAX];
        }
        let mut waves = [[0.0; CHANNELS_MAX]; 2 * HARMONICS_MAX];
        let pairs = waves.iter_mut().zip(solution.lines());
        pairs.for_each(|(wave, line)| *wave = *line);
        Some(Self {
            frames,
            step: (data.domain.u(last) - data.domain.u(0)) / last as f32,
            last,
            course: *course,
            lines: solution.shape.lines,
            waves,
        })
    }

    /// Finds what lateness changes, by the latest solution. From then on each visit takes it out of
    /// the frames; false if it is less than the noise, and stays.
    #[inline(never)]
    pub fn take_out(data: &mut Data, work: &Work, course: &Course) -> bool {
        data.late = None;
        let Some(late) = Self::new(data, &work.solution, course) else {
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

    /// Takes the change out of a frame. It is not inlined, so that all passes share one copy.
    #[inline(never)]
    pub fn subtract(&self, domain: &Domain, frame: &mut Frame) {
        let change = self.change(domain, frame);
        let pairs = frame.values.iter_mut().zip(&change);
        pairs.for_each(|(value, change)| *value -= change);
    }

    /// How much each channel of a frame differs from one that is read at the frame's position, to second
    /// order of the angle.
    fn change(&self, domain: &Domain, frame: &Frame) -> Values {
        let (before, after) = (
            frame.number.saturating_sub(1),
            (frame.number + 1).min(self.last),
        );
        let step = (domain.u(after) - domain.u(before)) / (after - before).max(1) as f32;
        let turn = PI * self.course.cycles * (step - self.step);
        let powers: [_; HARMONICS_MAX + 1] =
            first_powers(self.course.at(frame.u, 1.0), self.lines.most());
        let mut change = [0.0; CHANNELS_MAX];
        let pairs = self.waves.as_chunks::<2>().0.iter();
        for ([of_cos, of_sin], line) in pairs.zip(self.lines.iter()) {
            let [cos, sin] = powers[line.min(HARMONICS_MAX)];
            for k in 0..CHANNELS_MAX {
                let angle = turn * line as f32 * self.frames[k];
                let (wave, quarter) = (
                    of_cos[k] * cos + of_sin[k] * sin,
                    of_sin[k] * cos - of_cos[k] * sin,
                );
                change[k] += angle * quarter - 0.5 * angle * angle * wave;
            }
        }
        change
    }
}
