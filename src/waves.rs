//! The harmonics of one frequency over a window, block after block.

use crate::moments::{BLOCK, Block, GROUP, GROUPS, HARMONICS_MAX, Stretch, Trigonometric};
use crate::phase::{cos_sin, from_turns};
use crate::window::FrameSource;

/// The harmonics over one block of frames, zero where a frame is missing.
pub(crate) struct Waves {
    pub u: [f32; BLOCK],
    pub cos: [[f32; BLOCK]; HARMONICS_MAX],
    pub sin: [[f32; BLOCK]; HARMONICS_MAX],
}

impl Waves {
    pub const fn new() -> Self {
        Self { u: [0.0; BLOCK], cos: [[0.0; BLOCK]; HARMONICS_MAX], sin: [[0.0; BLOCK]; HARMONICS_MAX] }
    }
}

/// Orders of products of two harmonics, the constant included.
const ORDERS: usize = 2 * HARMONICS_MAX + 1;

/// Makes the harmonics of a frequency without drifting: each block starts from the exact phase and is
/// turned by a table.
pub(crate) struct Oscillator {
    pub harmonics: usize,
    turn: [(f32, f32); BLOCK],
    phase_0: u32,
    step: u32,
    u_0: f32,
    u_step: f32,
    /// From a group's first frame to its centre: in `u`, and as a phase.
    half_group: f32,
    to_centre: u32,
    /// Sums over a group about its centre, for every order k: cos(k theta), and
    /// (u - its centre) sin(k theta). The others are zero by symmetry.
    even: [f32; ORDERS],
    odd: [f32; ORDERS],
    /// Sum over a group of the squared distances from its centre, in `u`.
    spread: f32,
}

impl Oscillator {
    pub fn new<S: FrameSource>(stretch: &Stretch<'_, S>, nu: f32, harmonics: usize) -> Self {
        let step = from_turns(nu / stretch.half());
        let mut turn = [(1.0, 0.0); BLOCK];
        for (i, turn) in turn.iter_mut().enumerate() {
            *turn = cos_sin(step.wrapping_mul(i as u32));
        }
        let u_step = 1.0 / stretch.half();
        let (mut even, mut odd) = ([0.0; ORDERS], [0.0; ORDERS]);
        for i in 0..GROUP / 2 {
            // Half a frame, one and a half ... from the centre.
            let out = 2 * i as u32 + 1;
            let (c1, s1) = cos_sin((step as u64 * out as u64 / 2) as u32);
            let (mut c, mut s) = (1.0, 0.0);
            for k in 0..=2 * harmonics {
                even[k] += 2.0 * c;
                odd[k] += out as f32 * u_step * s;
                (c, s) = (c * c1 - s * s1, s * c1 + c * s1);
            }
        }
        // Phase zero at the centre, which lies half way between two frames if their number is even.
        let back = step as u64 * stretch.frames.saturating_sub(1) as u64 / 2;
        let phase_0 = (back as u32).wrapping_neg();
        let n = GROUP as f32;
        Self {
            harmonics,
            turn,
            phase_0,
            step,
            u_0: stretch.u(0),
            u_step,
            half_group: 0.5 * (n - 1.0) * u_step,
            to_centre: (step as u64 * (GROUP as u64 - 1) / 2) as u32,
            even,
            odd,
            spread: u_step * u_step * n * (n * n - 1.0) / 12.0,
        }
    }

    /// `u` of a frame.
    pub fn u(&self, frame: u32) -> f32 {
        self.u_0 + self.u_step * frame as f32
    }

