//! Generates the inputs of the test cases: a tone of 12.34 Hz in three channels at 250 Hz, in
//! formats that instruments write.

use std::fmt::Write as _;
use std::io::Write as _;

/// Rows of each table, 4 s.
const ROWS: usize = 1000;

/// Returns the time of a row if rows are evenly spaced, seconds.
fn even_s(row: usize) -> f64 {
    row as f64 * 0.004
}

/// Returns the three channels at a time, with a little reproducible noise.
fn channels(row: usize, t_s: f64) -> [f64; 3] {
    // SplitMix64, which is the same on all platforms.
    let mut state = 1 + 1000 * row as u64;
    [10.0, 0.5, -0.8].map(|offset| {
        state = state.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut mixed = (state ^ state >> 30).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        mixed = (mixed ^ mixed >> 27).wrapping_mul(0x94D0_49BB_1331_11EB);
        let noise = ((mixed ^ mixed >> 31) >> 11) as f64 / (1u64 << 53) as f64 - 0.5;
        let phase = std::f64::consts::TAU * 12.34 * t_s + offset;
        offset + phase.cos() + 0.3 * (2.0 * phase).sin() + 0.2 * noise
    })
}

/// Formats a row from its number, its time and its channels.
type Text<'a> = &'a dyn Fn(usize, f64, [String; 3]) -> String;

fn table(header: &str, times_s: &[f64], text: Text) -> String {
    let mut csv = header.to_owned();
    for (row, t_s) in times_s.iter().enumerate() {
        let values = channels(row, *t_s).map(|value| format!("{value:.6}"));
        let _ = writeln!(csv, "{}", text(row, *t_s, values));
    }
    csv
}

fn evenly() -> Vec<f64> {
    (0..ROWS).map(even_s).collect()
}

/// Returns a table of evenly spaced rows, with stamps formatted by `stamp`.
fn stamped(header: &str, stamp: &dyn Fn(usize, f64) -> String) -> String {
    table(
        &format!("{header},ax,ay,az\n"),
        &evenly(),
        &|row, t_s, values| format!("{},{}", stamp(row, t_s), values.join(",")),
    )
}

fn plain() -> String {
    stamped("time_s", &|_, t_s| format!("{t_s:.3}"))
}

/// Returns a table in which `mark` replaces every eleventh reading of the second channel.
fn lacking(mark: &str) -> String {
    table("time_s,ax,ay,az\n", &evenly(), &|row, t_s, [x, y, z]| {
        let y = if row % 11 == 4 { mark } else { &y };
        format!("{t_s:.3},{x},{y},{z}")
    })
}

/// Formats a time of day, starting at 01:59:58.
fn clock(t_s: f64) -> String {
    let (hour, second) = if t_s < 2.0 {
        ("01:59", 58.0)
    } else {
        ("02:00", -2.0)
    };
    format!("{hour}:{:09.6}", t_s + second)
}

fn utf_16(text: &str) -> Vec<u8> {
    let units = std::iter::once(0xFEFF).chain(
        text.replace('\n', "\r\n")
            .encode_utf16()
            .collect::<Vec<_>>(),
    );
    units.flat_map(u16::to_le_bytes).collect()
}

fn gzip(text: &str) -> Vec<u8> {
    let mut writer = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
    writer.write_all(text.as_bytes()).expect("memory");
    writer.finish().expect("memory")
}

fn wav() -> Vec<u8> {
    let spec = hound::WavSpec {
        channels: 2,
        sample_rate: 8000,
        bits_per_sample: 16,
        sample_format: hound::SampleFormat::Int,
    };
    let mut bytes = std::io::Cursor::new(Vec::new());
    let mut writer = hound::WavWriter::new(&mut bytes, spec).expect("memory");
    for sample in 0..16_000 {
        let phase = std::f64::consts::TAU * 440.25 * f64::from(sample) / 8000.0;
        for value in [phase.sin(), phase.cos()] {
            let dither = f64::from(sample * 7919 % 101 - 50);
            writer
                .write_sample((8000.0 * value + dither) as i16)
                .expect("memory");
        }
    }
    writer.finalize().expect("memory");
    bytes.into_inner()
}

