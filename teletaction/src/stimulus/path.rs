//! Interpolates hand positions that arrive one by one, at uneven times.

/// Time without a position after which the hand counts as resting, seconds: pointers report at
/// least 60 times a second while they move.
const REST_S: f64 = 0.03;

/// Time before a new position at which a resting hand starts to move, seconds: the report interval
/// of a pointer at 125 Hz.
const SET_OUT_S: f64 = 0.008;

/// The latest `N` positions of a hand. Between two positions the hand moves in a straight line; a
/// resting hand starts only shortly before the next position.
#[derive(Clone, Copy, Debug)]
pub struct Path<const N: usize> {
    /// Times and positions, seconds and millimetres, in order of time from `first` on.
    points: [(f64, f64); N],
    first: usize,
    count: usize,
}

impl<const N: usize> Default for Path<N> {
    fn default() -> Self {
        Self {
            points: [(0.0, 0.0); N],
            first: 0,
            count: 0,
        }
    }
}

impl<const N: usize> Path<N> {
    /// Adds a position (millimetres) at a time (seconds). Returns false if either is not finite, or
    /// if the time is not later than the last one.
    pub fn push(&mut self, t_s: f64, position_mm: f64) -> bool {
        let last = self.last();
        if !(t_s.is_finite()
            && position_mm.is_finite()
            && last.is_none_or(|(last_s, _)| t_s > last_s))
        {
            return false;
        }
        if let Some((last_s, last_mm)) = last
            && t_s - last_s > REST_S
        {
            self.keep(t_s - SET_OUT_S, last_mm);
        }
        self.keep(t_s, position_mm);
        true
    }

    /// Forgets all positions, because the hand is put down elsewhere.
    pub fn clear(&mut self) {
        self.count = 0;
    }

    /// Time and position of the latest report, seconds and millimetres.
    pub fn last(&self) -> Option<(f64, f64)> {
        self.count.checked_sub(1).map(|n| self.point(n))
    }

    /// Position at `t_s`, millimetres: the first one before all reports, and the last one after
    /// them. `None` without a report.
    pub fn position_mm(&self, t_s: f64) -> Option<f64> {
        let (mut below, mut above) = (0, self.count.checked_sub(1)?);
        let (first, last) = (self.point(below), self.point(above));
        if !(t_s > first.0) {
            return Some(first.1);
        }
        if t_s >= last.0 {
            return Some(last.1);
        }
        while above - below > 1 {
            let middle = usize::midpoint(below, above);
            if self.point(middle).0 <= t_s {
                below = middle
            } else {
                above = middle
            }
        }
        let ((from_s, from_mm), (to_s, to_mm)) = (self.point(below), self.point(above));
        Some(from_mm + (to_mm - from_mm) * (t_s - from_s) / (to_s - from_s))
    }

    fn keep(&mut self, t_s: f64, position_mm: f64) {
        if N == 0 {
            return;
        }
        if self.count == N {
            self.first = (self.first + 1) % N;
            self.count -= 1;
        }
        if let Some(position) = self.points.get_mut((self.first + self.count) % N) {
            *position = (t_s, position_mm);
            self.count += 1;
        }
    }

    fn point(&self, n: usize) -> (f64, f64) {
        self.points
            .get((self.first + n) % N.max(1))
            .copied()
            .unwrap_or_default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_moving_hand_is_on_a_line_and_a_resting_one_stays() {
        let mut path = Path::<8>::default();
        assert_eq!((path.position_mm(0.0), path.last()), (None, None));
        assert!(path.push(0.0, 1.0) && path.push(0.01, 2.0));
        assert!(
            !path.push(0.01, 9.0) && !path.push(f64::NAN, 9.0) && !path.push(1.0, f64::INFINITY)
        );
        assert_eq!(
            [-1.0, 0.0, 0.005, 0.01, 9.0].map(|t_s| path.position_mm(t_s)),
            [1.0, 1.0, 1.5, 2.0, 2.0].map(Some)
        );
        // The hand rests for a second, and then moves.
        assert!(path.push(1.0, 3.0));
        assert_eq!(
            [0.5, 0.992, 1.0].map(|t_s| path.position_mm(t_s)),
            [2.0, 2.0, 3.0].map(Some)
        );
        assert!((path.position_mm(0.996).expect("a position") - 2.5).abs() < 1e-9);
    }

    #[test]
    fn the_oldest_places_go() {
        let mut path = Path::<4>::default();
        assert!((0..100).all(|n| path.push(0.01 * f64::from(n), f64::from(n))));
        assert_eq!(path.position_mm(0.0), Some(96.0));
        assert!((path.position_mm(0.975).expect("a position") - 97.5).abs() < 1e-9);
        path.clear();
        assert_eq!(path.position_mm(0.5), None);
    }
}
