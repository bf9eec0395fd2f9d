//! Traces: what is read, what is refused and how, and the way back.
use hal_mock::{
    Playback, RowReader, Rows, Scene, Sliding, SlidingScene, Table, Timing, Trace, write_csv,
};

fn table(text: &str) -> Table {
    Table::parse(text.as_bytes(), "t.csv").unwrap()
}

fn trace_error(text: &str, row_rate_hz: Option<f64>) -> String {
    let playback = Playback {
        row_rate_hz,
        ..PLAYBACK
    };
    let trace = Trace::parse(text.as_bytes(), "t.csv", playback);
    trace.err().unwrap().to_string()
}

fn error(text: &[u8]) -> String {
    Table::parse(text, "t.csv").unwrap_err().to_string()
}

#[test]
fn the_time_column_may_be_anywhere() {
    let t = table("a, time_s ,b\n1,0.5,2\n\n3,0.75,4e0\r\n");
    assert_eq!(t.names(), ["a", "b"]);
    assert_eq!(t.rows(), [[1.0, 2.0], [3.0, 4.0]]);
    assert_eq!(t.time_s(), Some(&[0.5, 0.75][..]));
}

/// A recording in front of a chip of ten scans a second.
fn trace(text: &str) -> Trace {
    Trace::parse(text.as_bytes(), "t.csv", PLAYBACK).unwrap()
}

const PLAYBACK: Playback = Playback {
    row_rate_hz: None,
    scan_rate_hz: 10.0,
    volts_per_unit: 1.0,
    limit_v: 4.0,
};

/// A CSV file with a row for each of `rows`, `rate_hz` of them a second, from 7 s on.
fn csv(rate_hz: f64, rows: impl Iterator<Item = usize>, value: impl Fn(f64) -> String) -> String {
    let row = |row| {
        format!(
            "{},{}\n",
            7.0 + row as f64 / rate_hz,
            value(row as f64 / rate_hz)
        )
    };
    format!("time_s,a\n{}", rows.map(row).collect::<String>())
}

#[test]
fn rows_at_the_scans_own_rate_are_held() {
    for rate_hz in [10.0, 9.97, 10.03] {
        let rough = |t_s: f64| ((t_s * 1234.5).sin() * 1e3).round().to_string();
        let mut trace = trace(&csv(rate_hz, 0..500, rough));
        assert!((trace.clock_error_ppm() - 1e5 * (rate_hz - 10.0)).abs() < 1e-3);
        assert!((trace.end_s() - 500.0 / rate_hz).abs() < 1e-6);
        // Anywhere in the scan, each value stays what it is.
        for (row, part) in (0..500).zip([0.03, 0.5, 0.97].into_iter().cycle()) {
            let found = trace.volts(0, (f64::from(row) + part) / rate_hz);
            assert_eq!(
                found.to_string(),
                rough(f64::from(row) / rate_hz),
                "row {row}"
            );
        }
        // It may be played again.
        assert_eq!(trace.volts(0, 0.01).to_string(), rough(0.0));
    }
}

/// A sine comes through at any rate; white noise loses what the scan cannot see, and nothing else.
#[test]
fn other_rates_are_resampled() {
    for (rate_hz, variance) in [(4.0, 1.0), (25.0, 0.4), (400.0, 0.025)] {
        let sine = |t_s: f64| (2.0 * t_s + 1.0).sin();
        let rows = 0..(100.0 * rate_hz) as usize;
        let mut clean = trace(&csv(rate_hz, rows, |t_s| sine(t_s).to_string()));
        assert_eq!(clean.clock_error_ppm(), 0.0);
        for step in 0..800 {
            let t_s = 10.0 + f64::from(step) * 0.1;
            let off_v = clean.volts(0, t_s) - sine(t_s);
            assert!(off_v.abs() < 0.01, "{rate_hz} Hz, {t_s} s");
        }
        let mut noise = hal_mock::Noisy::new(hal_mock::Constant::default(), 1.0, 5);
        let row = |k: usize| format!("{},{}\n", k as f64 / rate_hz, noise.volts(0, 0.0));
        let rows: String = (0..(2000.0 * rate_hz) as usize).map(row).collect();
        let mut trace = trace(&format!("time_s,a\n{rows}"));
        let played: Vec<f64> = (100..19_900)
            .map(|step| trace.volts(0, f64::from(step) * 0.1))
            .collect();
        let power = [0, 1, 2, 3].map(|lag: usize| {
            let products = played.iter().zip(&played[lag..]).map(|(a, b)| a * b);
            products.sum::<f64>() / 19_800.0
        });
        assert!(
            (power[0] / variance - 1.0).abs() < 0.08,
            "{rate_hz} Hz: {power:?}"
        );
        let is_white = power[1..].iter().all(|power| power.abs() < 0.08 * variance);
        assert!(is_white || rate_hz <= 10.0, "{rate_hz} Hz: {power:?}");
    }
}

