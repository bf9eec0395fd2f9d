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
        // Noticed and well again before the next one. Supply, reference and clock are only looked at now and then, and may
        // be right again before; a chip that does not answer is asked after growing pauses.
        let most = |delays: &Option<Delays>, of: usize| delays.is_none_or(|delays| 5 * delays.count >= 4 * of);
        assert!(most(&row.detected, row.injected) && most(&row.recovered, row.injected), "{row:?}");
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
