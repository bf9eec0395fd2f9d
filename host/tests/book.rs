//! Tests the documentation: its commands run or parse, its links are valid, and the wiring and
//! faults that it shows are correct.

mod common;
#[path = "book/facts.rs"]
mod facts;
#[path = "book/links.rs"]
mod links;
#[path = "common/raw_recording.rs"]
mod raw_recording;

use clap::Parser as _;
use common::{directory, file, run, stdout, text};
use pulldown_cmark::{CodeBlockKind, Event as Mark, Parser, Tag, TagEnd};
use ridgetone_host::cli::Cli;
use ridgetone_host::settings_form::change;
use ridgetone_proto::settings::Settings;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// Commands of `ridgetone-teletaction`, whose own tests run the commands of its guide.
const TELETACTION: [&str; 4] = ["touch", "pins", "link", "texture"];

/// Commands that talk to a board unless they get a file or `--emulated`.
const WITH_A_BOARD: [&str; 7] = [
    "check", "command", "monitor", "record", "serve", "settings", "view",
];

/// Commands that run until they are interrupted, and a part of their output.
const ENDLESS: [(&str, &str); 4] = [
    ("emulate --port", "/dev/"),
    ("monitor", " estimate "),
    ("serve", "/ridgetone/left/tone"),
    ("view", "http://127.0.0.1:8321/"),
];

/// Time after which an endless command is interrupted, seconds.
const RUN_S: &str = "15";

const LONGEST_S: &str = "600";

/// Words in commands that take long: they need the emulator, take minutes, or read such output.
const LONG: [&str; 6] = [
    "emulate",
    "--emulated",
    "reproduce",
    "touch.rec",
    "frames.csv",
    "finger.toml",
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

fn pages() -> Vec<PathBuf> {
    let book = fs::read_dir(root().join("docs/guide")).expect("the book");
    let mut pages: Vec<PathBuf> = book.map(|entry| entry.expect("an entry").path()).collect();
    pages.retain(|path| path.extension().is_some_and(|extension| extension == "md"));
    pages.sort();
    pages.insert(0, root().join("README.md"));
    pages
}

/// Documents other than the results and the guide. Code in the crates' READMEs is run by rustdoc.
const MORE: [&str; 8] = [
    "CONTRIBUTING.md",
    "docs/limits.md",
    "hal-mock/README.md",
    "host/python/README.md",
    "host/reference.md",
    "lab/README.md",
    "emulator/README.md",
    "teletaction/README.md",
];

fn documents() -> Vec<PathBuf> {
    let docs = fs::read_dir(root().join("docs/results"))
        .expect("documents")
        .map(|entry| entry.expect("an entry").path());
    docs.filter(|path| path.extension().is_some_and(|extension| extension == "md"))
        .chain(pages())
        .chain(MORE.map(|name| root().join(name)))
        .collect()
}

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

/// Returns the commands of all documents in order, without duplicates: the lines of shell blocks
/// without their comments, and commands in the text unless a longer command begins with them.
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
    // Check longer commands first: a bare name refers to a command that is shown in full elsewhere.
    mentioned.sort_by_key(|command| std::cmp::Reverse(command.len()));
    for command in mentioned {
        if !commands
            .iter()
            .any(|known| *known == command || known.starts_with(&format!("{command} ")))
        {
            commands.push(command);
        }
    }
    assert!(!commands.is_empty());
    commands
}

/// True if a word is `long` or ends with `=` and `long`, such as `left=touch.rec`.
fn is_of(word: &str, long: &str) -> bool {
    word.rsplit('=').next() == Some(long)
}

fn needs_board(words: &[&str]) -> bool {
    let is_file = |word: &&str| word.ends_with(".rec") || word.ends_with(".csv");
    let reads_file = words
        .iter()
        .enumerate()
        .any(|(at, word)| is_file(word) && !["-o", "follow"].contains(&words[at - 1]));
    WITH_A_BOARD.contains(&words[1]) && !reads_file && !words.contains(&"--emulated")
        || words.iter().any(|word| word.contains("/dev/"))
}

/// Command whose report the second chapter shows.
const CHECK: &str = "ridgetone check --emulated --for 10";

/// Asserts that the verdicts shown in the second chapter match the report. Figures may differ.
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

/// True if a command needs the emulator, or a file that needs it.
fn is_long(words: &[&str]) -> bool {
    let is_long = |word: &&str| LONG.iter().any(|long| is_of(word, long));
    words.iter().any(is_long) && !words.contains(&"--print-scene")
}

