//! How a start goes when something is not as it should be.

mod common;

use common::{BOARDS, Run, hello};
use hal_mock::Constant;
use ridgetone_proto::boot::Oscillator;
use rig::Start;

#[test]
#[ignore = "needs the boards' images: cargo xtask test --all"]
fn the_image_copes_with_what_the_rom_loader_leaves() {
    for board in BOARDS {
        let start = Start { after_rom_loader: true, ..Start::default() };
        let mut run = Run::new(board, Constant::default(), start);
        assert_eq!(run.run_to(1.0, hello).boot.oscillator, Oscillator::External, "{board:?}");
        run.run_s(0.5);
        run.assert_rules();
    }
}

#[test]
#[ignore = "needs the boards' images: cargo xtask test --all"]
fn the_board_greets_without_its_crystal_and_says_so() {
    for board in BOARDS {
        let start = Start { hse_is_dead: true, ..Start::default() };
        let mut run = Run::new(board, Constant::default(), start);
        assert_eq!(run.run_to(1.0, hello).boot.oscillator, Oscillator::Internal, "{board:?}");
        run.run_s(0.5);
        run.assert_rules();
    }
}
