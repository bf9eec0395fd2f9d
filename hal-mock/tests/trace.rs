//! Traces: what is read, what is refused and how, and the way back.
use hal_mock::{Scene, Sliding, SlidingScene, Table, Trace, write_csv};

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

#[test]
fn time_counts_from_the_first_row_and_values_are_interpolated() {
    let mut trace = Trace::from_table(table("time_s,a,b\n10,0,5\n11,2,5\n13,4,5\n"), 100.0).unwrap();
    assert_eq!(trace.end_s(), 5.0, "the last row lasts as long as the one before");
    for (t_s, v) in [(-1.0, 0.0), (0.0, 0.0), (0.25, 0.5), (1.0, 2.0), (2.0, 3.0), (3.0, 4.0), (9.0, 4.0), (0.5, 1.0)] {
        assert_eq!(trace.volts(0, t_s), v, "at {t_s} s");
    }
    assert_eq!((trace.volts(1, 0.5), trace.volts(2, 0.5), trace.volts(15, 0.5)), (5.0, 0.0, 0.0));
    let mut trace = trace.with_scale(1e-3);
    assert_eq!(trace.volts(0, 3.0), 4e-3);
}

#[test]
fn without_time_a_row_is_a_scan() {
    let mut trace = Trace::from_table(table("a\n0\n1\n2\n"), 4.0).unwrap();
    assert_eq!((trace.end_s(), trace.times_s()[2]), (0.75, 0.5));
    assert_eq!(trace.volts(0, 0.375), 1.5);
    assert_eq!(Trace::from_table(table("a\n7\n"), 4.0).unwrap().end_s(), 0.25);
}

#[test]
fn errors_name_file_and_line() {
    assert_eq!(error(b""), "t.csv: the file is empty");
    assert_eq!(error(b"\n \r\n\n"), "t.csv: the file is empty");
    assert_eq!(error(b"\n1,2\n3,4\n"), "t.csv: line 2: no header: the first line must name the columns");
    assert_eq!(error(b"a,b\n"), "t.csv: line 1: no data after the header");
    assert_eq!(error(b"time_s\n1\n"), "t.csv: line 1: no channel: the header has only a time column");
    assert_eq!(error(b"time_s,a,time_s\n"), "t.csv: line 1: more than one column is called time_s");
    assert_eq!(error(b"a,b\n1,2\n1,2,3\n"), "t.csv: line 3: 3 columns, the header has 2");
    assert_eq!(error(b"a,b\r\n\r\n1\r\n"), "t.csv: line 3: 1 columns, the header has 2");
    assert_eq!(error(b"a,b\n1,2\n\n\n1,x\n"), "t.csv: line 5: column b: \"x\" is not a number");
    assert_eq!(error(b"a,time_s\n1,\n"), "t.csv: line 2: column time_s: \"\" is no time");
    assert_eq!(error(b"a,b\n1,2\r\n1,2\r\n1,-\r\n"), "t.csv: line 4: column b: \"-\" is not a number");
    assert_eq!(error(b"a,b\n1,2\n-inf,2\n"), "t.csv: line 3: column a: \"-inf\" is not finite");
    assert_eq!(error(b"a,b\n1,1e999\n"), "t.csv: line 2: column b: \"1e999\" is not finite");
    assert_eq!(error(b"a,time_s\n1,1\n2,1\n"), "t.csv: line 3: time_s does not increase: 1 after 1");
    assert_eq!(error(b"a,b\n1,2\n1,\xFF\n"), "t.csv: line 3: not UTF-8 text");
}

#[test]
fn blank_cells_and_nan_are_missing_readings() {
    let t = table("time_s,a,b\n0,1,\n1,NaN,2\n2, nan ,\n");
    let missing: Vec<_> =
        t.rows().iter().map(|row| row.iter().map(|value| value.is_nan()).collect::<Vec<_>>()).collect();
    assert_eq!(missing, [[false, true], [true, false], [true, true]]);
}

#[test]
fn a_missing_file_is_named() {
    let text = Trace::load("/nowhere/to be.csv", 241.0).unwrap_err().to_string();
    assert!(text.starts_with("/nowhere/to be.csv: "), "{text}");
    assert!(!text.contains('\n'));
}

#[test]
fn a_table_may_be_wide_but_a_scene_has_16_channels() {
    let header: Vec<String> = (0..17).map(|k| format!("c{k}")).collect();
    let wide = table(&format!("{}\n{}\n", header.join(","), ["1"; 17].join(",")));
    assert_eq!(wide.names().len(), 17);
    let text = Trace::from_table(wide, 241.0).unwrap_err().to_string();
    assert_eq!(text, "t.csv: line 1: 17 channels, the chip has 16");
    let text = Trace::from_table(table("a\n1\n"), 0.0).unwrap_err().to_string();
    assert_eq!(text, "t.csv: scan rate 0 Hz: must be greater than 0");
}

#[test]
fn a_byte_order_mark_and_quotes_are_no_trouble() {
    let t = table("\u{FEFF}\"left, top\",time_s\n\"1\",0\n");
    assert_eq!((t.names(), t.rows()), (&["left, top".to_owned()][..], &[vec![1.0]][..]));
}

#[test]
fn a_recorded_scene_plays_back_to_the_last_bit() {
    let parameters = Sliding { slide_mm: 6.0, hold_before_s: 0.1, hold_after_s: 0.1, ..Sliding::default() };
    let mut original = SlidingScene::new(parameters.clone()).unwrap();
    let mut csv = Vec::new();
    let rows = write_csv(&mut original, 241.14, &mut csv).unwrap();
    let mut trace = Trace::from_table(Table::parse(&csv, "recorded").unwrap(), 241.14).unwrap();
    assert_eq!(trace.table().rows().len() as u64, rows);
    let mut again = SlidingScene::new(parameters).unwrap();
    for row in 0..rows as usize {
        let t_s = row as f64 / 241.14;
        for input in 0..16 {
            assert_eq!(trace.volts(input, t_s), again.volts(input, t_s), "row {row}, AIN{input}");
        }
    }
    // And a recording of the recording is the recording.
    let mut second = Vec::new();
    write_csv(&mut trace, 241.14, &mut second).unwrap();
    assert!(second == csv);
}

#[test]
fn an_endless_scene_is_not_written() {
    assert!(write_csv(&mut hal_mock::Constant::default(), 241.0, Vec::new()).is_err());
    assert!(write_csv(&mut hal_mock::Constant::default(), 0.0, Vec::new()).is_err());
}
