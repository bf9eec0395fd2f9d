//! The static image: what the grating at rest leaves on the sixteen taxels, before and after the slide.

use super::results::Firmware;
use super::taken::Taken;
use ridgetone::settings::TAXELS;

/// Part of a hold, at its end, whose mean is the image, seconds.
const IMAGE_S: f64 = 0.3;
/// What is left out in front of the next phase, seconds: the slide and the release are found to some hundredths.
const CLEAR_S: f64 = 0.05;

/// The images before and after the slide (phases B and D), volts above idle by taxel; empty where the phase was not
/// found.
///
/// This is the one place where they come from: a telemetry message of the firmware's own can take it over.
pub fn static_images(taken: &Taken, firmware: Option<&Firmware>) -> [Vec<f64>; 2] {
    let Some(found) = firmware else { return [Vec::new(), Vec::new()] };
    let released_s = taken.recording.releases_s.last().copied();
    let after =
        released_s.filter(|t_s| *t_s > found.slide_s.1).map_or_else(Vec::new, |t_s| image(taken, t_s - CLEAR_S));
    [image(taken, found.slide_s.0 - CLEAR_S), after]
}

/// The mean of the last stretch before a time.
fn image(taken: &Taken, end_s: f64) -> Vec<f64> {
    let mean = |taxel: usize| {
        let part = &taken.volts(taxel)[taken.frame_at(taxel, end_s - IMAGE_S)..taken.frame_at(taxel, end_s)];
        part.iter().map(|(_, volts)| volts).sum::<f64>() / part.len().max(1) as f64
    };
    (0..TAXELS).map(mean).map(|volts| (1e6 * volts).round() / 1e6).collect()
}
