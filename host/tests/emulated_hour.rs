//! An hour and a quarter of virtual time on the emulated chip: the board's microseconds wrap in it.
//! Takes long, so nothing runs it but you: `cargo test -p ridgetone-host --test emulated_hour --
//! --ignored --nocapture`, after `cargo xtask firmware`.
#![cfg(target_os = "linux")]

#[path = "common/steady.rs"]
mod steady;

#[test]
#[ignore = "75 minutes of virtual time"]
fn an_hour_and_a_quarter_of_touches_is_as_right_at_its_end_as_at_its_beginning() {
    steady::run(4500.0, true);
}
