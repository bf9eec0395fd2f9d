//! Tests tables in the formats that occur: separators, decimal marks, names and units of time,
//! missing cells. Also tests that every command reads what `record` and `export` write.

mod common;
#[path = "common/raw_recording.rs"]
mod raw_recording;

use common::{assert_one_line, directory, file, json_lines, run, stderr, stdout, text, tone};
use hal_mock::Sliding;
use ridgetone_proto::settings::Settings;
use serde_json::Value;
use std::path::Path;

/// Returns the fit of a table without the file's name, and the remarks.
fn fit(path: &Path, options: &[&str]) -> (Value, String) {
    let output = run(&[&["fit", text(path), "--json"], options].concat());
    let mut found = json_lines(&output).remove(0);
    found.as_object_mut().expect("an object").remove("file");
    (found, stderr(&output))
}

/// Rewrites a generated table with a different header and different cells.
fn rewritten(
    table: &str,
    header: &str,
    separator: &str,
    cell: impl Fn(usize, &str) -> String,
) -> String {
    let line = |line: &str| {
        let cells: Vec<String> = line
            .split(',')
            .enumerate()
            .map(|(at, text)| cell(at, text))
            .collect();
        cells.join(separator)
    };
    std::iter::once(header.to_owned())
        .chain(table.lines().skip(1).map(line))
        .collect::<Vec<_>>()
        .join("\n")
}

#[test]
fn separators_decimals_and_times_of_all_kinds_give_the_same_numbers() {
    let folder = directory();
    let table = tone(2, 400, 100.0, 5.0, 0.0);
    let plain = fit(&file(folder.path(), "plain.csv", &table), &[]);
    assert_eq!(
        (plain.0["status"].as_str(), plain.1.as_str()),
        (Some("good"), "")
    );
    let same = |_: usize, text: &str| text.to_owned();
    let comma = |_: usize, text: &str| text.replace('.', ",");
    let times = |factor: f64| {
        move |at: usize, text: &str| match at {
            0 => format!("{:.0}", text.parse::<f64>().expect("a time") * factor),
            _ => text.to_owned(),
        }
    };
    let clock = |at: usize, text: &str| match at {
        0 => format!("2026-01-31T12:00:0{text}"),
        _ => text.to_owned(),
    };
    type Cell<'a> = &'a dyn Fn(usize, &str) -> String;
    let (same, comma, clock): (Cell<'_>, Cell<'_>, Cell<'_>) = (&same, &comma, &clock);
    let after = |before: &'static str| {
        move |at: usize, text: &str| match at {
            0 => format!("{before}{text}"),
            _ => text.to_owned(),
        }
    };
    let (stopwatch, days, month) = (
        after("59:0"),
        after("0 days 00:00:0"),
        after("31-Jan-2026 12:00:0"),
    );
    let (ms, us) = (times(1e3), times(1e6));
    for (name, header, separator, cell, options, said) in [
        (
            "semicolons",
            "time_s;c0;c1",
            ";",
            comma,
            &[][..],
            "separated by semicolons; decimals follow a comma",
        ),
        (
            "tabs",
            "t (s)\tc0\tc1",
            "\t",
            same,
            &[],
            "tabs; column t (s) is the time in seconds",
        ),
        ("spaces", "time_s c0 c1", "  ", same, &[], "white space"),
        ("numpy", "# time_s,c0,c1", ",", same, &[], ""),
        (
            "bare",
            "Time,c0,c1",
            ",",
            same,
            &[],
            "column Time is the time in seconds",
        ),
        (
            "ms",
            "time_ms,c0,c1",
            ",",
            &ms,
            &[],
            "column time_ms is the time in milliseconds",
        ),
        ("us", "t [us],c0,c1", ",", &us, &[], "microseconds"),
        (
            "asked",
            "x,c0,c1",
            ",",
            &ms,
            &["--time-column", "x:ms"],
            "column x is the time in milliseconds",
        ),
        (
            "excel",
            "sep=;\ntime_s;c0;c1;",
            ";",
            &|_, text| text.to_owned(),
            &[],
            "semicolons",
        ),
        (
            "comments",
            "# made by hand\n# time_s,c0,c1",
            ",",
            same,
            &[],
            "",
        ),
        (
            "clock",
            "timestamp,c0,c1",
            ",",
            clock,
            &[],
            "column timestamp is the time as a date or a time of day",
        ),
        (
            "stopwatch",
            "Time,c0,c1",
            ",",
            &stopwatch,
            &[],
            "a time of day",
        ),
        (
            "days",
            "when,c0,c1",
            ",",
            &days,
            &[],
            "column when is the time as a date or a time of day",
        ),
        (
            "month",
            "Timestamp,c0,c1",
            ",",
            &month,
            &[],
            "a time of day",
        ),
        (
            "zeit",
            "Zeit (ms),c0,c1",
            ",",
            &ms,
            &[],
            "column Zeit (ms) is the time in milliseconds",
        ),
        (
            "minus",
            "time_s,c0,c1",
            ",",
            &|_, text| text.replace('-', "\u{2212}"),
            &[],
            "",
        ),
    ] {
        let mut rows = rewritten(&table, header, separator, cell);
        if header.ends_with(";c1;") {
            rows = rows
                .lines()
                .map(|line| {
                    if line.ends_with(';') || line.starts_with("sep") {
                        format!("{line}\n")
                    } else {
                        format!("{line};\n")
                    }
                })
                .collect();
        }
        let (found, beside) = fit(&file(folder.path(), &format!("{name}.csv"), &rows), options);
        // Seconds since 1970 in f64 resolve a quarter of a microsecond.
        if said.contains("time of day") {
            let hz = |found: &Value| found["frequency_hz"].as_f64().expect("a tone");
            assert!((hz(&found) / hz(&plain.0) - 1.0).abs() < 1e-6, "{found}");
        } else {
            assert_eq!(found, plain.0, "{name}");
        }
        assert!(
            beside.contains(said) && beside.lines().count() == usize::from(!said.is_empty()),
            "{name}: {beside}"
        );
    }
}

