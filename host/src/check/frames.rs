//! The frames: their rate, their times, and what the inputs show.

use super::observations::{Inputs, Observations, Watched, input_names};
use super::signals::{self, Clock, dead_and_railed, line};
use super::table::{Judged, Limits, Verdict};
use crate::input::rate_of;
use ads1258::DataRate;
use ridgetone_finger::CONVERSION_NS;
use ridgetone_finger::converter::SCAN;
use ridgetone_proto::plan::{Converters, Plan};
use ridgetone_proto::settings::{FRAME_RATE_HZ, TAXELS};
use ridgetone_proto::telemetry::Raw;
use serde_json::{Value, json};

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
const NOISE: Limits = Limits {
    pass: [0.0, 1.5],
    fail: [0.0, 3.0],
};

/// Mains and twice mains.
const LINES_HZ: [f64; 4] = [50.0, 60.0, 100.0, 120.0];

/// Pick-up, microvolts rms: twice the converter's noise, and a good part of a touch, which makes
/// millivolts.
const PICK_UP_UV: Limits = Limits {
    pass: [0.0, 10.0],
    fail: [0.0, 1000.0],
};

/// Rate off the nominal one, ppm: what two crystals may do with their capacitors, and the
/// firmware's limit for the fault `clock`.
const RATE_PPM: Limits = Limits::off(200.0, 5000.0);

/// Jitter, microseconds rms: at 100 Hz these are 1 % and 6 % of a tone's amplitude.
const JITTER_RMS_US: Limits = Limits {
    pass: [0.0, 20.0],
    fail: [0.0, 100.0],
};

/// Worst jitter, microseconds: half a conversion, and a whole one, which is a stamp of the wrong
/// edge.
const JITTER_WORST_US: Limits = Limits {
    pass: [0.0, CONVERSION_NS as f64 / 2000.0],
    fail: [0.0, CONVERSION_NS as f64 / 1000.0],
};

const NO_CLOCK: &str = "no second of frames without a restart of the scan";

/// Frames with what several checks need of them.
pub struct FrameStatistics<'a> {
    pub watched: &'a Watched,
    /// None without a second of frames of one scan.
    clock: Option<Clock>,
    /// Runs of frames without a touch.
    untouched: Vec<&'a [Raw]>,
    uv_per_code: f64,
    inputs: Inputs,
    plan: Plan,
}

impl<'a> FrameStatistics<'a> {
    pub fn new(watched: &'a Watched, seen: &Observations) -> Self {
        // A scan that is restarted has another phase.
        let is_one_scan = watched.before.chip_restarts == watched.after.chip_restarts;
        Self {
            watched,
            clock: Clock::of(&watched.frames).filter(|_| is_one_scan),
            untouched: watched.untouched(),
            uv_per_code: 1e6 * f64::from(seen.vref_v()) / VREF_CODES,
            inputs: seen.inputs,
            plan: seen.judged(),
        }
    }
}

pub fn frame_rate(seen: &FrameStatistics) -> Judged {
    let Some(Clock { frame_rate_hz, .. }) = seen.clock else {
        return Judged::skipped(NO_CLOCK);
    };
    let nominal_hz = rate_of(&seen.plan);
    let off_ppm = (frame_rate_hz / nominal_hz - 1.0) * 1e6;
    let adc_clock_hz = frame_rate_hz * f64::from(seen.plan.frame_ticks);
    let finding = format!(
        "{frame_rate_hz:.3} Hz, {off_ppm:+.0} ppm off the nominal {nominal_hz:.3} Hz; the ADC's clock is {:.4} MHz",
        adc_clock_hz * 1e-6
    );
    let values = json!({ "frame_rate_hz": frame_rate_hz, "off_nominal_ppm": off_ppm, "adc_clock_hz": adc_clock_hz });
    Judged::new(RATE_PPM.verdict(off_ppm), finding, values)
}

