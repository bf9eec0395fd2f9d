//! The scan: which inputs the chip converts, and how fast. It is a setting of the build, read from the environment.
//!
//! | variable | values | default |
//! |---|---|---|
//! | `RIDGETONE_INPUTS` | 1 to 16: the chip converts AIN0 and the inputs that follow, so many in all | 16 |
//! | `RIDGETONE_DRATE` | 0 to 2: the chip's data rate (SBAS297G, DRATE) | 1 |
//!
//! The default is the paper's scan of 241 Hz. The chip's five internal readings are part of every scan, for they show
//! its health. A scan that cannot work does not compile. Firmware and PC have to be built with the same scan.

use ads1258::{Config, DataRate, Delay, IdleMode, Mux, Sysred};

/// Places for taxels in a frame and in a message: one for each analog input of the chip, AIN0 to AIN15.
pub const TAXELS: usize = 16;

/// Taxels that the scan converts: taxel k is AINk, one piezoresistor each. The places behind them stay empty.
pub const INPUTS: usize = build_setting(
    option_env!("RIDGETONE_INPUTS"),
    16,
    (1, TAXELS),
    "RIDGETONE_INPUTS: choose 1 to 16, the number of inputs from AIN0 on",
);

/// Bit k: the scan converts taxel k.
pub const SCANNED: u16 = (u16::MAX as u32 >> (TAXELS - INPUTS)) as u16;

/// The board reads each conversion twice, which takes up to 48 us; at 3 a conversion takes 75 us (SBAS297G, rate formula).
const DRATE: usize = build_setting(
    option_env!("RIDGETONE_DRATE"),
    1,
    (0, 2),
    "RIDGETONE_DRATE: choose 0, 1 or 2; at 3 a conversion takes 75 us, and the board needs twice the 48 us of its read",
);

/// The chip's configuration. By default: 21 slots at 15.72864 MHz / (128 x 24.265625), which makes 241.14 scans a second
/// (SBAS297G, rate formula). Standby in place of sleep makes the first conversion after START come at once.
pub const SCAN: Config = Config {
    mux: Mux::AutoScan { differential: 0, single: SCANNED, internal: Sysred::ALL },
    data_rate: match DRATE {
        0 => DataRate::Drate0,
        1 => DataRate::Drate1,
        _ => DataRate::Drate2,
    },
    delay: Delay::Dly3,
    idle_mode: IdleMode::Standby,
    ..Config::RESET
};

/// Frames per second at the chip's nominal clock.
pub const FRAME_RATE_HZ: f32 = SCAN.frame_rate_hz();

/// Frames in the window's ring: the paper's longest slide (60 mm at 15 mm/s, 965 frames at 241 Hz) with 0.6 s to spare
/// for noticing its end and for the fit.
pub const RING_FRAMES: usize = 1120;

/// Shortest window, seconds: 24 frames, the fewest that hold four harmonics and their noise. Whole tenths of a second.
pub const WINDOW_LEAST_S: f32 = {
    let tenths = 23.5 / FRAME_RATE_HZ * 10.0;
    (tenths as u32 + 1) as f32 / 10.0
};

/// Longest window, seconds: what the ring holds with 180 frames left for the fit. Whole tenths of a second.
pub const WINDOW_MOST_S: f32 = {
    let tenths = (RING_FRAMES as f32 - 179.5) / FRAME_RATE_HZ * 10.0;
    tenths as u32 as f32 / 10.0
};

/// Frames in a time, rounded.
pub const fn frames_in(seconds: f32) -> u32 {
    (seconds * FRAME_RATE_HZ + 0.5) as u32
}

// Touch detection compares blocks of four frames, which have to be shorter than the changes that it looks for.
const _: () = assert!(
    FRAME_RATE_HZ >= 180.0,
    "RIDGETONE_INPUTS and RIDGETONE_DRATE: the scan makes less than 180 frames a second, too few for touch detection: \
     choose fewer inputs or a higher data rate"
);

// The default window lasts one second, and the ring has to hold it.
const _: () = assert!(
    WINDOW_MOST_S >= 1.0,
    "RIDGETONE_INPUTS and RIDGETONE_DRATE: the scan makes more than 940 frames a second, and the ring holds no window \
     of 1 s: choose more inputs or a lower data rate"
);

/// A number from the environment of the build.
// It runs only in the compiler, which prints `sentence` as its error.
#[allow(clippy::panic)]
const fn build_setting(text: Option<&str>, default: usize, range: (usize, usize), sentence: &str) -> usize {
    let Some(text) = text else { return default };
    match usize::from_str_radix(text, 10) {
        Ok(number) if number >= range.0 && number <= range.1 => number,
        _ => panic!("{}", sentence),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_default_is_the_papers_scan() {
        // Checked only where no other scan is set.
        if (INPUTS, SCAN.data_rate) == (16, DataRate::Drate1) {
            assert!((FRAME_RATE_HZ - 241.14).abs() < 0.005);
            assert_eq!((SCAN.slots(), WINDOW_LEAST_S, WINDOW_MOST_S), (21, 0.1, 3.9));
        }
        assert_eq!(SCANNED.count_ones() as usize, INPUTS);
        assert_eq!(SCAN.validate(), Ok(()));
    }
}
