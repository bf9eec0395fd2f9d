//! Tests `ridgetone touch`: refused options, and the page in a browser, which `cargo xtask test
//! --all` installs.
#![cfg(target_os = "linux")]

#[path = "../../host/tests/common/mod.rs"]
mod common;
#[path = "touch/page.rs"]
mod page;

use common::{assert_one_line, directory, file, run, stderr, text};

#[test]
fn impossible_textures_and_options_are_refused() {
    let folder = directory();
    for (content, words) in [
        (
            "period_mm = nan\n",
            &["bad.toml", "period_mm", "0.05 to 100"][..],
        ),
        ("period_mm = 0.0\n", &["period_mm = 0", "0.05 to 100"]),
        ("period_mm = 1.0\npower = inf\n", &["power"]),
        ("period_mm = 1.0\npower = -1.0\n", &["power = -1"]),
        ("speed = 3\n", &["bad.toml", "period_mm"]),
    ] {
        let bad = file(folder.path(), "bad.toml", content);
        let refused = run(&["touch", text(&bad)]);
        let printed = stderr(&refused);
        assert!(
            refused.status.code() == Some(1) && words.iter().all(|word| printed.contains(word)),
            "{printed}"
        );
    }
    let good = file(folder.path(), "texture.toml", "period_mm = 1.4\n");
    for (arguments, words) in [
        (&["--slew-v-s", "0.1"][..], &["slew_v_s"][..]),
        (&["--cutoff-hz", "1e6"], &["cutoff_hz"]),
        (&["--delay-ms", "-1"], &["--delay-ms"]),
        (&["--delay-ms", "NaN"], &["not a number"]),
        (&["--jitter-ms", "900"], &["--jitter-ms 900", "0 to 500"]),
        (&["--emulated"], &["--emulated"]),
        (&["--carrier-hz", "100"], &["--carrier-hz", "150 to 250"]),
    ] {
        let refused = run(&[&["touch", text(&good)], arguments].concat());
        assert_one_line(&refused, 2, words);
    }
    let law = file(
        folder.path(),
        "law.toml",
        "coefficients = [1, 0, 0, 0, 0]\nperiod_mm = [2.0, 1.0]\npower_max = 1\n",
    );
    let refused = run(&["touch", text(&good), "--law", text(&law)]);
    assert!(stderr(&refused).contains("period_mm.1"), "{refused:?}");
}
