//! Families of faults: their random parameters, and the reports that they must cause.

use crate::draw::Draw;
use clap::ValueEnum;
use hal_mock::Fault;
use ridgetone_proto::fault::FaultKind;

/// Families of injected faults, in the order of the table.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
#[value(rename_all = "snake_case")]
pub enum Family {
    /// No fault: any report is a false alarm.
    None,
    /// Edges of DRDY do not arrive.
    EdgesLost,
    /// An extra edge of DRDY.
    EdgeRepeated,
    /// DRDY is stuck.
    DrdyStuck,
    /// Continuous edges of DRDY.
    Storm,
    /// A bit error from the chip.
    DoutFlip,
    /// A bit error in a read's command.
    DinFlip,
    /// DOUT is stuck at ones or zeros.
    DoutStuck,
    /// The bus is cut: reads return all ones or zeros, and writes do not reach the chip.
    BusCut,
    /// The converter stops converting.
    Stall,
    /// The chip resets itself.
    Reset,
    /// A register's bit changes by itself.
    RegisterFlip,
    /// The analogue supply is out of range.
    Supply,
    /// The reference is out of range.
    Reference,
    /// The chip's clock is off by 1 %.
    Clock,
    /// An input is held at a rail.
    Input,
    /// Several faults, shortly after one another.
    Mixed,
    /// The board runs on its internal oscillator, and the chip's clock deviates from it.
    Oscillator,
}

