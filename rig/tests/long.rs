//! Runs of many minutes of virtual time, and counters that wrap.

mod common;

use common::{Run, on_pc, touches_and_tones};
use rig::{Board, ProcessorFault};

#[test]
#[ignore = "needs the boards' images: cargo xtask test --all"]
fn the_counter_may_wrap_while_the_grating_slides() {
    let mut run = Run::sliding(Board::FeatherF405);
    // The firmware waits for the ADC's supply; the slide lasts from 1.5 to 3.5 s of the scene.
    run.run_s(0.1);
    run.rig.inject(ProcessorFault::Microseconds(u32::MAX - 2_500_000));
    run.run_s(6.0);
    let t_us: Vec<u32> = run.rig.readings().iter().map(|reading| reading.t_us).collect();
    assert!(t_us.windows(2).any(|pair| pair[1] < pair[0]), "it wraps");
    run.assert_rules();
    let there = touches_and_tones(&run.events);
    assert!(there.len() > 8, "{there:?}");
    assert_eq!(there, touches_and_tones(&on_pc(&run, 0, None)), "to the bit");
}
