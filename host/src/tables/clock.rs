//! Derives row numbers and the even spacing of rows from their time stamps.

/// Rows are missing between two stamps that are further apart than this, in units of the row
/// spacing.
const GAP: f64 = 1.5;

/// Number of rows over which the spacing is first guessed, which reduces the effect of rounded
/// stamps by this factor.
const APART: usize = 16;

/// Fraction of a stamp's error by which the expected time of the next stamp is corrected: small
/// enough to follow a drift but not the rounding.
const FOLLOW: f64 = 0.125;

/// Fraction of the error to correct in each pass; a pass numbers the rows with the spacing from the
/// pass before. A first guess may be too inaccurate for more than one row.
const ROUNDS: [f64; 4] = [1.0, 1.0, FOLLOW, FOLLOW];

/// Numbers rows by their stamps, and fits a straight line through the stamps over these numbers by
/// least squares.
#[derive(Clone, Copy, Debug)]
pub struct RowClock {
    first_s: f64,
    /// Spacing by which rows are numbered, seconds.
    guess_s: f64,
    follow: f64,
    /// Time of the latest row predicted from earlier rows, seconds after the first.
    expected_s: f64,
    number: u64,
    rows: f64,
    mean_number: f64,
    /// Mean difference of the stamps from an even spacing of `guess_s`.
    mean_s: f64,
    numbers_squared: f64,
    products: f64,
    seconds_squared: f64,
}

impl RowClock {
    /// Creates a clock for rows whose stamps begin with `head` (seconds); `None` for fewer than
    /// two.
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

    /// Takes the next row's stamp (seconds). Returns the row's number, including missing rows; the
    /// first row has number 0.
    pub fn push(&mut self, t_s: f64) -> u64 {
        let since_s = t_s - self.first_s;
        if self.rows > 0.0 {
            let spacings = (since_s - self.expected_s) / self.guess_s;
            // Limit the steps, so that a stamp in a different century does not overflow.
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

    /// Returns the spacing of the rows so far, seconds.
    pub fn spacing_s(&self) -> f64 {
        self.guess_s + self.slope()
    }

    /// Returns the standard deviation of the spacing in seconds, for independent errors of the
    /// stamps of at least `error_s`.
    pub fn spacing_sigma_s(&self, error_s: f64) -> f64 {
        let residuals = (self.seconds_squared - self.slope() * self.products).max(0.0);
        let variance = (residuals / (self.rows - 2.0).max(1.0)).max(error_s * error_s);
        if self.rows > 1.0 {
            (variance / self.numbers_squared).sqrt()
        } else {
            0.0
        }
    }

    /// Returns the time of row 0 on the fitted line, seconds.
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
