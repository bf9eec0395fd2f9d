//! Tests that the pins, settings and faults in the documentation exist, and that its Python reader
//! works.

use super::common::{directory, file, json_lines, run};
use super::{blocks, read, root};
use ridgetone_host::input::Input;
use ridgetone_host::names;
use ridgetone_host::replay;
use ridgetone_host::settings_form::{change, json};
use ridgetone_proto::fault::FaultKind;
use ridgetone_proto::settings::Settings;
use ridgetone_proto::telemetry::{Packet, WIRE_MAX, encode};
use std::io::Write;
use std::process::{Command, Stdio};

/// The last column in the table of known issues must name an existing test.
#[test]
fn every_known_issue_has_a_test() {
    let page = read(&root().join("docs/known-issues.md"));
    let rows = page.lines().filter(|line| line.ends_with("` |"));
    let tests: Vec<&str> = rows.filter_map(|line| line.rsplit('`').nth(1)).collect();
    assert!(!tests.is_empty());
    for test in tests {
        let mut git = Command::new("git");
        git.current_dir(root())
            .args(["grep", "--quiet", &format!("^fn {test}()"), "--", "*.rs"]);
        assert!(git.status().expect("git").success(), "no test {test}");
    }
}

/// The pins in the table must match the boards' files, with lines such as `PA4 as Cs`.
#[test]
fn the_wiring_is_the_firmwares() {
    let page = read(&root().join("docs/guide/2-build.md"));
    let drawing = read(&root().join("docs/guide/wiring.svg"));
    let feather = read(&root().join("src/board/feather_f405.rs"));
    let nucleo = read(&root().join("src/board/nucleo_f446re.rs"));
    let rows: Vec<Vec<&str>> = page
        .lines()
        .filter(|line| line.starts_with("| "))
        .map(|line| line.trim_matches('|').split('|').map(str::trim).collect())
        .collect();
    // The bus and the clock are the same on all boards.
    let shared = read(&root().join("src/board/converter.rs"));
    // Name of each signal in the code.
    let signals = [
        ("CS", " as Cs"),
        ("SCLK", ">().into_alternate"),
        ("DOUT", ">().into_alternate"),
        ("DIN", ">().into_alternate"),
        ("DRDY", " as DrdyPin"),
        ("START", " as Start"),
        ("RESET", " as Reset"),
    ];
    for (signal, name) in signals {
        let row = rows
            .iter()
            .find(|row| row[0] == signal)
            .unwrap_or_else(|| panic!("no row {signal}"));
        for (code, pin) in [(&feather, row[2]), (&nucleo, row[4])] {
            let wired = format!("{pin}{name}");
            assert!(
                code.contains(&wired) || shared.contains(&wired),
                "no {wired} for {signal}"
            );
        }
        for text in [row[0], row[1], row[3]] {
            assert!(
                drawing.contains(&format!(">{text}<")),
                "{signal}: the drawing has no {text}"
            );
        }
    }
    assert!(page.contains("PB8") && shared.contains("TimerClock::new(timer, pin::<PB8>()"));
    let row = rows
        .iter()
        .find(|row| row[0].starts_with("telemetry"))
        .expect("the line's row");
    for (code, pins) in [(&feather, row[2]), (&nucleo, row[4])] {
        let (tx, rx) = pins.split_once(", ").expect("two pins");
        assert!(
            code.contains(&format!("{tx} as Tx, {rx} as Rx")),
            "the line is not on {pins}"
        );
    }
    // The pins of the Black Pill are listed in a sentence.
    let code = read(&root().join("src/board/blackpill_f411.rs"));
    let (_, section) = page.split_once("### Black Pill").expect("its section");
    for (signal, name) in [
        ("CS", "Cs"),
        ("START", "Start"),
        ("RESET", "Reset"),
        ("DRDY", "DrdyPin"),
        ("TX", "Tx"),
        ("RX", "Rx"),
    ] {
        let (before, _) = code.split_once(&format!(" as {name}")).expect(name);
        let pin = before.rsplit(['{', ' ', ':']).next().expect("a pin");
        let shown = format!("{signal} {pin}");
        assert!(section.contains(&shown), "no {shown}");
    }
}

/// The page must list the inputs of boards without an external converter in the firmware's order.
#[test]
fn the_inputs_of_the_own_converters_are_the_firmwares() {
    let page = read(&root().join("docs/guide/2-build.md"));
    for (board, file) in [
        ("Nucleo", "nucleo_f446re"),
        ("Feather", "feather_f405"),
        ("Black Pill", "blackpill_f411"),
    ] {
        let code = read(&root().join(format!("src/board/{file}.rs")));
        let (_, inputs) = code.split_once("inputs! {").expect("the inputs");
        let list = inputs.split(['[', ']']).nth(1).expect("a list of pins");
        let pins: Vec<&str> = list
            .split(',')
            .map(str::trim)
            .filter(|pin| !pin.is_empty())
            .collect();
        let start = format!("| {board} | ");
        let row = page.lines().find_map(|line| line.strip_prefix(&start));
        let inputs = row.expect("the board's row").split(" | ").next();
        let names = inputs.expect("its inputs").split(", ");
        let shown: Vec<&str> = names.filter_map(|name| name.rsplit(' ').next()).collect();
        assert_eq!(shown, pins, "{board}");
        assert!(shown.len() >= 8, "{board}: {shown:?}");
    }
}

