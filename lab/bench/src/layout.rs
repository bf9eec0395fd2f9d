//! Order of the rows of results, shared by the bench image and its reader.

/// Scenes: names, and bits for the parts that differ from the default: 1 baseline, 2 coloured
/// noise, 4 correlated noise, 8 impulses, 16 varying speed, 32 overtones.
pub const SCENES: [(&str, u8); 9] = [
    ("default: four harmonics", 0),
    ("harmonics = 1", 32),
    ("scene.curved_baseline = false", 1),
    ("scene.coloured_noise = false", 2),
    ("scene.shared_noise = false", 4),
    ("scene.impulses = false", 8),
    ("scene.moving_speed = true", 16),
    ("lean: one harmonic, all four false", 1 | 2 | 4 | 8 | 32),
    ("four harmonics, all four false", 1 | 2 | 4 | 8),
];

/// Window lengths in frames: 0.2, 0.4, 1 and 3.9 s.
pub const FRAMES: [usize; 4] = [48, 96, 241, 940];

/// Number of window rows: for each length, each scene untracked and tracked, the Hann FFT and IEEE
/// 1057.
pub const WINDOW_ROWS: usize = (2 * SCENES.len() + 2) * FRAMES.len();

/// Number of rows: the window rows, followed by square roots by the instruction and by `libm`.
pub const ROWS: usize = WINDOW_ROWS + 2;

pub const ROOTS: u32 = 4096;

/// Words per row: status, bits of the frequency in cycles per frame, bits of its sigma.
pub const WORDS: usize = 3;
