//! The commands that show, record and ask a board, on the emulated one.

use crate::common::{directory, json_lines, run, stderr, stdout, text};
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

#[test]
#[ignore = "needs the emulator: cargo xtask test"]
fn the_emulated_board_is_recorded_with_raw_frames_from_which_the_library_gets_the_same_tone() {
    let folder = directory();
    let (recording, frames) = (folder.path().join("touch.rec"), folder.path().join("frames.csv"));
    let recorded = run(&["record", "--emulated", "--raw", "-o", text(&recording)]);
    assert!(recorded.status.success(), "{}", stderr(&recorded));
    assert!(stderr(&recorded).contains("0 lost, 0 damaged"), "{}", stderr(&recorded));
    let said = json_lines(&run(&["replay", text(&recording), "--json"]));
    let tone = |lines: &[serde_json::Value]| {
        let whole = lines.iter().find(|line| line["span"] == "slide").expect("an estimate of the slide");
        whole["frequency_hz"].as_f64().expect("a tone")
    };
    let numbers: Vec<u64> =
        said.iter().filter(|line| line["type"] == "raw").filter_map(|line| line["number"].as_u64()).collect();
    assert!(numbers.len() > 1000 && numbers.windows(2).all(|pair| pair[1] == pair[0] + 1), "{}", numbers.len());
    let output = run(&["export", text(&recording), "--format", "csv", "--table", "frames", "-o", text(&frames)]);
    assert!(output.status.success(), "{}", stderr(&output));
    let again = json_lines(&run(&["replay", text(&frames), "--noise", "off", "--json"]));
    // The paper's 30 mm/s over 3.6 mm, on the board and from its frames.
    for found in [tone(&said), tone(&again)] {
        assert!((found / (30.0 / 3.6) - 1.0).abs() < 1e-3, "{found} Hz");
    }
}

#[test]
#[ignore = "needs the emulator: cargo xtask test"]
fn the_emulated_board_tells_its_settings_takes_others_and_refuses_what_is_out_of_bounds() {
    let folder = directory();
    let found = run(&["settings", "get", "--emulated"]);
    assert!(found.status.success(), "{}", stderr(&found));
    let file = crate::common::file(folder.path(), "finger.toml", &stdout(&found));
    assert_eq!(ridgetone_host::settings_form::load(&file).expect("settings"), Default::default());
    let set = run(&["settings", "set", "--emulated", "window_s=0.5", "--keep"]);
    assert!(set.status.success() && stderr(&set).contains("in force and stored"), "{}", stderr(&set));
    let file = crate::common::file(folder.path(), "short.toml", "window_s = 0.5\nhop_s = 0.5\n");
    let lines = run(&["monitor", "--emulated", "--once", "--json", "--settings", text(&file)]);
    let lines = json_lines(&lines);
    let windows: Vec<f64> =
        lines.iter().filter(|line| line["span"] == "window").filter_map(|line| line["window_s"].as_f64()).collect();
    assert!(windows.len() >= 3 && windows.iter().all(|window_s| (window_s - 0.5).abs() < 0.01), "{windows:?}");
}

/// Every line of the README that begins with one of these commands, one after the other in one folder. Those that need a
/// board say that there is none.
#[test]
#[ignore = "needs the emulator: cargo xtask test"]
fn the_readme_s_commands_on_boards_and_recordings_run() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().expect("the workspace");
    let readme = std::fs::read_to_string(root.join("README.md")).expect("README.md");
    let live = readme.split("\n## Live\n").nth(1).and_then(|rest| rest.split("\n## ").next()).expect("the section");
    let block = live.split("```").nth(1).expect("commands");
    let commands: Vec<&str> = block.lines().filter(|line| line.starts_with("ridgetone ")).collect();
    assert!(commands.len() >= 8, "{commands:?}");
    let folder = directory();
    let binary = Path::new(env!("CARGO_BIN_EXE_ridgetone")).parent().expect("a folder");
    let path = format!("{}:{}", text(binary), std::env::var("PATH").expect("a path"));
    for command in commands {
        let endless = command.starts_with("ridgetone monitor --emulated");
        // What is endless is interrupted, as Ctrl-C does, but once.
        let shell = if endless { format!("timeout --foreground --signal INT 8 {command}") } else { command.to_owned() };
        let begun = Instant::now();
        let elf = ridgetone_host::emulator::image::find().expect("an image");
        let target = elf.ancestors().nth(3).expect("the target folder");
        let output = Command::new("sh")
            .args(["-c", &shell])
            .current_dir(folder.path())
            .env("PATH", &path)
            .env("CARGO_TARGET_DIR", target)
            .stdin(Stdio::null())
            .output()
            .expect("a shell");
        let said = stderr(&output);
        // What timeout ends it calls 124, whatever the command made of it.
        let fine = output.status.success() || (endless && output.status.code() == Some(124));
        let no_ports = command.starts_with("ridgetone ports") && said.contains("cannot be listed");
        assert!(fine || no_ports, "{command}: {said}");
        assert!(!endless || begun.elapsed() > Duration::from_secs(5) && said.contains("0 lost, 0 damaged"), "{said}");
    }
    for file in ["touch.rec", "touch.mcap", "frames.csv", "finger.toml"] {
        assert!(folder.path().join(file).exists(), "{file}");
    }
}
