//! Tests files that once failed: those in the folder `files` next to users' files, if present, and
//! generated files of the same kinds.

use super::common::{directory, json_lines, run, stderr, text};
use super::made::made;
use super::{Case, Doubted, Expected, Hz, Mm, Noted, Refused, TONE, judge, shared};
use std::path::{Path, PathBuf};

/// Files in the folder, options of `fit`, and expected results.
const FILES: [Case; 57] = [
    ("unit_time_hr.csv", &[], Noted(2.3, &["in hours"])),
    ("unit_time_ks.csv", &[], Hz(2.3)),
    ("unit_timestamp_min.csv", &[], Noted(2.3, &["in minutes"])),
    (
        "time_excel_serial.csv",
        &[],
        Refused(&["days", "--time-column time:d"]),
    ),
    (
        "time_excel_serial.csv",
        &["--time-column", "time:d"],
        Hz(2.3),
    ),
    (
        "speed_km_h.csv",
        &["--speed-column", "speed (km/h)"],
        Mm(2.5),
    ),
    (
        "speed_m_min.csv",
        &["--speed-column", "speed_m_min"],
        Mm(2.5),
    ),
    (
        "speed_rpm.csv",
        &["--speed-column", "speed (rpm)"],
        Refused(&["\"rpm\"", "mm/s"]),
    ),
    (
        "position_inch.csv",
        &["--position-column", "position (inch)"],
        Mm(2.5),
    ),
    (
        "position_inch.csv",
        &["--position-column", "position"],
        Mm(2.5),
    ),
    ("pendulum_m_10.txt", &[], Hz(0.7)),
    ("decay_g.csv", &[], Hz(0.7)),
    ("damped_touch_too_short_1.csv", &[], Hz(0.7)),
    ("pause_of_an_hour.csv", &[], Refused(&["a gap of", "--to"])),
    (
        "slist.ascii",
        &["--rate", "200"],
        Refused(&["6 samples a row", "--flatten"]),
    ),
    ("slist.ascii", &["--flatten"], Noted(3.7, &["200 sps"])),
    (
        "frames_in_rows.csv",
        &[],
        Refused(&["50 samples a row", "--flatten"]),
    ),
    ("frames_in_rows.csv", &["--flatten"], Hz(43.3)),
    ("uff58.uff", &[], Refused(&["universal file", "pyuff"])),
    ("xsens.txt", &[], Noted(3.7, &["PacketCounter", "200.0Hz"])),
    (
        "acqknowledge.txt",
        &[],
        Noted(3.7, &["min is the time in minutes"]),
    ),
    (
        "no_header_micros.csv",
        &[],
        Refused(&["--time-column column_1:us"]),
    ),
    (
        "no_header_micros.csv",
        &["--time-column", "column_1:us"],
        Hz(10.0),
    ),
    (
        "arduino_plotter.txt",
        &["--rate", "100"],
        Noted(3.7, &["x, y, z"]),
    ),
    ("labelled_values.txt", &[], Hz(3.7)),
    ("units_in_cells.csv", &[], Hz(2.3)),
    (
        "numpy_rows.txt",
        &["--rate", "100"],
        Noted(2.3, &["brackets"]),
    ),
    ("hex_counts.csv", &[], Hz(3.7)),
    ("arduino_monitor_plain.txt", &["--rate", "100"], Hz(3.7)),
    (
        "arduino_monitor_plain.txt",
        &[],
        Noted(3.7, &["stamp in each line"]),
    ),
    ("labchart.txt", &[], Noted(3.7, &["Interval= 0.005 s"])),
    ("tspair.ascii", &[], Hz(3.7)),
    (
        "vicon_devices.csv",
        &["--rate", "1000"],
        Noted(3.7, &["Frame, Sub Frame"]),
    ),
    (
        "eighteen_named.csv",
        &[],
        Noted(2.3, &["18 channels", "2 groups"]),
    ),
    (
        "finger_circle_two_of_three.csv",
        &[],
        Doubted(1.113, &["Fz does not share it", "--columns Fx,Fy"]),
    ),
    ("epoch_seconds_header.csv", &[], Hz(24.7)),
    (
        "epoch_seconds_header.csv",
        &[
            "--from",
            "2023-02-23T10:09:00",
            "--to",
            "2023-02-23 10:09:05.5",
        ],
        Hz(24.7),
    ),
    ("two_runs.csv", &["--to", "4.99"], Hz(2.3)),
    (
        "two_runs.csv",
        &[],
        Refused(&["two recordings", "--to 4.99"]),
    ),
    ("descending.csv", &[], Refused(&["sort", "sort_values"])),
    ("time_seconds_only.csv", &[], Hz(2.3)),
    ("angle_wraps.csv", &[], Doubted(2.3, &["numpy.unwrap"])),
    ("motec.csv", &[], Hz(3.7)),
    ("opensim.sto", &[], Hz(3.7)),
    ("ltspice.txt", &[], Hz(3.7)),
    ("phyphox_de.csv", &[], Hz(3.7)),
    ("delsys.csv", &["--time-column", "X[s]:s"], Hz(3.7)),
    ("date_time_two_columns.csv", &[], Hz(2.3)),
    ("combined_disjoint.csv", &[], Hz(2.3)),
    ("time_ampm.csv", &[], Hz(2.3)),
    ("time_tod_colon_ms.csv", &[], Hz(2.3)),
    ("time_timedelta_pandas.csv", &[], Hz(2.3)),
    ("time_labview_ts.csv", &[], Hz(2.3)),
    (
        "json_lines_of_a_sensor.txt",
        &["--rate", "500"],
        Noted(43.3, &["mlx, mly"]),
    ),
    (
        "fit_rate_alloc_988_bytes.csv",
        &["--rate", "1000"],
        Refused(&["a gap of"]),
    ),
    ("ntpstep_hour.csv", &[], Refused(&["a gap of", "--to"])),
    (
        "two_rows_swapped.csv",
        &[],
        Noted(4.774_648, &["out of order"]),
    ),
];