impl Family {
    /// Families of a single fault that starts during a run: all but the first and the last two.
    fn single() -> &'static [Self] {
        let [_, single @ .., _, _] = Self::value_variants() else {
            return &[];
        };
        single
    }

    /// Name in the JSON and on the command line.
    pub fn name(self) -> String {
        self.to_possible_value()
            .map_or_else(String::new, |value| value.get_name().to_owned())
    }

    /// Returns the title; the kinds of report, one of which must follow; and true if the exact
    /// number of lost conversions is known, so that the firmware must not report more.
    const fn facts(self) -> (&'static str, &'static [FaultKind], bool) {
        use FaultKind::*;
        match self {
            Self::None => ("nothing (control)", &[], true),
            Self::EdgesLost => ("1 to 40 edges of DRDY lost", &[Lost], true),
            Self::EdgeRepeated => ("edge of DRDY repeated", &[Repeated], true),
            // If shorter than the watch's half second, it looks like a gap.
            Self::DrdyStuck => (
                "DRDY stuck high or low, 1 to 600 ms",
                &[Silent, Lost],
                false,
            ),
            Self::Storm => ("storm on DRDY, 5 to 300 ms", &[Storm, Repeated], false),
            Self::DoutFlip => ("bit error from the chip", &[Bus], true),
            // Depending on the flipped bit, the chip reads registers, writes them, or does nothing.
            Self::DinFlip => (
                "bit error in a read's command",
                &[Bus, BusDead, Repeated, Registers, Channel, Lost],
                false,
            ),
            Self::DoutStuck => (
                "DOUT stuck at ones or zeros, 0.2 to 300 ms",
                &[BusDead],
                false,
            ),
            Self::BusCut => ("bus cut: ones or zeros, 0.2 to 300 ms", &[BusDead], false),
            Self::Stall => ("converter stood still, 1 to 600 ms", &[Silent, Lost], false),
            Self::Reset => ("chip reset itself", &[Registers], false),
            Self::RegisterFlip => ("register changed by itself", &[Registers], false),
            Self::Supply => (
                "supply of 3.5 to 4.6 V or 5.4 to 5.8 V, 20 to 700 ms",
                &[Supply],
                true,
            ),
            Self::Reference => (
                "reference off by 3 to 20 %, 20 to 700 ms",
                &[Reference],
                true,
            ),
            Self::Clock => ("chip's clock off by 1 %, 0.6 to 1.2 s", &[Clock], true),
            Self::Input => ("input at a rail, 5 to 300 ms", &[Overload], true),
            Self::Mixed => ("six of these, 30 to 300 ms apart", &FaultKind::ALL, false),
            Self::Oscillator => (
                "board on its internal oscillator, off by 0.2 to 1 %",
                &[Clock],
                true,
            ),
        }
    }

    pub const fn title(self) -> &'static str {
        self.facts().0
    }

    /// True if this kind of report is one of those that may follow. If conversions are read only
    /// once, a bit error in the status counts as the flag that it sets.
    pub fn expects(self, kind: FaultKind, is_read_twice: bool) -> bool {
        let flips_flags = !is_read_twice && matches!(self, Self::DoutFlip | Self::DinFlip);
        self.facts().1.contains(&kind)
            || flips_flags && matches!(kind, FaultKind::Overload | FaultKind::Supply)
    }

    pub const fn loss_is_known(self) -> bool {
        self.facts().2
    }

    /// True if the fault changes bits that are read, directly or through the data format.
    pub const fn alters(self) -> bool {
        matches!(
            self,
            Self::DoutFlip | Self::DinFlip | Self::RegisterFlip | Self::Mixed
        )
    }

    /// Draws a fault of this family and its duration in seconds.
    pub fn draw(self, draw: &mut Draw) -> (Fault, f64) {
        let bit = |draw: &mut Draw, from: u64| 1u8 << draw.whole(from, 7);
        match self {
            Self::None | Self::Mixed => {
                let single = Self::single();
                single[draw.whole(0, single.len() as u64 - 1) as usize].draw(draw)
            }
            Self::RegisterFlip => {
                // From CONFIG0 to GPIOC, because GPIOD reads back the pins and ID is read-only.
                let address = draw.whole(0, 7) as u8;
                (
                    Fault::RegisterFlip {
                        address,
                        mask: bit(draw, 0),
                    },
                    0.0,
                )
            }
            Self::Reset => (Fault::Reset, 0.0),
            Self::Stall => (Fault::Stall, draw.log(0.001, 0.6)),
            // Flips a bit in one of the four bytes of the result, in the first read.
            Self::DoutFlip => (
                Fault::DoutFlip {
                    bytes_ahead: draw.whole(1, 4),
                    mask: bit(draw, 0),
                },
                0.0,
            ),
            // The chip ignores the lower four bits of a command, and the bytes after it.
            Self::DinFlip => (
                Fault::DinFlip {
                    bytes_ahead: 5 * draw.whole(0, 1),
                    mask: bit(draw, 4),
                },
                0.0,
            ),
            Self::DoutStuck => (
                Fault::DoutStuck { high: draw.coin() },
                draw.log(0.0002, 0.3),
            ),
            Self::BusCut => (Fault::BusCut { high: draw.coin() }, draw.log(0.0002, 0.3)),
            Self::DrdyStuck => (Fault::DrdyStuck { high: draw.coin() }, draw.log(0.001, 0.6)),
            // Faster than the chip's fastest scan of 23,739 conversions a second.
            Self::Storm => (
                Fault::Storm {
                    period_ns: draw.whole(5_000, 40_000),
                },
                draw.log(0.005, 0.3),
            ),
            Self::EdgesLost => (
                Fault::EdgesLost {
                    count: draw.whole(1, 40) as u32,
                },
                0.0,
            ),
            Self::EdgeRepeated => (
                Fault::EdgeRepeated {
                    after_ns: draw.whole(30_000, 160_000),
                },
                0.0,
            ),
            Self::Supply => {
                let volts = if draw.coin() {
                    draw.even(3.5, 4.6)
                } else {
                    draw.even(5.4, 5.8)
                };
                (Fault::Supply { volts }, draw.log(0.02, 0.7))
            }
            Self::Reference => {
                let off = draw.even(0.03, 0.2);
                let volts = 4.096 * if draw.coin() { 1.0 - off } else { 1.0 + off };
                (Fault::Reference { volts }, draw.log(0.02, 0.7))
            }
            Self::Clock => {
                let error_ppm = if draw.coin() { 10_000.0 } else { -10_000.0 };
                (Fault::Clock { error_ppm }, draw.even(0.6, 1.2))
            }
            // The error changes in steps, as after a change of temperature.
            Self::Oscillator => {
                let off_ppm = draw.even(2_000.0, 10_000.0);
                let error_ppm = if draw.coin() { off_ppm } else { -off_ppm };
                (Fault::Clock { error_ppm }, draw.even(0.6, 1.2))
            }
            Self::Input => {
                let volts = if draw.coin() { 5.0 } else { -5.0 };
                (
                    Fault::Input {
                        input: draw.whole(0, 15) as u8,
                        volts,
                    },
                    draw.log(0.005, 0.3),
                )
            }
        }
    }
}
