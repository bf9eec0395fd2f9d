//! The README, the book and the other documents: every command in them is run, or is in a list that says what runs it; every
//! link leads somewhere; the wiring is the firmware's; the reader in Python reads.

mod common;

use common::{directory, file, json_lines, run, stdout, text};
use pulldown_cmark::{CodeBlockKind, Event as Mark, Parser, Tag, TagEnd};
use ridgetone_host::input::{Input, Source};
use ridgetone_host::names;
use ridgetone_host::replay;
use ridgetone_proto::fault::FaultKind;
use ridgetone_proto::settings::Settings;
use ridgetone_proto::telemetry::{Packet, WIRE_MAX, encode};
use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// Commands that need a board. Those of `ridgetone` are run on the emulated one, or on a simulated port, by `emulated.rs`,
/// `link.rs`, `listen.rs`, `recordings.rs`, `serve.rs`, `streams.rs` and `view.rs`.
const WITH_A_BOARD: [&str; 26] = [
    "ridgetone link --finger /dev/ttyUSB0 --stylus /dev/ttyUSB1",
    "ridgetone link --finger udp:robot.local:7450 --stylus /dev/ttyUSB0",
    "ridgetone link --finger /dev/ttyUSB0 --stylus udp:0.0.0.0:7450",
    "ridgetone link --finger udp:robot.local:7450",
    "ridgetone serve --finger left=/dev/ttyUSB0 --finger right=emulated --foxglove",
    "ridgetone serve --finger left=/dev/ttyUSB0 --mqtt mqtt://robot.local",
    "ridgetone view --listen 0.0.0.0:8321",
    "ridgetone monitor --raw --json",
    "ridgetone listen --raw",
    "ridgetone record --raw -o -",
    "cargo xtask flash",
    "ridgetone check",
    "ridgetone check -o check.txt",
    "ridgetone monitor",
    "ridgetone monitor --odometry -",
    "ridgetone record --for 60 -o touch.rec",
    "ridgetone settings set window_s=0.4 hop_s=0.1 --keep",
    "ridgetone settings set plan=hand",
    "ridgetone settings set plan.inputs=0x00ff plan.data_rate=2",
    "ridgetone settings set vref_v=2.5 --keep",
    "ridgetone command follow speed.csv",
    "ridgetone listen --port /dev/ttyUSB0",
    "stty -F /dev/ttyUSB0 921600 raw && python3 reader.py < /dev/ttyUSB0",
    "dfu-util -a 0 -s :leave -D target/release-images/ridgetone-0.1.0-feather-f405.dfu",
    "probe-rs attach --no-catch-reset --no-catch-hardfault --chip STM32F405RGTx target/firmware/feather-f405/ridgetone-firmware.elf",
    "probe-rs attach --no-catch-reset --no-catch-hardfault --chip STM32F446RETx target/firmware/nucleo-f446re/ridgetone-firmware.elf",
];

