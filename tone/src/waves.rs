//! The harmonics of one frequency over a span, and sums of products of them.

use crate::abscissa::Abscissa;
use crate::frame_span::{BLOCK, Block, FrameSpan};
use crate::limits::HARMONICS_MAX;
use crate::phase::{cos_sin, from_turns};

/// Orders of the sums: products of two harmonics have up to twice the order of either.
const ORDERS: usize = 2 * HARMONICS_MAX + 1;

/// The weight of a sum.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Weight {
    /// 1
    One,
    /// u
    U,
    /// u squared
    UU,
    /// Second Legendre polynomial of a block's centre, complete blocks only.
    Second,
    /// The third.
    Third,
}

const WEIGHTS: usize = 5;
/// The first of them, up to and with u squared, are needed for products of two harmonics too.
const PRODUCT_WEIGHTS: usize = 3;

/// One of the functions a channel is made of, but for a power of `u`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Wave {
    /// 1
    One,
    /// cos(h theta)
    Cos(usize),
    /// sin(h theta)
    Sin(usize),
}

/// Sums of the harmonics alone, over the frames that count: weight x cos(k theta) and
/// weight x sin(k theta) for every [`Weight`], and k = 0 ..= harmonics; with 1, u and u squared up to twice as many.
#[derive(Clone, Debug)]
pub struct Trigonometric {
    cos: [[f32; ORDERS]; WEIGHTS],
    sin: [[f32; ORDERS]; WEIGHTS],
}

/// Second and third Legendre polynomial.
#[inline(always)]
pub fn legendre(u: f32) -> [f32; 2] {
    let uu = u * u;
    [1.5 * uu - 0.5, (2.5 * uu - 1.5) * u]
}

impl Trigonometric {
    /// Sums of the products of cosine and sine of harmonic `h` (rows) with those of harmonic `k`, at most `h`.
    #[inline(always)]
    pub fn products(&self, h: usize, k: usize) -> [[f32; 2]; 2] {
        let (cos, sin) = (&self.cos[Weight::One as usize], &self.sin[Weight::One as usize]);
        let (apart, together) = (h.saturating_sub(k).min(ORDERS - 1), (h + k).min(ORDERS - 1));
        [
            [0.5 * (cos[apart] + cos[together]), 0.5 * (sin[together] - sin[apart])],
            [0.5 * (sin[together] + sin[apart]), 0.5 * (cos[apart] - cos[together])],
        ]
    }

    /// Sum of weight x a x b.
    #[inline(always)]
    pub fn product(&self, weight: Weight, a: Wave, b: Wave) -> f32 {
        let (cos, sin) = (&self.cos[weight as usize], &self.sin[weight as usize]);
        let signed = |to: usize, from: usize| if to >= from { sin[to - from] } else { -sin[from - to] };
        match (a, b) {
            (Wave::One, Wave::One) => cos[0],
            (Wave::One, Wave::Cos(h)) | (Wave::Cos(h), Wave::One) => cos[h],
            (Wave::One, Wave::Sin(h)) | (Wave::Sin(h), Wave::One) => sin[h],
            (Wave::Cos(i), Wave::Cos(j)) => 0.5 * (cos[i.abs_diff(j)] + cos[i + j]),
            (Wave::Sin(i), Wave::Sin(j)) => 0.5 * (cos[i.abs_diff(j)] - cos[i + j]),
            (Wave::Cos(i), Wave::Sin(j)) | (Wave::Sin(j), Wave::Cos(i)) => 0.5 * (sin[i + j] + signed(j, i)),
        }
    }
}

/// The harmonics of a frequency, block by block without drifting: each block starts from its
/// exact phase and is turned by a table.
pub struct Oscillator<'a> {
    pub harmonics: usize,
    nu: f32,
    frames: u32,
    abscissa: Abscissa<'a>,
    phase_0: u32,
    step: u32,
    /// The harmonics about a block's centre.
    pub centred: CentredWaves,
    /// From a block's first frame to its centre.
    to_centre_u: f32,
    to_centre_phase: u32,
    /// Sums over a block about its centre, for every order k: cos(k theta); distance x sin(k theta); distance
    /// squared x cos(k theta). The others are zero by symmetry.
    even: [f32; ORDERS],
    odd: [f32; ORDERS],
    spread: [f32; ORDERS],
}

