//! Tests runs and recording at the server without a browser.

use super::served::{LONG, request};
use super::{View, packets, recorded};
use crate::common;
use ridgetone_proto::telemetry::{Event, Packet, Release, WIRE_MAX, encode};
use rustix::process::{Pid, Signal, kill_process};
use serde_json::Value;
use std::io::{Read, Write};
use std::net::TcpStream;
use std::thread::sleep;
use std::time::{Duration, Instant};

/// Posts a request. Returns status and body of the answer.
fn post(address: &str, path: &str, origin: &str, body: &[u8]) -> (u16, String) {
    let mut line = TcpStream::connect(address).expect("it listens");
    write!(
        line,
        "POST {path} HTTP/1.1\r\nHost: {address}\r\nConnection: close\r\nOrigin: {origin}\r\n"
    )
    .expect("sent");
    write!(
        line,
        "Content-Type: application/octet-stream\r\nContent-Length: {}\r\n\r\n",
        body.len()
    )
    .expect("sent");
    line.write_all(body).expect("sent");
    let mut text = String::new();
    line.read_to_string(&mut text).expect("an answer");
    let status = text
        .split(' ')
        .nth(1)
        .and_then(|status| status.parse().ok())
        .expect("a status");
    (
        status,
        text.split_once("\r\n\r\n").expect("a head").1.to_owned(),
    )
}

