//! Tests the command line: misspelt words, shell completions, the manual, and existing files.

mod common;

use common::{assert_one_line, directory, file, run, stderr, stdout, text, tone};
use std::process::Command;

#[test]
fn a_word_that_is_nearly_right_is_supposed() {
    assert_one_line(
        &run(&["replya"]),
        2,
        &["unrecognized subcommand 'replya'", "similar", "'replay'"],
    );
    assert_one_line(
        &run(&["replay", "--windw", "1"]),
        2,
        &["--windw", "similar", "'--window'"],
    );
    assert_one_line(
        &run(&["export", "a", "--format", "mcpa"]),
        2,
        &["mcpa", "'mcap'"],
    );
    let folder = directory();
    let table = file(folder.path(), "tone.csv", &tone(2, 400, 100.0, 5.0, 0.0));
    assert_one_line(
        &run(&["fit", text(&table), "--columns", "c0,d1"]),
        1,
        &["no column d1", "c0, c1"],
    );
}

#[test]
fn shells_get_scripts_that_they_can_read_and_the_manual_has_a_page_for_each_command() {
    for (shell, word) in [
        ("bash", "complete -F _ridgetone"),
        ("zsh", "#compdef ridgetone"),
        ("fish", "complete -c ridgetone"),
    ] {
        let script = run(&["help-files", "--completions", shell]);
        assert!(
            script.status.success() && stdout(&script).contains(word),
            "{shell}"
        );
        assert!(stdout(&script).contains("time-column"), "{shell}");
    }
    let folder = directory();
    let script = file(
        folder.path(),
        "ridgetone.bash",
        &stdout(&run(&["help-files", "--completions", "bash"])),
    );
    // Bash itself completes the word.
    let completion = "source \"$0\"; COMP_WORDS=(ridgetone rep); COMP_CWORD=1; _ridgetone ridgetone rep ridgetone; echo ${COMPREPLY[*]}";
    let found = Command::new("bash")
        .args(["-c", completion, text(&script)])
        .output()
        .expect("bash");
    assert_eq!(stdout(&found).trim(), "replay", "{}", stderr(&found));

    let man = folder.path().join("man1");
    assert!(run(&["help-files", "--man", text(&man)]).status.success());
    for page in ["ridgetone.1", "ridgetone-fit.1", "ridgetone-settings-set.1"] {
        let page = std::fs::read_to_string(man.join(page)).expect("a page");
        assert!(
            page.contains(".SH OPTIONS") && page.contains("force"),
            "{page}"
        );
    }
}

#[test]
fn no_file_is_overwritten_without_a_word() {
    let folder = directory();
    let there = file(folder.path(), "there.csv", "mine\n");
    let rec = folder.path().join("touch.rec");
    let input = ridgetone_host::input::Input::default()
        .open()
        .expect("a scene");
    let made =
        ridgetone_host::replay::run(input, Default::default(), &mut |_| Ok(()), &mut |_, _| {});
    std::fs::write(&rec, made.expect("a replay").serial).expect("a file");
    let there = text(&there);
    for command in [
        &["emulate", "--print-scene", there][..],
        &["export", text(&rec), "-o", there],
        &["demo", "--svg", there],
        &["fit", "none.csv", "--svg", there],
    ] {
        assert_one_line(
            &run(command),
            1,
            &["there.csv", "exists already", "--force"],
        );
        assert_eq!(std::fs::read_to_string(there).expect("a file"), "mine\n");
    }
    assert!(
        run(&["export", text(&rec), "-o", there, "--force"])
            .status
            .success()
    );
    assert!(
        std::fs::read_to_string(there)
            .expect("a file")
            .starts_with("t_s,")
    );
    // `-` means standard output; the table determines the format.
    for command in [
        &["export", text(&rec), "--table", "health"][..],
        &["export", text(&rec), "--table", "health", "-o", "-"],
        &["emulate", "--print-scene", "-"],
    ] {
        let done = run(command);
        assert!(done.status.success(), "{}", stderr(&done));
        let rows = stdout(&done);
        assert!(rows.starts_with("t") && rows.lines().count() > 1, "{rows}");
    }
    // A recording is never replaced, because it cannot be made again.
    assert_one_line(
        &run(&[
            "export",
            text(&rec),
            "-o",
            text(&rec),
            "--format",
            "csv",
            "--force",
        ]),
        1,
        &["not overwritten"],
    );
}