/// Frames on either side of a block's centre.
pub const HALF_BLOCK: usize = BLOCK / 2;

/// The factors of the even (or odd) parts of columns at one distance from a block's centre - half a frame, one and a half
/// ... - for each harmonic: the wave, and the other wave times the distance.
pub type Factors = [[f32; 2]; HARMONICS_MAX];

/// The harmonics about a block's centre, the same in every block: cosines are even, sines are odd, and times the
/// distance it is the other way round.
pub struct CentredWaves {
    /// Cosine, and distance in `u` times sine.
    pub even: [Factors; HALF_BLOCK],
    /// Sine, and distance times cosine.
    pub odd: [Factors; HALF_BLOCK],
}

impl CentredWaves {
    const fn new() -> Self {
        let none = [[[0.0; 2]; HARMONICS_MAX]; HALF_BLOCK];
        Self { even: none, odd: none }
    }
}

/// A block's centre: its `u`, and cosine and sine of multiples of its phase.
pub struct Centre {
    pub u: f32,
    harmonics: usize,
    turn: [(f32, f32); ORDERS],
}

impl Centre {
    pub const fn new() -> Self {
        Self { u: 0.0, harmonics: 0, turn: [(1.0, 0.0); ORDERS] }
    }

    /// Cosine and sine of harmonic `h`, 0 the fundamental.
    pub fn turn(&self, h: usize) -> (f32, f32) {
        self.turn[(h + 1).min(ORDERS - 1)]
    }

    /// Cosine and sine of the harmonics.
    pub fn turns(&self) -> &[(f32, f32)] {
        &self.turn[1..=self.harmonics.min(HARMONICS_MAX)]
    }
}

/// The harmonics over one block of frames.
pub struct Waves {
    pub u: [f32; BLOCK],
    pub cos: [[f32; BLOCK]; HARMONICS_MAX],
    pub sin: [[f32; BLOCK]; HARMONICS_MAX],
}

/// Multiples of an angle by the sum formula: (cos, sin) of 0, 1, 2 ... times it.
#[inline(always)]
fn multiples((c1, s1): (f32, f32), most: usize, mut visit: impl FnMut(usize, f32, f32)) {
    let (mut c, mut s) = (1.0, 0.0);
    for k in 0..=most {
        visit(k, c, s);
        (c, s) = (c * c1 - s * s1, s * c1 + c * s1);
    }
}

impl<'a> Oscillator<'a> {
    #[inline(always)]
    pub fn new(span: &FrameSpan<'a>, nu: f32, harmonics: usize) -> Self {
        let harmonics = harmonics.clamp(1, HARMONICS_MAX);
        let u_step = 2.0 / span.frames.max(1) as f32;
        let step = from_turns(nu * u_step);
        // Phase zero at the centre, which lies half way between two frames if their number is even.
        let back = step as u64 * span.frames.saturating_sub(1) as u64 / 2;
        Self {
            harmonics,
            nu,
            frames: span.frames,
            abscissa: span.abscissa(),
            phase_0: (back as u32).wrapping_neg(),
            step,
            centred: CentredWaves::new(),
            to_centre_u: 0.5 * (BLOCK - 1) as f32 * u_step,
            to_centre_phase: (step as u64 * (BLOCK as u64 - 1) / 2) as u32,
            even: [0.0; ORDERS],
            odd: [0.0; ORDERS],
            spread: [0.0; ORDERS],
        }
    }

    /// Fills in the harmonics about a block's centre; in time only. `new` would copy them.
    #[inline(never)]
    pub fn fill_centred(&mut self) {
        let Some(u_step) = self.abscissa.step() else { return };
        let (step, harmonics) = (self.step as u64, self.harmonics.min(HARMONICS_MAX));
        let Self { even, odd, spread, centred, .. } = self;
        for (i, (with_even, with_odd)) in centred.even.iter_mut().zip(&mut centred.odd).enumerate() {
            let far = (i as f32 + 0.5) * u_step;
            let angle = cos_sin((step * (2 * i as u64 + 1) / 2) as u32);
            multiples(angle, 2 * harmonics, |k, c, s| {
                even[k] += 2.0 * c;
                odd[k] += 2.0 * far * s;
                spread[k] += 2.0 * far * far * c;
                if k >= 1 && k <= harmonics {
                    with_even[k - 1] = [c, far * s];
                    with_odd[k - 1] = [s, far * c];
                }
            });
        }
    }

