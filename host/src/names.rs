//! Words for what the library has enums for, the same in every output.

use ridgetone_proto::boot::{Death, ResetCause, SettingsSource};
use ridgetone_proto::fault::FaultKind;
use ridgetone_proto::telemetry::{Direction, Hold, Span, Status, TravelStatus};

/// Name of a status in JSON and text.
pub fn status_name(status: Status) -> &'static str {
    match status {
        Status::Good => "good",
        Status::NoTone => "no_tone",
        Status::TooShort => "too_short",
        Status::Nothing => "nothing",
        Status::Ambiguous => "ambiguous",
        Status::Doubtful => "doubtful",
    }
}

/// Name of a verdict on period, speed and direction in JSON and text.
pub fn verdict_name(verdict: TravelStatus) -> &'static str {
    match verdict {
        TravelStatus::Nothing => "nothing",
        TravelStatus::Unique => "unique",
        TravelStatus::Ambiguous => "ambiguous",
        TravelStatus::OutOfRange => "out_of_range",
        TravelStatus::Given => "given",
        TravelStatus::Contradicted => "contradicted",
    }
}

/// Name of a direction in JSON and text, if it is known.
pub fn direction_name(direction: Direction) -> Option<&'static str> {
    match direction {
        Direction::Unknown => None,
        Direction::Forward => Some("forward"),
        Direction::Backward => Some("backward"),
    }
}

/// Name of a span in JSON and text.
pub fn span_name(span: Span) -> &'static str {
    match span {
        Span::Window => "window",
        Span::Slide => "slide",
    }
}

/// Name of a hold in JSON.
pub fn hold_name(hold: Hold) -> &'static str {
    match hold {
        Hold::BeforeSlide => "before_slide",
        Hold::AfterSlide => "after_slide",
    }
}

/// Name of a kind of fault in JSON and text.
pub fn fault_name(kind: FaultKind) -> &'static str {
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

/// Name of what a run began with in JSON and text.
pub fn cause_name(cause: ResetCause) -> &'static str {
    match cause {
        ResetCause::Unknown => "unknown",
        ResetCause::Power => "power",
        ResetCause::Pin => "pin",
        ResetCause::Software => "software",
        ResetCause::Watchdog => "watchdog",
    }
}

/// Name of how a run ended in JSON and text.
pub fn death_name(death: Death) -> &'static str {
    match death {
        Death::Panic => "panic",
        Death::HardFault => "hard_fault",
    }
}

/// Name of where settings come from in JSON and text.
pub fn source_name(source: SettingsSource) -> &'static str {
    match source {
        SettingsSource::Default => "default",
        SettingsSource::Stored => "stored",
        SettingsSource::Sent => "sent",
        SettingsSource::Damaged => "damaged",
        SettingsSource::StoredBefore => "stored_before",
    }
}
