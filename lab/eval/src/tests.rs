//! Tests of the campaign, and of the committed figures, which must not contain a wrong `good`.

mod emulated_faults;
mod faults;
