//! Entries of the table of settings, and everything derived from them.

use super::Settings;
use crate::plan::Plan;
use serde::Serialize;
use serde::de::DeserializeOwned;

/// Description of a setting for a PC. The firmware does not refer to descriptions, so they are not
/// linked into it.
#[derive(Clone, Copy, Debug)]
pub struct Setting {
    /// Id of the setting in stored records; never changes.
    pub id: u8,
    /// Path, such as `window_s` or `array.pitch_mm`.
    pub name: &'static str,
    /// Title of the setting's group.
    pub group: &'static str,
    /// Type.
    pub kind: Kind,
    /// Unit; empty if dimensionless.
    pub unit: &'static str,
    /// Bounds.
    pub bounds: Bounds,
    /// Description: the lines of the row's comment, each with a leading space.
    pub description: &'static str,
    /// Name of the command's option, without the two dashes; empty if there is none.
    pub option: &'static str,
    /// Reason for the bounds, or empty.
    pub reason: &'static str,
    /// Reads the setting.
    pub get: fn(&Settings) -> Value,
    /// Writes the setting. Returns false if the value is not of the setting's type.
    pub set: fn(&mut Settings, Value) -> bool,
}

impl Setting {
    /// Meaning of the setting.
    pub fn sentence(&self) -> &'static str {
        self.description.trim()
    }

    /// Default value.
    pub fn default(&self) -> Value {
        (self.get)(&Settings::DEFAULT)
    }
}

/// Type of a setting.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Any number.
    Number,
    /// A whole number from 0 to 255.
    Whole,
    /// True or false.
    Switch,
    /// A bit per taxel.
    Mask,
    /// Four masks of taxels.
    Masks,
    /// One of these words.
    Word(&'static [&'static str]),
    /// A plan: its name, or its fields.
    Plan,
}

/// Value of a setting.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Value {
    /// A number.
    Number(f32),
    /// A whole number.
    Whole(u8),
    /// True or false.
    Switch(bool),
    /// A bit per taxel.
    Mask(u16),
    /// Four masks of taxels.
    Masks([u16; 4]),
    /// A word.
    Word(&'static str),
    /// A plan.
    Plan(Plan),
}

/// Allowed values. NaN is never allowed.
#[derive(Clone, Copy, Debug)]
pub enum Bounds {
    /// Every value of its type.
    Any,
    /// Values from the first number to the second.
    Between(f32, f32),
    /// Values from the first number to the second, or zero, which switches the setting off.
    ZeroOr(f32, f32),
    /// Values that depend on other settings.
    By(fn(&Settings) -> Limits),
}

/// Minimum and maximum value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    /// Minimum value.
    pub min: f32,
    /// Maximum value.
    pub max: f32,
}

impl Limits {
    /// From `min` to `max`.
    pub const fn new(min: f32, max: f32) -> Self {
        Self { min, max }
    }
}

impl Bounds {
    /// Returns the limits, given the other settings; `None` if every value is allowed.
    pub fn limits(&self, settings: &Settings) -> Option<Limits> {
        match *self {
            Self::Any => None,
            Self::Between(min, max) | Self::ZeroOr(min, max) => Some(Limits::new(min, max)),
            Self::By(limits) => Some(limits(settings)),
        }
    }

    /// Returns the limits that a value violates.
    pub(super) fn broken(&self, value: f32, settings: &Settings) -> Option<Limits> {
        let is_off = matches!(self, Self::ZeroOr(..)) && value == 0.0;
        let limits = self.limits(settings)?;
        let is_within = value >= limits.min && value <= limits.max;
        (!is_off && !is_within).then_some(limits)
    }
}

/// Type of a setting.
pub trait Field: Copy + Serialize + DeserializeOwned {
    /// Kind of value for a PC.
    const KIND: Kind;

    /// Number to compare with the bounds.
    fn number(self) -> f32;

    /// Value for a PC.
    fn value(self) -> Value;

    /// Converts a value from a PC. Returns `None` if the value is not of this type.
    fn of(value: Value) -> Option<Self>;
}

macro_rules! field {
    ($type:ty, $kind:ident, $number:expr) => {
        impl Field for $type {
            const KIND: Kind = Kind::$kind;

            fn number(self) -> f32 {
                let number: fn(Self) -> f32 = $number;
                number(self)
            }

            fn value(self) -> Value {
                Value::$kind(self)
            }

            fn of(value: Value) -> Option<Self> {
                match value {
                    Value::$kind(value) => Some(value),
                    _ => None,
                }
            }
        }
    };
}

