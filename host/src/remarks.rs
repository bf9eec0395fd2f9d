//! Remarks on an estimate: advice on its status, and values other than the frequency if they are
//! significant.

use crate::digits::{plus_minus, significant};
use crate::tone::{Domain, Tone, WithSigma};
use ridgetone_proto::telemetry::{Estimate, OtherTone, Status};

/// Standard deviations above which a chirp is shown.
const SIGNIFICANT: f64 = 3.0;

/// Returns advice on a status that depends on the window, short enough for a narrow box.
pub const fn remedy(status: Status) -> Option<&'static str> {
    match status {
        Status::Unsteady => Some("shorten the window, or give the speed"),
        Status::Ambiguous => Some("use a longer window"),
        Status::TooShort => Some("use a longer window, or slide faster"),
        _ => None,
    }
}

/// Returns names and values of significant remarks on the tone's phase modulation and on other
/// tones. The wander is shown only for an unsteady tone, because its standard deviation is at least
/// half its value and so cannot prove that there is any.
pub fn remarks(status: Status, domain: Domain, tone: &Tone) -> Vec<(&'static str, String)> {
    let chirp_unit = match domain {
        Domain::Time => "Hz/s",
        Domain::Position => "/mm2",
    };
    let mut remarks = Vec::new();
    let wander = tone.wander_percent.filter(|wander| *wander > 0.0);
    if let (Status::Unsteady, Some(wander)) = (status, wander) {
        remarks.push(("wander", format!("{} %", significant(wander.into(), 2))));
    }
    if let Some(WithSigma { value, sigma }) = tone.chirp()
        && value.abs() > SIGNIFICANT * sigma
    {
        let found = plus_minus(value, sigma);
        remarks.push(("chirp", format!("{found} {chirp_unit}")));
    }
    if let Some(OtherTone {
        frequency,
        fraction,
    }) = tone.other_tone()
    {
        let frequency = significant(frequency.into(), 4);
        remarks.push((
            "other tone",
            format!(
                "{frequency} {}, {:.0} % of the power",
                domain.unit(),
                100.0 * fraction
            ),
        ));
    }
    remarks
}

pub fn phrases(estimate: &Estimate) -> Vec<String> {
    remarks(estimate.status, Domain::Time, &Tone::from(estimate))
        .into_iter()
        .map(|(name, value)| format!("{name} {value}"))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use ridgetone_proto::telemetry::Movement;

    #[test]
    fn only_what_is_significant_is_shown() {
        let movement = Movement {
            wander: 0.021,
            wander_sigma: 0.013,
            chirp: -0.31,
            chirp_sigma: 0.05,
        };
        let other_tone = Some(OtherTone {
            frequency: 12.3063,
            fraction: 0.42,
        });
        let tone = |domain, movement, other_tone| {
            let frequency = WithSigma {
                value: 8.0,
                sigma: 0.1,
            };
            Tone::new(domain, Some(frequency), movement, other_tone, Some(50.0))
        };
        let shown = |status, domain, movement, other_tone| {
            remarks(status, domain, &tone(domain, movement, other_tone))
                .into_iter()
                .map(|(_, value)| value)
                .collect::<Vec<_>>()
        };
        let moving = |domain| shown(Status::Unsteady, domain, Some(movement), other_tone);
        let in_time = [
            "2.1 %",
            "-0.310 +- 0.050 Hz/s",
            "12.31 Hz, 42 % of the power",
        ];
        assert_eq!(moving(Domain::Time), in_time);
        let by_position = [
            "2.1 %",
            "-0.310 +- 0.050 /mm2",
            "12.31 /mm, 42 % of the power",
        ];
        assert_eq!(moving(Domain::Position), by_position);
        let steady = Movement {
            chirp_sigma: 0.2,
            ..movement
        };
        let none: [&str; 0] = [];
        for movement in [Some(steady), Some(Movement::default()), None] {
            assert_eq!(shown(Status::Good, Domain::Time, movement, None), none);
        }
        let still = shown(
            Status::Unsteady,
            Domain::Time,
            Some(Movement::default()),
            None,
        );
        assert_eq!(still, none, "its amplitude moves");
    }
}
