//! Figures on the README and in the guide: they follow from the JSON and the pages beside the
//! results. With `RIDGETONE_WRITE=1` tables are written instead of compared.

use super::{read, root};
use ridgetone_host::digits::significant;
use serde_json::Value;
use std::path::Path;

fn tables(topic: &str) -> Value {
    let path = root().join(format!("docs/results/{topic}.json"));
    let figures: Value = serde_json::from_str(&read(&path)).expect("JSON");
    figures["tables"].clone()
}

/// Ridgetone with sixteen channels: a window, the harmonics of the tone, and those that are set.
#[derive(Clone, Copy)]
struct Choice {
    window_s: f64,
    there: u64,
    set: u64,
}

/// What the trade measured of a choice.
struct Measured {
    rms_percent: f64,
    latency_ms: f64,
    instructions: f64,
}

impl Choice {
    fn measured(self, trade: &Value) -> Measured {
        let choices = &trade["choices"];
        let columns = choices["columns"].as_array().expect("columns");
        let column = |name: &str| {
            let place = columns.iter().position(|column| column == name);
            place.unwrap_or_else(|| panic!("no column {name}"))
        };
        let is_it = |row: &&Value| {
            row[column("method")] == "Ridgetone"
                && row[column("window, s")] == self.window_s
                && row[column("harmonics there")] == self.there
                && row[column("set")] == self.set
                && row[column("channels")] == 16
        };
        let row = choices["rows"].as_array().expect("rows").iter();
        let row = row.into_iter().find(is_it).expect("the choice");
        let figure = |name: &str| row[column(name)].as_f64().expect("a figure");
        Measured {
            rms_percent: figure("RMS, %"),
            latency_ms: figure("latency, ms"),
            instructions: figure("instructions"),
        }
    }

    fn cells(self, trade: &Value) -> String {
        let measured = self.measured(trade);
        format!(
            "{} s | {} % | {} s | {} million |",
            self.window_s,
            significant(measured.rms_percent, 2),
            significant(measured.latency_ms / 1e3, 3),
            significant(measured.instructions / 1e6, 2)
        )
    }
}

/// Compares what stands between `<!-- NAME -->` and `<!-- end -->`, or writes it.
fn compare_or_write(page: &Path, name: &str, table: &str) {
    let all = read(page);
    let begin = format!("<!-- {name} -->\n");
    let (before, rest) = all.split_once(&begin).expect("a beginning");
    let (found, after) = rest.split_once("<!-- end -->").expect("an end");
    if std::env::var_os("RIDGETONE_WRITE").is_some() {
        let all = [before, &begin, table, "<!-- end -->", after].concat();
        std::fs::write(page, all).expect("written");
        return;
    }
    let shown = page.display();
    assert!(
        found == table,
        "{shown}: run RIDGETONE_WRITE=1 cargo test -p ridgetone-host --test book figures\n{table}"
    );
}

#[test]
fn the_tables_are_the_trades() {
    let trade = tables("trade");
    let head = "window | RMS error | latency | instructions |\n";
    let rules = "---:|---:|---:|---:|\n";
    let mut table = format!("| scene | set | {head}|---|---|{rules}");
    for (scene, set, choice) in [
        (
            "pure tone",
            "`--harmonics 1`",
            Choice {
                window_s: 1.0,
                there: 1,
                set: 1,
            },
        ),
        (
            "tone with three overtones",
            "the default",
            Choice {
                window_s: 1.0,
                there: 4,
                set: 4,
            },
        ),
        (
            "tone with three overtones",
            "`--window 0.4`",
            Choice {
                window_s: 0.4,
                there: 4,
                set: 4,
            },
        ),
    ] {
        table += &format!("| {scene} | {set} | {}\n", choice.cells(&trade));
    }
    compare_or_write(&root().join("README.md"), "trade", &table);

    let mut table = format!("| {head}|{rules}");
    for window_s in [0.2, 0.4, 1.0, 3.9] {
        let choice = Choice {
            window_s,
            there: 4,
            set: 4,
        };
        table += &format!("| {}\n", choice.cells(&trade));
    }
    let chapter = root().join("docs/guide/3-speed-or-accuracy.md");
    compare_or_write(&chapter, "windows", &table);
}

