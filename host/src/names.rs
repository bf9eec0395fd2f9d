//! Words for what the library has enums for, the same in every output.

use ridgetone::telemetry::{Direction, Hold, Span, Status, Verdict};

/// Name of a status in JSON and text.
pub fn status_name(status: Status) -> &'static str {
    match status {
        Status::Good => "good",
        Status::NoTone => "no_tone",
        Status::TooShort => "too_short",
        Status::Nothing => "nothing",
        Status::Ambiguous => "ambiguous",
    }
}

/// Name of a verdict on period, speed and direction in JSON and text.
pub fn verdict_name(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::Nothing => "nothing",
        Verdict::Unique => "unique",
        Verdict::Ambiguous => "ambiguous",
        Verdict::OutOfRange => "out_of_range",
        Verdict::Told => "told",
        Verdict::Contradicted => "contradicted",
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
