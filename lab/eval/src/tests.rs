//! Tests of the campaign, and of the committed figures, which must have no wrong `good`.

mod emulated_faults;
mod faults;
