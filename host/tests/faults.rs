//! Faults injected into the chip, its bus and its lines, with the firmware's rooms on this PC. The same on the emulated
//! chip is in `emulated.rs`; a hundred thousand of them are `cargo xtask faults --full`.

use ridgetone_host::faults::Campaign;
use ridgetone_host::faults::family::Family;
use ridgetone_host::faults::row::Delays;

/// A thousand injections and some: nothing wrong is told as right, nothing is lost silently.
#[test]
fn a_thousand_faults_and_nothing_wrong_is_told_as_right() {
    let campaign = Campaign::on_pc(1100, 1, None).expect("a campaign");
    let injected: usize = campaign.rows.iter().map(|row| row.injected).sum();
    assert!(injected >= 1000, "{injected}");
    for row in &campaign.rows {
        let must_be_zero = (row.wrong, row.silent, row.altered, row.false_alarms);
        assert_eq!(must_be_zero, (0, 0, 0, 0), "{row:?}");
        // Noticed, every single one; in a mixed run one fault may hide another.
        let mixed = row.fault == Family::Mixed.title();
        let told = row.detected.map_or(0, |delays: Delays| delays.count);
        assert!(if mixed { 10 * told >= 9 * row.injected } else { told == row.injected }, "{row:?}");
        // Well again before the next one; a chip that does not answer is asked after growing pauses.
        assert!(row.recovered.is_none_or(|delays| 5 * delays.count >= 4 * row.injected), "{row:?}");
        assert!(row.good > 0, "{row:?}");
    }
}

/// Runs that once told something wrong as right, lost conversions silently, or kept a fault to themselves.
#[test]
fn what_once_went_wrong_does_not() {
    for (family, seeds) in [
        (Family::Reset, &[101, 155, 157][..]),
        (Family::RegisterFlip, &[74, 79, 95, 170]),
        (Family::DoutStuck, &[55, 76]),
        (Family::Reference, &[251]),
        (Family::DrdyStuck, &[28, 49, 50, 144]),
        (Family::Storm, &[2, 188]),
        (Family::Mixed, &[21, 48, 940]),
    ] {
        for seed in seeds {
            let row = &Campaign::on_pc(1, *seed, Some(family)).expect("a campaign").rows[0];
            let wrong = row.wrong + row.wrong_with_doubts;
            assert_eq!((row.runs, wrong, row.silent, row.altered), (1, 0, 0, 0), "{row:?}");
            let told = row.detected.map_or(0, |delays| delays.count);
            assert!(told == row.injected || family == Family::Mixed, "{row:?}");
        }
    }
}

/// Without faults nothing is told but what is there: estimates, none in doubt.
#[test]
fn without_faults_there_is_no_doubt() {
    let campaign = Campaign::on_pc(60, 7, Some(Family::None)).expect("a campaign");
    let row = &campaign.rows[0];
    assert_eq!((row.runs, row.injected, row.doubtful, row.false_alarms, row.wrong), (30, 0, 0, 0, 0), "{row:?}");
}