#[test]
fn a_run_is_what_the_commands_say_of_its_file_at_any_time_and_in_any_part() {
    let folder = common::directory();
    let all = packets(f64::INFINITY);
    let path = recorded(folder.path(), &all);
    let view = View::start(&["--file", common::text(&path), "--pace", "1"]);
    let (address, origin) = (
        view.address().to_owned(),
        format!("http://{}", view.address()),
    );
    let json =
        |text: &str| -> Value { serde_json::from_str(text).unwrap_or_else(|_| panic!("{text}")) };
    let bytes = std::fs::read(&path).expect("a file");
    let (status, body) = post(&address, "/runs?name=touch.rec", &origin, &bytes);
    let run = json(&body);
    assert!(
        status == 200 && run["name"] == "touch.rec" && run["touches"] == 1,
        "{body}"
    );
    let id = run["id"].as_u64().expect("a number");
    let get = |path: &str| request(&address, path, &address, LONG);
    let at = |query: &str| json(&get(&format!("/runs/{id}/state.json?{query}")).2);

    // The state at a time must be based on all packets sent by then.
    let lines = common::json_lines(&common::run(&[
        "monitor",
        "--file",
        common::text(&path),
        "--pace",
        "0",
        "--json",
    ]));
    let estimates: Vec<&Value> = lines
        .iter()
        .filter(|line| line["type"] == "estimate")
        .collect();
    let third = estimates[2];
    let t_s = third["t_s"].as_f64().expect("a time");
    let state = at(&format!("t_s={}", t_s + 0.01));
    assert_eq!(
        state["live"]["latest"]["estimate"]["frequency_hz"],
        third["frequency_hz"]
    );
    assert_eq!(
        (
            &state["live"]["history"].as_array().map(Vec::len),
            &state["live"]["phase"]
        ),
        (&Some(3), &"sliding".into())
    );
    let last_s = state["live"]["strips"]["t_s"]
        .as_array()
        .and_then(|all| all.last()?.as_f64())
        .expect("frames");
    assert!(
        (last_s - t_s).abs() < 0.02 && state["curves"]["fit_v"].is_array(),
        "{last_s} and {t_s}"
    );
    assert_eq!(
        run["estimate"]["frequency_hz"],
        estimates
            .iter()
            .rfind(|e| e["span"] == "slide")
            .expect("one")["frequency_hz"]
    );

    // The fits of a part and of the whole must equal those of `fit`, also for a table.
    let frames = folder.path().join("frames.csv");
    let export = [
        "export",
        common::text(&path),
        "--format",
        "csv",
        "--table",
        "frames",
        "-o",
        common::text(&frames),
    ];
    assert!(common::run(&export).status.success());
    let bytes_of_table = std::fs::read(&frames).expect("a file");
    let (status, body) = post(&address, "/runs?name=frames.csv", &origin, &bytes_of_table);
    let table = json(&body);
    assert!(
        status == 200 && table["is_table"] == true && table["touches"] == 1,
        "{body}"
    );
    let (from, to) = (format!("{}", t_s - 1.3), format!("{}", t_s - 0.1));
    for (id, path) in [(&run["id"], &path), (&table["id"], &frames)] {
        let file = common::text(path);
        let part = ["fit", file, "--from", &from, "--to", &to, "--json"];
        for (query, command) in [
            (format!("?from_s={from}&until_s={to}"), &part[..]),
            (String::new(), &["fit", file, "--json"]),
        ] {
            let here = json(&get(&format!("/runs/{id}/fit.json{query}")).2);
            let there = &common::json_lines(&common::run(command))[0];
            let found = there.as_object().expect("a fit").iter();
            let differ = found.filter(|(name, value)| *name != "file" && here[*name] != **value);
            assert_eq!(differ.count(), 0, "{here} {there}");
        }
    }
    let svg = get(&format!("/runs/{}/fit.svg", table["id"])).2;
    assert!(
        svg.starts_with("<svg") && svg.contains("frames.csv"),
        "{svg}"
    );
    let outside = get(&format!("/runs/{id}/fit.json?from_s=200&until_s=201"));
    assert!(
        outside.0 == 422 && outside.2.starts_with("touch.rec") && !outside.2.contains("/tmp"),
        "{}",
        outside.2
    );

    let (status, body) = post(
        &address,
        &format!("/runs/{id}/settings"),
        &origin,
        br#"{"window_s":0.5}"#,
    );
    assert!(status == 200, "{body}");
    let state = at(&format!("t_s={}", t_s + 0.01));
    assert!(
        (state["live"]["latest"]["estimate"]["window_s"]
            .as_f64()
            .expect("a window")
            - 0.5)
            .abs()
            < 0.01
    );
    let refused = post(
        &address,
        &format!("/runs/{id}/settings"),
        &origin,
        br#"{"window_s":9}"#,
    );
    assert!(
        refused.0 == 422 && refused.1.contains("0.1 to 3.9"),
        "{}",
        refused.1
    );
    let exported = folder.path().join("touch.mcap");
    assert!(
        common::run(&["export", common::text(&path), "-o", common::text(&exported)])
            .status
            .success()
    );
    let (status, body) = post(
        &address,
        "/runs?name=touch.mcap",
        &origin,
        &std::fs::read(&exported).expect("a file"),
    );
    let [a, b] = [&run, &json(&body)].map(|run| {
        run["estimate"]["frequency_hz"]
            .as_f64()
            .expect("a frequency")
    });
    assert!(status == 200 && (a / b - 1.0).abs() < 1e-4, "{a} and {b}");

    // A file that is not a run must be refused under its original name, and requests from other
    // pages must be refused.
    let refused = post(
        &address,
        "/runs?name=a%20letter.txt",
        &origin,
        b"Dear all,\nthis is no table.\n",
    );
    assert!(
        refused.0 == 422 && refused.1.starts_with("a letter.txt") && !refused.1.contains("/tmp"),
        "{}",
        refused.1
    );
    assert_eq!(
        post(&address, "/runs?name=x", "http://example.org", &bytes).0,
        403
    );
    // The command opens its own file as the first run. Close this run.
    let names = |text: &str| {
        json(text)
            .as_array()
            .expect("a list")
            .iter()
            .map(|run| run["name"].clone())
            .collect::<Vec<_>>()
    };
    let listed = names(&get("/runs").2);
    assert!(
        listed.iter().filter(|name| **name == "touch.rec").count() == 2
            && listed.contains(&"touch.mcap".into())
    );
    assert_eq!(
        post(&address, &format!("/runs/{id}/close"), &origin, b"").0,
        200
    );
    assert_eq!(get(&format!("/runs/{id}/state.json?t_s=1")).0, 422);
}

#[test]
fn what_is_recorded_and_the_last_minute_are_runs_that_the_commands_read() {
    let folder = common::directory();
    let path = recorded(folder.path(), &packets(f64::INFINITY));
    // Play slowly, so that the file does not end before the recording does.
    let view = View::start(&["--file", common::text(&path), "--pace", "0.5"]);
    let (address, origin) = (
        view.address().to_owned(),
        format!("http://{}", view.address()),
    );
    let json =
        |text: &str| -> Value { serde_json::from_str(text).unwrap_or_else(|_| panic!("{text}")) };
    let get = |path: &str| request(&address, path, &address, LONG);
    let received = || {
        json(&get("/state.json").2)["live"]["counts"]["received"]
            .as_u64()
            .expect("a count")
    };
    let wait_for = |count: u64| {
        let begun = Instant::now();
        while received() < count {
            assert!(begun.elapsed() < LONG, "{}", received());
            sleep(Duration::from_millis(20));
        }
    };
    wait_for(50);
    let before = received();
    assert_eq!(
        post(&address, "/record", &origin, b""),
        (200, String::new())
    );
    assert!(json(&get("/state.json").2)["recording_s"].is_number());
    wait_for(before + 200);
    let (status, body) = post(&address, "/record", &origin, b"");
    let run = json(&body);
    let frames = run["frames"].as_u64().expect("a count");
    assert!(
        status == 200 && (150..=received()).contains(&frames) && run["name"] != "",
        "{body}"
    );
    // Less than a minute was received, so the last minute must contain all of it.
    let (status, body) = post(&address, "/record/latest", &origin, b"");
    let latest = json(&body);
    assert!(
        status == 200 && latest["from_s"].as_f64() < Some(0.1),
        "{body}"
    );
    assert!(
        latest["frames"].as_u64() >= Some(frames + 40)
            && latest["until_s"].as_f64() >= run["until_s"].as_f64()
    );
    let (_, _, file) = get(&format!("/runs/{}/file", run["id"]));
    assert!(
        file.starts_with("ridgetone telemetry 2 {"),
        "{}",
        &file[..40]
    );
}

