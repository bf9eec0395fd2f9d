//! The trade: that it runs, and that what is told of it is what was measured.

use ridgetone_eval::trade::{Effort, Trade, advice, with_advice};
use std::fs;
use std::path::PathBuf;

fn from_root(path: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("..").join(path)
}

fn read(path: &str) -> String {
    fs::read_to_string(from_root(path)).unwrap_or_else(|error| panic!("{path}: {error}"))
}

#[test]
fn the_least_run_measures_every_choice_and_every_bar() {
    let mut trade = Trade::measure(Effort::Least, None).expect("a run");
    // Six windows of: four harmonics with four channel counts; three other settings in a grating, one in a pure tone;
    // eight baselines in two scenes.
    assert_eq!(trade.rows.len(), 6 * (16 + 4 + 2 * 8));
    assert!(trade.rows.iter().all(|row| row.accuracy.windows > 0));
    // Seven lines of Table 2 have a cycle in 0.2 s, all ten in the other five windows; three noises.
    assert_eq!(trade.bars.cells.len(), 3 * (7 + 5 * 10));
    assert_eq!((trade.verdicts().len(), trade.chip.len()), (6, 0));
    // Of two windows in a setting, too: the fit is near the bound and the peak of a periodogram is not.
    let percent = |method: &str| {
        let row = trade.rows.iter().find(|row| row.method == method && row.window_s == 1.0 && row.channels == 16);
        row.and_then(|row| row.accuracy.error).expect("an error").rms_percent
    };
    assert!(30.0 * percent("Ridgetone") < percent("periodogram"));

    assert!(trade.document().is_err(), "there are no instructions to tell of");
    trade.rows.iter_mut().for_each(|row| row.instructions = Some(168_000));
    let (document, svg) = (trade.document().expect("a document"), trade.svg());
    assert!(document.contains("| 1001.00 | 168,000 | 11.7 |"), "{document}");
    for text in [document, svg] {
        assert!(!text.contains("NaN") && !text.contains("inf") && !text.contains("{{"), "{text}");
    }
}

#[test]
fn the_document_and_its_picture_are_what_their_data_give() {
    let trade = Trade::load(&from_root("docs/trade.json")).expect("the data");
    // `ridgetone bench --render docs` writes them anew after a change of the text, `cargo xtask bench --write` measures.
    assert!(trade.document().expect("a document") == read("docs/trade.md"), "docs/trade.md is not what its data give");
    assert!(trade.svg() == read("docs/trade.svg"), "docs/trade.svg is not what its data give");
}

#[test]
fn the_readme_gives_the_documents_advice() {
    let trade = Trade::load(&from_root("docs/trade.json")).expect("the data");
    let (readme, advice) = (read("README.md"), advice(&trade).expect("advice"));
    assert!(with_advice(&readme, &advice) == Some(readme), "the README does not say: {advice}");
    assert!(read("docs/trade.md").contains(&advice));
}
