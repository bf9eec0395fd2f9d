//! Faults injected into the chip, its bus and its lines, with the firmware's rooms on this PC. The same on the emulated
//! chip is in `emulated.rs`; a hundred thousand of them are `cargo xtask faults --full`.

use ridgetone_host::faults::Campaign;
use ridgetone_host::faults::family::Family;

/// A thousand injections and some: nothing wrong is told as right, nothing is lost silently.
#[test]
fn a_thousand_faults_and_nothing_wrong_is_told_as_right() {
    let campaign = Campaign::on_pc(1100, 1, None).expect("a campaign");
    let injected: usize = campaign.rows.iter().map(|row| row.injected).sum();
    assert!(injected >= 1000, "{injected}");
    for row in &campaign.rows {
        assert_eq!((row.wrong, row.wrong_with_doubts), (0, 0), "{row:?}");
        assert_eq!((row.silent, row.altered, row.false_alarms), (0, 0, 0), "{row:?}");
        // All was well again before the next one; in a mixed run that may come at once.
        let is_mixed = row.fault == Family::Mixed.title();
        assert!(is_mixed || row.recovered.is_none_or(|recovered| recovered.count == row.injected), "{row:?}");
        assert!(row.detected.is_none_or(|detected| detected.count == row.injected), "{row:?}");
        assert!(row.good > 0, "{row:?}");
    }
}

/// Without faults nothing is told but what is there: estimates, none in doubt.
#[test]
fn without_faults_there_is_no_doubt() {
    let campaign = Campaign::on_pc(60, 7, Some(Family::None)).expect("a campaign");
    let row = &campaign.rows[0];
    assert_eq!((row.runs, row.injected, row.doubtful, row.false_alarms, row.wrong), (30, 0, 0, 0, 0), "{row:?}");
}
