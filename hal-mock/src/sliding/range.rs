//! The ranges of a scene's parameters.

/// Maximum magnitude of any parameter, and the reciprocal of the minimum of a positive one. No real
/// object or motion reaches these limits, and products of a few parameters stay finite.
const MAX: f64 = 1e6;

/// Range of a parameter; all have to be finite.
pub(crate) enum Range {
    Any,
    Positive,
    NotNegative,
    Between(f64, f64),
    /// From 0 to a limit, with the limit's expression.
    UpTo(f64, &'static str),
    /// Below a limit, with the limit's expression.
    Below(f64, &'static str),
}

/// Name, value and range of a parameter.
pub(crate) type Rule = (&'static str, f64, Range);

/// Refuses the first parameter that is out of its range.
pub(crate) fn check(rules: &[Rule]) -> Result<(), ParameterError> {
    let broken = rules.iter().find_map(|&(name, value, ref range)| {
        let (fits, expected, limit) = match *range {
            _ if value.is_finite() && value.abs() > MAX => {
                (false, format!("from -{MAX} to {MAX}"), "")
            }
            Range::Any => (true, "a number".into(), ""),
            Range::Positive if value > 0.0 && value < 1.0 / MAX => {
                (false, format!("at least {}", 1.0 / MAX), "")
            }
            Range::Positive => (value > 0.0, "greater than 0".into(), ""),
            Range::NotNegative => (value >= 0.0, "not negative".into(), ""),
            Range::Between(low, high) => (
                (low..=high).contains(&value),
                format!("from {low} to {high}"),
                "",
            ),
            Range::UpTo(limit, what) => (
                (0.0..=limit).contains(&value),
                format!("from 0 to {limit:.4} = {what}"),
                what,
            ),
            Range::Below(limit, what) => {
                (value < limit, format!("less than {limit} = {what}"), what)
            }
        };
        (!(fits && value.is_finite())).then_some(ParameterError {
            name,
            value,
            expected,
            limit,
        })
    });
    broken.map_or(Ok(()), Err)
}

/// A parameter of [`Sliding`](crate::Sliding) that is out of its range.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{name} = {value}: must be finite and {expected}")]
pub struct ParameterError {
    /// Field of [`Sliding`](crate::Sliding) or of a part of it.
    pub name: &'static str,
    /// Value of the parameter.
    pub value: f64,
    expected: String,
    /// Expression of other fields that limits the parameter, or empty.
    limit: &'static str,
}

impl ParameterError {
    /// Fields involved: the one out of range, then those that limit it.
    pub(crate) fn keys(&self) -> impl Iterator<Item = &'static str> {
        [self.name].into_iter().chain(self.limit.split(' '))
    }
}