/// Commands that take too long for a test, and the test that does a little of the same.
const LITTLE_OF: [(&str, &str); 27] = [
    ("cargo xtask worklet", "host/tests/touch/page.rs"),
    ("cargo xtask distance --chip", "eval/src/tests/distance.rs"),
    ("cargo xtask distance --write docs", "eval/src/tests/distance.rs"),
    ("cargo install --path host --features foxglove,mqtt", "host/tests/streams.rs"),
    ("cargo xtask streams", "host/tests/streams.rs"),
    ("ridgetone serve --finger left=touch.rec --json", "host/tests/serve.rs"),
    ("cargo xtask pictures", "host/tests/view/page.rs"),
    ("cargo test -p ridgetone-host --test view -- --ignored", "xtask/src/test.rs"),
    ("pip install ./python", "python/tests/test_same.py"),
    ("pip install ./python pylsl", "python/tests/test_lsl.py"),
    ("python python/lsl.py left /dev/ttyUSB0", "python/tests/test_lsl.py"),
    ("cargo xtask board --write", "eval/src/tests/board.rs"),
    ("cargo xtask bench --write", "eval/src/tests/bench.rs"),
    ("cargo xtask bench --chip", "eval/src/tests/bench.rs"),
    ("cargo xtask bench --plans", "eval/src/trade/plans/tests.rs"),
    ("cargo xtask bench --render", "eval/src/tests/trade.rs"),
    ("cargo xtask faults --full", "eval/src/tests/faults.rs"),
    ("cargo xtask faults --plan hand --seed 777001 --injections 1000 --write docs", "eval/src/tests/faults.rs"),
    ("cargo xtask noise --seed 1", "eval/src/tests/noise.rs"),
    ("cargo xtask noise --write docs", "eval/src/tests/noise.rs"),
    ("cargo xtask touch --write docs", "eval/src/tests/touch.rs"),
    ("cargo xtask reproduce --wavelengths", "eval/src/reproduce/okamoto.rs"),
    ("cargo +nightly fuzz run settings", "tests/extremes/settings.rs"),
    ("cargo test --workspace", "xtask/src/test.rs"),
    ("cargo test -p ridgetone-tone", "xtask/src/test.rs"),
    ("cargo test -p ridgetone-firmware --test path", "xtask/src/test.rs"),
    ("cargo test -p ridgetone-firmware --test estimator --test extremes", "xtask/src/test.rs"),
];

/// What a command that needs the emulator, or minutes, or what another of these has written, has one of.
const LONG: [&str; 6] = ["emulate", "--emulated", "reproduce", "touch.rec", "frames.csv", "finger.toml"];

/// Commands that go on until somebody interrupts them, for how long they may, seconds, and what they say by then.
const ENDLESS: [(&str, &str, &str); 6] = [
    ("ridgetone link --emulated --delay-ms 120 --jitter-ms 40 --loss 5%", "4", " received, "),
    ("ridgetone monitor --emulated", "15", " estimate "),
    ("ridgetone pins --emulated", "15", " sensor "),
    ("ridgetone pins --emulated --page", "4", "http://127.0.0.1:8323/"),
    ("ridgetone touch --emulated", "4", "http://127.0.0.1:8322/"),
    ("ridgetone view --emulated", "4", "http://127.0.0.1:8321/"),
];

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..").canonicalize().expect("the workspace")
}

