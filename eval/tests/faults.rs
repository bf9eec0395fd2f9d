//! Faults injected into the chip, its bus and its lines, with the firmware's task_sim on this PC. The same on the emulated
//! chip, one run of each family, is in `emulated/faults.rs`; a hundred thousand of them are `cargo xtask faults --full`.

use ridgetone_eval::faults::Campaign;
use ridgetone_eval::faults::family::Family;
use ridgetone_eval::faults::judge::Judgement;
use ridgetone_eval::faults::lines;
use ridgetone_eval::faults::row::{Delays, Place, Row};

/// A thousand injections and some: nothing wrong is told as right, nothing is lost silently.
#[test]
fn a_thousand_faults_and_nothing_wrong_is_told_as_right() {
    let campaign = Campaign::on_pc(1100, 1, None).expect("a campaign");
    let injected: usize = campaign.rows.iter().map(|row| row.injected).sum();
    assert!(injected >= 1100, "{injected}");
    for row in &campaign.rows {
        let must_be_zero = [row.wrong, row.wrong_with_doubts, row.silent, row.altered, row.false_alarms];
        assert!(must_be_zero == [0; 5] && row.is_clean(), "{row:?}");
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
        (Family::Input, &[245, 2442, 2933]),
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
    assert_eq!((row.runs, row.injected, row.false_alarms, row.wrong), (30, 0, 0, 0), "{row:?}");
    assert_eq!((row.good_with_doubts, row.doubtful), (0, 0), "{row:?}");
}

/// The document is of a full run of all there is now: `cargo xtask faults --full`.
#[test]
fn the_document_is_whole() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../docs/faults.md");
    let document = std::fs::read_to_string(path).expect("docs/faults.md");
    let injected = document.lines().find_map(|line| line.split_once(" faults injected into ")).expect("a count").0;
    let injected: u64 = injected.replace(',', "").parse().expect("a number");
    assert!(injected >= 100_000, "{injected} injections are no full run: cargo xtask faults --full");
    let has = |row: String| assert!(document.lines().any(|line| line.starts_with(&row)), "no row {row}");
    for family in Family::ALL {
        [Place::Pc, Place::Emulator]
            .iter()
            .for_each(|place| has(format!("| {} | {} |", family.title(), place.title())));
    }
    lines::TITLES.iter().for_each(|title| has(format!("| {title}")));
}

#[test]
fn what_makes_no_sense_is_refused() {
    for (arguments, word) in [
        (&["--injections", "0"][..], "1.."),
        (&["--only", "edges"], "edges_lost"),
        (&["--only", "reset", "--write", "."], "--write"),
    ] {
        let refused = run(&[&["faults"], arguments].concat());
        assert_eq!(refused.status.code(), Some(2), "{arguments:?}");
        assert!(String::from_utf8_lossy(&refused.stderr).contains(word), "{arguments:?}: {refused:?}");
    }
}

/// What is told as lost beyond what was lost, and what is wrong with doubts, is not clean.
#[test]
fn a_row_is_clean_only_if_all_is_zero_that_must_be() {
    let of = |family, verdict: Judgement| Row::of_family(family, Place::Pc, &[(1, verdict)]);
    assert!(of(Family::EdgesLost, Judgement::default()).is_clean());
    assert!(!of(Family::EdgesLost, Judgement { excess: 1, ..Judgement::default() }).is_clean());
    assert!(of(Family::BusCut, Judgement { excess: 1, ..Judgement::default() }).is_clean());
    assert!(!of(Family::BusCut, Judgement { wrong_with_doubts: 1, ..Judgement::default() }).is_clean());
    assert!(!of(Family::BusCut, Judgement { silent: 1, ..Judgement::default() }).is_clean());
}

/// Runs the command with arguments.
fn run(arguments: &[&str]) -> std::process::Output {
    std::process::Command::new(env!("CARGO_BIN_EXE_ridgetone-eval")).args(arguments).output().expect("the command runs")
}