#[test]
fn what_a_recording_lacks_is_bridged_or_no_result() {
    let value = |t_s: f64| match (t_s * 10.0).round() as u32 {
        20..23 | 60..90 => String::new(),
        row => row.to_string(),
    };
    // Stamps miss rows 40 to 49; rows 20 to 22 are blank, and so are 60 to 89, which have another
    // column.
    let rows =
        csv(10.0, (0..100).filter(|row| !(40..50).contains(row)), value).replace('\n', ",1\n");
    let mut trace = trace(&rows.replacen("a,1", "a,b", 1));
    let mut at = |row: u32| trace.volts(0, (f64::from(row) + 0.5) / 10.0);
    for row in (0..40).chain(50..60).chain(90..100) {
        assert!((at(row) - f64::from(row)).abs() < 1e-9, "row {row}");
    }
    // Missing rows have no result, and a long run of blanks is beyond the scale.
    assert!((40..50).all(|row| at(row).is_nan()));
    assert!((60..90).all(|row| at(row) == f64::INFINITY));
}

#[test]
fn time_may_be_absent_and_so_may_columns() {
    let playback = Playback {
        row_rate_hz: Some(4.0),
        ..PLAYBACK
    };
    let mut four = Trace::parse(b"a,b\n2,\n2,\n2,\n", "t.csv", playback).unwrap();
    assert_eq!((four.end_s(), four.rate_hz()), (0.75, 4.0));
    assert!((four.volts(0, 0.3) - 2.0).abs() < 1e-9);
    assert_eq!(
        (four.volts(1, 0.3), four.volts(15, 0.3)),
        (0.0, 0.0),
        "no reading, no column"
    );
    let mut late = Trace::parse(b"a,b\n,1\n3,1\n", "t.csv", PLAYBACK).unwrap();
    assert_eq!(late.volts(0, 0.05), 3.0, "blank at the beginning");
    let one = Trace::parse(b"a\n5\n", "t.csv", PLAYBACK).unwrap();
    assert_eq!(
        (one.end_s(), one.beyond().map(|beyond| beyond.row)),
        (0.1, Some(1))
    );
}

#[test]
fn errors_name_file_and_line() {
    for (text, expected) in [
        (&b""[..], "t.csv: the file is empty"),
        (b"\n \r\n\n", "t.csv: the file is empty"),
        (b"a,b\n", "t.csv: line 1: no data after the header"),
        (
            b"time_s\n1\n",
            "t.csv: line 1: no channel: the table has only a time column",
        ),
        (
            b"time_s,a,time_s\n0,1,0\n",
            "t.csv: line 1: columns 1 and 3 are both called time_s",
        ),
        (
            b"a,time_s\n1,1\n2,0.5\n",
            "t.csv: line 3: the time does not increase: 0.5 s after 1 s; if it is none, override it with --rate HZ, or choose another --time-column",
        ),
        (
            b"a,b\n1,2,3,4\n5,6,7,8\n",
            "t.csv: line 2: 4 columns, the header has 2; if commas are decimals, separate columns by semicolons",
        ),
        (
            b"a,time_s\n1,\n2,\n",
            "t.csv: line 2: column time_s: \"\" is no time",
        ),
        (
            b"a;b\n1,5;2\n1.5;2\n",
            "t.csv: line 3: column a: \"1.5\" is not a number beside the others: decimals follow either points or commas, and nothing else has any",
        ),
        (
            b"these are\nno numbers\n",
            "t.csv: line 2: no line with more numbers than words: this is no table of samples",
        ),
        (
            b"t_s,frequency_hz,sigma_hz\n1,2,3\n",
            "t.csv: these are estimates, not samples: give the recording that they come from",
        ),
    ] {
        assert_eq!(error(text), expected);
    }
}

