//! The four kinds of mechanoreceptors of hairless skin, and the vibration threshold at which each
//! fires.

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

/// A straight line in base-ten logarithms: displacement in um peak to peak over frequency in hertz.
#[derive(Clone, Copy)]
struct Asymptote {
    intercept: f32,
    slope: f32,
}

const fn line(intercept: f32, slope: f32) -> Asymptote {
    Asymptote { intercept, slope }
}

impl Receptor {
    /// All kinds, in the order of all arrays.
    pub const ALL: [Self; RECEPTORS] = [Self::Fa1, Self::Fa2, Self::Sa1, Self::Sa2];

    /// Name in the literature.
    pub const fn name(self) -> &'static str {
        ["FA I", "FA II", "SA I", "SA II"][self as usize]
    }

    /// Frequencies at which the range begins, the threshold bends and the range ends, hertz (Table
    /// 1).
    pub const fn corners_hz(self) -> [f32; 3] {
        match self {
            Self::Fa1 => [0.5, 12.2, 67.0],
            Self::Fa2 => [20.0, 241.0, 800.0],
            Self::Sa1 => [0.5, 26.2, 120.0],
            Self::Sa2 => [0.5, 91.2, 400.0],
        }
    }

    /// Threshold below and above the bend (equations 1 to 4). The intercepts are the logarithms of
    /// 499, 52.1; 1690, 2.00e-5; 43.5, 0.787; 501, 17.1.
    const fn lines(self) -> [Asymptote; 2] {
        match self {
            Self::Fa1 => [line(2.698_100_5, -0.890), line(1.716_837_7, 0.0119)],
            Self::Fa2 => [line(3.227_886_7, -1.93), line(-4.698_97, 1.39)],
            Self::Sa1 => [line(1.638_489_3, -0.545), line(-0.104_025_27, 0.683)],
            Self::Sa2 => [line(2.699_837_7, -0.783), line(1.232_996_1, -0.0340)],
        }
    }

    /// Base-ten logarithm of the threshold, um peak to peak; `None` outside the receptor's range.
    pub(crate) fn log_threshold(self, hz: f32) -> Option<f32> {
        let [from, bend, to] = self.corners_hz();
        let [below, above] = self.lines();
        let line = if hz <= bend { below } else { above };
        (from < hz && hz <= to).then(|| line.intercept + line.slope * libm::log10f(hz))
    }

    /// Threshold at a frequency, um peak to peak; `None` outside the receptor's range.
    pub fn threshold_um(self, hz: f32) -> Option<f32> {
        self.log_threshold(hz).map(libm::exp10f)
    }
}
