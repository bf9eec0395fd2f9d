//! The README, the book and the other documents: every command in them is run, or is in a list that
//! says what runs it.

mod common;
#[path = "book/facts.rs"]
mod facts;
#[path = "book/figures.rs"]
mod figures;
#[path = "book/links.rs"]
mod links;
#[path = "book/words.rs"]
mod words;

use clap::Parser as _;
use common::{directory, file, run, stdout, text};
use pulldown_cmark::{CodeBlockKind, Event as Mark, Parser, Tag, TagEnd};
use ridgetone_host::cli::Cli;
use ridgetone_host::settings_form::change;
use ridgetone_proto::settings::Settings;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// Commands that need a board. Those of `ridgetone` are run on the emulated one, or on a simulated
/// port, by `emulated.rs`, `listen.rs`, `recordings.rs`, `serve.rs`, `streams.rs` and
/// `view.rs`.
const WITH_A_BOARD: [&str; 23] = [
    "ridgetone serve --finger left=/dev/ttyUSB0 --finger right=emulated --foxglove",
    "ridgetone serve --finger left=/dev/ttyUSB0 --mqtt mqtt://robot.local",
    "ridgetone view --listen 0.0.0.0:8321",
    "ridgetone monitor --raw --json",
    "ridgetone listen --port /dev/ttyUSB0 --raw",
    "ridgetone record --raw -o -",
    "cargo xtask flash",
    "cargo xtask flash --board nucleo-f446re-adc",
    "cargo xtask flash --board stylus-f405",
    "ridgetone check",
    "ridgetone check -o check.txt",
    "ridgetone monitor",
    "ridgetone monitor --odometry -",
    "ridgetone record --for 60 -o touch.rec",
    "ridgetone settings set window_s=0.4 stride_s=0.1 --keep",
    "ridgetone settings set plan=hand",
    "ridgetone settings set plan.inputs=0x00ff plan.data_rate=2",
    "ridgetone settings set vref_v=2.5 --keep",
    "ridgetone command follow speed.csv",
    "stty -F /dev/ttyUSB0 921600 raw && python3 reader.py < /dev/ttyUSB0",
    "dfu-util -a 0 -s :leave -D target/release-images/ridgetone-0.2.0-feather-f405.dfu",
    "probe-rs attach --no-catch-reset --no-catch-hardfault --chip STM32F405RGTx target/firmware/feather-f405/ridgetone-firmware.elf",
    "probe-rs attach --no-catch-reset --no-catch-hardfault --chip STM32F446RETx target/firmware/nucleo-f446re/ridgetone-firmware.elf",
];

/// Commands that take too long for a test, each with the test that covers a short form of it.
const LITTLE_OF: [(&str, &str); 32] = [
    (
        "cargo run -p ridgetone-finger --example plain_frames",
        "crates/finger/tests/plain_frames.rs",
    ),
    ("cargo xtask worklet", "teletaction/tests/touch/page.rs"),
    (
        "cargo xtask bench --converters",
        "lab/eval/src/trade/converters.rs",
    ),
    (
        "cargo xtask distance --write",
        "lab/eval/src/tests/distance.rs",
    ),
    (
        "cargo install --path host --features foxglove,mqtt",
        "host/tests/streams.rs",
    ),
    ("cargo xtask soak --write", "host/tests/streams/soak.rs"),
    (
        "cargo xtask streams --fingers 100 --write",
        "host/tests/fingers.rs",
    ),
    ("cargo xtask pictures", "host/tests/view/page.rs"),
    (
        "cargo test -p ridgetone-host --test view -- --ignored",
        "xtask/src/test.rs",
    ),
    (
        "pip install ./host/python",
        "host/python/tests/test_same.py",
    ),
    (
        "pip install ./host/python pylsl",
        "host/python/tests/test_lsl.py",
    ),
    (
        "python host/python/lsl.py left /dev/ttyUSB0",
        "host/python/tests/test_lsl.py",
    ),
    ("cargo xtask board --write", "lab/eval/src/tests/board.rs"),
    ("cargo xtask bench --write", "lab/eval/src/tests/bench.rs"),
    ("cargo xtask bench --chip", "lab/eval/src/tests/bench.rs"),
    (
        "cargo xtask bench --plans",
        "lab/eval/src/trade/plans/tests.rs",
    ),
    ("cargo xtask faults --full", "lab/eval/src/tests/faults.rs"),
    (
        "cargo xtask faults --plan hand,texture,vibration,single --seed 777001 --injections 1000 --write docs/results",
        "lab/eval/src/tests/faults.rs",
    ),
    ("cargo xtask noise --write", "lab/eval/src/noise.rs"),
    ("cargo xtask touch --write", "lab/eval/src/touch.rs"),
    (
        "cargo xtask reproduce --wavelengths",
        "lab/eval/src/reproduce/okamoto.rs",
    ),
    ("cargo xtask papers --write", "xtask/src/long.rs"),
    ("cargo xtask events", "xtask/src/events.rs"),
    (
        "cargo xtask settings",
        "host/src/settings_form/generated.rs",
    ),
    ("cargo xtask real FOLDER", "lab/eval/src/real.rs"),
    ("cargo xtask noise --seed 1", "lab/eval/src/noise.rs"),
    (
        "cargo test -p ridgetone-host --lib check::tests::conversation",
        "xtask/src/test.rs",
    ),
    ("cargo xtask test --fresh", "xtask/src/fresh.rs"),
    ("cargo test -p ridgetone-tone", "xtask/src/test.rs"),
    ("cargo test -p ridgetone-emulator", "xtask/src/test.rs"),
    (
        "cargo test -p ridgetone-firmware --test path",
        "xtask/src/test.rs",
    ),
    (
        "cargo test -p ridgetone-firmware --test estimator --test extremes",
        "xtask/src/test.rs",
    ),
];

