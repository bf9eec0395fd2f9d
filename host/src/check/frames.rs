//! Checks the frames: their rate, their times, and the signals of the inputs.

use super::observations::{Inputs, Observations, input_names};
use super::signals::{self, dead_and_railed, line};
use super::verdict::{Limits, Outcome, Verdict, judged, skipped};
use crate::input::rate_of;
use ads1258::DataRate;
use ridgetone_finger::CONVERSION_NS;
use ridgetone_finger::converter::SCAN;
use ridgetone_proto::plan::Converters;
use ridgetone_proto::settings::{FRAME_RATE_HZ, TAXELS};
use serde_json::json;

/// Noise of one reading with shorted inputs, microvolts rms (SBAS297G, noise table, without CHOP).
const NOISE_UV: f64 = match SCAN.data_rate {
    DataRate::Drate0 => 2.8,
    DataRate::Drate1 => 4.5,
    DataRate::Drate2 => 7.9,
    DataRate::Drate3 => 12.0,
};

/// Mains frequencies and their second harmonics.
const LINES_HZ: [f64; 4] = [50.0, 60.0, 100.0, 120.0];

/// Limits of the jitter in microseconds rms: at 100 Hz, they cause errors of 1 % and 6 % of a
/// tone's amplitude.
const JITTER_RMS_US: Limits = Limits::up_to(20.0, 100.0);

/// Limits of the worst jitter in microseconds: half a conversion, and a whole one, at which a stamp
/// belongs to the wrong edge.
const JITTER_WORST_US: Limits =
    Limits::up_to(CONVERSION_NS as f64 / 2000.0, CONVERSION_NS as f64 / 1000.0);

pub fn frame_rate(seen: &Observations, limits: Limits) -> Outcome {
    let (hz, plan) = (seen.clock()?.frame_rate_hz, seen.judged());
    let nominal_hz = rate_of(&plan);
    let off_ppm = (hz / nominal_hz - 1.0) * 1e6;
    let adc_clock_hz = hz * f64::from(plan.frame_ticks);
    let adc_clock_mhz = adc_clock_hz * 1e-6;
    let finding = format!(
        "{hz:.3} Hz, {:+.0} ppm off the nominal {nominal_hz:.3} Hz; the ADC's clock is {adc_clock_mhz:.4} MHz",
        // Adding zero turns a rounded minus zero into zero.
        off_ppm.round() + 0.0
    );
    let values = json!({
        "frame_rate_hz": hz, "off_nominal_ppm": off_ppm, "adc_clock_hz": adc_clock_hz,
    });
    limits.judge(off_ppm, finding, values)
}

pub fn drdy_jitter(seen: &Observations) -> Outcome {
    let clock = seen.clock()?;
    let (rms, worst) = (clock.jitter_rms_us, clock.jitter_worst_us);
    let verdict = JITTER_RMS_US
        .verdict(rms)
        .max(JITTER_WORST_US.verdict(worst));
    let finding = format!("{rms:.2} us rms, {worst:.1} us at worst");
    Ok(judged(
        verdict,
        finding,
        json!({ "rms_us": rms, "worst_us": worst }),
    ))
}

pub fn inputs(seen: &Observations) -> Outcome {
    let (frames, plan) = (seen.frames()?, seen.judged());
    let (dead, railed) = dead_and_railed(frames);
    let present = frames.iter().fold(0, |all, frame| all | frame.present);
    let [absent, dead, at_rail] = [plan.inputs & !present, dead, railed].map(input_names);
    let mut wrong = Vec::new();
    for (what, names) in [
        ("never read", &absent),
        ("dead, always the same code", &dead),
        ("at the end of the scale", &at_rail),
    ] {
        wrong.extend((!names.is_empty()).then(|| format!("{what}: {names}")));
    }
    let finding = match &wrong[..] {
        [] => format!("all {} live, none at the end of the scale", plan.channels()),
        wrong => wrong.join("; "),
    };
    let values = json!({ "absent": absent, "dead": dead, "at_rail": at_rail });
    Ok(judged(
        Verdict::graded(false, !wrong.is_empty()),
        finding,
        values,
    ))
}

pub fn noise(seen: &Observations, limits: Limits) -> Outcome {
    seen.frames()?;
    let (untouched, uv_per_code) = (seen.need(&seen.watched)?.untouched(), seen.uv_per_code());
    let lsb: [_; TAXELS] = std::array::from_fn(|input| signals::noise(&untouched, input));
    let uv = lsb.map(|lsb| lsb.map(|lsb| lsb * uv_per_code));
    let (worst, max_uv) =
        max_of(&uv).ok_or_else(|| skipped("the finger was touched all the time"))?;
    let values = json!({ "lsb_rms": lsb, "uv_rms": uv, "datasheet_uv_rms": NOISE_UV });
    let max_lsb = max_uv / uv_per_code;
    let noise = format!("{max_lsb:.1} LSB = {max_uv:.1} uV rms on AIN{worst}, the most");
    let is_known = seen.judged().own.converter == Converters::ADS1258;
    if seen.inputs != Inputs::Shorted || !is_known {
        let finding = format!("{noise}; judged with --inputs shorted only");
        return Err(judged(Verdict::Skipped, finding, values));
    }
    let finding = format!("{noise}; the datasheet has {NOISE_UV} uV");
    limits.judge(max_uv / NOISE_UV, finding, values)
}

pub fn mains(seen: &Observations, limits: Limits) -> Outcome {
    seen.frames()?;
    let (untouched, uv_per_code) = (seen.need(&seen.watched)?.untouched(), seen.uv_per_code());
    let rate_hz = seen
        .clock()
        .map_or(FRAME_RATE_HZ.into(), |clock| clock.frame_rate_hz);
    let mut values = json!({});
    let mut max: Option<(f64, usize, f64)> = None;
    for line_hz in LINES_HZ {
        let line = |input| Some(line(&untouched, input, line_hz, rate_hz)? * uv_per_code);
        let uv_rms: [Option<f64>; TAXELS] = std::array::from_fn(line);
        if let Some((input, uv)) = max_of(&uv_rms)
            && max.is_none_or(|(.., max_uv)| uv > max_uv)
        {
            max = Some((line_hz, input, uv));
        }
        values[format!("uv_rms_at_{line_hz:.0}_hz")] = json!(uv_rms);
    }
    let (line_hz, input, uv) = max.ok_or_else(|| skipped("no two seconds without a touch"))?;
    let finding = format!("{uv:.1} uV rms at {line_hz:.0} Hz on AIN{input}, the most");
    if seen.inputs == Inputs::Open {
        let finding = format!("{finding}; not judged with open inputs");
        return Err(judged(Verdict::Skipped, finding, values));
    }
    limits.judge(uv, finding, values)
}

fn max_of(values: &[Option<f64>; TAXELS]) -> Option<(usize, f64)> {
    let known = values
        .iter()
        .enumerate()
        .filter_map(|(input, value)| Some((input, (*value)?)));
    known.max_by(|a, b| a.1.total_cmp(&b.1))
}
