//! What can go wrong in the field and be seen: kinds of faults, and what they cast doubt on.

use serde::{Deserialize, Serialize};

/// What was seen to be wrong. The numbers are on the wire: new kinds go to the end.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[repr(u8)]
pub enum FaultKind {
    /// Conversions of the scan never came: the chip's own ids or the time say so.
    Lost,
    /// An edge of DRDY without a new conversion (NEW = 0).
    Repeated,
    /// Two reads of one conversion differ: a bit fell over on the bus.
    Bus,
    /// Nothing but ones or nothing but zeros on the bus.
    BusDead,
    /// A channel id that is not the scan's, or not its next.
    Channel,
    /// No conversion for long: for 16 ms or more, if others followed.
    Silent,
    /// Edges of DRDY faster than the chip can convert.
    Storm,
    /// A register does not hold what was written: it changed by itself, or the chip reset itself.
    Registers,
    /// The chip could not be set up.
    NoAnswer,
    /// SUPPLY is set, or the chip's own reading of its supply is out of range.
    Supply,
    /// The chip's own reading of the reference is not what is set.
    Reference,
    /// The scan's rate is not the nominal one: the chip's clock or the board's is off.
    Clock,
    /// OVF is set, or a code is at the end of the scale.
    Overload,
}

impl FaultKind {
    /// Whether it may change a frequency that is measured while it lasts, beyond what the estimate's own uncertainty
    /// says: then no estimate is [`Good`](crate::telemetry::Status::Good).
    ///
    /// It may if the conversions may not be where or what the fit takes them for: after [`Self::BusDead`],
    /// [`Self::Silent`], [`Self::Registers`] and [`Self::NoAnswer`] the scan begins anew, and not at the beat of
    /// the one before; with [`Self::Channel`] and [`Self::Clock`] it is off the beat or its rate is not known; in a
    /// [`Self::Storm`] times may belong to other edges; with [`Self::Supply`] and [`Self::Reference`] the codes are not
    /// specified. It may not where the fit leaves out what is missing and knows when the rest was: [`Self::Lost`],
    /// [`Self::Repeated`], [`Self::Bus`] (mended or left out), [`Self::Overload`] (the channel is left out; but when it comes
    /// back shortly before a window's end it hides that the slide is over, and the estimate is doubtful).
    pub const fn changes_frequency(self) -> bool {
        match self {
            Self::Lost | Self::Repeated | Self::Bus | Self::Overload => false,
            Self::BusDead
            | Self::Channel
            | Self::Silent
            | Self::Storm
            | Self::Registers
            | Self::NoAnswer
            | Self::Supply
            | Self::Reference
            | Self::Clock => true,
        }
    }

    /// Whether what the taxels read may move with it, or unseen meanwhile: then something else than a slide may look like
    /// the beginning of one, or hide its end.
    pub const fn moves_levels(self) -> bool {
        matches!(self, Self::Registers | Self::Supply | Self::Reference | Self::Silent)
    }

    /// Every kind, in the order of their numbers.
    pub const ALL: [Self; KINDS] = [
        Self::Lost,
        Self::Repeated,
        Self::Bus,
        Self::BusDead,
        Self::Channel,
        Self::Silent,
        Self::Storm,
        Self::Registers,
        Self::NoAnswer,
        Self::Supply,
        Self::Reference,
        Self::Clock,
        Self::Overload,
    ];
}

/// How many kinds there are.
pub const KINDS: usize = 13;

/// A bout of one kind: told when it begins and when it is over.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Fault {
    /// What is wrong.
    pub kind: FaultKind,
    /// Device time at which the bout was noticed, microseconds.
    pub from_us: u64,
    /// Device time at which it was seen last, microseconds; none while it lasts.
    pub until_us: Option<u64>,
    /// Times that this kind was seen since start-up.
    pub count: u32,
}

/// A set of kinds: what casts doubt on a window.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct FaultSet(u16);

impl FaultSet {
    /// None.
    pub const NONE: Self = Self(0);

    /// By the bits of their numbers.
    pub const fn of_bits(bits: u32) -> Self {
        Self(bits as u16 & ((1 << KINDS) - 1))
    }

    /// With this kind too.
    #[must_use]
    pub const fn with(self, kind: FaultKind) -> Self {
        Self(self.0 | 1 << kind as u8)
    }

    /// Without this kind.
    #[must_use]
    pub const fn without(self, kind: FaultKind) -> Self {
        Self(self.0 & !(1 << kind as u8))
    }

    /// Those of both.
    #[must_use]
    pub const fn and(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }

    /// Whether this kind is among them.
    pub const fn has(self, kind: FaultKind) -> bool {
        self.0 & 1 << kind as u8 != 0
    }

    /// Whether there is none.
    pub const fn is_none(self) -> bool {
        self.0 == 0
    }

    /// They, one by one.
    pub fn iter(self) -> impl Iterator<Item = FaultKind> {
        FaultKind::ALL.into_iter().filter(move |kind| self.has(*kind))
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
        let two = FaultSet::NONE.with(FaultKind::Clock).and(FaultSet::NONE.with(FaultKind::Lost));
        assert!(two.iter().eq([FaultKind::Lost, FaultKind::Clock]) && !two.is_none() && FaultSet::NONE.is_none());
    }
}
