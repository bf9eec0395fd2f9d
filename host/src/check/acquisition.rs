//! The frames: their rate, their times, and what the inputs show.

use super::observations::{Observations, Watched, input_names};
use super::signals::{Clock, dead_and_railed, line, noise};
use super::verdict::{Check, Inputs, TROUBLESHOOTING, Verdict, WIRING, graded};
use ads1258::DataRate;
use ridgetone::scan::CONVERSION_NS;
use ridgetone_proto::plan::Plan;
use ridgetone_proto::settings::{FRAME_RATE_HZ, SCAN, TAXELS};
use serde_json::json;

/// Codes of the reference: 1 LSB is VREF / 780000h (SBAS297G, data format).
const VREF_CODES: f64 = 7_864_320.0;

/// Noise of one reading with shorted inputs, microvolts rms (SBAS297G, noise table, without CHOP).
const NOISE_UV: f64 = match SCAN.data_rate {
    DataRate::Drate0 => 2.8,
    DataRate::Drate1 => 4.5,
    DataRate::Drate2 => 7.9,
    DataRate::Drate3 => 12.0,
};

/// Noise over that of the datasheet, whose figures are typical.
const NOISE: (f64, f64) = (1.5, 3.0);

/// Mains and twice mains.
const LINES_HZ: [f64; 4] = [50.0, 60.0, 100.0, 120.0];

/// Pick-up, microvolts rms: twice the converter's noise, and a good part of a touch, which makes
/// millivolts.
const PICK_UP_UV: (f64, f64) = (10.0, 1000.0);

/// Rate off the nominal one, ppm: what two crystals may do with their capacitors, and the
/// firmware's limit for the fault `clock`.
const RATE_PPM: (f64, f64) = (200.0, 5000.0);

/// Jitter, microseconds rms: at 100 Hz these are 1 % and 6 % of a tone's amplitude.
const JITTER_RMS_US: (f64, f64) = (20.0, 100.0);

/// Worst jitter, microseconds: half a conversion, and a whole one, which is a stamp of the wrong
/// edge.
const JITTER_WORST_US: (f64, f64) = (CONVERSION_NS as f64 / 2000.0, CONVERSION_NS as f64 / 1000.0);

pub fn checks(seen: &Observations, inputs: Inputs) -> Vec<Check> {
    let names = ["frame_rate", "drdy_jitter", "inputs", "noise", "mains"];
    let Some(watched) = &seen.watched else {
        return names
            .map(|name| Check::skipped(name, TROUBLESHOOTING, seen.why()))
            .into();
    };
    if watched.frames.is_empty() {
        return names
            .map(|name| {
                Check::new(
                    name,
                    WIRING,
                    Verdict::Fail,
                    "no frame was read".into(),
                    json!({}),
                )
            })
            .into();
    }
    let vref_v = seen
        .hello
        .as_ref()
        .map_or(0.0, |hello| f64::from(hello.settings.vref_v));
    let uv = 1e6 * vref_v / VREF_CODES;
    // A scan that is restarted has another phase.
    let is_one_scan = watched.before.chip_restarts == watched.after.chip_restarts;
    let clock = if is_one_scan {
        Clock::of(&watched.frames)
    } else {
        None
    };
    vec![
        frame_rate(clock),
        drdy_jitter(clock),
        dead_or_railed(watched),
        noise_of_inputs(watched, uv, inputs),
        mains(watched, uv, inputs, clock),
    ]
}

fn frame_rate(clock: Option<Clock>) -> Check {
    let Some(Clock { frame_rate_hz, .. }) = clock else {
        return Check::skipped(
            "frame_rate",
            TROUBLESHOOTING,
            "no second of frames without a restart of the scan",
        );
    };
    let off_ppm = (frame_rate_hz / f64::from(FRAME_RATE_HZ) - 1.0) * 1e6;
    let finding =
        format!("{frame_rate_hz:.3} Hz, {off_ppm:+.0} ppm off the nominal {FRAME_RATE_HZ:.3} Hz");
    let verdict = graded(off_ppm.abs() > RATE_PPM.0, off_ppm.abs() > RATE_PPM.1);
    let values = json!({ "frame_rate_hz": frame_rate_hz, "off_nominal_ppm": off_ppm });
    Check::new("frame_rate", TROUBLESHOOTING, verdict, finding, values)
}