#[test]
fn preambles_that_look_like_rows_are_passed_over() {
    let folder = directory();
    let table = tone(2, 400, 100.0, 5.0, 0.0);
    let plain = fit(&file(folder.path(), "plain.csv", &table), &[]).0;
    let rows = |separator: &str| {
        let same = |_: usize, text: &str| text.to_owned();
        rewritten(&table, "", separator, same)
    };
    let oscilloscope = format!(
        "Model,MSO44\nSample Interval,0.01\nVertical Units,V,V\nVertical Offset,0,0\nVertical Scale,1,1\n,,\nLabel,,\nTIME,c0,c1{}",
        rows(",")
    );
    let labview = format!(
        "LabVIEW Measurement\t\nSeparator\tTab\n***End_of_Header***\t\n\t\nChannels\t2\t\t\nDate\t2021/03/04\t2021/03/04\t\nTime\t10:11:12.12\t10:11:12.12\t\nX0\t0.0E+0\t0.0E+0\t\nDelta_X\t0.01\t0.01\t\n***End_of_Header***\t\t\t\nX_Value\tc0\tc1\tComment\n{}\t",
        rows("\t").trim_start().replace('\n', "\t\n")
    );
    for (name, text) in [("oscilloscope.csv", oscilloscope), ("labview.lvm", labview)] {
        assert_eq!(
            fit(&file(folder.path(), name, &text), &[]).0,
            plain,
            "{name}"
        );
    }
    // Some instruments write their settings in columns next to the first rows.
    let settings = [
        "Record Length,4.0e+02,,",
        "Sample Interval,0.01,,",
        "Source,CH1,,",
    ];
    let beside: String = table
        .lines()
        .skip(1)
        .enumerate()
        .map(|(row, line)| format!("{}{line}\n", settings.get(row).unwrap_or(&",,,")))
        .collect();
    let path = file(folder.path(), "beside.csv", &beside);
    assert_one_line(
        &run(&["fit", text(&path)]),
        1,
        &["no header", "--time-column column_4:s"],
    );
    let found = fit(&path, &["--time-column", "column_4:s"]).0;
    for field in ["rows", "frequency_hz", "sigma_hz"] {
        assert_eq!(found[field], plain[field]);
    }
}

#[test]
fn missing_cells_have_many_names() {
    let folder = directory();
    let table = tone(2, 400, 100.0, 5.0, 0.0);
    let lacking = |mark: &str| {
        let cell = |at: usize, text: &str| {
            if at == 1 && text.ends_with('7') {
                mark
            } else {
                text
            }
            .to_owned()
        };
        fit(
            &file(
                folder.path(),
                "lacking.csv",
                &rewritten(&table, "time_s,c0,c1", ",", cell),
            ),
            &[],
        )
        .0
    };
    let blank = lacking("");
    assert!(
        blank["readings_missing"]
            .as_u64()
            .is_some_and(|count| count > 10)
            && blank["status"] == "good"
    );
    for mark in ["NaN", "nan", "NA", "N/A", "null"] {
        assert_eq!(lacking(mark), blank, "{mark}");
    }
}