    /// The centre of the block that begins with frame `at`.
    pub fn centre(&self, at: u32, centre: &mut Centre) {
        let phase = self.phase_0.wrapping_add(self.step.wrapping_mul(at)).wrapping_add(self.to_centre_phase);
        (centre.u, centre.harmonics) = (self.abscissa.u(at) + self.to_centre_u, self.harmonics);
        multiples(cos_sin(phase), 2 * self.harmonics.min(HARMONICS_MAX), |k, c, s| centre.turn[k] = (c, s));
    }

    /// The harmonics frame by frame, of those of a block that count.
    pub fn fill(&self, block: &Block, waves: &mut Waves) {
        let at = block.first;
        waves.u = self.abscissa.block(at, self.frames);
        let in_time = matches!(self.abscissa, Abscissa::Time { .. });
        let phase = self.phase_0.wrapping_add(self.step.wrapping_mul(at));
        for i in (0..BLOCK).filter(|i| block.valid[*i] != 0) {
            let (c1, s1) = cos_sin(match in_time {
                true => phase.wrapping_add(self.step.wrapping_mul(i as u32)),
                false => from_turns(self.nu * waves.u[i]),
            });
            let (mut ch, mut sh) = (c1, s1);
            for h in 0..self.harmonics.min(HARMONICS_MAX) {
                (waves.cos[h][i], waves.sin[h][i]) = (ch, sh);
                (ch, sh) = (ch * c1 - sh * s1, sh * c1 + ch * s1);
            }
        }
    }
}

impl Waves {
    pub const fn new() -> Self {
        Self { u: [0.0; BLOCK], cos: [[0.0; BLOCK]; HARMONICS_MAX], sin: [[0.0; BLOCK]; HARMONICS_MAX] }
    }
}

impl Trigonometric {
    /// Empty sums.
    #[inline(always)]
    pub const fn new() -> Self {
        Self { cos: [[0.0; ORDERS]; WEIGHTS], sin: [[0.0; ORDERS]; WEIGHTS] }
    }

    /// Empties the sums that `harmonics` harmonics use.
    pub fn clear(&mut self, harmonics: usize) {
        for row in self.cos.iter_mut().chain(&mut self.sin) {
            row.iter_mut().take(2 * harmonics + 1).for_each(|sum| *sum = 0.0);
        }
    }

    /// Adds a complete block in time.
    pub fn add_block(&mut self, centre: &Centre, oscillator: &Oscillator) {
        let u = centre.u;
        let [second, third] = legendre(u);
        for (k, (c, s)) in centre.turn.iter().enumerate().take(2 * oscillator.harmonics + 1) {
            let (even, odd, spread) = (oscillator.even[k], oscillator.odd[k], oscillator.spread[k]);
            let (cos, sin) = (even * c, even * s);
            let (u_cos, u_sin) = (u * cos - odd * s, u * sin + odd * c);
            // (u + d)^2 = u (u + 2 d) + d^2, d the distance from the centre.
            let uu_cos = u * (u_cos - odd * s) + spread * c;
            let uu_sin = u * (u_sin + odd * c) + spread * s;
            self.add(0, k, [cos, u_cos, uu_cos], [sin, u_sin, uu_sin]);
            if k <= oscillator.harmonics {
                self.add(PRODUCT_WEIGHTS, k, [second * cos, third * cos], [second * sin, third * sin]);
            }
        }
    }

    /// Adds the frames of a block that count, one by one.
    pub fn add_frames(&mut self, block: &Block, waves: &Waves, harmonics: usize) {
        for i in 0..BLOCK {
            if block.valid[i] == 0 {
                continue;
            }
            let u = waves.u[i];
            multiples((waves.cos[0][i], waves.sin[0][i]), 2 * harmonics.min(HARMONICS_MAX), |k, c, s| {
                self.add(0, k, [c, u * c, u * u * c], [s, u * s, u * u * s]);
            });
        }
    }

    /// Adds to the sums with weights from `first` on.
    #[inline(always)]
    fn add<const N: usize>(&mut self, first: usize, k: usize, cos: [f32; N], sin: [f32; N]) {
        for w in 0..N {
            self.cos[first + w][k] += cos[w];
            self.sin[first + w][k] += sin[w];
        }
    }
}
