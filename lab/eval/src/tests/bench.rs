//! The benchmark in the emulator. `cargo xtask test` builds its image and runs this.
#![cfg(target_os = "linux")]

use crate::bench;
use std::path::PathBuf;

#[test]
#[ignore = "needs the emulator: cargo xtask test --all"]
fn two_runs_count_the_same() {
    let [elf, baselines] = ["RIDGETONE_BENCH_ELF", "RIDGETONE_BASELINES_ELF"].map(|name| {
        std::env::var_os(name)
            .map(PathBuf::from)
            .unwrap_or_else(|| panic!("{name} names an image"))
    });
    // Each run finds bit for bit what this PC finds, or it is an error.
    let [first, second] =
        [(); 2].map(|()| bench::run(&elf, &baselines, None, 1, 2).expect("a run"));
    assert_eq!(first, second);
    // They did run: a pass over 16 x 241 samples alone is more than this.
    let whole = first
        .fits
        .iter()
        .find(|cell| (cell.channels, cell.frames) == (16, 241))
        .expect("the usual window");
    assert!(
        whole.instructions_worst > 14_300
            && whole.instructions_mean <= f64::from(whole.instructions_worst)
    );
    assert_eq!((first.fit_bars().len(), first.bars.len()), (3 * 4 + 1, 5));
    // Two channels by every method, sixteen by all but one of them, in five lengths of windows of
    // two kinds of scenes.
    assert_eq!(first.baselines.len(), 5 * 2 * (3 + 2));
}