#[test]
fn what_cannot_be_guessed_is_refused_with_the_way_out() {
    let folder = directory();
    let cases = [
        (
            "whole.csv",
            "t,a\n0,1\n4,2\n8,1\n",
            &["column t", "whole numbers", "--time-column t:ms"][..],
        ),
        (
            "two.csv",
            "t,time,a\n0,0,1\n",
            &["t, time", "--time-column"],
        ),
        (
            "thousands.csv",
            "time_s;a\n0,5;1,5\n1.5;2.5\n",
            &["line 3", "1.5", "points or commas"],
        ),
        (
            "decimals.csv",
            "time_s,a\n0,0,1,5\n0,1,2,5\n",
            &["4 columns, the header has 2", "semicolons"],
        ),
        (
            "ties.csv",
            "t,a\n0.5,1\n0.5,2\n",
            &["does not increase", "--rate HZ"],
        ),
        (
            "word.csv",
            "time_ms,a\n0,1\nsoon,1\n",
            &["line 3", "column time_ms", "soon"],
        ),
        (
            "latin.csv",
            "time_s,a\n0,1\n",
            &["no column x; there are: time_s, a"],
        ),
    ];
    for (name, content, parts) in cases {
        let path = file(folder.path(), name, content);
        let options: &[&str] = if name == "latin.csv" {
            &["--time-column", "x"]
        } else {
            &[]
        };
        for command in ["fit", "replay"] {
            assert_one_line(&run(&[&[command, text(&path)], options].concat()), 1, parts);
        }
    }
    let ways_out = file(
        folder.path(),
        "whole.csv",
        &(0..100).fold("t,a\n".into(), |csv, row| {
            format!("{csv}{},{}\n", 4 * row, row % 7)
        }),
    );
    assert!(
        run(&["fit", text(&ways_out), "--time-column", "t:ms"])
            .status
            .success()
    );
    assert!(
        run(&[
            "fit",
            text(&ways_out),
            "--time-column",
            "none",
            "--rate",
            "250"
        ])
        .status
        .success()
    );
    assert_one_line(
        &run(&["fit", text(&ways_out), "--time-column", "t:furlong"]),
        2,
        &["s, ms, us, ns, min, h or d"],
    );
}

/// Writes a recording of telemetry with raw frames, as a board sends them, and everything that
/// `export` can make of it.
fn recorded(folder: &Path) -> Vec<std::path::PathBuf> {
    let bytes = raw_recording::of(Sliding::default(), Settings::DEFAULT);
    let rec = folder.join("touch.rec");
    std::fs::write(&rec, bytes).expect("a file");
    let mut all = vec![rec.clone()];
    for (name, format) in [
        ("csv", &["csv", "--table", "frames"][..]),
        ("mcap", &["mcap"]),
        ("ndjson", &["ndjson"]),
    ] {
        let path = folder.join(format!("touch.{name}"));
        let made = run(&[
            &["export", text(&rec), "--format"],
            format,
            &["-o", text(&path)],
        ]
        .concat());
        assert!(made.status.success(), "{}", stderr(&made));
        all.push(path);
    }
    all
}

#[test]
fn what_is_written_is_read_by_every_command_that_takes_a_recording() {
    let folder = directory();
    let all = recorded(folder.path());
    let results = |path: &Path| {
        let path = text(path);
        let without_name = |output| {
            json_lines(&output)
                .into_iter()
                .map(|mut line| {
                    line.as_object_mut().expect("an object").remove("file");
                    line
                })
                .collect::<Vec<_>>()
        };
        let gratings = [2.5, 3.6, 4.0].map(|mm| format!("{mm}={path}"));
        let calibrated = run(&[
            "calibrate",
            &gratings[0],
            &gratings[1],
            &gratings[2],
            "--json",
        ]);
        [
            without_name(run(&[
                "fit", path, "--from", "1.6", "--to", "3.4", "--json",
            ])),
            // The same grating three times does not determine a line. This is refused only after
            // the replay.
            vec![stderr(&calibrated).replace(path, "").into()],
        ]
    };
    let expected = results(&all[1]);
    assert_eq!(expected[0][0]["status"], "good");
    for path in &all {
        assert_eq!(results(path), expected, "{}", path.display());
    }
    // With a changed setting, `replay` runs the frames through the library again, in any file
    // format.
    let tone = |path: &Path| {
        let lines = json_lines(&run(&[
            "replay",
            text(path),
            "--json",
            "--set",
            "window_s=1",
        ]));
        let whole = lines
            .iter()
            .find(|line| line["span"] == "slide")
            .expect("an estimate of the slide");
        whole["frequency_hz"].as_f64().expect("a tone")
    };
    let board_hz = tone(&all[0]);
    for path in &all[1..] {
        let is_same = match path.extension().is_some_and(|extension| extension == "csv") {
            true => (tone(path) / board_hz - 1.0).abs() < 1e-4,
            false => tone(path) == board_hz,
        };
        assert!(is_same, "{}", path.display());
    }
    assert_one_line(
        &run(&["fit", text(&all[0]), "--time-column", "x"]),
        1,
        &["--time-column and --flatten are for tables"],
    );
    let shown = stdout(&run(&["monitor", "--file", text(&all[0]), "--pace", "0"]));
    assert!(shown.contains("contact"));
    // Frames are also printed in volts: 7,864,320 codes are 4.096 V (SBAS297G).
    let frame = shown
        .lines()
        .find(|line| line.contains("raw       frame 700"))
        .expect("a frame");
    let (codes, volts) = frame
        .split_once("codes [")
        .and_then(|(_, rest)| rest.split_once("]; mV "))
        .expect("both");
    for (code, mv) in codes.split(", ").zip(volts.split(' ')) {
        let expected = code.parse::<f64>().expect("a code") * 4096.0 / 7_864_320.0;
        assert!(
            (mv.parse::<f64>().expect("a voltage") - expected).abs() < 1e-3,
            "{frame}"
        );
    }
}
