//! What people read about an estimate besides its frequency: what to do about its status, and which
//! of its movement and of its companions are significant.

use crate::digits::{decimals, significant};
use crate::tone::Beside;
use ridgetone_proto::telemetry::{Abscissa, Estimate, Movement, OtherTone, Status};

/// Standard deviations from which on a chirp is shown.
const SIGNIFICANT: f32 = 3.0;

/// What to do about a status that depends on the window; few words, for a narrow box.
pub const fn remedy(status: Status) -> Option<&'static str> {
    match status {
        Status::Unsteady => Some("shorten the window, give the speed, or add one harmonic"),
        Status::Ambiguous => Some("use a longer window"),
        Status::TooShort => Some("use a longer window, or slide faster"),
        _ => None,
    }
}

/// Significant remarks on the movement and on what is beside the tone: names and values. The wander
/// is shown only for an unsteady tone: its standard deviation is at least half of it, and so does
/// not say whether it is there.
pub fn remarks(status: Status, abscissa: Abscissa, beside: &Beside) -> Vec<(&'static str, String)> {
    let (unit, chirp_unit) = match abscissa {
        Abscissa::Time => ("Hz", "Hz/s"),
        Abscissa::Place => ("/mm", "/mm2"),
    };
    let mut remarks = Vec::new();
    let Movement {
        wander,
        chirp,
        chirp_sigma,
        ..
    } = beside.movement.unwrap_or_default();
    if status == Status::Unsteady && wander > 0.0 {
        remarks.push((
            "wander",
            format!("{} %", significant(100.0 * f64::from(wander), 2)),
        ));
    }
    if chirp.abs() > SIGNIFICANT * chirp_sigma {
        let places = decimals(chirp_sigma.into(), 2);
        remarks.push((
            "chirp",
            format!("{chirp:.places$} +- {chirp_sigma:.places$} {chirp_unit}"),
        ));
    }
    if let Some(OtherTone { frequency, share }) = beside.other_tone {
        let frequency = significant(frequency.into(), 4);
        remarks.push((
            "other tone",
            format!("{frequency} {unit}, {:.0} % of the power", 100.0 * share),
        ));
    }
    remarks
}

/// Remarks on an estimate as phrases.
pub fn phrases(estimate: &Estimate) -> Vec<String> {
    let remarks = remarks(estimate.status, estimate.abscissa, &estimate.into()).into_iter();
    remarks
        .map(|(name, value)| format!("{name} {value}"))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_is_significant_is_shown() {
        let movement = Movement {
            wander: 0.021,
            wander_sigma: 0.013,
            sigma_mean: 0.1,
            chirp: -0.31,
            chirp_sigma: 0.05,
        };
        let other_tone = Some(OtherTone {
            frequency: 12.3063,
            share: 0.42,
        });
        let moving = Beside {
            movement: Some(movement),
            other_tone,
            interferer_hz: Some(50.0),
        };
        let shown = |abscissa, beside| {
            remarks(Status::Unsteady, abscissa, beside)
                .into_iter()
                .map(|(_, value)| value)
                .collect::<Vec<_>>()
        };
        let in_time = ["2.1 %", "-0.31 +- 0.05 Hz/s", "12.31 Hz, 42 % of the power"];
        assert_eq!(shown(Abscissa::Time, &moving), in_time);
        let by_place = [
            "2.1 %",
            "-0.31 +- 0.05 /mm2",
            "12.31 /mm, 42 % of the power",
        ];
        assert_eq!(shown(Abscissa::Place, &moving), by_place);
        let steady = Movement {
            chirp_sigma: 0.2,
            ..movement
        };
        for movement in [Some(steady), Some(Movement::default()), None] {
            assert_eq!(
                remarks(
                    Status::Good,
                    Abscissa::Time,
                    &Beside {
                        movement,
                        ..Beside::default()
                    }
                ),
                []
            );
        }
        let beside = Beside {
            movement: Some(Movement::default()),
            ..Beside::default()
        };
        assert_eq!(
            remarks(Status::Unsteady, Abscissa::Time, &beside),
            [],
            "its amplitude moves"
        );
    }
}