/// The rows of a text, and what was guessed of it.
fn read(text: &[u8]) -> (Vec<String>, Vec<Vec<f64>>, Option<String>) {
    let mut rows = Rows::new(text, "t.csv").unwrap();
    let (mut all, mut row) = (Vec::new(), Vec::new());
    while rows.advance().unwrap() {
        rows.values(&mut row).unwrap();
        all.push(row.clone());
    }
    (rows.names().to_vec(), all, rows.guessed())
}

#[test]
fn what_is_no_row_is_passed_over_and_counted() {
    let two = vec![vec![1.0], vec![2.0]];
    for (text, said) in [
        (&b"time_s,a\n0,1\n0.1,2\n"[..], None),
        (
            b"time_s,a\n0,1\n0.1,2\n0.2",
            Some("1 line is skipped: line 4: 1 columns, where others have 2"),
        ),
        (
            b"time_s,a\n0,1\ntime_s,a\n0.1,2\n",
            Some("1 line is skipped: line 3"),
        ),
        (
            b"time_s,a\n0,1\n0.1,2\n\nstopped by user\n",
            Some("1 line is skipped: line 5"),
        ),
        (b"# a comment\ntime_s,a\n0,1\n# another\n0.1,2\n", None),
        (
            b"by hand\n\ntime_s,a\n0,1\n0.1,2\n",
            Some("the header is on line 3"),
        ),
        (b"time_s,a\n(s),(mV)\n0,1\n0.1,2\n", None),
        (b"time_s,a\r0,1\r0.1,2\r", None),
        (
            b"time_s,where,a\n0,left,1\n0.1,left,2\n",
            Some("counters or other times: where"),
        ),
        (b"0.1,1\n0.2,2\n", Some("no header")),
        (b"a,Temp \xB0C\n1,\n2,\n", None),
    ] {
        let (_, rows, guessed) = read(text);
        let values: Vec<Vec<f64>> = rows
            .iter()
            .map(|row| match guessed {
                Some(ref said) if said.starts_with("no header") => vec![row[1]],
                _ => vec![row[0]],
            })
            .collect();
        let shown = String::from_utf8_lossy(text);
        assert_eq!(values, two, "{shown}");
        match said {
            Some(said) => assert!(
                guessed.as_ref().is_some_and(|found| found.contains(said)),
                "{shown}: {guessed:?}"
            ),
            None => assert_eq!(guessed, None, "{shown}"),
        }
    }
    // A word among numbers is a missing reading, and is said.
    let (_, rows, guessed) = read(b"time_s,a,b\n0,1,2\n0.1,two,2\n0.2,3,2\n");
    assert!(rows[1][0].is_nan() && rows[1][1] == 2.0);
    assert_eq!(
        guessed.unwrap(),
        "\"two\" in line 3, column a, is taken for a missing reading"
    );
    assert_eq!(read(b"a,T_\xB0C\n1,2\n").0, ["a", "T_\u{B0}C"]);
}

/// A carriage return alone ends a line, too, and the next one has the same number then.
#[test]
fn mixed_ends_of_lines_do_not_mix_up_lines() {
    let (_, rows, _) = read(b"7\r0.0,1\n0.1,2\n0.2,3\n");
    assert_eq!(rows, [[0.0, 1.0], [0.1, 2.0], [0.2, 3.0]]);
}

#[test]
fn rows_that_share_a_stamp_are_spread() {
    let text = "time_s,a\n0,1\n0,2\n0,3\n0.3,4\n0.3,5\n0.3,6\n";
    let mut rows = Rows::new(text.as_bytes(), "t.csv").unwrap();
    let mut times = Vec::new();
    while rows.advance().unwrap() {
        times.push((rows.time_s().unwrap() * 1e6).round());
    }
    assert_eq!(times, [0e5, 1e5, 2e5, 3e5, 4e5, 5e5]);
}