#[test]
fn the_format_is_that_of_the_files_name() {
    let folder = directory();
    let rec = folder.path().join("touch.rec");
    let input = ridgetone_host::input::Input::default()
        .open()
        .expect("a scene");
    let made =
        ridgetone_host::replay::run(input, Default::default(), &mut |_| Ok(()), &mut |_, _| {});
    std::fs::write(&rec, made.expect("a replay").serial).expect("a file");
    for (name, start) in [
        ("a.csv", &b"t_s,"[..]),
        ("a.ndjson", b"{\"type\":\"hello\""),
        ("a.jsonl", b"{"),
        ("A.MCAP", b"\x89MCAP"),
    ] {
        let path = folder.path().join(name);
        assert!(
            run(&["export", text(&rec), "-o", text(&path)])
                .status
                .success(),
            "{name}"
        );
        assert!(
            std::fs::read(&path).expect("a file").starts_with(start),
            "{name}"
        );
    }
    assert_one_line(
        &run(&[
            "export",
            text(&rec),
            "-o",
            text(&folder.path().join("a.txt")),
        ]),
        2,
        &["--format"],
    );
    assert_one_line(&run(&["export", text(&rec)]), 2, &["--format"]);
}

#[test]
fn text_of_a_run_that_is_over_is_in_the_order_of_time() {
    let lines = stdout(&run(&["replay"]));
    let times: Vec<f64> = lines
        .lines()
        .filter_map(|line| line.get(..8)?.trim().parse().ok())
        .collect();
    assert!(times.len() > 10 && times.is_sorted(), "{times:?}");
    // The estimate of a whole slide is reported after the slide's end, but its time is earlier.
    let at = |part: &str| lines.find(part).expect("a line");
    assert!(at("SLIDE") < at("ends; "), "{lines}");
}

/// Runs `ridgetone` in a separate folder, next to `script` as `ridgetone-teletaction` if there is
/// one.
#[cfg(unix)]
fn beside(script: Option<&str>, words: &[&str]) -> std::process::Output {
    let folder = directory();
    // A separate process copies the file: a file that this process has open for writing cannot be
    // run while a child forked by a parallel test still holds it open.
    let install = |from: &std::path::Path, name: &str| {
        let to = folder.path().join(name);
        let mut install = std::process::Command::new("install");
        let done = install.args(["-m", "755"]).arg(from).arg(&to).status();
        assert!(done.expect("install runs").success());
        to
    };
    let ridgetone = install(env!("CARGO_BIN_EXE_ridgetone").as_ref(), "ridgetone");
    if let Some(script) = script {
        let written = file(folder.path(), "script", script);
        install(&written, "ridgetone-teletaction");
    }
    std::process::Command::new(&ridgetone)
        .args(words)
        .env("PATH", "/nowhere")
        .output()
        .expect("the command runs")
}

#[cfg(unix)]
#[test]
fn teletaction_gets_its_words_and_gives_its_status() {
    let script = "#!/bin/sh\nfor word; do echo \"[$word]\"; done\nexit 7\n";
    for command in ["touch", "pins", "link"] {
        let words = [command, "--help", "a b", "--open", "-o", "-"];
        let output = beside(Some(script), &words);
        assert_eq!(output.status.code(), Some(7));
        assert_eq!(
            stdout(&output),
            words.map(|word| format!("[{word}]\n")).concat()
        );
        for words in [
            ["--force", command, "a"],
            [command, "--force", "a"],
            [command, "a", "--force"],
        ] {
            assert!(stdout(&beside(Some(script), &words)).contains("[--force]"));
        }
    }
}

#[cfg(unix)]
#[test]
fn without_teletaction_a_line_says_how_to_install_it() {
    for command in ["touch", "pins", "link"] {
        let parts = [command, "cargo install --path teletaction"];
        assert_one_line(&beside(None, &[command, "--emulated"]), 1, &parts);
    }
}

#[test]
fn an_unknown_command_is_refused_with_what_may_be_meant() {
    assert_one_line(&run(&["fitt", "a.csv"]), 2, &["fitt", "'fit'", "--help"]);
    assert_one_line(&run(&["nothing-like-it"]), 2, &["nothing-like-it"]);
    let help = stdout(&run(&["--help"]));
    let line = help
        .lines()
        .find(|line| line.contains("ridgetone-teletaction"))
        .expect("a line");
    assert!(
        ["touch", "pins", "link"]
            .iter()
            .all(|name| line.contains(name)),
        "{help}"
    );
}