field!(f32, Number, |value| value);
field!(u8, Whole, f32::from);
field!(bool, Switch, |value| f32::from(u8::from(value)));
field!(u16, Mask, f32::from);
// The number to check is the mask of the taxels that are in more than one mask: it must be zero.
field!([u16; 4], Masks, |masks| {
    let (_, twice) = masks.iter().fold((0, 0), |(seen, twice), mask| {
        (seen | mask, twice | seen & mask)
    });
    f32::from(twice)
});
// A plan has its own check, `Plan::validate`.
field!(Plan, Plan, |_| 0.0);

/// Declares the groups' structs with their defaults from the table, and passes its rows to
/// [`rows!`].
///
/// A row is `/// sentence`, id, name, type, default, unit, bounds, and optionally the command's
/// option and the reason for the bounds.
macro_rules! settings {
    (
        $(#[$all_doc:meta])*
        $All:ident $all_title:literal {
            $( $(#[doc = $sentence:literal])+
               $id:literal $name:ident: $type:ty = $default:expr, $unit:literal, $bounds:expr
               $(, option $option:literal)? $(, because $reason:literal)?; )+
        }
        $(
            $(#[$group_doc:meta])*
            $group:ident: $Group:ident $title:literal {
                $( $(#[doc = $its_sentence:literal])+
                   $its_id:literal $its_name:ident: $its_type:ty = $its_default:expr,
                   $its_unit:literal, $its_bounds:expr
                   $(, option $its_option:literal)? $(, because $its_reason:literal)?; )+
            }
        )+
    ) => {
        $(#[$all_doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
        pub struct $All {
            $( $(#[doc = $sentence])+ pub $name: $type, )+
            $( $(#[$group_doc])* pub $group: $Group, )+
        }

        impl $All {
            /// The defaults.
            pub const DEFAULT: Self = Self {
                $( $name: $default, )+
                $( $group: $Group::DEFAULT, )+
            };
        }

        $(
            $(#[$group_doc])*
            #[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
            pub struct $Group {
                $( $(#[doc = $its_sentence])+ pub $its_name: $its_type, )+
            }

            impl $Group {
                /// The defaults.
                pub const DEFAULT: Self = Self { $( $its_name: $its_default, )+ };
            }
        )+

        $crate::settings::table::rows! {
            $( $all_title $id, $name, $type, $unit, $bounds,
               [$($option)?], [$($reason)?], [$($sentence)+]; )+
            $( $( $title $its_id, $group.$its_name, $its_type, $its_unit, $its_bounds,
               [$($its_option)?], [$($its_reason)?], [$($its_sentence)+]; )+ )+
        }
    };
}

/// Declares the descriptions, the checks and the stored form from all rows.
macro_rules! rows {
    (
        $( $title:literal $id:literal, $first:ident $(. $more:ident)*, $type:ty, $unit:literal,
           $bounds:expr, [$($option:literal)?], [$($reason:literal)?], [$($sentence:literal)+]; )+
    ) => {
        /// All settings, in the order in which they are checked.
        pub static TABLE: &[Setting] = &[
            $( Setting {
                id: $id,
                name: concat!(stringify!($first) $(, ".", stringify!($more))*),
                group: $title,
                kind: <$type as Field>::KIND,
                unit: $unit,
                bounds: $bounds,
                description: concat!($($sentence),+),
                option: concat!($($option)?),
                reason: concat!($($reason)?),
                get: |settings| Field::value(settings.$first $(. $more)*),
                set: |settings, value| match <$type as Field>::of(value) {
                    Some(value) => {
                        settings.$first $(. $more)* = value;
                        true
                    }
                    None => false,
                },
            }, )+
        ];

        pub(crate) const COUNT: usize = [$($id),+].len();

        /// Names and bounds. Only these are in the firmware: the table itself has every
        /// description.
        const CHECKS: [(&str, Bounds); COUNT] = [
            $( (concat!(stringify!($first) $(, ".", stringify!($more))*), $bounds), )+
        ];

        impl Settings {
            /// Numbers to compare with the bounds, in the order of the table.
            fn numbers(&self) -> [f32; COUNT] {
                [$( Field::number(self.$first $(. $more)*), )+]
            }

            /// Appends every setting to a record. Returns false if it is full.
            pub(crate) fn write(&self, pairs: &mut record::Writer) -> bool {
                $( pairs.push($id, &self.$first $(. $more)*) )&&+
            }

            /// Reads the value of a setting. Returns false if the id is unknown or the value is not
            /// of the setting's type.
            pub(crate) fn read(&mut self, id: u8, value: &[u8]) -> bool {
                match id {
                    $( $id => record::value(value, &mut self.$first $(. $more)*), )+
                    _ => false,
                }
            }
        }
    };
}

pub(super) use {rows, settings};