/// Every setting must have a row in the reference with its default, and values outside the range in
/// that row must be refused.
#[test]
fn every_setting_is_in_a_table_with_its_range() {
    let pages = read(&root().join("host/reference.md"));
    let rows: Vec<Vec<&str>> = pages
        .lines()
        .map(|line| line.split('|').map(str::trim).collect())
        .collect();
    let settings: serde_json::Value =
        serde_json::from_str(&json(&Settings::DEFAULT).unwrap()).unwrap();
    let tables = |(name, value): (&String, &serde_json::Value)| match value {
        serde_json::Value::Object(fields) => fields
            .keys()
            .map(|field| format!("{name}.{field}"))
            .collect(),
        _ => vec![name.clone()],
    };
    let names: Vec<String> = settings
        .as_object()
        .unwrap()
        .iter()
        .flat_map(tables)
        .collect();
    assert!(names.len() > 20, "{names:?}");
    for name in names {
        let row = rows.iter().find(|row| {
            row.get(1)
                .is_some_and(|cell| cell.contains(&format!("`{name}`")))
        });
        let row = row.unwrap_or_else(|| panic!("{name} is in no table"));
        // Numbers in the range; the last two are its bounds.
        let cell = row[2].split(';').next().unwrap().replace(',', "");
        let range: Vec<f64> = cell
            .split(' ')
            .filter_map(|word| word.parse().ok())
            .collect();
        let default = settings
            .pointer(&format!("/{}", name.replace('.', "/")))
            .and_then(serde_json::Value::as_f64);
        let (Some(default), [.., min, max]) = (default, &range[..]) else {
            continue;
        };
        let shown = row[3].split(&[' ', ':'][..]).next().unwrap();
        let shown = shown.trim_matches('`');
        let shown = shown.strip_prefix("0x").map_or(shown.parse().ok(), |hex| {
            Some(u32::from_str_radix(hex, 16).unwrap().into())
        });
        assert_eq!(shown, Some(default), "{name}");
        // The shortest period must not exceed the longest, so raise the longest first.
        let longest = (name == "array.period_min_mm").then_some("array.period_max_mm=100");
        let set = |value: f64| {
            let changes = longest.map(str::to_owned).into_iter();
            let changes: Vec<String> = changes.chain([format!("{name}={value}")]).collect();
            change(&Settings::DEFAULT, &changes)
        };
        for wrong in [
            min - 0.3 * (max - min).abs().max(1.0),
            max + 0.3 * (max - min).abs().max(1.0),
        ] {
            assert!(set(wrong).is_err(), "{name} = {wrong}");
        }
        for right in [min, max] {
            // The page rounds bounds outwards, except for whole numbers.
            let inwards = right + (0.5 * (min + max) - right) * 1e-3;
            assert!(
                [*right, inwards].iter().any(|value| set(*value).is_ok()),
                "{name} = {right}"
            );
        }
    }
}

#[test]
fn every_kind_of_fault_has_a_remedy() {
    let page = read(&root().join("docs/guide/2-build.md"));
    let symptoms: Vec<&str> = page
        .lines()
        .filter_map(|line| line.strip_prefix("| ")?.split(" | ").next())
        .collect();
    for kind in FaultKind::ALL {
        let name = format!("`{}`", names::name(kind));
        assert!(
            symptoms.iter().any(|symptom| symptom.contains(&name)),
            "{name}"
        );
    }
}

#[test]
fn the_reader_in_python_reads_what_the_command_prints() {
    let page = read(&root().join("crates/proto/README.md"));
    let [reader] = &blocks(&page, "python")[..] else {
        panic!("one reader")
    };
    let folder = directory();
    let script = file(folder.path(), "reader.py", reader);

    // The line starts in the middle of a frame and has damaged bytes between frames.
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
    let input = Input::default().open().expect("an input");
    replay::run(input, Settings::DEFAULT, &mut sink, &mut |_, _| {}).expect("a replay");

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
    let estimates: Vec<_> = printed
        .iter()
        .filter(|message| message["type"] == "estimate")
        .collect();
    assert!(
        estimates.len() > 4 && read.len() == estimates.len(),
        "{read:?}"
    );
    let number = |value: &serde_json::Value| value.as_f64().unwrap_or(0.0);
    for (read, printed) in read.iter().zip(estimates) {
        assert_eq!(read[0], printed["sequence"]);
        assert!((number(&read[1]) - number(&printed["t_s"])).abs() < 1e-9);
        assert_eq!(read[2], printed["status"]);
        // Values are f32 on the line, and both texts must parse to the same f32.
        assert_eq!(
            number(&read[3]) as f32,
            number(&printed["frequency_hz"]) as f32
        );
        assert_eq!(number(&read[4]) as f32, number(&printed["sigma_hz"]) as f32);
    }
}