/// Returns a table for a finger that accelerates over a grating of 2.5 mm.
fn by_place(header: &str, column: &dyn Fn(f64, f64) -> String) -> String {
    let mut csv = header.to_owned();
    for t_s in evenly() {
        let (speed_mm_s, place_mm) = (20.0 + 10.0 * t_s, 20.0 * t_s + 5.0 * t_s * t_s);
        let row = (t_s * 250.0) as usize;
        let noise = channels(row, 0.0)[0] - channels(0, 0.0)[0];
        let phase = std::f64::consts::TAU * place_mm / 2.5;
        let values = [phase.sin(), phase.cos()].map(|value| format!("{:.5}", value + noise));
        let _ = writeln!(
            csv,
            "{t_s:.3},{},{}",
            values.join(","),
            column(speed_mm_s, place_mm)
        );
    }
    csv
}

pub fn made(name: &str) -> Vec<u8> {
    let text = match name {
        "data.csv.gz" => return gzip(&plain()),
        "utf16le_bom.csv" => return utf_16(&plain()),
        "audio.wav" => return wav(),
        "arr.npz" => return b"PK\x03\x04\x2d\0\0\0\0\0\0\0\x21\0time_s.npy\x93NUMPY".to_vec(),
        "latin1_header.csv" => {
            let text = plain().replace("ax,ay", "accel_#g,T_#C");
            return text
                .bytes()
                .map(|byte| if byte == b'#' { 0xB5 } else { byte })
                .collect();
        }
        "sine_5hz.csv" => (0..1000).fold("time_s,y\n".into(), |csv, row| {
            let t_s = f64::from(row) * 0.002;
            format!(
                "{csv}{t_s:.3},{:.6}\n",
                (std::f64::consts::TAU * 5.0 * t_s).sin()
            )
        }),
        "percent_time_ns.csv" => stamped("%time", &|row, _| {
            (1_704_441_234_123_456_789_u64 + 4_000_000 * row as u64).to_string()
        }),
        "datetime_column.csv" => {
            stamped("datetime", &|_, t_s| format!("2016-11-24 {}", clock(t_s)))
        }
        "iso_offset.csv" => stamped("timestamp", &|_, t_s| {
            format!("2016-11-24T{}+01:00", clock(t_s))
        }),
        "date_and_time_columns.csv" => {
            stamped("Date,Time", &|_, t_s| format!("2016-11-24,{}", clock(t_s)))
        }
        "local_time_dst.csv" => stamped("Timestamp", &|_, t_s| {
            format!("2025-03-30 {}", clock(t_s).replace("02:00", "03:00"))
        }),
        "stamps_in_batches.csv" => {
            stamped("time_s", &|row, _| format!("{:.3}", even_s(row / 3 * 3)))
        }
        "six_digits_time.csv" => stamped("time_s", &|_, t_s| format!("{:.2}", 1000.0 + t_s)),
        "time_us_wrap.csv" => stamped("time_us", &|row, _| {
            4_292_967_296_u32
                .wrapping_add(4000 * row as u32)
                .to_string()
        }),
        "stamps_8_and_2_ms.csv" => {
            let times_s: Vec<f64> = (0..ROWS)
                .map(|row| (row / 2) as f64 * 0.01 + (row % 2) as f64 * 0.008)
                .collect();
            table("timestamp,ax,ay,az\n", &times_s, &|_, t_s, values| {
                format!("{:.6},{}", 1_501_822_123.0 + t_s, values.join(","))
            })
        }
        "dropped_40pct.csv" => {
            let kept = |row: &usize| (row * row * 31 + row * 17) % 10 < 6;
            let times_s: Vec<f64> = (0..ROWS).filter(kept).map(even_s).collect();
            table("time_s,ax,ay,az\n", &times_s, &|_, t_s, values| {
                format!("{t_s:.3},{}", values.join(","))
            })
        }
        "random_times.csv" => {
            let step_s = |row: usize| 0.0005 + 0.007 * ((row * 7919) % 1009) as f64 / 1009.0;
            let times_s: Vec<f64> = (0..ROWS)
                .scan(0.0, |t_s, row| {
                    *t_s += step_s(row);
                    Some(*t_s)
                })
                .collect();
            table("time_s,ax,ay,az\n", &times_s, &|_, t_s, values| {
                format!("{t_s:.6},{}", values.join(","))
            })
        }
        "units_in_second_row.csv" => table(
            "Time,Channel A,Channel B\n(ms),(mV),(mV)\n\n",
            &evenly(),
            &|_, t_s, [x, y, _]| format!("{:.8},{x},{y}", 1e3 * t_s),
        ),
        "preamble_key_value.csv" => table(
            "Model,MSO24\nFirmware Version,1.24\n,\nPoint Format,Y,\nHorizontal Units,S,\nSample Interval,0.004,\nRecord Length,1000,\n,,\nTIME,CH1,CH2\n",
            &evenly(),
            &|_, t_s, [x, y, _]| format!("{t_s:.3},{x},{y}"),
        ),
        "percent_comments.txt" => table(
            "%OpenBCI Raw EXG Data\n%Number of channels = 3\n%Sample Rate = 250 Hz\n%Board = OpenBCI_GUI$BoardCytonSerial\nSample Index, EXG Channel 0, EXG Channel 1, EXG Channel 2, Timestamp, Timestamp (Formatted)\n",
            &evenly(),
            &|row, t_s, values| {
                let stamp_s = 1_704_441_234.0 + t_s;
                format!(
                    "{}, {}, {stamp_s:.6}, 2024-01-05 {}",
                    row % 256,
                    values.join(", "),
                    clock(t_s)
                )
            },
        ),
        "labview.lvm" => table(
            "LabVIEW Measurement\t\nWriter_Version\t2\nSeparator\tTab\nDecimal_Separator\t,\nDate\t2026/01/31\n***End_of_Header***\t\n\t\nChannels\t2\t\t\nSamples\t1000\t1000\t\nDelta_X\t0,004\t0,004\t\n***End_of_Header***\t\t\t\nX_Value\tForce\tForce 1\tComment\n",
            &evenly(),
            &|_, t_s, [x, y, _]| format!("{t_s:.6}\t{x}\t{y}").replace('.', ","),
        ),
        "no_header.csv" => table("", &evenly(), &|_, _, values| values.join(",")),
        "cr_only.csv" => plain().replace('\n', "\r"),
        "thousands.csv" => table("time_s,ax,ay,az\n", &evenly(), &|_, t_s, [x, y, z]| {
            let (whole, decimals) = x.split_once('.').expect("decimals");
            format!(
                "{t_s:.3},\"{whole},{}.{}\",{y},{z}",
                &decimals[..3],
                &decimals[3..]
            )
        }),
        "text_column.csv" => table(
            "time,.header.seq,.header.stamp.secs,.header.frame_id,.linear_acceleration.x,.linear_acceleration.y\n",
            &evenly(),
            &|row, t_s, [x, y, _]| {
                let stamp_s = 1_704_441_234.0 + t_s;
                format!("{stamp_s:.9},{row},{stamp_s:.0},imu_link,{x},{y}")
            },
        ),
        "dup_channel_names.csv" => plain().replace("ax,ay,az", "acc,acc,acc"),
        "missing_dash.csv" => lacking("-"),
        "missing_n_a.csv" => lacking("n/a"),
        "missing_err.csv" => lacking("ERR"),
        "last_line_cut.csv" => {
            let whole = plain();
            whole[..whole.len() - 12].to_owned()
        }
        "header_repeated.csv" => plain().replace("\n2.000,", "\ntime_s,ax,ay,az\n2.000,"),
        "footer_text.csv" => plain() + "\nMeasurement stopped by user\n",
        "encoder_counts.csv" => by_place("time_s,ax,ay,encoder\n", &|_, place_mm| {
            format!("{:.0}", 40.0 * place_mm)
        }),
        "speed_m_s.csv" => by_place("time_s,ax,ay,speed_m_s\n", &|speed_mm_s, _| {
            format!("{:.6}", 1e-3 * speed_mm_s)
        }),
        other => return failing(other),
    };
    text.into_bytes()
}

