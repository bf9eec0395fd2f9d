use super::{RowReader, Rows, Table, Timing};

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
            "t.csv: line 2: no line with more numbers than words: this is no table of samples; other forms go through Python: ridgetone.fit(pandas.DataFrame({'time_s': ..., 'a': ...}))",
        ),
        (
            b"t_s,frequency_hz,sigma_hz\n1,2,3\n",
            "t.csv: these are estimates, not samples: give the recording that they come from",
        ),
    ] {
        assert_eq!(error(text), expected);
    }
}

/// Returns the names, rows and guesses for a text.
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
fn two_lines_above_the_rows_give_one_name_each() {
    for (head, expected) in [
        ("time,fx,fy\ns,N,N", ["fx", "fy"]),
        ("n,fx,fy\n-,m/s^2,°/s", ["fx", "fy"]),
        ("time,fx,fy\n,V,mV", ["fx", "fy"]),
        ("s,N,N\ntime,fx,fy", ["fx", "fy"]),
        ("time,fx,fy\ntime of the row,force x,force y", ["fx", "fy"]),
        ("time,fx,fy\nstamp,left,right\ns,N,N", ["fx", "fy"]),
        ("n,fx,fy\nnumber,left,right", ["fx", "fy"]),
        ("Device,left,right\ntime,fx,fy", ["fx", "fy"]),
        (",A 1,\ntime,fx,fy\n,N,N", ["fx", "fy"]),
        ("time,A 1,B 2\ntime,x,x", ["A 1", "B 2"]),
        (",A 1,\ntime,x,x", ["A 1 x", "A 1 x"]),
        (",A 1,B 2\ntime,x,x\ns,N,V", ["A 1 x", "B 2 x"]),
        (",acc,gyro\n,x,x\ntime,,", ["acc x", "gyro x"]),
        ("Sample Rate,10,Hz\ntime,a,a", ["a", "a"]),
    ] {
        let text = format!("{head}\n0.0,1,2\n0.1,2,1\n0.2,3,2\n0.3,3,2\n0.4,1,1\n");
        let (names, ..) = read(text.as_bytes());
        let names: Vec<&str> = names.iter().map(String::as_str).collect();
        assert!(names.ends_with(&expected), "{head}: {names:?}");
    }
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
    // A word among numbers is a missing reading, and is reported.
    let (_, rows, guessed) = read(b"time_s,a,b\n0,1,2\n0.1,two,2\n0.2,3,2\n");
    assert!(rows[1][0].is_nan() && rows[1][1] == 2.0);
    assert_eq!(
        guessed.unwrap(),
        "\"two\" in line 3, column a, is taken for a missing reading"
    );
    assert_eq!(read(b"a,T_\xB0C\n1,2\n").0, ["a", "T_\u{B0}C"]);
}

/// A single carriage return also ends a line; the next line then has the same number.
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

/// Asserts that the error for a table without a time says what to type.
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
fn a_byte_order_mark_and_quotes_are_no_trouble() {
    let t = table("\u{FEFF}\"left, top\",time_s\n\"1\",0\n");
    assert_eq!(
        (t.names(), t.rows()),
        (&["left, top".to_owned()][..], &[vec![1.0]][..])
    );
}