/// What one harmonic costs where there are four, and four where there is one, over all windows.
#[test]
fn the_sentence_on_harmonics_is_the_trades() {
    let trade = tables("trade");
    let most = |there: u64, set: [u64; 2], of: fn(&Measured) -> f64| {
        [0.2, 0.3, 0.4, 0.6, 1.0, 3.9]
            .map(|window_s| {
                let [a, b] = set.map(|set| {
                    Choice {
                        window_s,
                        there,
                        set,
                    }
                    .measured(&trade)
                });
                of(&a) / of(&b)
            })
            .into_iter()
            .fold(0.0, f64::max)
    };
    let sentence = format!(
        "One where there are four makes the error up to {} times as large; three too many take up to {} times the instructions and cost up to {} % of accuracy.",
        significant(most(4, [1, 4], |m| m.rms_percent), 2),
        significant(most(1, [4, 1], |m| m.instructions), 2),
        (100.0 * (most(1, [4, 1], |m| m.rms_percent) - 1.0)).ceil(),
    );
    let chapter = read(&root().join("docs/guide/3-speed-or-accuracy.md"));
    assert!(chapter.contains(&sentence), "the chapter lacks: {sentence}");
}

/// What the register model adds to a window of the default plan, and how old answers of the fast
/// plans are.
#[test]
fn the_sentence_on_latency_is_the_trades() {
    let plans = tables("trade")["plans"].clone();
    let columns = plans["columns"].as_array().expect("columns");
    let column = |name: &str| columns.iter().position(|column| column == name);
    let place = |name: &str| column(name).unwrap_or_else(|| panic!("no column {name}"));
    let [window, plan, latency] = ["window, ms", "plan", "latency, ms"].map(place);
    let (mut more_ms, mut fast_ms) = (Vec::new(), Vec::new());
    for row in plans["rows"].as_array().expect("rows") {
        let ms = |column: usize| row[column].as_f64().expect("a figure");
        if row[plan] == "`paper`" {
            more_ms.push(ms(latency) - ms(window));
        } else {
            fast_ms.push(ms(latency) / 1e3);
        }
    }
    let least = |values: &[f64]| values.iter().copied().fold(f64::MAX, f64::min);
    let most = |values: &[f64]| values.iter().copied().fold(0.0, f64::max);
    let sentence = format!(
        "takes {:.0} to {:.0} ms longer than its window with the default plan; with fast plans it is there after {} to {} s.",
        least(&more_ms),
        most(&more_ms),
        significant(least(&fast_ms), 2),
        significant(most(&fast_ms), 2),
    );
    let chapter = read(&root().join("docs/guide/3-speed-or-accuracy.md"));
    assert!(chapter.contains(&sentence), "the chapter lacks: {sentence}");
}

/// The cells of a row of a page's table.
fn row<'a>(page: &'a str, name: &str) -> Vec<&'a str> {
    let begins = format!("| {name} |");
    let line = page.lines().find(|line| line.starts_with(&begins));
    let line = line.unwrap_or_else(|| panic!("no row {name}"));
    line.split('|').map(str::trim).collect()
}

#[test]
fn the_readme_says_what_somebody_elses_finger_gave() {
    let real = read(&root().join("docs/results/real.md"));
    let share = |name: &str| {
        let (holds, of) = row(&real, name)[2].split_once(" of ").expect("N of M");
        (holds.to_owned(), of.to_owned())
    };
    let (right, of) = share("right within tolerance");
    let (good, _) = share("good, of those with six cycles");
    let (holds, of_good) = share("interval holds, of the good");
    assert_eq!((&right, &good, &holds), (&of, &of, &of_good), "not all");
    let sentence = format!(
        "of {of} recordings of other people's sensors with a known frequency all {right} fits are within 1 % and `good`, and all {holds} of their 95 % intervals hold it"
    );
    let readme = read(&root().join("README.md"));
    assert!(readme.contains(&sentence), "README.md lacks: {sentence}");
    let cloth = row(
        &real,
        "cloth without a grating, whole and in 1.5 and 3 s: good",
    );
    let (good, of) = cloth[2]
        .trim_matches('*')
        .split_once(" of ")
        .expect("N of M");
    let percent = 100.0 * good.parse::<f64>().unwrap() / of.parse::<f64>().unwrap();
    let sentence = format!(
        "{percent:.0} % of windows of cloth without a grating are `good` instead of {}",
        cloth[4]
    );
    assert!(readme.contains(&sentence), "README.md lacks: {sentence}");
}
