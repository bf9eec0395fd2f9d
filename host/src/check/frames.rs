//! The frames: their rate, their times, and what the inputs show.

use super::observations::{Inputs, input_names};
use super::run::Run;
use super::signals::{self, Clock, dead_and_railed, line};
use super::verdict::{Judged, Limits, Measured, Verdict};
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

/// Mains and twice mains.
const LINES_HZ: [f64; 4] = [50.0, 60.0, 100.0, 120.0];

/// Jitter, microseconds rms: at 100 Hz these are 1 % and 6 % of a tone's amplitude.
const JITTER_RMS_US: Limits = Limits::up_to(20.0, 100.0);

/// Worst jitter, microseconds: half a conversion, and a whole one, which is a stamp of the wrong
/// edge.
const JITTER_WORST_US: Limits =
    Limits::up_to(CONVERSION_NS as f64 / 2000.0, CONVERSION_NS as f64 / 1000.0);

pub fn frame_rate(run: &Run<'_>, _: &Limits) -> Result<Measured, Judged> {
    let Clock { frame_rate_hz, .. } = run.clock()?;
    let plan = run.seen.judged();
    let nominal_hz = rate_of(&plan);
    let off_ppm = (frame_rate_hz / nominal_hz - 1.0) * 1e6;
    let adc_clock_hz = frame_rate_hz * f64::from(plan.frame_ticks);
    let adc_clock_mhz = adc_clock_hz * 1e-6;
    Ok(Measured {
        value: off_ppm,
        finding: format!(
            "{frame_rate_hz:.3} Hz, {off_ppm:+.0} ppm off the nominal {nominal_hz:.3} Hz; the ADC's clock is {adc_clock_mhz:.4} MHz"
        ),
        values: json!({
            "frame_rate_hz": frame_rate_hz, "off_nominal_ppm": off_ppm, "adc_clock_hz": adc_clock_hz,
        }),
    })
}

pub fn drdy_jitter(run: &Run<'_>) -> Result<Judged, Judged> {
    let clock = run.clock()?;
    let (rms, worst) = (clock.jitter_rms_us, clock.jitter_worst_us);
    let verdicts = [JITTER_RMS_US.verdict(rms), JITTER_WORST_US.verdict(worst)];
    let finding = format!("{rms:.2} us rms, {worst:.1} us at worst");
    let values = json!({ "rms_us": rms, "worst_us": worst });
    Ok(Judged::new(verdicts[0].max(verdicts[1]), finding, values))
}

pub fn inputs(run: &Run<'_>) -> Result<Judged, Judged> {
    let (dead, railed) = dead_and_railed(run.frames()?);
    let plan = run.seen.judged();
    let absent = plan.inputs & !run.watched()?.present();
    let [absent, dead, at_rail] = [absent, dead, railed].map(input_names);
    let wrong: Vec<String> = [
        ("never read", &absent),
        ("dead, always the same code", &dead),
        ("at the end of the scale", &at_rail),
    ]
    .into_iter()
    .filter(|(_, names)| !names.is_empty())
    .map(|(what, names)| format!("{what}: {names}"))
    .collect();
    let values = json!({ "absent": absent, "dead": dead, "at_rail": at_rail });
    let (verdict, finding) = match &wrong[..] {
        [] => {
            let count = plan.channels();
            let finding = format!("all {count} live, none at the end of the scale");
            (Verdict::Pass, finding)
        }
        wrong => (Verdict::Fail, wrong.join("; ")),
    };
    Ok(Judged::new(verdict, finding, values))
}

pub fn noise(run: &Run<'_>, _: &Limits) -> Result<Measured, Judged> {
    run.frames()?;
    let lsb: [_; TAXELS] = std::array::from_fn(|input| signals::noise(&run.untouched, input));
    let uv = lsb.map(|lsb| lsb.map(|lsb| lsb * run.uv_per_code));
    let (worst, max_uv) =
        greatest(&uv).ok_or_else(|| Judged::skipped("the finger was touched all the time"))?;
    let values = json!({ "lsb_rms": lsb, "uv_rms": uv, "datasheet_uv_rms": NOISE_UV });
    let max_lsb = max_uv / run.uv_per_code;
    let most = format!("{max_lsb:.1} LSB = {max_uv:.1} uV rms on AIN{worst}, the most");
    let is_known = run.seen.judged().own.converter == Converters::ADS1258;
    if run.seen.inputs != Inputs::Shorted || !is_known {
        let finding = format!("{most}; judged with --inputs shorted only");
        return Err(Judged::new(Verdict::Skipped, finding, values));
    }
    Ok(Measured {
        value: max_uv / NOISE_UV,
        finding: format!("{most}; the datasheet has {NOISE_UV} uV"),
        values,
    })
}

pub fn mains(run: &Run<'_>, _: &Limits) -> Result<Measured, Judged> {
    run.frames()?;
    let rate_hz = run
        .clock()
        .map_or(f64::from(FRAME_RATE_HZ), |clock| clock.frame_rate_hz);
    let mut values = json!({});
    let mut most: Option<(f64, usize, f64)> = None;
    for line_hz in LINES_HZ {
        let uv_rms: [_; TAXELS] = std::array::from_fn(|input| {
            let codes = line(&run.untouched, input, line_hz, rate_hz)?;
            Some(codes * run.uv_per_code)
        });
        if let Some((input, uv)) = greatest(&uv_rms)
            && most.is_none_or(|(.., most_uv)| uv > most_uv)
        {
            most = Some((line_hz, input, uv));
        }
        values[format!("uv_rms_at_{line_hz:.0}_hz")] = json!(uv_rms);
    }
    let (line_hz, input, uv) =
        most.ok_or_else(|| Judged::skipped("no two seconds without a touch"))?;
    let finding = format!("{uv:.1} uV rms at {line_hz:.0} Hz on AIN{input}, the most");
    if run.seen.inputs == Inputs::Open {
        let finding = format!("{finding}; not judged with open inputs");
        return Err(Judged::new(Verdict::Skipped, finding, values));
    }
    Ok(Measured {
        value: uv,
        finding,
        values,
    })
}

/// The input with the greatest value.
fn greatest(values: &[Option<f64>; TAXELS]) -> Option<(usize, f64)> {
    let known = values
        .iter()
        .enumerate()
        .filter_map(|(input, value)| Some((input, (*value)?)));
    known.max_by(|a, b| a.1.total_cmp(&b.1))
}