/// What the message of a table without a time tells to type.
#[test]
fn a_missing_time_is_explained() {
    for (text, parts) in [
        (
            "counter,a\n0,1\n4,2\n8,1\n12,3\n16,1\n",
            &[
                "there are: counter, a",
                "--time-column counter:ms",
                "--rate HZ",
            ][..],
        ),
        ("a,b\n1,2\n0,2\n3,1\n", &["there are: a, b", "--rate HZ"]),
        ("1,2\n0,2\n3,1\n", &["no header", "column_1, column_2"]),
    ] {
        let Timing::Absent(why) = Rows::new(text.as_bytes(), "t.csv").unwrap().timing() else {
            panic!("{text}")
        };
        assert!(parts.iter().all(|part| why.contains(part)), "{why}");
    }
    let rows = Rows::new(&b"t,a\n0,1\n4,2\n8,1\n"[..], "t.csv").unwrap();
    assert!(matches!(rows.timing(), Timing::Unclear(why) if why.contains("--time-column t:ms")));
}

#[test]
fn blank_cells_and_nan_are_missing_readings() {
    let t = table("time_s,a,b\n0,1,\n1,NaN,2\n2, nan ,\n");
    let missing: Vec<_> = t
        .rows()
        .iter()
        .map(|row| row.iter().map(|value| value.is_nan()).collect::<Vec<_>>())
        .collect();
    assert_eq!(missing, [[false, true], [true, false], [true, true]]);
}

#[test]
fn a_missing_file_is_named() {
    let trace = Trace::open("/nowhere/to be.csv".as_ref(), PLAYBACK, &mut |_| {});
    let text = trace.err().unwrap().to_string();
    assert!(
        text.starts_with("/nowhere/to be.csv: ") && !text.contains('\n'),
        "{text}"
    );
}

#[test]
fn a_table_may_be_wide_but_a_scene_has_16_channels() {
    let header: Vec<String> = (0..17).map(|k| format!("c{k}")).collect();
    let wide = format!("{}\n{}\n", header.join(","), ["1"; 17].join(","));
    assert_eq!(table(&wide).names().len(), 17);
    let text = trace_error(&wide, None);
    assert_eq!(text, "t.csv: line 1: 17 channels, the chip has 16");
    assert_eq!(
        trace_error("a\n1\n", Some(0.0)),
        "t.csv: its rows have no rate"
    );
}

#[test]
fn a_byte_order_mark_and_quotes_are_no_trouble() {
    let t = table("\u{FEFF}\"left, top\",time_s\n\"1\",0\n");
    assert_eq!(
        (t.names(), t.rows()),
        (&["left, top".to_owned()][..], &[vec![1.0]][..])
    );
}

#[test]
fn a_recorded_scene_plays_back_to_the_last_bit() {
    let parameters = Sliding {
        slide_mm: 6.0,
        hold_before_s: 0.1,
        hold_after_s: 0.1,
        ..Sliding::default()
    };
    let mut original = SlidingScene::new(parameters.clone()).unwrap();
    let mut csv = Vec::new();
    let rows = write_csv(&mut original, 241.14, 0.0, &mut csv).unwrap();
    let mut playback = PLAYBACK;
    playback.scan_rate_hz = 241.14;
    let mut trace = Trace::parse(&csv, "recorded", playback).unwrap();
    let mut again = SlidingScene::new(parameters).unwrap();
    for row in 0..rows as usize {
        let t_s = row as f64 / 241.14;
        for input in 0..16 {
            let expected_v = again.volts(input, t_s);
            assert_eq!(
                trace.volts(input, t_s + 1e-6),
                expected_v,
                "row {row}, AIN{input}"
            );
        }
    }
}

#[test]
fn an_endless_scene_is_not_written() {
    assert!(write_csv(&mut hal_mock::Constant::default(), 241.0, 0.0, Vec::new()).is_err());
    assert!(write_csv(&mut hal_mock::Constant::default(), 0.0, 0.0, Vec::new()).is_err());
}