fn failing(name: &str) -> Vec<u8> {
    let numbered =
        |header: &str, stamp: &dyn Fn(usize) -> String| stamped(header, &|row, _| stamp(row));
    let rows = |text: Text| table("", &evenly(), text);
    let first = |row: usize| format!("{:.6}", channels(row, even_s(row))[0]);
    let wrapped = |width: usize, stamp: &dyn Fn(usize) -> String, separator: &str| -> String {
        let line = |line: usize| {
            let values: Vec<String> = (line * width..ROWS.min((line + 1) * width))
                .map(first)
                .collect();
            format!("{}{}\n", stamp(line * width), values.join(separator))
        };
        (0..ROWS.div_ceil(width)).map(line).collect()
    };
    let text = match name {
        "time_min.csv" => stamped("Elapsed (min)", &|_, t_s| format!("{:.9}", t_s / 60.0)),
        "time_days.csv" => stamped("time_days", &|_, t_s| format!("{:.12}", t_s / 86_400.0)),
        "time_10ms.csv" => stamped("Time (10 ms)", &|_, t_s| format!("{:.2}", t_s * 100.0)),
        "time_hundredths.csv" => stamped("Time (1/100 s)", &|_, t_s| format!("{:.1}", 1e2 * t_s)),
        "time_milli.csv" => stamped("time(1e-3 s)", &|_, t_s| format!("{:.0}", 1e3 * t_s)),
        "time_parts.csv" => stamped("Time (s/100)", &|_, t_s| format!("{:.1}", 1e2 * t_s)),
        "time_factor.csv" => stamped("Time (s x 100)", &|_, t_s| format!("{:.1}", 1e2 * t_s)),
        "time_in_words.csv" => stamped("Time (hundredths of a second)", &|_, t_s| {
            format!("{:.1}", 1e2 * t_s)
        }),
        "matlab_factor.txt" => format!(
            "x =\n\n   1.0e+03 *\n\n{}",
            table("", &evenly(), &|row, t_s, _| {
                let [x, y, z] = channels(row, t_s).map(|value| value / 1e3);
                format!("    {:.7}   {x:.7}   {y:.7}   {z:.7}", t_s / 1e3)
            })
        ),
        "excel_date.csv" => stamped("Date", &|_, t_s| {
            format!("{:.10}", 45_366.430_9 + t_s / 86_400.0)
        }),
        "scope.csv" => stamped("X", &|_, t_s| format!("{:.9}", 1e-3 * t_s)),
        "time_m.csv" => stamped("Time (m)", &|_, t_s| format!("{:.9}", t_s / 60.0)),
        "filetime.csv" => numbered("Timestamp", &|row| {
            (133_549_716_300_000_000 + 40_000 * row).to_string()
        }),
        "net_ticks.csv" => numbered("Ticks", &|row| {
            (638_460_948_300_000_000 + 40_000 * row).to_string()
        }),
        "ticks.csv" => numbered("Ticks", &|row| (400 * row).to_string()),
        "time_us_x100.csv" => numbered("time_us_x100", &|row| (400_000 * row).to_string()),
        "timestamp_camel.csv" => numbered("timestampMs", &|row| (4 * row).to_string()),
        "elapsed_camel.csv" => stamped("elapsedSeconds", &|_, t_s| format!("{t_s:.3}")),
        "gps_utc.csv" => stamped("UTC", &|_, t_s| match t_s < 2.0 {
            true => format!("{:.3}", 102_058.0 + t_s),
            false => format!("{:.3}", 102_100.0 + t_s - 2.0),
        }),
        "commas_no_header.csv" => {
            rows(&|_, t_s, [x, y, _]| format!("{t_s:.3},{x},{y}").replace('.', ","))
        }
        "ros2.csv" => numbered("sec,nanosec", &|row| {
            format!("{},{}", 1_700_000_000 + row / 250, row % 250 * 4_000_000)
        }),
        "ros1.csv" => numbered("header.seq,header.stamp.secs,header.stamp.nsecs", &|row| {
            format!(
                "{row},{},{}",
                1_700_000_000 + row / 250,
                row % 250 * 4_000_000
            )
        }),
        "timeval.csv" => numbered("tv_sec,tv_usec", &|row| {
            format!("{},{}", 7 + row / 250, row % 250 * 4000)
        }),
        // Two whole times, not seconds and their fraction.
        "seconds_and_total.csv" => numbered("time_sec,time_ms", &|row| {
            format!("{},{}", row / 250, 4 * row)
        }),
        "utc_after_a_space.csv" => {
            stamped("time", &|_, t_s| format!("2016-11-24 {} UTC", clock(t_s)))
        }
        "offset_after_a_space.csv" => {
            stamped("time", &|_, t_s| format!("2016-11-24 {} +0200", clock(t_s)))
        }
        "syslog.csv" => stamped("time", &|_, t_s| format!("May  1 {}", clock(t_s))),
        "syslog.txt" => {
            rows(&|_, t_s, values| format!("May  1 {} {}", clock(t_s), values.join(" ")))
        }
        "python_log.txt" => rows(&|_, t_s, [x, y, _]| {
            let clock = clock(t_s)[..12].replace('.', ",");
            format!("2016-11-24 {clock} INFO root: ax={x} ay={y}")
        }),
        "syslog_labels.txt" => {
            rows(&|_, t_s, [x, y, _]| format!("May  1 {} host imu: ax={x} ay={y}", clock(t_s)))
        }
        "ctime.csv" => stamped("time", &|_, t_s| format!("Thu Nov 24 {} 2016", clock(t_s))),
        "ctime.txt" => {
            rows(&|_, t_s, values| format!("Thu Nov 24 {} 2016 {}", clock(t_s), values.join(" ")))
        }
        "json_dates.txt" => rows(&|_, t_s, [x, y, _]| {
            let date = format!("2016-11-24T{}Z", clock(t_s));
            format!("{{\"ts\": \"{date}\", \"dev\": \"a1\", \"ax\": {x}, \"ay\": {y}}}")
        }),
        "units_and_dates.csv" => table("time,force\n", &evenly(), &|_, t_s, [x, ..]| {
            format!("2016-11-24 {} UTC,{x} N", clock(t_s))
        }),
        "unknown_dates.txt" => {
            rows(&|_, t_s, [x, y, _]| format!("on 2016_11_24-{}: ax={x} ay={y}", clock(t_s)))
        }
        "transposed.csv" => {
            let line = |name: &str, value: &dyn Fn(usize) -> String| {
                let values: Vec<String> = (0..ROWS).map(value).collect();
                format!("{name},{}\n", values.join(","))
            };
            line("time", &|row| format!("{:.3}", even_s(row))) + &line("force", &first)
        }
        "time_code.csv" => stamped("Timecode", &|row, _| {
            format!("10:00:{:02}:{:02}", row / 25, row % 25)
        }),
        "time_x10ms.csv" => stamped("time x10 ms", &|_, t_s| format!("{:.1}", 1e2 * t_s)),
        "time_samples.csv" => stamped("Time (samples)", &|row, _| row.to_string()),
        "ticks_10us.csv" => stamped("Ticks (10 us)", &|_, t_s| format!("{:.0}", 1e5 * t_s)),
        "json_nested.txt" => table("", &evenly(), &|_, t_s, values| {
            let [x, y, _] = values;
            format!("{{\"t\": {t_s:.3}, \"acc\": {{\"x\": {x}, \"y\": {y}}}}}")
        }),
        "time_furlongs.csv" => stamped("time (furlongs)", &|_, t_s| format!("{t_s:.3}")),
        "time_ticks.csv" => stamped("time_ticks", &|_, t_s| format!("{:.0}", 1e3 * t_s)),
        "datenum.csv" => stamped("time", &|_, t_s| {
            format!("{:.10}", 738_000.25 + t_s / 86_400.0)
        }),
        "compact_dates.csv" => stamped("timestamp", &|_, t_s| {
            format!("202601311230{:06.3}", 10.0 + t_s)
        }),
        "two_clocks.csv" => stamped("time_s,timestamp_ms", &|_, t_s| {
            format!("{t_s:.3},{t_s:.3}")
        }),
        "micros_no_header.csv" => {
            numbered("", &|row| (4000 * row).to_string()).replacen(",ax,ay,az\n", "", 1)
        }
        "numbered_micros.csv" => table("", &evenly(), &|row, t_s, values| {
            format!("{},{:.0},{}", row + 1, 1e6 * t_s, values.join(","))
        }),
        "row_numbers.csv" => numbered("n", &|row| (row + 1).to_string()),
        "stated_rate.csv" => format!(
            "device: glove\nsampling rate: 250 Hz\n{}",
            table("ax,ay,az\n", &evenly(), &|_, _, values| values.join(","))
        ),
        "stated_interval.csv" => format!(
            "NPTS= 1000, DT= 0.004 SEC\n{}",
            rows(&|_, _, values| values.join(" "))
        ),
        "wrapped_5.txt" => wrapped(5, &|_| String::new(), " "),
        "wrapped_stamped.csv" => wrapped(8, &|row| format!("{:.3},", even_s(row)), ","),
        "labels.txt" => rows(&|_, _, [x, y, z]| format!("ax:{x},ay:{y},az:{z}")),
        "labels_stamped.txt" => {
            rows(&|_, t_s, [x, y, z]| format!("14:14:{:06.3} -> X,Y,Z= {x},{y},{z}", 10.0 + t_s))
        }
        "stamps_bracketed.txt" => {
            rows(&|_, t_s, [x, y, z]| format!("[14:14:{:06.3}] {x} {y} {z}", 10.0 + t_s))
        }
        "units_in_cells_ms.csv" => table("time,force,level\n", &evenly(), &|_, t_s, [x, y, _]| {
            format!("{:.0} ms,{x} N,{y} V", 1e3 * t_s)
        }),
        "json_lines.txt" => {
            rows(&|_, t_s, [x, y, z]| format!("{{\"t\": {t_s:.3}, \"acc\": [{x}, {y}, {z}]}}"))
        }
        "units_decimal_commas.csv" => {
            let commas = |text: &str| text.replace('.', ",");
            table("Zeit;Kraft;Weg\n", &evenly(), &|_, t_s, [x, y, _]| {
                commas(&format!("{t_s:.3} s;{x} N;{y} mm"))
            })
        }
        "units_missing.csv" => table("Zeit;Kraft\n", &evenly(), &|row, t_s, [x, ..]| {
            let force = match row % 50 {
                0 => "-".to_owned(),
                _ => format!("{x} N"),
            };
            format!("{t_s:.3} s;{force}").replace('.', ",")
        }),
        "teleplot_started.txt" => {
            let started = String::from_utf8(failing("teleplot.txt")).expect("text");
            format!("start, 3 ok\n\n{started}")
        }
        "units_change.csv" => table("time_s,u\n", &evenly(), &|row, t_s, [x, ..]| {
            let unit = if row < 150 { "mV" } else { "V" };
            format!("{t_s:.3},{x} {unit}")
        }),
        "thousands_points.csv" => table("t;u\n", &evenly(), &|row, t_s, _| {
            let tenths = (2e5 + 1e4 * channels(row, t_s)[1]) as u32;
            let (whole, tenth) = (tenths / 10, tenths % 10);
            let u = format!("{}.{:03},{tenth}", whole / 1000, whole % 1000);
            format!("{};{u}", format!("{t_s:.3}").replace('.', ","))
        }),
        "fortran.txt" => rows(&|_, t_s, values| {
            let values = values.map(|value| format!("{value}D+00"));
            format!("{t_s:.3} {}", values.join(" "))
        }),
        "markdown.md" => table(
            "# Run 3\n\n| t [s] | ax | ay |\n|:---|---:|---:|\n",
            &evenly(),
            &|_, t_s, [x, y, _]| format!("| {t_s:.3} | {x} | {y} |"),
        ),
        "query.txt" => {
            table(
                " time_s |  ax  |  ay\n--------+------+------\n",
                &evenly(),
                &|_, t_s, [x, y, _]| format!(" {t_s:.3} | {x} | {y}"),
            ) + "(1000 rows)\n"
        }
        "printed_rows.txt" => table("    t   ax   ay\n", &evenly(), &|row, t_s, [x, y, _]| {
            format!("{row}  {t_s:.3}  {x}  {y}")
        }),
        "colours.txt" => rows(&|_, t_s, [x, y, _]| {
            format!("\x1b[0;32mI ({:.0}) ADC: a={x} b={y}\x1b[0m", 1e3 * t_s)
        }),
        "zephyr.txt" => rows(&|_, t_s, [x, y, _]| {
            format!("[00:00:{:06.3},000] <inf> adc: a {x} b {y}", 10.0 + t_s)
        }),
        "teleplot.txt" => rows(&|_, t_s, [x, ..]| {
            format!(">force:{:.0}:{x}\u{a7}N|g", 1_627_551_892_437.0 + 1e3 * t_s)
        }),
        "teleplot_two.txt" => rows(&|_, t_s, [x, y, _]| {
            let ms = 1e3 * t_s;
            format!(">a:{ms:.0}:{x}\n>b:{ms:.0}:{y}")
        }),
        "long.csv" => table("time,channel,value\n", &evenly(), &|_, t_s, [x, y, _]| {
            format!("{t_s:.3},a,{x}\n{t_s:.3},b,{y}")
        }),
        "candump.log" => rows(&|row, t_s, _| format!("({t_s:.6}) can0 123#{:08X}", 977 * row)),
        "candump.txt" => rows(&|row, _, _| format!("  can0  1F334455   [2]  {:02X} 00", row % 256)),
        "vector.asc" => rows(&|row, t_s, _| format!(" {t_s:.6} 1  123  Rx  d 1 {:02X}", row % 256)),
        "arrays.json" => {
            let times: Vec<String> = evenly().iter().map(|t_s| format!("{t_s:.3}")).collect();
            format!("{{\"t\": [{0}], \"a\": [{0}]}}", times.join(", "))
        }
        "tuples.txt" => rows(&|_, _, [x, y, z]| format!("({x}, {y}, {z})")),
        "hexadecimal.csv" => table("time_s,adc\n", &evenly(), &|row, t_s, _| {
            format!(
                "{t_s:.3},0x{:04X}",
                (2000.0 + 300.0 * channels(row, t_s)[1]) as u32
            )
        }),
        "seconds_alone.csv" => stamped("time", &|_, t_s| {
            format!("2026-01-31 12:00:{:02}", (10.3 + t_s) as u32)
        }),
        "swapped.csv" => {
            let mut lines: Vec<String> = plain().lines().map(str::to_owned).collect();
            lines.swap(300, 301);
            lines.swap(500, 503);
            lines.join("\n") + "\n"
        }
        "reversed.csv" => {
            let whole = plain();
            let (header, rows) = whole.split_once('\n').expect("a header");
            let rows: Vec<&str> = rows.lines().rev().collect();
            format!("{header}\n{}\n", rows.join("\n"))
        }
        "two_files.csv" => plain() + plain().split_once('\n').expect("a header").1,
        "clock_set.csv" => stamped("time_s", &|row, t_s| {
            format!("{:.3}", t_s + if row < 300 { 0.0 } else { 3600.0 })
        }),
        "twenty_channels.csv" => {
            let names: Vec<String> = (0..20).map(|at| format!("c{at} (N)")).collect();
            let row = |row: usize| {
                let values: Vec<String> = (0..20)
                    .map(|at| format!("{:.5}", channels(20 * row + at, even_s(row))[at % 3]))
                    .collect();
                format!("{:.3},{}\n", even_s(row), values.join(","))
            };
            format!(
                "time_s,{}\n{}",
                names.join(",").replace("c19 (N)", "c19"),
                (0..ROWS).map(row).collect::<String>()
            )
        }
        // Has more rows than the estimator takes at once.
        "long_fast.csv" => (0..70_000).fold("time_s,x\n".into(), |csv, row| {
            let phase = std::f64::consts::TAU * 0.16 * f64::from(row);
            let noise = channels(row as usize, 0.0)[1] - channels(0, 0.0)[1];
            format!(
                "{csv}{:.3},{:.5}\n",
                f64::from(row) * 1e-3,
                phase.sin() + noise
            )
        }),
        // Two channels that must not be taken for a series with two samples per row.
        "two_phases.csv" => table("time_s,a,b\n", &evenly(), &|row, t_s, _| {
            let noise = channels(row, 0.0)[1] - channels(0, 0.0)[1];
            let value = |phase: f64| (std::f64::consts::TAU * 65.0 * t_s + phase).sin() + noise;
            format!("{t_s:.3},{:.5},{:.5}", value(0.0), value(1.0))
        }),
        "epoch.csv" => stamped("time", &|_, t_s| format!("{:.3}", 1_677_146_936.4 + t_s)),
        "one_channel.csv" => table("time_s,x\n", &evenly(), &|_, t_s, [_, y, _]| {
            format!("{t_s:.3},{y}")
        }),
        other => panic!("{other} is not made here"),
    };
    text.into_bytes()
}
