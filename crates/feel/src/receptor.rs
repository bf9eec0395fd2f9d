//! The four kinds of mechanoreceptors of hairless skin, and the vibration from which on each fires.

/// A kind of mechanoreceptive unit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Receptor {
    /// Meissner corpuscles, FA I.
    Fa1,
    /// Pacinian corpuscles, FA II.
    Fa2,
    /// Merkel disks, SA I.
    Sa1,
    /// Ruffini endings, SA II.
    Sa2,
}

/// Number of kinds.
pub const RECEPTORS: usize = 4;

/// A straight line in logarithms to the base of ten: displacement in um from peak to peak over
/// frequency in hertz.
#[derive(Clone, Copy)]
struct Asymptote {
    intercept: f32,
    slope: f32,
}

impl Receptor {
    /// All kinds, in the order of all arrays.
    pub const ALL: [Self; RECEPTORS] = [Self::Fa1, Self::Fa2, Self::Sa1, Self::Sa2];

    /// Its name in the literature.
    pub const fn name(self) -> &'static str {
        ["FA I", "FA II", "SA I", "SA II"][self as usize]
    }

    /// Where its range begins, where its threshold bends, and where its range ends, hertz (Table
    /// 1).
    pub const fn corners_hz(self) -> [f32; 3] {
        match self {
            Self::Fa1 => [0.5, 12.2, 67.0],
            Self::Fa2 => [20.0, 241.0, 800.0],
            Self::Sa1 => [0.5, 26.2, 120.0],
            Self::Sa2 => [0.5, 91.2, 400.0],
        }
    }

    /// Its two lines (equations 1 to 4). The intercepts are the logarithms of 499, 52.1; 1690,
    /// 2.00e-5; 43.5, 0.787; 501, 17.1.
    const fn lines(self) -> [Asymptote; 2] {
        let [below, above] = match self {
            Self::Fa1 => [(2.698_100_5, -0.890), (1.716_837_7, 0.0119)],
            Self::Fa2 => [(3.227_886_7, -1.93), (-4.698_97, 1.39)],
            Self::Sa1 => [(1.638_489_3, -0.545), (-0.104_025_27, 0.683)],
            Self::Sa2 => [(2.699_837_7, -0.783), (1.232_996_1, -0.0340)],
        };
        [
            Asymptote {
                intercept: below.0,
                slope: below.1,
            },
            Asymptote {
                intercept: above.0,
                slope: above.1,
            },
        ]
    }

    /// Logarithm to the base of ten of the threshold in um from peak to peak, at a frequency and
    /// its logarithm; none outside the receptor's range.
    pub(crate) fn log_threshold(self, hz: f32, log_hz: f32) -> Option<f32> {
        let [from, bend, to] = self.corners_hz();
        let [below, above] = self.lines();
        let line = if hz <= bend { below } else { above };
        (from < hz && hz <= to).then_some(line.intercept + line.slope * log_hz)
    }

    /// The ends of the threshold's two lines, below the bend and above it: frequency in hertz, um
    /// from peak to peak. In logarithms the threshold is straight between them.
    pub fn threshold_ends(self) -> [[(f32, f32); 2]; 2] {
        let ([from, bend, to], [below, above]) = (self.corners_hz(), self.lines());
        let at = |line: Asymptote, hz: f32| {
            (
                hz,
                libm::exp10f(line.intercept + line.slope * libm::log10f(hz)),
            )
        };
        [
            [at(below, from), at(below, bend)],
            [at(above, bend), at(above, to)],
        ]
    }

    /// The threshold at a frequency, um from peak to peak; none outside the receptor's range.
    pub fn threshold_um(self, hz: f32) -> Option<f32> {
        self.log_threshold(hz, libm::log10f(hz)).map(libm::exp10f)
    }
}
