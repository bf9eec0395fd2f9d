//! The clock of a recording's rows: their numbers by their time stamps, and the even spacing behind
//! these.

/// A stamp of more than this many spacings behind the row before it follows a gap, in which rows
/// are missing.
const GAP: f64 = 1.5;

/// Rows over which the first guess of the spacing is taken: it divides the rounding of stamps by
/// this number.
const APART: usize = 16;

/// Fraction of a stamp's error that corrects the expected time of the next one. Small enough to
/// follow a drift and not the rounding.
const FOLLOW: f64 = 0.125;

/// The same each time that the rows are numbered by the spacing that the numbers before gave. A
/// first guess may be too wrong for more than one row.
const ROUNDS: [f64; 4] = [1.0, 1.0, FOLLOW, FOLLOW];

/// Numbers rows by their stamps, and fits a straight line through the stamps over these numbers by
/// least squares.
#[derive(Clone, Copy, Debug)]
pub struct RowClock {
    first_s: f64,
    /// Spacing by which rows are numbered, seconds.
    guess_s: f64,
    follow: f64,
    /// Time of the latest row by the rows before it, seconds after the first.
    expected_s: f64,
    number: u64,
    rows: f64,
    mean_number: f64,
    /// Mean of the stamps, less those of an even spacing of `guess_s`.
    mean_s: f64,
    numbers_squared: f64,
    products: f64,
    seconds_squared: f64,
}

impl RowClock {
    /// A clock for rows with stamps that begin with `head`, in seconds. `None` of fewer than two.
    pub fn new(head: &[f64]) -> Option<Self> {
        let apart = APART.min(head.len().saturating_sub(1));
        let mut spans: Vec<f64> = head
            .windows(apart + 1)
            .map(|stamps| stamps[apart] - stamps[0])
            .collect();
        if apart == 0 {
            return None;
        }
        let middle = spans.len() / 2;
        let (_, median_s, _) = spans.select_nth_unstable_by(middle, f64::total_cmp);
        let guess_s = *median_s / apart as f64;
        drop(spans);
        let mut clock = Self::with_spacing(head[0], guess_s);
        for follow in ROUNDS {
            clock.follow = follow;
            head.iter().for_each(|t_s| {
                clock.push(*t_s);
            });
            clock = Self::with_spacing(head[0], clock.spacing_s());
        }
        Some(clock)
    }

    fn with_spacing(first_s: f64, guess_s: f64) -> Self {
        let (expected_s, number, rows, mean_number, mean_s) = (0.0, 0, 0.0, 0.0, 0.0);
        let (numbers_squared, products, seconds_squared) = (0.0, 0.0, 0.0);
        Self {
            first_s,
            guess_s,
            follow: FOLLOW,
            expected_s,
            number,
            rows,
            mean_number,
            mean_s,
            numbers_squared,
            products,
            seconds_squared,
        }
    }

    /// Takes the next row's stamp, seconds. Gives the row's number, missing rows counted; the first
    /// one has number 0.
    pub fn push(&mut self, t_s: f64) -> u64 {
        let since_s = t_s - self.first_s;
        if self.rows > 0.0 {
            let spacings = (since_s - self.expected_s) / self.guess_s;
            // Clipped, so that a stamp in another century does not overflow.
            let steps = if spacings > GAP {
                spacings.round().min(1e12)
            } else {
                1.0
            };
            self.number += steps as u64;
            self.expected_s += steps * self.guess_s;
            self.expected_s += self.follow * (since_s - self.expected_s);
        }
        let number = self.number as f64;
        let off_s = since_s - number * self.guess_s;
        self.rows += 1.0;
        let (number_off, second_off) = (number - self.mean_number, off_s - self.mean_s);
        self.mean_number += number_off / self.rows;
        self.mean_s += second_off / self.rows;
        self.numbers_squared += number_off * (number - self.mean_number);
        self.products += number_off * (off_s - self.mean_s);
        self.seconds_squared += second_off * (off_s - self.mean_s);
        self.number
    }

    /// Spacing of the rows so far, seconds.
    pub fn spacing_s(&self) -> f64 {
        self.guess_s + self.slope()
    }

    /// Standard deviation of the spacing, seconds, if the stamps' errors are independent, and at
    /// least `error_s` each.
    pub fn spacing_sigma_s(&self, error_s: f64) -> f64 {
        let residuals = (self.seconds_squared - self.slope() * self.products).max(0.0);
        let variance = (residuals / (self.rows - 2.0).max(1.0)).max(error_s * error_s);
        if self.rows > 1.0 {
            (variance / self.numbers_squared).sqrt()
        } else {
            0.0
        }
    }

    /// Time of row 0 by the straight line, seconds.
    pub fn zero_s(&self) -> f64 {
        self.first_s + self.mean_s - self.slope() * self.mean_number
    }

    fn slope(&self) -> f64 {
        if self.rows > 1.0 {
            self.products / self.numbers_squared
        } else {
            0.0
        }
    }
}
