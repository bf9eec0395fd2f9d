use ridgetone_host::trade::{Bars, Windows};
#[test]
#[ignore]
fn bars() {
    let n: u32 = std::env::var("N").unwrap().parse().unwrap();
    let started = std::time::Instant::now();
    let bars = Bars::measure(Windows { accuracy: n, noise: 7 * n, detection: n / 3 }).unwrap();
    for cell in &bars.cells {
        if let Some(e) = cell.accuracy.error {
            if e.ratio > 1.05 || cell.accuracy.good < cell.accuracy.windows {
                println!("{} cycles {:.2}: {:?}", cell.setting, cell.setting.cycles(), cell.accuracy);
            }
        } else {
            println!("{}: none", cell.setting);
        }
    }
    let mut sig: Vec<f64> = bars.cells.iter().filter_map(|c| Some(c.accuracy.error?.ratio_sigma)).collect();
    sig.sort_by(f64::total_cmp);
    println!("median ratio sigma {}", sig[sig.len() / 2]);
    for v in bars.verdicts() {
        println!("{v:?}");
    }
    println!("{:?}", started.elapsed());
}
#[test]
#[ignore]
fn grid() {
    let n: u32 = std::env::var("N").unwrap().parse().unwrap();
    let started = std::time::Instant::now();
    for r in ridgetone_host::trade::grid::measure(n).unwrap() {
        let a = r.accuracy;
        print!(
            "{:20} {:4} s carried {} h {} ch {:2}: {:4} good {:4} amb {:3} oct {:3} ",
            r.method, r.window_s, r.carried, r.harmonics, r.channels, a.windows, a.good, a.ambiguous, a.octaves
        );
        if let Some(e) = a.error {
            print!(
                "{:8.4} Hz {:8.4} % bound {:.4} ratio {:.3} +- {:.3}",
                e.rms_hz, e.rms_percent, e.bound_percent, e.ratio, e.ratio_sigma
            );
        }
        println!();
    }
    println!("{:?}", started.elapsed());
}