/// Runs the long or the short `ridgetone` commands in order, in a folder with the files that they
/// need.
fn run_all(long: bool) {
    let folder = directory();
    std::os::unix::fs::symlink(root().join("hal-mock"), folder.path().join("hal-mock"))
        .expect("a link");
    for name in ["recording.csv", "trace.csv"] {
        let path = folder.path().join(name);
        assert!(
            run(&["emulate", "--print-scene", text(&path)])
                .status
                .success()
        );
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
    let rows: String = (0..500)
        .map(|row| format!("{},{}\n", f64::from(row) * 0.02, f64::from(row) * 0.6))
        .collect();
    file(
        folder.path(),
        "robot.csv",
        &format!("time_s,position_mm\n{rows}"),
    );
    // Surfaces with a tone of 100 Hz, and how people rated them.
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
        let scene = hal_mock::Sliding {
            period_mm,
            ..ridgetone_host::input::first_scene().expect("a scene")
        };
        let bytes = raw_recording::of(scene, Settings::DEFAULT);
        fs::write(folder.path().join(format!("{name}.rec")), bytes).expect("a recording");
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
            || needs_board(&words)
            || is_long(&words) != long
        {
            continue;
        }
        let endless = ENDLESS.iter().find(|(name, _)| {
            let mut following = words[1..].iter();
            name.split(' ').all(|word| following.next() == Some(&word))
        });
        // Interrupts once, as Ctrl-C does. Without `--foreground`, the command would be signalled
        // twice.
        let limit = match endless {
            Some(_) => format!("--preserve-status --signal INT {RUN_S}"),
            None => LONGEST_S.to_owned(),
        };
        let shell = format!("timeout --foreground {limit} {command}");
        let output = Command::new("sh")
            .args(["-c", &shell])
            .current_dir(folder.path())
            .env("PATH", &path)
            .stdin(Stdio::null())
            .output()
            .expect("a shell");
        let all = format!("{}{}", stdout(&output), common::stderr(&output));
        assert!(output.status.success(), "{command}: {all}");
        assert!(
            !all.is_empty() || command.contains(" > "),
            "{command} prints nothing"
        );
        if let Some((_, part)) = endless {
            assert!(all.contains(part), "{command}: no \"{part}\" in {all}");
        }
        if command == CHECK {
            assert_shown(&stdout(&output));
        }
        ran += 1;
    }
    assert!(ran > 0, "no page has such a command");
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

/// Board commands of `ridgetone` must use existing options, and settings and values that the board
/// accepts.
#[test]
fn the_commands_with_a_board_parse() {
    let all = commands();
    let with_options = all.iter().filter_map(|command| {
        let words: Vec<&str> = command.split_whitespace().collect();
        // Skip bare names, which refer to commands with arguments.
        (words[0] == "ridgetone" && words.len() > 2 && needs_board(&words)).then_some(words)
    });
    for words in with_options.filter(|words| !TELETACTION.contains(&words[1])) {
        // Skip sinks that are not part of this build.
        let is_feature = words
            .iter()
            .any(|word| ["--foxglove", "--mqtt"].contains(word));
        if let Err(error) = Cli::try_parse_from(&words) {
            assert!(is_feature, "{words:?}: {error}");
        }
        if words[1..].starts_with(&["settings", "set"]) {
            let changes = words.iter().filter(|word| word.contains('='));
            let changes: Vec<String> = changes.map(|word| (*word).to_owned()).collect();
            change(&Settings::DEFAULT, &changes)
                .unwrap_or_else(|error| panic!("{words:?}: {error}"));
        }
    }
}

/// Cargo commands must name existing packages and test programs. A test of xtask parses commands of
/// `cargo xtask`.
#[test]
fn the_commands_of_cargo_name_what_exists() {
    let lock = read(&root().join("Cargo.lock"));
    let folders = [
        "tests",
        "host/tests",
        "crates/finger/examples",
        "crates/tone/tests",
        "emulator/examples",
    ];
    for command in commands() {
        let words: Vec<&str> = command.split_whitespace().collect();
        for pair in words.windows(2).filter(|_| words[0] == "cargo") {
            let [option, name] = pair else { continue };
            let exists = match *option {
                "-p" => lock.contains(&format!("name = \"{name}\"")),
                "--path" => root().join(name).join("Cargo.toml").is_file(),
                "--test" | "--example" => folders.iter().any(|folder| {
                    let path = root().join(folder).join(name);
                    path.join("main.rs").is_file() || path.with_extension("rs").is_file()
                }),
                _ => true,
            };
            assert!(exists, "`{command}`: there is no {name}");
        }
    }
}
