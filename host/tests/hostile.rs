//! Tests that randomly damaged files and requests are either read completely or refused.

#[path = "hostile/mutator.rs"]
mod mutator;
#[path = "hostile/readers.rs"]
mod readers;

use mutator::Mutator;
use readers::Reader;
use ridgetone_finger::Pipeline;
use ridgetone_host::export::{self, Format, Kind};
use ridgetone_host::input::Input;
use ridgetone_host::recording::{self, Keep};
use ridgetone_host::{replay, settings_form};
use ridgetone_proto::command::{Command, Request};
use ridgetone_proto::framing;
use ridgetone_proto::settings::Settings;
use ridgetone_proto::telemetry::{Event, Packet, WIRE_MAX, encode};

/// Reads `count` damaged inputs. At least 2 % must be accepted and at least 2 % refused.
fn try_all(reader: Reader, wholes: &[Vec<u8>], count: usize) {
    for whole in wholes {
        assert!(reader.accepts(whole), "{}", String::from_utf8_lossy(whole));
    }
    let mut mutator = Mutator::new(1);
    let damaged = (0..count).map(|_| mutator.changed(wholes));
    let accepted = damaged.filter(|bytes| reader.accepts(bytes)).count();
    println!("{reader:?}: {accepted} of {count} accepted");
    assert!(
        (count / 50..count - count / 50).contains(&accepted),
        "{accepted}"
    );
}

/// Returns two recordings: the beginning of a touch with raw frames, and a whole touch without.
fn recordings() -> [Vec<u8>; 2] {
    let mut pipeline = Box::new(Pipeline::new(Settings::DEFAULT));
    pipeline.report_raw(u32::MAX);
    let mut events = vec![pipeline.hello()];
    let mut conversions = 0;
    let mut take = |timed| {
        conversions += 1;
        if conversions < 2000 {
            pipeline.push(timed, &mut |event: Event| events.push(event));
        }
        Ok(())
    };
    let touch = || Input::default().open().expect("a scene");
    replay::conversions(touch(), &mut take).expect("a run");
    let raw: Vec<u8> = (0..)
        .zip(events)
        .flat_map(|(sequence, event)| {
            let mut wire = [0; WIRE_MAX];
            let used = encode(&Packet { sequence, event }, &mut wire).expect("it fits");
            wire[..used].to_vec()
        })
        .collect();
    let whole = replay::run(touch(), Settings::DEFAULT, &mut |_| Ok(()), &mut |_, _| {});
    [raw, whole.expect("a run").serial].map(|serial| {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("touch.rec");
        let mut file = recording::create(&path, "a test", 0.0).expect("a file");
        file.keep(&serial, None).expect("kept");
        drop(file);
        std::fs::read(&path).expect("a file")
    })
}

fn exported(recording: &[u8], format: Format) -> Vec<u8> {
    let folder = tempfile::tempdir().expect("a folder");
    let (path, mut out) = (folder.path().join("touch.rec"), Vec::new());
    std::fs::write(&path, recording).expect("written");
    export::run(&path, format, Kind::Frames, &mut out).expect("exported");
    out
}

#[test]
#[ignore = "some seconds"]
fn damaged_rows_are_read_in_whole_or_refused() {
    let [raw, _] = recordings();
    let value = |row: u32| f64::from(row % 17) / 9.0 - 1.0;
    let table = |separator: &str, decimal: &str| {
        let row = |row| {
            let cells = [f64::from(row) / 250.0, value(row), value(row * row)];
            let cells = cells.map(|cell| format!("{cell:.5}").replace('.', decimal));
            format!("{}\r\n", cells.join(separator))
        };
        let head = ["Time [s]", "left (V)", "right (V)"].join(separator);
        format!("{head}\r\n{}", (0..60).map(row).collect::<String>()).into_bytes()
    };
    let dated = (0..60).map(|row| format!("2026-03-29T01:59:{row:02}.250Z,{}\n", value(row)));
    let dated = format!("# made\nwhen,acc\n{}", dated.collect::<String>()).into_bytes();
    let mut wholes = vec![table(",", "."), table(";", ","), dated];
    wholes.extend([Format::Csv, Format::Ndjson, Format::Mcap].map(|format| exported(&raw, format)));
    wholes.push(raw);
    try_all(Reader::Rows, &wholes, 2000);
}

#[test]
#[ignore = "some seconds"]
fn damaged_recordings_are_read_in_part_or_refused() {
    // Damaged bytes lose only packets. A damaged header loses the file.
    let mut wholes = recordings().to_vec();
    wholes.push(wholes[1][..600].to_vec());
    try_all(Reader::Recording, &wholes, 2000);
}

#[test]
#[ignore = "some seconds"]
fn damaged_files_of_mcap_are_read_in_whole_or_refused() {
    let wholes = recordings().map(|recording| exported(&recording, Format::Mcap));
    try_all(Reader::Mcap, &wholes, 3000);
}

#[test]
#[ignore = "some seconds"]
fn damaged_settings_and_scenes_are_valid_or_refused() {
    let settings = settings_form::toml(&Settings::DEFAULT)
        .expect("TOML")
        .into_bytes();
    let plan = b"plan = \"hand\"\nwindow_s = 0.3\n[slide]\nrule = \"protocol\"\nspeed_mm_s = 10\n"
        .to_vec();
    try_all(Reader::Settings, &[settings, plan], 4000);
    let scenes = ["c7.toml", "hand.toml"].map(|name| {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../hal-mock/scenes/");
        std::fs::read(format!("{path}{name}")).expect("a scene")
    });
    try_all(Reader::Scene, &scenes, 300);
}

#[test]
#[ignore = "some seconds"]
fn damaged_requests_are_whole_or_refused() {
    let commands = [
        Command::Greet,
        Command::Raw { frames: 7 },
        Command::Set {
            settings: Settings::DEFAULT,
            keep: true,
        },
    ];
    let wholes = commands.map(|command| {
        let mut wire = [0; WIRE_MAX];
        let request = Request { number: 1, command };
        let used = framing::encode(&request, &mut wire).expect("it fits");
        framing::unseal(&mut wire[..used - 1])
            .expect("whole")
            .to_vec()
    });
    try_all(Reader::Request, &wholes, 20_000);
}