/// Commands of `ridgetone-teletaction`: its own tests run those of its guide.
const TELETACTION: [&str; 4] = ["touch", "pins", "link", "texture"];

/// Words that mark a command as one that needs the emulator, minutes, or a file that another of
/// these has written.
const LONG: [&str; 6] = [
    "emulate",
    "--emulated",
    "reproduce",
    "touch.rec",
    "frames.csv",
    "finger.toml",
];

/// Commands that go on until somebody interrupts them, for how long they may, seconds, and what
/// they say by then.
const ENDLESS: [(&str, &str, &str); 4] = [
    ("ridgetone monitor --emulated", "15", " estimate "),
    ("ridgetone view --emulated", "4", "http://127.0.0.1:8321/"),
    (
        "ridgetone view recording.csv",
        "4",
        "http://127.0.0.1:8321/",
    ),
    (
        "ridgetone serve --finger left=touch.rec --json",
        "15",
        "/ridgetone/left/tone",
    ),
];

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("..")
        .canonicalize()
        .expect("the workspace")
}

fn read(path: &Path) -> String {
    fs::read_to_string(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// The README and the chapters of the guide.
fn pages() -> Vec<PathBuf> {
    let book = fs::read_dir(root().join("docs/guide")).expect("the book");
    let mut pages: Vec<PathBuf> = book.map(|entry| entry.expect("an entry").path()).collect();
    pages.retain(|path| path.extension().is_some_and(|extension| extension == "md"));
    pages.sort();
    pages.insert(0, root().join("README.md"));
    pages
}

/// Documents besides the results and the guide. The crates' READMEs are documentation of Rust, whose
/// code runs as such.
const MORE: [&str; 7] = [
    "CONTRIBUTING.md",
    "hal-mock/README.md",
    "host/python/README.md",
    "host/reference.md",
    "emulator/README.md",
    "teletaction/README.md",
    "teletaction/stimulus/README.md",
];

/// The results, the guide, the READMEs and [`MORE`].
fn documents() -> Vec<PathBuf> {
    let docs = fs::read_dir(root().join("docs/results"))
        .expect("documents")
        .map(|entry| entry.expect("an entry").path());
    docs.filter(|path| path.extension().is_some_and(|extension| extension == "md"))
        .chain(pages())
        .chain(MORE.map(|name| root().join(name)))
        .collect()
}

/// The code blocks of a page in one language.
fn blocks(page: &str, language: &str) -> Vec<String> {
    let (mut blocks, mut inside) = (Vec::new(), false);
    for mark in Parser::new(page) {
        match mark {
            Mark::Start(Tag::CodeBlock(CodeBlockKind::Fenced(name))) if &*name == language => {
                inside = true;
                blocks.push(String::new());
            }
            Mark::End(TagEnd::CodeBlock) => inside = false,
            Mark::Text(text) if inside => blocks.last_mut().expect("begun").push_str(&text),
            _ => {}
        }
    }
    blocks
}

/// The commands in a page's text.
fn mentioned(page: &str) -> Vec<String> {
    let ours = |text: &str| {
        ["ridgetone ", "cargo "]
            .iter()
            .any(|name| text.starts_with(name))
    };
    let code = |mark| {
        if let Mark::Code(text) = mark {
            Some(text.to_string())
        } else {
            None
        }
    };
    Parser::new(page)
        .filter_map(code)
        .filter(|text| ours(text))
        .collect()
}

/// The commands of all documents, each once, as they follow: lines of blocks of the shell, without
/// the comments behind them, and those in the text that are not the beginning of another.
fn commands() -> Vec<String> {
    let mut commands: Vec<String> = Vec::new();
    let documents: Vec<String> = documents().iter().map(|path| read(path)).collect();
    for line in documents
        .iter()
        .flat_map(|page| blocks(page, "sh"))
        .collect::<Vec<_>>()
        .join("\n")
        .lines()
    {
        let command = line.split(" #").next().unwrap_or_default().trim();
        if !command.is_empty()
            && !command.starts_with('#')
            && !commands.iter().any(|known| known == command)
        {
            commands.push(command.to_owned());
        }
    }
    let mut mentioned: Vec<String> = documents.iter().flat_map(|page| mentioned(page)).collect();
    // Longer commands first: a name alone stands for a command that is shown in full elsewhere.
    mentioned.sort_by_key(|command| std::cmp::Reverse(command.len()));
    for command in mentioned {
        if !commands
            .iter()
            .any(|known| *known == command || known.starts_with(&format!("{command} ")))
        {
            commands.push(command);
        }
    }
    assert!(commands.len() > 25, "{commands:?}");
    commands
}

/// Whether a word of a command is this one, or gives an option it, as `left=touch.rec` does.
fn is_of(word: &str, long: &str) -> bool {
    word.rsplit('=').next() == Some(long)
}

/// Whether something else than these tests, or than the script of CI, runs a command, or nothing
/// can.
fn is_elsewhere(command: &str) -> bool {
    WITH_A_BOARD.contains(&command) || LITTLE_OF.iter().any(|(long, _)| *long == command)
}

/// The command whose report is shown in the second chapter.
const CHECK: &str = "ridgetone check --emulated --for 10";

/// The verdicts in the second chapter are those of the report; figures may differ a little.
fn assert_shown(report: &str) {
    let page = read(&root().join("docs/guide/2-build.md"));
    let [shown] = &blocks(&page, "text")[..] else {
        panic!("one report")
    };
    let verdict = |line: &str| {
        let words: Vec<String> = line.split_whitespace().map(str::to_owned).collect();
        [words.first().cloned(), words.get(1).cloned()]
    };
    let reported: Vec<_> = report.lines().map(verdict).collect();
    for line in shown.lines().filter(|line| *line != "...") {
        assert!(reported.contains(&verdict(line)), "{line}\n{report}");
    }
}

/// Runs the `ridgetone` commands, the long ones or the others, one after the other in a folder that
/// has the files that they speak of.
fn run_all(long: bool) {
    let folder = directory();
    std::os::unix::fs::symlink(root().join("hal-mock"), folder.path().join("hal-mock"))
        .expect("a link");
    for name in ["recording.csv", "trace.csv"] {
        let path = folder.path().join(name);
        assert!(run(&["scene", "-o", text(&path)]).status.success());
    }
    let (mut by_hand, mut place_mm) = (String::from("time_s,a,v_mm_s\n"), 0.0_f64);
    for row in 0..500 {
        let speed_mm_s = 30.0 + f64::from(row) / 25.0;
        place_mm += speed_mm_s / 500.0;
        let a = (std::f64::consts::TAU * place_mm / 2.5).cos();
        by_hand += &format!("{:.4},{a:.6},{speed_mm_s:.6}\n", f64::from(row) / 500.0);
    }
    file(folder.path(), "by_hand.csv", &by_hand);
    file(
        folder.path(),
        "speed.csv",
        "time_s,speed_mm_s\n0,30\n4,30\n",
    );
    let rows: String = (0..200)
        .map(|row| format!("{},{}\n", f64::from(row) * 0.02, f64::from(row) * 0.6))
        .collect();
    file(
        folder.path(),
        "robot.csv",
        &format!("time_s,place_mm\n{rows}"),
    );
    // Surfaces with a tone of 100 Hz, and what people say of them.
    let mut scores = String::from("file,soft,m\n");
    for (number, name) in ["smooth.csv", "vibration.csv", "third.csv", "fourth.csv"]
        .into_iter()
        .enumerate()
    {
        let sample =
            |row: i32| (1 + number) as f64 * (std::f64::consts::TAU * f64::from(row) / 100.0).sin();
        let rows: Vec<String> = (0..20_000)
            .map(|row| format!("{:.6}", sample(row)))
            .collect();
        file(folder.path(), name, &format!("a\n{}\n", rows.join("\n")));
        scores += &format!("{name},{},{}\n", 6 - number, 1 + number);
    }
    file(folder.path(), "scores.csv", &scores);
    // Gratings of known period under the physical finger.
    for (name, period_mm) in [("a", 2.5), ("b", 3.0), ("c", 4.0)] {
        let scene = file(
            folder.path(),
            &format!("{name}.toml"),
            &format!("period_mm = {period_mm}\nspeed_mm_s = 15\n"),
        );
        let path = folder.path().join(format!("{name}.csv"));
        assert!(
            run(&["scene", "--scene", text(&scene), "-o", text(&path)])
                .status
                .success()
        );
    }
    let binary = Path::new(env!("CARGO_BIN_EXE_ridgetone"))
        .parent()
        .expect("a folder");
    let path = format!(
        "{}:{}",
        text(binary),
        std::env::var("PATH").expect("a path")
    );

    let mut ran = 0;
    for command in commands() {
        let words: Vec<&str> = command.split_whitespace().collect();
        if words[0] != "ridgetone"
            || TELETACTION.contains(&words[1])
            || is_elsewhere(&command)
            || words
                .iter()
                .any(|word| LONG.iter().any(|long| is_of(word, long)))
                != long
        {
            continue;
        }
        // Interrupted as Ctrl-C does, once; without `--foreground` it would be twice.
        let endless = ENDLESS.iter().find(|(endless, ..)| *endless == command);
        let shell = endless.map_or(command.clone(), |(_, s, _)| {
            format!("timeout --foreground --preserve-status --signal INT {s} {command}")
        });
        let output = Command::new("sh")
            .args(["-c", &shell])
            .current_dir(folder.path())
            .env("PATH", &path)
            .stdin(Stdio::null())
            .output()
            .expect("a shell");
        assert!(
            output.status.success(),
            "{command}: {}",
            common::stderr(&output)
        );
        let says =
            !output.stdout.is_empty() || !output.stderr.is_empty() || command.contains(" > ");
        assert!(says, "{command} says nothing");
        if let Some((_, s, word)) = endless {
            let all = format!("{}{}", stdout(&output), common::stderr(&output));
            assert!(
                all.contains(word),
                "{command} does not say \"{word}\" within {s} s"
            );
        }
        if command == CHECK {
            assert_shown(&stdout(&output));
        }
        ran += 1;
    }
    assert!(ran > 6, "{ran} commands");
}

#[test]
fn the_commands_of_readme_and_book_run() {
    run_all(false);
}

#[test]
#[ignore = "needs the emulator: cargo xtask test"]
fn the_commands_that_take_long_run() {
    run_all(true);
}

#[test]
fn every_other_command_is_run_by_ci_or_needs_a_board() {
    let ci = read(&root().join(".ci/run"));
    let ci: Vec<&str> = ci.lines().map(str::trim).collect();
    let all = commands();
    for command in all
        .iter()
        .filter(|command| !command.starts_with("ridgetone "))
    {
        let run_by_ci = ci
            .iter()
            .any(|line| *line == command || line.starts_with(&format!("{command} ")));
        assert!(
            run_by_ci || is_elsewhere(command),
            "nothing runs `{command}`"
        );
    }
    for command in WITH_A_BOARD
        .into_iter()
        .chain(LITTLE_OF.map(|(long, _)| long))
    {
        assert!(
            all.iter().any(|known| known == command),
            "no page has `{command}` any more"
        );
    }
    for (_, test) in LITTLE_OF {
        assert!(root().join(test).is_file(), "{test}");
    }
}

/// What needs a board is at least understood: its options exist, and so do the settings and values
/// that it sends.
#[test]
fn the_commands_with_a_board_are_understood() {
    let mut sent = 0;
    for command in WITH_A_BOARD {
        let words: Vec<&str> = command.split_whitespace().collect();
        if words[0] != "ridgetone" {
            continue;
        }
        // Receivers that this build was not made with.
        let is_feature = words
            .iter()
            .any(|word| ["--foxglove", "--mqtt"].contains(word));
        if let Err(error) = Cli::try_parse_from(&words) {
            assert!(is_feature, "{command}: {error}");
        }
        if words[1..].starts_with(&["settings", "set"]) {
            let changes = words.iter().filter(|word| word.contains('='));
            let changes: Vec<String> = changes.map(|word| (*word).to_owned()).collect();
            change(&Settings::DEFAULT, &changes)
                .unwrap_or_else(|error| panic!("{command}: {error}"));
            sent += 1;
        }
    }
    assert!(sent > 3, "{sent}");
}