/// Generated files of the same kinds, with a tone of 12.34 Hz.
const TWINS: &[Case] = &[
    ("long_fast.csv", &[], Noted(160.0, &["around 160.00 Hz"])),
    ("two_phases.csv", &[], Hz(65.0)),
    ("time_min.csv", &[], Noted(12.34, &["in minutes"])),
    ("time_days.csv", &[], Noted(12.34, &["in days"])),
    ("time_10ms.csv", &[], TONE),
    (
        "time_furlongs.csv",
        &[],
        Refused(&["\"furlongs\"", "--time-column 'time (furlongs):s'"]),
    ),
    ("time_ticks.csv", &[], Refused(&["\"ticks\"", "--rate HZ"])),
    (
        "time_samples.csv",
        &[],
        Refused(&["\"samples\"", "--rate HZ"]),
    ),
    ("time_hundredths.csv", &[], TONE),
    ("time_milli.csv", &[], TONE),
    ("time_parts.csv", &[], TONE),
    ("time_factor.csv", &[], Refused(&["\"s x 100\""])),
    (
        "time_in_words.csv",
        &[],
        Refused(&[
            "hundredths of a second",
            "--time-column 'Time (hundredths of a second):second/100'",
        ]),
    ),
    (
        "time_in_words.csv",
        &["--time-column", "Time (hundredths of a second):second/100"],
        TONE,
    ),
    (
        "excel_date.csv",
        &[],
        Refused(&["if it is the time, --time-column Date:d;"]),
    ),
    (
        "excel_date.csv",
        &["--time-column", "Date:d"],
        Noted(12.34, &["counts from 1900"]),
    ),
    ("scope.csv", &[], Refused(&["--time-column X:s"])),
    ("scope.csv", &["--time-column", "X:s"], Hz(12_340.0)),
    (
        "time_m.csv",
        &[],
        Refused(&[
            "--time-column 'Time (m):min' or --time-column 'Time (m):ms'",
            "may be min or ms",
        ]),
    ),
    (
        "filetime.csv",
        &[],
        Noted(12.34, &["units of 100 ns", "counts from 1601"]),
    ),
    (
        "net_ticks.csv",
        &[],
        Refused(&["--time-column Ticks:100ns;"]),
    ),
    ("net_ticks.csv", &["--time-column", "Ticks:100ns"], TONE),
    // The length of a tick is unknown, so no unit is suggested.
    (
        "ticks.csv",
        &[],
        Refused(&["there are: Ticks, ax, ay, az; give the rate"]),
    ),
    (
        "time_us_x100.csv",
        &[],
        Refused(&["time_us_x100:us/100 or --time-column time_us_x100:100us"]),
    ),
    (
        "time_us_x100.csv",
        &["--time-column", "time_us_x100:us/100"],
        TONE,
    ),
    (
        "timestamp_camel.csv",
        &[],
        Noted(12.34, &["in milliseconds"]),
    ),
    ("elapsed_camel.csv", &[], Noted(12.34, &["in seconds"])),
    ("gps_utc.csv", &[], Refused(&["hhmmss", "d.pop(\"UTC\")"])),
    (
        "commas_no_header.csv",
        &[],
        Refused(&["decimals follow commas", "semicolons"]),
    ),
    (
        "ros2.csv",
        &[],
        Noted(12.34, &["sec is the time", "nanosec"]),
    ),
    ("ros1.csv", &[], Noted(12.34, &["header.stamp.nsecs"])),
    ("timeval.csv", &[], TONE),
    (
        "seconds_and_total.csv",
        &[],
        Noted(12.34, &["column time_ms is the time in milliseconds"]),
    ),
    ("utc_after_a_space.csv", &[], TONE),
    ("offset_after_a_space.csv", &[], TONE),
    ("syslog.csv", &[], TONE),
    ("syslog.txt", &[], TONE),
    (
        "syslog_labels.txt",
        &[],
        Noted(12.34, &["stamp in each line"]),
    ),
    ("python_log.txt", &[], Noted(12.34, &["root: ax, ay"])),
    ("ctime.csv", &[], TONE),
    ("ctime.txt", &[], TONE),
    (
        "json_dates.txt",
        &[],
        Noted(12.34, &["stamp in each line", "ax, ay"]),
    ),
    ("units_and_dates.csv", &[], Noted(12.34, &["force (N)"])),
    (
        "unknown_dates.txt",
        &[],
        Refused(&["no line with more numbers than words"]),
    ),
    (
        "transposed.csv",
        &[],
        Refused(&["2 rows of 1001", "index_col=0).T"]),
    ),
    (
        "transposed.csv",
        &["--rate", "250"],
        Refused(&["2 rows of 1001"]),
    ),
    (
        "matlab_factor.txt",
        &[],
        Refused(&["1.0e+03 *", "format long g"]),
    ),
    ("time_code.csv", &[], Refused(&["--rate HZ"])),
    ("time_code.csv", &["--rate", "250"], TONE),
    (
        "time_x10ms.csv",
        &[],
        Refused(&["--time-column 'time x10 ms:10 ms'"]),
    ),
    (
        "time_x10ms.csv",
        &["--time-column", "time x10 ms:10 ms"],
        TONE,
    ),
    (
        "ticks_10us.csv",
        &[],
        Noted(12.34, &["Ticks (10 us) is the time"]),
    ),
    ("json_nested.txt", &[], Noted(12.34, &["acc.x, y"])),
    ("time_ticks.csv", &["--time-column", "time_ticks:ms"], TONE),
    (
        "datenum.csv",
        &[],
        Refused(&["days", "--time-column time:d"]),
    ),
    ("datenum.csv", &["--time-column", "time:d"], TONE),
    ("compact_dates.csv", &[], TONE),
    (
        "two_clocks.csv",
        &[],
        Refused(&["disagree", "--time-column"]),
    ),
    ("two_clocks.csv", &["--time-column", "time_s"], TONE),
    (
        "micros_no_header.csv",
        &[],
        Refused(&["--time-column column_1:us"]),
    ),
    (
        "numbered_micros.csv",
        &[],
        Refused(&["column_1 counts the rows", "--time-column column_2:us"]),
    ),
    (
        "numbered_micros.csv",
        &["--time-column", "column_2:us"],
        TONE,
    ),
    (
        "row_numbers.csv",
        &[],
        Refused(&["n counts the rows", "--rate HZ"]),
    ),
    ("row_numbers.csv", &["--rate", "250"], TONE),
    (
        "stated_rate.csv",
        &[],
        Noted(12.34, &["sampling rate: 250 Hz"]),
    ),
    ("stated_interval.csv", &[], Noted(12.34, &["DT= 0.004 SEC"])),
    (
        "wrapped_5.txt",
        &[],
        Refused(&["5 samples a row", "--flatten"]),
    ),
    ("wrapped_5.txt", &["--flatten", "--rate", "250"], TONE),
    (
        "wrapped_stamped.csv",
        &[],
        Refused(&["8 samples a row", "--flatten and --time-column column_1:s"]),
    ),
    (
        "wrapped_stamped.csv",
        &["--flatten", "--time-column", "column_1:s"],
        TONE,
    ),
    (
        "labels.txt",
        &["--rate", "250"],
        Noted(12.34, &["ax, ay, az"]),
    ),
    ("labels_stamped.txt", &[], TONE),
    ("stamps_bracketed.txt", &[], TONE),
    (
        "units_in_cells_ms.csv",
        &[],
        Noted(12.34, &["in milliseconds"]),
    ),
    (
        "units_decimal_commas.csv",
        &[],
        Noted(12.34, &["decimals follow a comma", "Kraft (N)"]),
    ),
    (
        "units_missing.csv",
        &[],
        Noted(12.34, &["Kraft (N)", "lines are skipped"]),
    ),
    ("teleplot_started.txt", &[], Noted(12.34, &["force (N)"])),
    ("units_change.csv", &[], Refused(&["\"mV\"", "one unit"])),
    ("thousands_points.csv", &[], TONE),
    ("fortran.txt", &["--time-column", "column_1:s"], TONE),
    ("markdown.md", &[], Noted(12.34, &["vertical bars"])),
    ("query.txt", &[], TONE),
    ("printed_rows.txt", &[], Noted(12.34, &["column t is"])),
    (
        "colours.txt",
        &["--time-column", "I:ms"],
        Noted(12.34, &["ADC: a, b"]),
    ),
    ("zephyr.txt", &[], TONE),
    ("teleplot.txt", &[], Noted(12.34, &["force (N)"])),
    (
        "teleplot_two.txt",
        &[],
        Refused(&["Teleplot", "d['name'] == NAME"]),
    ),
    (
        "long.csv",
        &[],
        Refused(&["in column channel", "d[\"channel\"] == \"a\""]),
    ),
    ("candump.log", &[], Refused(&["CAN frames", "cantools"])),
    ("candump.txt", &[], Refused(&["CAN frames", "cantools"])),
    ("vector.asc", &[], Refused(&["CAN frames", "cantools"])),
    ("arrays.json", &[], Refused(&["pandas.read_json"])),
    ("json_lines.txt", &[], TONE),
    ("tuples.txt", &["--rate", "250"], TONE),
    ("hexadecimal.csv", &[], TONE),
    ("seconds_alone.csv", &[], TONE),
    ("swapped.csv", &[], Noted(12.34, &["out of order"])),
    ("reversed.csv", &[], Refused(&["sort"])),
    ("two_files.csv", &["--to", "3.996"], TONE),
    ("clock_set.csv", &["--rate", "250"], Refused(&["a gap of"])),
    (
        "twenty_channels.csv",
        &[],
        Noted(12.34, &["20 channels", "2 groups"]),
    ),
    ("twenty_channels.csv", &["--columns", "3-8,c19"], TONE),
];