fn read(path: &Path) -> String {
    fs::read_to_string(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// The README and the pages of the book.
fn pages() -> Vec<PathBuf> {
    let book = fs::read_dir(root().join("docs/book")).expect("the book");
    let mut pages: Vec<PathBuf> = book.map(|entry| entry.expect("an entry").path()).collect();
    pages.retain(|path| path.extension().is_some_and(|extension| extension == "md"));
    assert!((1..=12).contains(&pages.len()), "at most twelve short pages: {pages:?}");
    pages.sort();
    pages.insert(0, root().join("README.md"));
    pages
}

/// All of `docs/`, the book and the README.
fn documents() -> Vec<PathBuf> {
    let docs = fs::read_dir(root().join("docs")).expect("documents").map(|entry| entry.expect("an entry").path());
    docs.filter(|path| path.extension().is_some_and(|extension| extension == "md")).chain(pages()).collect()
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
    let ours = |text: &str| ["ridgetone ", "cargo "].iter().any(|name| text.starts_with(name));
    let code = |mark| if let Mark::Code(text) = mark { Some(text.to_string()) } else { None };
    Parser::new(page).filter_map(code).filter(|text| ours(text)).collect()
}

/// The commands of all documents, each once, as they follow: lines of blocks of the shell, without the comments behind them,
/// and those in the text that are not the beginning of another.
fn commands() -> Vec<String> {
    let mut commands: Vec<String> = Vec::new();
    let documents: Vec<String> = documents().iter().map(|path| read(path)).collect();
    for line in documents.iter().flat_map(|page| blocks(page, "sh")).collect::<Vec<_>>().join("\n").lines() {
        let command = line.split(" #").next().unwrap_or_default().trim();
        if !command.is_empty() && !command.starts_with('#') && !commands.iter().any(|known| known == command) {
            commands.push(command.to_owned());
        }
    }
    let mut mentioned: Vec<String> = documents.iter().flat_map(|page| mentioned(page)).collect();
    // The longer ones first: a name alone stands for a command that is shown whole somewhere.
    mentioned.sort_by_key(|command| std::cmp::Reverse(command.len()));
    for command in mentioned {
        if !commands.iter().any(|known| *known == command || known.starts_with(&format!("{command} "))) {
            commands.push(command);
        }
    }
    assert!(commands.len() > 25, "{commands:?}");
    commands
}

/// Whether something else than these tests, or than the script of CI, runs a command, or nothing can.
fn is_elsewhere(command: &str) -> bool {
    WITH_A_BOARD.contains(&command) || LITTLE_OF.iter().any(|(long, _)| *long == command)
}

/// Runs the `ridgetone` commands, the long ones or the others, one after the other in a folder that has the files that they
/// speak of.
fn run_all(long: bool) {
    let folder = directory();
    std::os::unix::fs::symlink(root().join("scenes"), folder.path().join("scenes")).expect("a link");
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
    file(folder.path(), "speed.csv", "time_s,speed_mm_s\n0,30\n4,30\n");
    let rows: String = (0..200).map(|row| format!("{},{}\n", f64::from(row) * 0.02, f64::from(row) * 0.6)).collect();
    file(folder.path(), "robot.csv", &format!("time_s,place_mm\n{rows}"));
    // Surfaces with a tone of 100 Hz, and what people say of them.
    let mut scores = String::from("file,soft,m\n");
    for (number, name) in ["smooth.csv", "vibration.csv", "third.csv", "fourth.csv"].into_iter().enumerate() {
        let sample = |row: i32| (1 + number) as f64 * (std::f64::consts::TAU * f64::from(row) / 100.0).sin();
        let rows: Vec<String> = (0..20_000).map(|row| format!("{:.6}", sample(row))).collect();
        file(folder.path(), name, &format!("a\n{}\n", rows.join("\n")));
        scores += &format!("{name},{},{}\n", 6 - number, 1 + number);
    }
    file(folder.path(), "scores.csv", &scores);
    // Gratings of known period under the physical finger.
    for (name, period_mm) in [("a", 2.5), ("b", 3.0), ("c", 4.0)] {
        let scene =
            file(folder.path(), &format!("{name}.toml"), &format!("period_mm = {period_mm}\nspeed_mm_s = 15\n"));
        let path = folder.path().join(format!("{name}.csv"));
        assert!(run(&["scene", "--scene", text(&scene), "-o", text(&path)]).status.success());
    }
    let binary = Path::new(env!("CARGO_BIN_EXE_ridgetone")).parent().expect("a folder");
    let path = format!("{}:{}", text(binary), std::env::var("PATH").expect("a path"));

    let mut ran = 0;
    for command in commands() {
        if !command.starts_with("ridgetone ")
            || is_elsewhere(&command)
            || command.split_whitespace().any(|word| LONG.contains(&word)) != long
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
        assert!(output.status.success(), "{command}: {}", common::stderr(&output));
        let says = !output.stdout.is_empty() || !output.stderr.is_empty() || command.contains(" > ");
        assert!(says, "{command} says nothing");
        if let Some((_, s, word)) = endless {
            let all = format!("{}{}", stdout(&output), common::stderr(&output));
            assert!(all.contains(word), "{command} does not say \"{word}\" within {s} s");
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
    for command in all.iter().filter(|command| !command.starts_with("ridgetone ")) {
        let run_by_ci = ci.iter().any(|line| *line == command || line.starts_with(&format!("{command} ")));
        assert!(run_by_ci || is_elsewhere(command), "nothing runs `{command}`");
    }
    for command in WITH_A_BOARD.into_iter().chain(LITTLE_OF.map(|(long, _)| long)) {
        assert!(all.iter().any(|known| known == command), "no page has `{command}` any more");
    }
    for (_, test) in LITTLE_OF {
        assert!(root().join(test).is_file(), "{test}");
    }
}

#[test]
fn every_link_leads_to_a_file() {
    let mut links = 0;
    for page in pages() {
        for mark in Parser::new(&read(&page)) {
            let (Mark::Start(Tag::Link { dest_url: to, .. }) | Mark::Start(Tag::Image { dest_url: to, .. })) = mark
            else {
                continue;
            };
            let to = to.split('#').next().unwrap_or_default();
            if !to.is_empty() && !to.contains("://") {
                links += 1;
                assert!(page.with_file_name("").join(to).exists(), "{}: {to}", page.display());
            }
        }
    }
    assert!(links > 30);
}

/// The tables of the ways of a conversion and of a window: `file`: `function`, or `file`: `Type::function`, each once.
#[test]
fn the_ways_name_functions_that_exist() {
    let page = read(&root().join("docs/book/9-how-it-works.md"));
    let (_, ways) = page.split_once("## The way of one conversion").expect("the ways");
    let mut named = Vec::new();
    let mut source = None;
    for code in ways.lines().filter(|line| line.starts_with('|')).flat_map(|line| line.split('`').skip(1).step_by(2)) {
        if code.ends_with(".rs") {
            source = Some((code, read(&root().join(code))));
            continue;
        }
        let (file, source) = source.as_ref().expect("a file before its functions");
        let (of, function) = code.rsplit_once("::").unwrap_or(("", code));
        let has = |starts: &str, name: &str| {
            let words = |line: &str| line.split(|c: char| !c.is_alphanumeric() && c != '_').any(|word| word == name);
            source.lines().any(|line| line.contains(starts) && words(line))
        };
        assert!(has("fn ", function), "{file} has no function {function}");
        assert!(of.is_empty() || has("impl", of), "{file} has no methods of {of}");
        named.push((*file, code));
    }
    let mut once = named.clone();
    once.sort_unstable();
    once.dedup();
    assert!(named.len() > 35 && once.len() == named.len(), "a function comes once: {named:?}");
}

/// What `init` of a board's file names belongs together: the pins' names in the table are those in the code.
#[test]
fn the_wiring_is_the_firmwares() {
    let page = read(&root().join("docs/book/1-wiring.md"));
    let drawing = read(&root().join("docs/book/wiring.svg"));
    let feather = read(&root().join("src/board/feather_f405.rs"));
    let nucleo = read(&root().join("src/board/nucleo_f446re.rs"));
    let rows: Vec<Vec<&str>> = page
        .lines()
        .filter(|line| line.starts_with("| "))
        .map(|line| line.trim_matches('|').split('|').map(str::trim).collect())
        .collect();
    // The name of a signal in the code.
    let signals = [
        ("CS", "spi: "),
        ("SCLK", "spi: "),
        ("DOUT", "spi: "),
        ("DIN", "spi: "),
        ("DRDY", "drdy: "),
        ("START", "start: "),
        ("RESET", "reset: "),
    ];
    for (signal, field) in signals {
        let row = rows.iter().find(|row| row[0] == signal).unwrap_or_else(|| panic!("no row {signal}"));
        for (code, pin) in [(&feather, row[2]), (&nucleo, row[4])] {
            let line = code.lines().find(|line| line.trim_start().starts_with(field)).expect("the field");
            assert!(line.contains(&format!(".{}", pin.to_lowercase())), "{signal} is not on {pin}: {line}");
        }
        for text in [row[1], row[2]] {
            assert!(drawing.contains(&format!(">{text}<")), "{signal}: the drawing has no {text}");
        }
    }
    let row = rows.iter().find(|row| row[0].starts_with("telemetry")).expect("the line's row");
    for (code, pins) in [(&feather, row[2]), (&nucleo, row[4])] {
        let (tx, rx) = pins.split_once(", ").expect("two pins");
        assert!(code.contains(&format!(".{}, rx)", tx.to_lowercase())), "TX is not on {tx}");
        assert!(code.contains(&format!(".{}.into_alternate", rx.to_lowercase())), "RX is not on {rx}");
    }
}

/// The pins of the stylus, each on the line of its function.
#[test]
fn the_stylus_s_pins_are_the_firmwares() {
    let page = read(&root().join("docs/book/5-another-board.md"));
    let board = read(&root().join("src/stylus/board.rs"));
    let pins = [
        ("| amplifier", "PA4", "gpioa.pa4.into_analog()"),
        ("| encoder, channel A", "PC6", "gpioc.pc6.into_alternate::<2>()"),
        ("| encoder, channel B", "PC7", "gpioc.pc7.into_alternate::<2>()"),
        ("| telemetry out", "PB10, PB11", "(gpiob.pb10, rx)"),
    ];
    for (signal, pin, code) in pins {
        let row = page.lines().find(|line| line.starts_with(signal)).unwrap_or_else(|| panic!("no row {signal}"));
        assert!(row.split('|').nth(3).is_some_and(|cell| cell.trim() == pin), "{row}");
        assert!(board.contains(code), "{signal} is not on {pin}");
    }
}

#[test]
fn every_kind_of_fault_has_a_remedy() {
    let page = read(&root().join("docs/book/6-troubleshooting.md"));
    let symptoms: Vec<&str> = page.lines().filter_map(|line| line.strip_prefix("| ")?.split(" | ").next()).collect();
    for kind in FaultKind::ALL {
        let name = format!("`{}`", names::name(kind));
        assert!(symptoms.iter().any(|symptom| symptom.contains(&name)), "{name}");
    }
}

#[test]
fn the_reader_in_python_reads_what_the_command_prints() {
    let page = read(&root().join("docs/book/4-telemetry.md"));
    let [reader] = &blocks(&page, "python")[..] else { panic!("one reader") };
    assert!(reader.lines().count() <= 30, "{} lines", reader.lines().count());
    let folder = directory();
    let script = file(folder.path(), "reader.py", reader);

    // Damage in between, and a beginning in the middle of a frame.
    let mut line: Vec<u8> = b"middle of a frame\0\0\x01\0".to_vec();
    let mut wire = [0; WIRE_MAX];
    let mut sink = |packet: &Packet| {
        let length = encode(packet, &mut wire).expect("it fits");
        line.extend_from_slice(&wire[..length]);
        if packet.sequence.is_multiple_of(3) {
            let mut flipped = wire[..length].to_vec();
            flipped[length / 2] ^= 0x40;
            line.extend(flipped);
        }
        Ok(())
    };
    let input = Input { source: Source::Scene(Default::default()), ..Input::default() }.open().expect("an input");
    replay::run(input, Settings::DEFAULT, None, &mut sink, &mut |_, _| {}).expect("a replay");

    let mut python = Command::new("python3")
        .arg(&script)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .expect("Python 3 is there");
    let mut stdin = python.stdin.take().expect("a pipe");
    let fed = std::thread::spawn(move || stdin.write_all(&line));
    let output = python.wait_with_output().expect("it ends");
    fed.join().expect("a thread").expect("it read all");
    let read: Vec<serde_json::Value> = json_lines(&output);

    let printed = json_lines(&run(&["replay", "--json"]));
    let estimates: Vec<_> = printed.iter().filter(|message| message["type"] == "estimate").collect();
    assert!(estimates.len() > 4 && read.len() == estimates.len(), "{read:?}");
    let number = |value: &serde_json::Value| value.as_f64().unwrap_or(0.0);
    for (read, printed) in read.iter().zip(estimates) {
        assert_eq!(read[0], printed["sequence"]);
        assert!((number(&read[1]) - number(&printed["t_s"])).abs() < 1e-9);
        assert_eq!(read[2], printed["status"]);
        // They are f32 on the wire; each prints what reads back to the same.
        assert_eq!(number(&read[3]) as f32, number(&printed["frequency_hz"]) as f32);
        assert_eq!(number(&read[4]) as f32, number(&printed["sigma_hz"]) as f32);
    }
}
