//! Tests traces, held or resampled, and the CSV of a scene.
use hal_mock::{Scene, Sliding, SlidingScene, Trace, write_csv};

/// A recording in front of a chip with ten scans a second.
fn trace(text: &str) -> Trace {
    Trace::parse(text.as_bytes(), "t.csv", 10.0).unwrap()
}

/// Creates a CSV file with a row for each of `rows`, at `rate_hz`, starting at 7 s.
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
        // Each value is held over the whole scan.
        for (row, part) in (0..500).zip([0.03, 0.5, 0.97].into_iter().cycle()) {
            let found = trace.volts(0, (f64::from(row) + part) / rate_hz);
            assert_eq!(
                found.to_string(),
                rough(f64::from(row) / rate_hz),
                "row {row}"
            );
        }
        // A trace may be played again.
        assert_eq!(trace.volts(0, 0.01).to_string(), rough(0.0));
    }
}

/// A sine passes at any rate; white noise loses only what is beyond the scan's band.
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
fn a_missing_frame_is_no_result_and_a_missing_reading_overflows() {
    let value = |t_s: f64| match (t_s * 10.0).round() as u32 {
        60..90 => String::new(),
        row => row.to_string(),
    };
    // Rows 40 to 49 have no stamps, and rows 60 to 89 only a value in a different column.
    let rows =
        csv(10.0, (0..100).filter(|row| !(40..50).contains(row)), value).replace('\n', ",1\n");
    let mut trace = trace(&rows.replacen("a,1", "a,b", 1));
    let mut at = |row: u32| trace.volts(0, (f64::from(row) + 0.5) / 10.0);
    for row in (0..40).chain(50..60).chain(90..100) {
        assert!((at(row) - f64::from(row)).abs() < 1e-9, "row {row}");
    }
    // Missing frames have no result, and missing readings are out of range.
    assert!((40..50).all(|row| at(row).is_nan()));
    assert!((60..90).all(|row| at(row) == f64::INFINITY));
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
    let mut trace = Trace::parse(&csv, "recorded", 241.14).unwrap();
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

#[test]
fn files_in_another_layout_are_refused_with_the_line() {
    for (csv, expected) in [
        ("", "t.csv: line 1: the file is empty"),
        (
            "a,time_s\n1,0\n",
            "t.csv: line 1: needs time_s, then 1 to 16 columns",
        ),
        ("time_s,a\n", "t.csv: line 1: no data after the header"),
        (
            "time_s,a\n0,1,2\n",
            "t.csv: line 2: 3 columns, the header has 2",
        ),
        ("time_s,a\n0,one\n", "t.csv: line 2: \"one\": no number"),
        (
            "time_s,a\n0,1\n0,1\n",
            "t.csv: line 3: the time does not increase",
        ),
        (
            "time_s,a\n0,1\n1,1\n2,1\n1e12,1\n",
            "t.csv: line 4: too long to be played",
        ),
    ] {
        let error = Trace::parse(csv.as_bytes(), "t.csv", 10.0).err().unwrap();
        assert_eq!(error.to_string(), expected);
    }
    let frames = vec![None; 2];
    for rate_hz in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(
            Trace::new(frames.clone(), rate_hz, 10.0).is_err(),
            "{rate_hz}"
        );
    }
    assert!(Trace::new(Vec::new(), 10.0, 10.0).is_err());
}