#[test]
fn files_that_failed_are_fitted_or_refused_with_the_way_out() {
    let files = shared().join("files");
    if !files.is_dir() {
        println!("{} is not here: its files are not judged", files.display());
        return;
    }
    report(
        FILES
            .into_iter()
            .map(|(name, options, expected)| (files.join(name), options, expected)),
    );
}

#[test]
fn made_files_of_their_kinds_are_fitted_or_refused_with_the_way_out() {
    let folder = directory();
    report(TWINS.iter().map(|&(name, options, expected)| {
        let path = folder.path().join(name);
        std::fs::write(&path, made(name)).expect("a file");
        (path, options, expected)
    }));
}

fn report(cases: impl Iterator<Item = (PathBuf, &'static [&'static str], Expected)>) {
    let cases: Vec<_> = cases.collect();
    let wrong = cases
        .iter()
        .filter_map(|(path, options, expected)| judge(path, options, *expected));
    let wrong: Vec<String> = wrong.collect();
    println!(
        "{} of {} cases are right",
        cases.len() - wrong.len(),
        cases.len()
    );
    assert!(
        wrong.is_empty(),
        "{} cases:\n{}",
        wrong.len(),
        wrong.join("\n")
    );
}

/// `--from` must accept dates as printed.
#[test]
fn printed_dates_choose_a_part() {
    let folder = directory();
    let path = folder.path().join("epoch.csv");
    std::fs::write(&path, made("epoch.csv")).expect("a file");
    let printed = String::from_utf8(run(&["fit", text(&path)]).stdout).expect("text");
    let part = printed
        .lines()
        .find(|line| line.starts_with("part"))
        .expect("a part");
    let dates: Vec<&str> = part
        .split_whitespace()
        .filter(|word| word.starts_with("20"))
        .collect();
    let [from, to] = dates[..] else {
        panic!("{part}")
    };
    assert_eq!(judge(&path, &["--from", from, "--to", to], TONE), None);
}

