//! Entries of the table of settings, and what is derived from them.

use super::Settings;
use crate::plan::Plan;
use serde::Serialize;
use serde::de::DeserializeOwned;

/// A setting as a PC sees it. Firmware never refers to it, so that no description is linked there.
#[derive(Clone, Copy, Debug)]
pub struct Setting {
    /// Id of the setting in stored records; never changes.
    pub id: u8,
    /// Path, such as `window_s` or `array.pitch_mm`.
    pub name: &'static str,
    /// Title of its group.
    pub group: &'static str,
    /// Type.
    pub kind: Kind,
    /// Unit; empty if it has none.
    pub unit: &'static str,
    /// Bounds.
    pub bounds: Bounds,
    /// What it is, in one sentence per line of the table, each with a space before it.
    pub description: &'static str,
    /// Name of the command's option that sets it, without the two dashes; empty if it has none.
    pub option: &'static str,
    /// Reason for the bounds; empty if there is nothing to say.
    pub reason: &'static str,
    /// Reads the setting.
    pub get: fn(&Settings) -> Value,
    /// Writes the setting. False if the value has another type.
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
    /// A bit for each taxel.
    Mask,
    /// Four of them.
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
    /// A bit for each taxel.
    Mask(u16),
    /// Four of them.
    Masks([u16; 4]),
    /// A word.
    Word(&'static str),
    /// A plan.
    Plan(Plan),
}

/// Values that are allowed. NaN never is.
#[derive(Clone, Copy, Debug)]
pub enum Bounds {
    /// Every value of its type.
    Any,
    /// Values from the first to the second one.
    Between(f32, f32),
    /// Values from the first to the second one, or zero, which switches the setting off.
    ZeroOr(f32, f32),
    /// Values that depend on other settings.
    By(fn(&Settings) -> Limits),
}

/// The least and the greatest value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    /// The least value.
    pub min: f32,
    /// The greatest value.
    pub max: f32,
}

impl Limits {
    /// From `min` to `max`.
    pub const fn new(min: f32, max: f32) -> Self {
        Self { min, max }
    }
}

impl Bounds {
    /// The limits next to these other settings; `None` if every value is allowed.
    pub fn limits(&self, settings: &Settings) -> Option<Limits> {
        match *self {
            Self::Any => None,
            Self::Between(min, max) | Self::ZeroOr(min, max) => Some(Limits::new(min, max)),
            Self::By(limits) => Some(limits(settings)),
        }
    }

    /// The limits that a value breaks.
    pub(super) fn broken(&self, value: f32, settings: &Settings) -> Option<Limits> {
        let is_off = matches!(self, Self::ZeroOr(..)) && value == 0.0;
        let limits = self.limits(settings)?;
        let is_within = value >= limits.min && value <= limits.max;
        (!is_off && !is_within).then_some(limits)
    }
}

/// A type that a setting may have.
pub trait Field: Copy + Serialize + DeserializeOwned {
    /// Value as a PC sees it.
    const KIND: Kind;

    /// Reason for the bounds.
    fn number(self) -> f32;

    /// It, for a PC.
    fn value(self) -> Value;

    /// Reads a value from a PC. `None` if it has another type.
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
// The taxels that are in two masks.
field!([u16; 4], Masks, |masks| {
    let (_, twice) = masks.iter().fold((0, 0), |(seen, twice), mask| {
        (seen | mask, twice | seen & mask)
    });
    f32::from(twice)
});
// A plan checks itself.
field!(Plan, Plan, |_| 0.0);

/// Makes the groups' structs with their defaults from the table, and hands its rows to [`rows!`].
///
/// A row is `/// sentence`, id, name, type, default, unit, bounds, and, if there are any, the
/// command's option and the reason for the bounds.
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

/// Makes the descriptions, the checks and the form in flash from all rows.
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

        /// Number of settings.
        pub(crate) const COUNT: usize = [$($id),+].len();

        /// Names and bounds. Firmware has these alone: the table itself has every description.
        const CHECKS: [(&str, Bounds); COUNT] = [
            $( (concat!(stringify!($first) $(, ".", stringify!($more))*), $bounds), )+
        ];

        impl Settings {
            /// What the bounds are for, in the order of the table.
            fn numbers(&self) -> [f32; COUNT] {
                [$( Field::number(self.$first $(. $more)*), )+]
            }

            /// Appends every setting to a record. False if it is full.
            pub(crate) fn write(&self, pairs: &mut record::Writer) -> bool {
                $( pairs.push($id, &self.$first $(. $more)*) )&&+
            }

            /// Reads the value of a setting. False if the id is unknown, or the value of another
            /// type.
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
