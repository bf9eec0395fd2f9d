//! What each setting is, and why its bounds are what they are.

use ridgetone_proto::settings::SettingsError;

/// What a setting is, with its unit.
pub fn meaning(name: &str) -> Option<&'static str> {
    Some(match name {
        "window_s" => "length of a window, s",
        "hop_s" => "from the start of one window to the start of the next, s",
        "harmonics" => "most harmonics to fit, the fundamental included",
        "accuracy" => "required, as a share of the frequency; 0: windows of one length",
        "interferer_hz" => "known hum in all channels, Hz; 0: none",
        "vref_v" => "the ADS1258's reference, V",
        "plan" => {
            "what the chip converts: \"paper\", \"hand\", \"texture\", \"vibration\", \"single\""
        }
        "inputs" => "that are converted: bit k is AINk",
        "data_rate" => "DRATE of the ADS1258, 0 to 3",
        "delay" => "DLY of the ADS1258, 0 to 7: an input settles before it is converted",
        "chop" => "each conversion is two with the inputs exchanged",
        "health" => "the chip's own readings: \"every_scan\" or \"between_touches\"",
        "rule" => "\"found\" in the signal, or by \"protocol\": delay_s, speed_mm_s, length_mm",
        "delay_s" => "from contact to slide, s",
        "speed_mm_s" => "of the stimulus, mm/s",
        "length_mm" => "of the slide to use, mm",
        "pitch_mm" => {
            "between the columns of units, mm: `ridgetone calibrate` finds it, and the next two"
        }
        "edge_phase_rad" => {
            "phase by which the contact's ends reduce the lag between the columns, rad"
        }
        "edge_phase_sigma_rad" => "standard deviation of true lags around these, rad",
        "period_least_mm" => "shortest possible period, mm",
        "period_most_mm" => "longest possible period, mm",
        "may_go_forward" => "whether the grating may move along +x",
        "may_go_backward" => "whether it may move against +x",
        "front" => "taxels of the front column: bit k is taxel k",
        "volts_per_um" => {
            "of a taxel's reading by displacement, V/um from peak to peak; 0: no event `feel`"
        }
        "sigma_share" => "standard deviation of volts_per_um over it",
        "force_ratio" => "tangential over normal force; 0: by the static image before the slide",
        "alike" => "taxels that respond alike, as bits: the same sensor of every unit",
        _ => return None,
    })
}

/// A value out of its bounds, with the reason for the bounds.
pub fn explained(error: &SettingsError) -> String {
    explain(&error.field, &error.to_string())
}

/// `text` with the reason for the bounds of a setting.
pub fn explain(field: &str, text: &str) -> String {
    let why = match field {
        "window_s" => {
            "24 frames are the fewest that hold four harmonics; the longest is what the board has memory for with this plan"
        }
        "inputs" => "bit k of `plan.inputs` stands for AINk",
        "chop" => {
            "the chip cannot read its own health while it chops: choose plan.health = \"between_touches\""
        }
        "frame_rate_hz" => {
            "what this plan gives: touch detection needs 180 frames a second; choose fewer inputs, a higher data_rate or a shorter delay"
        }
        "hop_s" => "0.02 s are five frames; a hop longer than a window leaves frames out",
        "harmonics" => "the fundamental counts as one",
        "accuracy" => {
            "a share of the frequency, or 0 for windows of one length; no crystal is better than a millionth"
        }
        "interferer_hz" => "0 for none; below 5 Hz it cannot be distinguished from drift",
        "vref_v" => "the ADS1258 takes a reference of 0.5 V up to its supply",
        "delay_s" | "speed_mm_s" | "length_mm" => "the protocol that the stimulus follows",
        "pitch_mm" | "edge_phase_rad" | "edge_phase_sigma_rad" => {
            "`ridgetone calibrate` finds them"
        }
        "period_least_mm" | "period_most_mm" => {
            "the longest possible period is not below the shortest"
        }
        _ => return text.to_owned(),
    };
    format!("{text} ({why})")
}