fn drdy_jitter(clock: Option<Clock>) -> Check {
    let Some(Clock {
        jitter_rms_us: rms,
        jitter_worst_us: worst,
        ..
    }) = clock
    else {
        return Check::skipped(
            "drdy_jitter",
            TROUBLESHOOTING,
            "no second of frames without a restart of the scan",
        );
    };
    let warns = rms > JITTER_RMS_US.0 || worst > JITTER_WORST_US.0;
    let verdict = graded(warns, rms > JITTER_RMS_US.1 || worst > JITTER_WORST_US.1);
    let finding = format!("{rms:.2} us rms, {worst:.1} us at worst");
    Check::new(
        "drdy_jitter",
        TROUBLESHOOTING,
        verdict,
        finding,
        json!({ "rms_us": rms, "worst_us": worst }),
    )
}

fn dead_or_railed(watched: &Watched) -> Check {
    let (dead, railed) = dead_and_railed(&watched.frames);
    let absent = Plan::PAPER.inputs & !watched.present();
    let named = [
        (absent, "never read"),
        (dead, "dead, always the same code"),
        (railed, "at the end of the scale"),
    ];
    let findings: Vec<String> = named
        .into_iter()
        .filter(|(mask, _)| *mask != 0)
        .map(|(mask, what)| format!("{what}: {}", input_names(mask)))
        .collect();
    let values = json!({ "absent": input_names(absent), "dead": input_names(dead), "at_rail": input_names(railed) });
    match findings.is_empty() {
        true => {
            let finding = format!(
                "all {} live, none at the end of the scale",
                Plan::PAPER.channels()
            );
            Check::new("inputs", WIRING, Verdict::Pass, finding, values)
        }
        false => Check::new("inputs", WIRING, Verdict::Fail, findings.join("; "), values),
    }
}

fn noise_of_inputs(watched: &Watched, uv: f64, inputs: Inputs) -> Check {
    let runs = watched.untouched();
    let lsb: [Option<f64>; TAXELS] = std::array::from_fn(|input| noise(&runs, input));
    let Some((worst, most)) = greatest(&lsb) else {
        return Check::skipped("noise", WIRING, "the finger was touched all the time");
    };
    let all_uv: Vec<_> = lsb.iter().map(|lsb| lsb.map(|lsb| lsb * uv)).collect();
    let values = json!({ "lsb_rms": lsb, "uv_rms": all_uv, "datasheet_uv_rms": NOISE_UV });
    let ratio = most * uv / NOISE_UV;
    let most = format!(
        "{:.1} LSB = {:.1} uV rms on AIN{worst}, the most",
        most,
        most * uv
    );
    match inputs {
        Inputs::Shorted => {
            let finding = format!("{most}; the datasheet has {NOISE_UV} uV");
            Check::new(
                "noise",
                WIRING,
                graded(ratio > NOISE.0, ratio > NOISE.1),
                finding,
                values,
            )
        }
        Inputs::Open | Inputs::InUse => Check::new(
            "noise",
            WIRING,
            Verdict::Skipped,
            format!("{most}; judged with --inputs shorted only"),
            values,
        ),
    }
}

fn mains(watched: &Watched, uv: f64, inputs: Inputs, clock: Option<Clock>) -> Check {
    let runs = watched.untouched();
    let rate_hz = clock.map_or(f64::from(FRAME_RATE_HZ), |clock| clock.frame_rate_hz);
    let lines = LINES_HZ.map(|line_hz| {
        let uv_rms: [Option<f64>; TAXELS] = std::array::from_fn(|input| {
            line(&runs, input, line_hz, rate_hz).map(|codes| codes * uv)
        });
        (line_hz, uv_rms)
    });
    let worst = lines
        .iter()
        .filter_map(|(line_hz, uv_rms)| Some((*line_hz, greatest(uv_rms)?)));
    let Some((line_hz, (input, most))) = worst.max_by(|a, b| a.1.1.total_cmp(&b.1.1)) else {
        return Check::skipped("mains", TROUBLESHOOTING, "no two seconds without a touch");
    };
    let values: serde_json::Map<_, _> = lines
        .iter()
        .map(|(line_hz, uv_rms)| (format!("uv_rms_at_{line_hz:.0}_hz"), json!(uv_rms)))
        .collect();
    let finding = format!("{most:.1} uV rms at {line_hz:.0} Hz on AIN{input}, the most");
    let (verdict, finding) = match inputs {
        Inputs::Open => (
            Verdict::Skipped,
            format!("{finding}; not judged with open inputs"),
        ),
        _ => (graded(most > PICK_UP_UV.0, most > PICK_UP_UV.1), finding),
    };
    Check::new("mains", TROUBLESHOOTING, verdict, finding, values.into())
}

/// The input with the greatest value.
fn greatest(values: &[Option<f64>; TAXELS]) -> Option<(usize, f64)> {
    let known = values
        .iter()
        .enumerate()
        .filter_map(|(input, value)| Some((input, (*value)?)));
    known.max_by(|a, b| a.1.total_cmp(&b.1))
}
