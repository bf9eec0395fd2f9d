//! Tests faults on the emulated chip with the firmware image, one run per family.

use crate::faults::campaign::Campaign;
use crate::faults::family::Family;
use clap::ValueEnum;
use ridgetone_host::emulator::{self, Options};

#[test]
#[ignore = "needs the emulator: cargo xtask test --all"]
fn a_run_of_each_family_of_faults_and_nothing_wrong_is_reported_as_right() {
    let elf = emulator::image::find().expect("an image");
    for family in Family::value_variants() {
        let mut campaign = Campaign {
            seed: 1,
            rows: Vec::new(),
            bit_errors: None,
        };
        campaign
            .on_emulator(1, Some(*family), Options::new(&elf))
            .expect("a run");
        let [row] = &campaign.rows[..] else {
            panic!("{:?}", campaign.rows)
        };
        assert!(row.is_clean(), "{row:?}");
        assert_eq!(row.injected == 0, *family == Family::None, "{row:?}");
        // Every fault must be reported, except that one may hide another in a mixed run.
        let reported = row.detected.map_or(0, |delays| delays.count);
        assert!(
            reported == row.injected || *family == Family::Mixed,
            "{row:?}"
        );
    }
}
