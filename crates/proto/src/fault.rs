//! Kinds of faults that can occur in the field and be detected, and their effects on an estimate.

use serde::{Deserialize, Serialize, Serializer};

/// Kind of a fault. The numbers are on the wire: new kinds go to the end.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemars", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
#[repr(u8)]
pub enum FaultKind {
    /// Conversions of the scan are missing, by the chip's channel ids or by time.
    Lost,
    /// An edge of DRDY without a new conversion (NEW = 0).
    Repeated,
    /// Two reads of one conversion differ: bit errors on the bus.
    Bus,
    /// Only ones or only zeros on the bus.
    BusDead,
    /// A channel id that is not in the scan, or not the next one.
    Channel,
    /// No conversion for 16 ms or more.
    Silent,
    /// Edges of DRDY faster than the chip can convert.
    Storm,
    /// A register differs from what was written: it changed by itself, or the chip was reset.
    Registers,
    /// The chip could not be set up.
    NoAnswer,
    /// SUPPLY is set, or the chip's own reading of its supply is out of range.
    Supply,
    /// The chip's own reading of the reference differs from the setting.
    Reference,
    /// The scan's rate is not the nominal one, as the chip's clock or the board's is off; or the
    /// board runs on its internal oscillator, and every estimate has this fault.
    Clock,
    /// OVF is set, or a code is at the end of the scale.
    Overload,
}

/// Number of kinds.
pub const KINDS: usize = 13;

impl FaultKind {
    /// All kinds, in the order of their numbers.
    pub const ALL: [Self; KINDS] = {
        use FaultKind::*;
        [
            Lost, Repeated, Bus, BusDead, Channel, Silent, Storm, Registers, NoAnswer, Supply,
            Reference, Clock, Overload,
        ]
    };

    /// True if the fault may change a measured frequency by more than the estimate's uncertainty,
    /// so that no estimate is [`Good`](crate::telemetry::Status::Good).
    ///
    /// These faults do not, because the fit leaves out the missing values and knows the times of
    /// all other frames: [`Self::Lost`], [`Self::Repeated`], [`Self::Bus`] (corrected or left out)
    /// and [`Self::Overload`] (the channel is left out; if it returns shortly before a window's end
    /// it can hide the end of the slide, which the qualification checks).
    ///
    /// All other faults do. After [`Self::BusDead`], [`Self::Silent`], [`Self::Registers`] and
    /// [`Self::NoAnswer`] the scan restarts at a different time; with [`Self::Channel`] and
    /// [`Self::Clock`] its rate is unknown; in a [`Self::Storm`] times may belong to other edges;
    /// with [`Self::Supply`] and [`Self::Reference`] the codes are not specified.
    pub const fn changes_frequency(self) -> bool {
        !matches!(
            self,
            Self::Lost | Self::Repeated | Self::Bus | Self::Overload
        )
    }

    /// True if the levels of the taxels may change because of the fault, or unnoticed during it.
    /// Such a change can look like the start of a slide, or hide its end.
    pub const fn moves_levels(self) -> bool {
        matches!(
            self,
            Self::Registers | Self::Supply | Self::Reference | Self::Silent
        )
    }
}

/// An episode of one kind of fault, reported when it begins and when it ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Fault {
    /// Kind of the fault.
    pub kind: FaultKind,
    /// Device time at which it was detected, microseconds.
    pub from_us: u64,
    /// Device time of the latest detection, microseconds; `None` while the fault lasts.
    pub until_us: Option<u64>,
    /// Number of times that this kind was detected since start-up.
    pub count: u32,
}

/// A set of kinds of faults. In text formats it is a list of names.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
pub struct FaultSet(u16);

impl Serialize for FaultSet {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        if serializer.is_human_readable() {
            serializer.collect_seq(self.iter())
        } else {
            self.0.serialize(serializer)
        }
    }
}

impl FaultSet {
    /// The empty set.
    pub const NONE: Self = Self(0);

    /// Creates a set from bits.
    pub const fn of_bits(bits: u32) -> Self {
        Self(bits as u16 & ((1 << KINDS) - 1))
    }

    /// Adds a kind.
    #[must_use]
    pub const fn with(self, kind: FaultKind) -> Self {
        Self(self.0 | 1 << kind as u8)
    }

    /// Removes a kind.
    #[must_use]
    pub const fn without(self, kind: FaultKind) -> Self {
        Self(self.0 & !(1 << kind as u8))
    }

    /// Union of both sets.
    #[must_use]
    pub const fn and(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }

    /// True if `kind` is in the set.
    pub const fn has(self, kind: FaultKind) -> bool {
        self.0 & 1 << kind as u8 != 0
    }

    /// True if the set is empty.
    pub const fn is_none(self) -> bool {
        self.0 == 0
    }

    /// Kinds in the set, in the order of their numbers.
    pub fn iter(self) -> impl Iterator<Item = FaultKind> {
        FaultKind::ALL
            .into_iter()
            .filter(move |kind| self.has(*kind))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_kind_has_a_bit_of_its_own() {
        for (number, kind) in FaultKind::ALL.into_iter().enumerate() {
            assert_eq!(kind as usize, number);
            assert!(FaultSet::NONE.with(kind).iter().eq([kind]));
        }
        let two = FaultSet::NONE
            .with(FaultKind::Clock)
            .and(FaultSet::NONE.with(FaultKind::Lost));
        assert!(
            two.iter().eq([FaultKind::Lost, FaultKind::Clock])
                && !two.is_none()
                && FaultSet::NONE.is_none()
        );
    }
}