    /// The harmonics over a block.
    pub fn fill(&self, block: &Block, waves: &mut Waves) {
        let (c, s) = cos_sin(self.phase_0.wrapping_add(self.step.wrapping_mul(block.at)));
        for i in 0..BLOCK {
            let (tc, ts) = self.turn[i];
            let (mut c1, mut s1) = (c * tc - s * ts, s * tc + c * ts);
            if block.valid[i] == 0 {
                (c1, s1) = (0.0, 0.0);
            }
            waves.u[i] = self.u(block.at + i as u32);
            waves.cos[0][i] = c1;
            waves.sin[0][i] = s1;
            let (mut ch, mut sh) = (c1, s1);
            for h in 1..self.harmonics.min(HARMONICS_MAX) {
                (ch, sh) = (ch * c1 - sh * s1, sh * c1 + ch * s1);
                waves.cos[h][i] = ch;
                waves.sin[h][i] = sh;
            }
        }
    }

    /// Adds a block to the sums, by the centres of its groups where all of their frames count; gives
    /// the groups' levers.
    pub fn add_groups(&self, block: &Block, waves: &Waves, sums: &mut Trigonometric) -> [f32; GROUPS] {
        let mut levers = [0.0; GROUPS];
        for (q, lever) in levers.iter_mut().enumerate() {
            let first = GROUP * q;
            *lever = self.u(block.at + first as u32) + self.half_group;
            if block.valid[first..first + GROUP].iter().all(|valid| *valid != 0) {
                self.add_group(block.at + first as u32, *lever, sums);
            } else {
                for i in first..first + GROUP {
                    self.add_frame(block, waves, i, *lever, sums);
                }
            }
        }
        levers
    }

    fn add_group(&self, at: u32, lever: f32, sums: &mut Trigonometric) {
        let (c1, s1) = cos_sin(self.phase_0.wrapping_add(self.step.wrapping_mul(at)).wrapping_add(self.to_centre));
        let (mut c, mut s) = (1.0, 0.0);
        for k in 0..=2 * self.harmonics.min(HARMONICS_MAX) {
            let (cos, sin) = (self.even[k] * c, self.even[k] * s);
            let (u_cos, u_sin) = (lever * cos - self.odd[k] * s, lever * sin + self.odd[k] * c);
            // `u` squared is asked for by slopes alone, without a wave.
            let uu = if k == 0 { lever * lever * cos + self.spread } else { 0.0 };
            let cosines = [cos, u_cos, uu, lever * cos, lever * u_cos, lever * lever * cos];
            sums.add(k, cosines, [sin, u_sin, 0.0, lever * sin, lever * u_sin, lever * lever * sin]);
            (c, s) = (c * c1 - s * s1, s * c1 + c * s1);
        }
    }

    /// Adds a frame of a group with a gap.
    fn add_frame(&self, block: &Block, waves: &Waves, i: usize, lever: f32, sums: &mut Trigonometric) {
        if block.valid[i] == 0 {
            return;
        }
        let (u, c1, s1) = (waves.u[i], waves.cos[0][i], waves.sin[0][i]);
        let (mut c, mut s) = (1.0, 0.0);
        for k in 0..=2 * self.harmonics.min(HARMONICS_MAX) {
            let (lever_c, lever_s) = (lever * c, lever * s);
            sums.add(
                k,
                [c, u * c, u * u * c, lever_c, u * lever_c, lever * lever_c],
                [s, u * s, u * u * s, lever_s, u * lever_s, lever * lever_s],
            );
            (c, s) = (c * c1 - s * s1, s * c1 + c * s1);
        }
    }

    /// Adds the frames of a block that count, one by one, with `u` for a lever.
    pub fn add_frames(&self, block: &Block, waves: &Waves, sums: &mut Trigonometric) {
        for i in 0..BLOCK {
            if block.valid[i] == 0 {
                continue;
            }
            let (u, c1, s1) = (waves.u[i], waves.cos[0][i], waves.sin[0][i]);
            let (mut c, mut s) = (1.0, 0.0);
            for k in 0..=2 * self.harmonics.min(HARMONICS_MAX) {
                let (u_c, u_s) = (u * c, u * s);
                sums.add(k, [c, u_c, u * u_c], [s, u_s, u * u_s]);
                (c, s) = (c * c1 - s * s1, s * c1 + c * s1);
            }
        }
    }
}
