//! `ridgetone skin fit`: a row of the paper's Table 5 from the force that it describes, and a
//! display with one's own skin.

#[path = "../../host/tests/common/mod.rs"]
mod common;

use common::{assert_one_line, directory, file, json_lines, run, stdout, text};

/// The force of subject 1 before the step at 2.5 s and after it.
fn force() -> String {
    let mut csv = "time_s,force_n,depth_mm\n".to_owned();
    for row in 0..1750 {
        let t_s = 0.01 * f64::from(row);
        let force_n = if t_s < 2.5 {
            0.1
        } else {
            2.29 + 1.15 * (-0.70 * (t_s - 2.5)).exp()
        };
        csv += &format!("{t_s:.2},{force_n:.6},{}\n", u8::from(t_s >= 2.5));
    }
    csv
}

#[test]
fn a_row_of_table_5_comes_out() {
    let folder = directory();
    let path = file(folder.path(), "force.csv", &force());
    let arguments = ["skin", "fit", text(&path), "--from", "2.5"];
    // Two columns could be the force.
    assert_one_line(&run(&arguments), 1, &["--column"]);
    let arguments = [&arguments[..], &["--column", "force_n"]].concat();
    let [found] = &json_lines(&run(&[&arguments[..], &["--json"]].concat()))[..] else {
        panic!("one line")
    };
    for (name, expected) in [
        ("a", 2.29),
        ("b", 1.15),
        ("c_per_s", 0.70),
        ("relaxation_s", 1.43),
        ("creep_s", 2.15),
    ] {
        let value = found[name]["value"].as_f64().expect("a number");
        assert!((value / expected - 1.0).abs() < 2e-3, "{name}: {found}");
    }
    let shown = stdout(&run(&arguments));
    assert!(shown.contains("pins --subject 1.429,2.146"), "{shown}");
    // With the time before the step it is no exponential that fades.
    let before = ["skin", "fit", text(&path), "--column", "force_n"];
    assert_one_line(&run(&before), 1, &["force"]);
}
