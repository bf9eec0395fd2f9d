//! Traces: what is read, what is refused and how, and the way back.
use hal_mock::{Playback, Scene, Sliding, SlidingScene, Table, Trace, write_csv};

fn table(text: &str) -> Table {
    Table::parse(text.as_bytes(), "t.csv").unwrap()
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
        assert!(
            (trace.clock_error_ppm() - 1e5 * (rate_hz - 10.0)).abs() < 1e-3
                && trace.sigma_factor() == 1.0
        );
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
    for (rate_hz, variance, factor) in [(4.0, 1.0, 2.5), (25.0, 0.4, 1.0), (400.0, 0.025, 1.0)] {
        let sine = |t_s: f64| (2.0 * t_s + 1.0).sin();
        let mut clean = trace(&csv(rate_hz, 0..(100.0 * rate_hz) as usize, |t_s| {
            sine(t_s).to_string()
        }));
        assert!(
            (clean.sigma_factor().powi(2) - factor).abs() < 1e-6 && clean.clock_error_ppm() == 0.0
        );
        for step in 0..800 {
            let t_s = 10.0 + f64::from(step) * 0.1;
            assert!(
                (clean.volts(0, t_s) - sine(t_s)).abs() < 0.01,
                "{rate_hz} Hz, {t_s} s"
            );
        }
        let mut noise = hal_mock::Noisy::new(hal_mock::Constant::default(), 1.0, 5);
        let mut values: Vec<String> = (0..(2000.0 * rate_hz) as usize)
            .map(|_| noise.volts(0, 0.0).to_string())
            .collect();
        values.insert(0, "time_s".into());
        let rows: String = values[1..]
            .iter()
            .enumerate()
            .map(|(k, v)| format!("{},{v}\n", k as f64 / rate_hz))
            .collect();
        let mut trace = trace(&format!("time_s,a\n{rows}"));
        let played: Vec<f64> = (100..19_900)
            .map(|step| trace.volts(0, f64::from(step) * 0.1))
            .collect();
        let power = |lag: usize| {
            played
                .iter()
                .zip(&played[lag..])
                .map(|(a, b)| a * b)
                .sum::<f64>()
                / 19_800.0
        };
        assert!(
            (power(0) / variance - 1.0).abs() < 0.08,
            "{rate_hz} Hz: {}",
            power(0)
        );
        if rate_hz > 10.0 {
            assert!(
                (1..4).all(|lag| power(lag).abs() < 0.08 * variance),
                "{rate_hz} Hz: {:?}",
                [1, 2, 3].map(power)
            );
        }
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
        assert!(
            (at(row) - f64::from(row)).abs() < 1e-9,
            "row {row}: {}",
            at(row)
        );
    }
    assert!(
        (40..50).all(|row| at(row).is_nan()),
        "missing rows have no result"
    );
    assert!(
        (60..90).all(|row| at(row) == f64::INFINITY),
        "a long run of blanks is beyond the scale"
    );
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
    assert_eq!(error(b""), "t.csv: the file is empty");
    assert_eq!(error(b"\n \r\n\n"), "t.csv: the file is empty");
    assert_eq!(
        error(b"\n1,2\n3,4\n"),
        "t.csv: line 2: no header: the first line must name the columns"
    );
    assert_eq!(error(b"a,b\n"), "t.csv: line 1: no data after the header");
    assert_eq!(
        error(b"time_s\n1\n"),
        "t.csv: line 1: no channel: the header has only a time column"
    );
    assert_eq!(
        error(b"time_s,a,time_s\n"),
        "t.csv: line 1: more than one column is called time_s"
    );
    assert_eq!(
        error(b"a,b\n1,2\n1,2,3\n"),
        "t.csv: line 3: 3 columns, the header has 2"
    );
    assert_eq!(
        error(b"a,b\r\n\r\n1\r\n"),
        "t.csv: line 3: 1 columns, the header has 2"
    );
    assert_eq!(
        error(b"a,b\n1,2\n\n\n1,x\n"),
        "t.csv: line 5: column b: \"x\" is not a number"
    );
    assert_eq!(
        error(b"a,time_s\n1,\n"),
        "t.csv: line 2: column time_s: \"\" is no time"
    );
    assert_eq!(
        error(b"a,b\n1,2\r\n1,2\r\n1,-\r\n"),
        "t.csv: line 4: column b: \"-\" is not a number"
    );
    assert_eq!(
        error(b"a,b\n1,2\n-inf,2\n"),
        "t.csv: line 3: column a: \"-inf\" is not finite"
    );
    assert_eq!(
        error(b"a,b\n1,1e999\n"),
        "t.csv: line 2: column b: \"1e999\" is not finite"
    );
    assert_eq!(
        error(b"a,time_s\n1,1\n2,1\n"),
        "t.csv: line 3: time_s does not increase: 1 after 1"
    );
    assert_eq!(
        error(b"a,b\n1,2\n1,\xFF\n"),
        "t.csv: line 3: not UTF-8 text: save it as such"
    );
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
    let text = Trace::open("/nowhere/to be.csv".as_ref(), PLAYBACK, &mut |_| {})
        .err()
        .unwrap()
        .to_string();
    assert!(text.starts_with("/nowhere/to be.csv: "), "{text}");
    assert!(!text.contains('\n'));
}

#[test]
fn a_table_may_be_wide_but_a_scene_has_16_channels() {
    let header: Vec<String> = (0..17).map(|k| format!("c{k}")).collect();
    let wide = format!("{}\n{}\n", header.join(","), ["1"; 17].join(","));
    assert_eq!(table(&wide).names().len(), 17);
    let text = Trace::parse(wide.as_bytes(), "t.csv", PLAYBACK)
        .err()
        .unwrap()
        .to_string();
    assert_eq!(text, "t.csv: line 1: 17 channels, the chip has 16");
    let text = Trace::parse(
        b"a\n1\n",
        "t.csv",
        Playback {
            row_rate_hz: Some(0.0),
            ..PLAYBACK
        },
    )
    .err()
    .unwrap()
    .to_string();
    assert_eq!(text, "t.csv: its rows have no rate");
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
    let mut trace = Trace::parse(
        &csv,
        "recorded",
        Playback {
            scan_rate_hz: 241.14,
            ..PLAYBACK
        },
    )
    .unwrap();
    let mut again = SlidingScene::new(parameters).unwrap();
    for row in 0..rows as usize {
        let t_s = row as f64 / 241.14;
        for input in 0..16 {
            assert_eq!(
                trace.volts(input, t_s + 1e-6),
                again.volts(input, t_s),
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
