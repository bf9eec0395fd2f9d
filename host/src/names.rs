//! Words for what the library has enums for, the same in every output.

use ridgetone::telemetry::{Hold, Span, Status};

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