/// Events must not contain anything that is not in the file.
#[test]
fn replay_of_a_table_reports_its_own_channels_alone() {
    let folder = directory();
    let made_path = folder.path().join("one_channel.csv");
    std::fs::write(&made_path, made("one_channel.csv")).expect("a file");
    let shared_path = shared().join("files/replay_1_columns.csv");
    let files: Vec<&Path> = [&*made_path, &*shared_path]
        .into_iter()
        .filter(|path| path.exists())
        .collect();
    for path in files {
        let lines = json_lines(&run(&["replay", text(path), "--json"]));
        assert!(
            lines.iter().any(|line| line["type"] == "estimate"),
            "{}",
            path.display()
        );
        for line in lines {
            let kind = line["type"].as_str().expect("a type");
            assert!(
                !["hello", "health", "contact", "texture", "image"].contains(&kind),
                "{line}"
            );
            for absent in ["period_mm", "speed_mm_s", "direction"] {
                assert!(
                    line[absent].is_null() && line["surface"][absent].is_null(),
                    "{line}"
                );
            }
            if kind == "estimate" {
                assert_eq!(line["channels"].as_array().map(Vec::len), Some(1), "{line}");
            }
        }
    }
}

#[test]
fn a_row_alone_has_no_answer() {
    let folder = directory();
    let path = folder.path().join("one.csv");
    std::fs::write(&path, "time_s,a\n0,1\n").expect("a file");
    for options in [&[][..], &["--rate", "100"]] {
        let output = run(&[&["fit", text(&path)], options].concat());
        assert_eq!(output.status.code(), Some(3), "{}", stderr(&output));
    }
}

/// A file whose clock jumps must be refused before anything is replayed or searched.
#[test]
fn gaps_are_refused_by_all_readers() {
    let folder = directory();
    let path = folder.path().join("clock_set.csv");
    std::fs::write(&path, made("clock_set.csv")).expect("a file");
    let calibrated = format!("3={}", text(&path));
    for arguments in [
        &["fit", text(&path)][..],
        &["fit", text(&path), "--rate", "1000"],
        &["replay", text(&path)],
        &["calibrate", &calibrated],
    ] {
        let output = run(arguments);
        let why = stderr(&output);
        assert!(
            output.status.code() == Some(1) && why.contains("a gap of"),
            "{arguments:?}: {why}"
        );
    }
}