pub fn drdy_jitter(seen: &FrameStatistics) -> Judged {
    let Some(Clock {
        jitter_rms_us: rms,
        jitter_worst_us: worst,
        ..
    }) = seen.clock
    else {
        return Judged::skipped(NO_CLOCK);
    };
    let verdict = JITTER_RMS_US
        .verdict(rms)
        .max(JITTER_WORST_US.verdict(worst));
    let finding = format!("{rms:.2} us rms, {worst:.1} us at worst");
    Judged::new(
        verdict,
        finding,
        json!({ "rms_us": rms, "worst_us": worst }),
    )
}

pub fn inputs(seen: &FrameStatistics) -> Judged {
    let (dead, railed) = dead_and_railed(&seen.watched.frames);
    let absent = seen.plan.inputs & !seen.watched.present();
    let mut wrong = Vec::new();
    for (mask, what) in [
        (absent, "never read"),
        (dead, "dead, always the same code"),
        (railed, "at the end of the scale"),
    ] {
        if mask != 0 {
            wrong.push(format!("{what}: {}", input_names(mask)));
        }
    }
    let [absent, dead, at_rail] = [absent, dead, railed].map(input_names);
    let values = json!({ "absent": absent, "dead": dead, "at_rail": at_rail });
    if wrong.is_empty() {
        let count = seen.plan.channels();
        let finding = format!("all {count} live, none at the end of the scale");
        Judged::new(Verdict::Pass, finding, values)
    } else {
        Judged::new(Verdict::Fail, wrong.join("; "), values)
    }
}

pub fn noise(seen: &FrameStatistics) -> Judged {
    let lsb: [_; TAXELS] = std::array::from_fn(|input| signals::noise(&seen.untouched, input));
    let uv = lsb.map(|lsb| lsb.map(|lsb| lsb * seen.uv_per_code));
    let Some((worst, most_uv)) = greatest(&uv) else {
        return Judged::skipped("the finger was touched all the time");
    };
    let values = json!({ "lsb_rms": lsb, "uv_rms": uv, "datasheet_uv_rms": NOISE_UV });
    let most_lsb = most_uv / seen.uv_per_code;
    let most = format!("{most_lsb:.1} LSB = {most_uv:.1} uV rms on AIN{worst}, the most");
    let is_known = seen.plan.own.converter == Converters::ADS1258;
    if seen.inputs == Inputs::Shorted && is_known {
        let finding = format!("{most}; the datasheet has {NOISE_UV} uV");
        Judged::new(NOISE.verdict(most_uv / NOISE_UV), finding, values)
    } else {
        let finding = format!("{most}; judged with --inputs shorted only");
        Judged::new(Verdict::Skipped, finding, values)
    }
}

pub fn mains(seen: &FrameStatistics) -> Judged {
    let rate_hz = seen
        .clock
        .map_or(f64::from(FRAME_RATE_HZ), |clock| clock.frame_rate_hz);
    let mut values = serde_json::Map::new();
    let mut most: Option<(f64, usize, f64)> = None;
    for line_hz in LINES_HZ {
        let uv_rms: [_; TAXELS] = std::array::from_fn(|input| {
            let codes = line(&seen.untouched, input, line_hz, rate_hz)?;
            Some(codes * seen.uv_per_code)
        });
        if let Some((input, uv)) = greatest(&uv_rms)
            && most.is_none_or(|(.., most_uv)| uv > most_uv)
        {
            most = Some((line_hz, input, uv));
        }
        values.insert(format!("uv_rms_at_{line_hz:.0}_hz"), json!(uv_rms));
    }
    let Some((line_hz, input, uv)) = most else {
        return Judged::skipped("no two seconds without a touch");
    };
    let finding = format!("{uv:.1} uV rms at {line_hz:.0} Hz on AIN{input}, the most");
    let values = Value::Object(values);
    if seen.inputs == Inputs::Open {
        let finding = format!("{finding}; not judged with open inputs");
        Judged::new(Verdict::Skipped, finding, values)
    } else {
        Judged::new(PICK_UP_UV.verdict(uv), finding, values)
    }
}

/// The input with the greatest value.
fn greatest(values: &[Option<f64>; TAXELS]) -> Option<(usize, f64)> {
    let known = values
        .iter()
        .enumerate()
        .filter_map(|(input, value)| Some((input, (*value)?)));
    known.max_by(|a, b| a.1.total_cmp(&b.1))
}
