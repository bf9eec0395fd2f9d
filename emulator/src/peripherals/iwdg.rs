//! The independent watchdog (RM0090, 21.4).

/// Frequency of the low-speed oscillator, hertz; 17 to 47 kHz from chip to chip (DS8626, LSI
/// characteristics).
pub const LSI_HZ: u64 = 32_000;
/// Maximum number of oscillator cycles until a new prescaler or reload value takes effect.
const UPDATE_CYCLES: u64 = 5;

#[derive(Default)]
pub struct Iwdg {
    is_started: bool,
    is_open: bool,
    pr: u32,
    rlr: u32,
    /// Times at which writes to PR and RLR take effect, nanoseconds.
    updated_ns: [u64; 2],
    fed_ns: u64,
    pub feeds: u64,
}

impl Iwdg {
    pub fn new() -> Self {
        Self {
            rlr: 0xFFF,
            ..Self::default()
        }
    }

    /// Returns to the state after a reset, but keeps the count of feeds.
    pub fn reset(&mut self) {
        *self = Self {
            feeds: self.feeds,
            ..Self::new()
        };
    }

    /// Time at which the watchdog expires unless it is fed.
    pub fn next_event_ns(&self) -> Option<u64> {
        let cycles = u64::from(self.rlr + 1) * (4 << self.pr.min(6));
        self.is_started
            .then(|| self.fed_ns + cycles * 1_000_000_000 / LSI_HZ)
    }

    pub fn read(&self, offset: u32, now_ns: u64) -> Option<u32> {
        Some(match offset {
            0x00 => 0,
            0x04 => self.pr,
            0x08 => self.rlr,
            0x0C => {
                u32::from(now_ns < self.updated_ns[0]) | u32::from(now_ns < self.updated_ns[1]) << 1
            }
            _ => return None,
        })
    }

    pub fn write(&mut self, offset: u32, value: u32, now_ns: u64) -> Option<()> {
        let arrives_ns = now_ns + UPDATE_CYCLES * 1_000_000_000 / LSI_HZ;
        match (offset, value) {
            (0x00, 0xCCCC) => {
                (self.is_started, self.fed_ns) = (true, now_ns);
            }
            (0x00, 0x5555) => self.is_open = true,
            (0x00, 0xAAAA) => {
                (self.is_open, self.fed_ns) = (false, now_ns);
                self.feeds += 1;
            }
            (0x00, _) => self.is_open = false,
            (0x04, 0..=7) if self.is_open => (self.pr, self.updated_ns[0]) = (value, arrives_ns),
            (0x08, 0..=0xFFF) if self.is_open => {
                (self.rlr, self.updated_ns[1]) = (value, arrives_ns)
            }
            _ => return None,
        }
        Some(())
    }
}