/// The upload has 13 MB, but would need thirty times as much memory.
#[test]
fn an_upload_is_bounded_by_what_it_expands_to() {
    let (mut bytes, mut wire) = (Vec::new(), [0; WIRE_MAX]);
    for number in 0..1_000_000u32 {
        let event = Event::Release(Release {
            t_us: u64::from(number),
            reported_after_us: 0,
        });
        let sequence = number as u16;
        let used = encode(&Packet { sequence, event }, &mut wire).expect("it fits");
        bytes.extend_from_slice(&wire[..used]);
    }
    let folder = common::directory();
    let path = recorded(folder.path(), &packets(1.0));
    let view = View::start(&["--file", common::text(&path)]);
    let (address, origin) = (view.address(), format!("http://{}", view.address()));
    let (status, why) = post(address, "/runs?name=a", &origin, &bytes);
    assert!(status == 422 && why.contains("256 MiB"), "{status}: {why}");
    let (_, _, listed) = request(address, "/runs", address, LONG);
    let listed: Value = serde_json::from_str(&listed).expect("JSON");
    let count = listed.as_array().map(Vec::len);
    assert_eq!(count, Some(1), "the command's own file");
}

#[test]
fn a_table_is_read_as_its_options_say() {
    let folder = common::directory();
    // Each row has four samples of one series.
    let sample = |at: usize| (core::f64::consts::TAU * 12.34 * at as f64 / 250.0).sin();
    let cells = |row: usize| (0..4).map(move |cell| format!("{:.5}", sample(4 * row + cell)));
    let rows = (0..300).map(|row| cells(row).collect::<Vec<_>>().join(" ") + "\n");
    let path = common::file(folder.path(), "wrapped.txt", &rows.collect::<String>());
    let options = ["--rate", "250", "--flatten"];
    let view = View::start(&[&[common::text(&path)], &options[..]].concat());
    let address = view.address();
    let (status, _, listed) = request(address, "/runs", address, LONG);
    let listed: Value = serde_json::from_str(&listed).expect("JSON");
    let found = listed[0]["fit"]["frequency_hz"].as_f64();
    assert!(
        status == 200 && found.is_some_and(|hz| (hz - 12.34).abs() < 0.01),
        "{listed}"
    );
    for command in ["view", "replay"] {
        let refused = common::run(&[command, "--flatten"]);
        common::assert_one_line(&refused, 2, &["--flatten", "name its file"]);
    }
}

/// The folder of runs must be removed however the command ends, even while a page is connected.
#[test]
fn the_folder_of_runs_goes_with_the_command() {
    let folder = common::directory();
    let temporary = common::directory();
    let path = recorded(folder.path(), &packets(f64::INFINITY));
    let bytes = std::fs::read(&path).expect("a file");
    for signal in [Signal::INT, Signal::TERM, Signal::HUP, Signal::INT] {
        let mut view = View::with(
            &["--file", common::text(&path)],
            &[("TMPDIR", common::text(temporary.path()))],
        );
        let (address, origin) = (view.address(), format!("http://{}", view.address()));
        let (status, body) = post(address, "/runs?name=touch.rec", &origin, &bytes);
        assert_eq!(status, 200, "{body}");
        let mut page = TcpStream::connect(address).expect("it listens");
        write!(page, "GET /events HTTP/1.1\r\nHost: {address}\r\n\r\n").expect("sent");
        page.set_read_timeout(Some(LONG)).expect("a time");
        page.read_exact(&mut [0; 512]).expect("updates");
        let files = || {
            std::fs::read_dir(temporary.path())
                .expect("a folder")
                .count()
        };
        assert_eq!(files(), 1);
        kill_process(Pid::from_child(&view.child), signal).expect("a signal");
        view.child.wait().expect("ended");
        assert_eq!(files(), 0, "{signal:?}");
    }
}
