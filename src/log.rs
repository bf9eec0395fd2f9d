//! The log: a line over RTT for each touch, slide, estimate and fault.

use ridgetone_proto::fault::FaultKind;
use ridgetone_proto::telemetry::{Headline, Status};

pub fn log(headline: Headline) {
    match headline {
        Headline::Contact => defmt::info!("contact"),
        Headline::Slide => defmt::info!("slide"),
        Headline::Stop => defmt::info!("slide over"),
        Headline::Release => defmt::info!("release"),
        Headline::Estimate(hz, sigma_hz, status) if status.has_tone() => {
            defmt::info!(
                "{=f32} +- {=f32} Hz {=str}",
                hz,
                sigma_hz,
                of_status(status)
            );
        }
        Headline::Estimate(_, _, status) => defmt::info!("no frequency: {=str}", of_status(status)),
        Headline::Fault(kind, true) => defmt::info!("fault over: {=str}", of_fault(kind)),
        Headline::Fault(kind, false) => defmt::warn!("fault: {=str}", of_fault(kind)),
    }
}

/// Name of a status, as in all other outputs.
const fn of_status(status: Status) -> &'static str {
    match status {
        Status::Good => "good",
        Status::NoTone => "no_tone",
        Status::TooShort => "too_short",
        Status::Nothing => "nothing",
        Status::Ambiguous => "ambiguous",
        Status::Doubtful => "doubtful",
        Status::Unsteady => "unsteady",
    }
}

/// Name of a fault, as in all other outputs.
const fn of_fault(kind: FaultKind) -> &'static str {
    match kind {
        FaultKind::Lost => "lost",
        FaultKind::Repeated => "repeated",
        FaultKind::Bus => "bus",
        FaultKind::BusDead => "bus_dead",
        FaultKind::Channel => "channel",
        FaultKind::Silent => "silent",
        FaultKind::Storm => "storm",
        FaultKind::Registers => "registers",
        FaultKind::NoAnswer => "no_answer",
        FaultKind::Supply => "supply",
        FaultKind::Reference => "reference",
        FaultKind::Clock => "clock",
        FaultKind::Overload => "overload",
    }
}
