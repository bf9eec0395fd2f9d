//! Tests of the campaign, and that the committed figures have no wrong `good`.

mod emulated_faults;
mod faults;
