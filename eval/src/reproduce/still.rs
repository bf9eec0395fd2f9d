//! The static image: what the grating at rest leaves on the sixteen taxels, before and after the slide.

use super::taken::Taken;
use ridgetone_host::static_image::by_taxel;
use ridgetone_proto::telemetry::{Event, Hold};

/// The images that the firmware told, before and after the slide (phases B and D): volts over the level before the touch
/// by taxel; empty where it told none or a taxel was dead. Of several holds the last one.
pub fn static_images(taken: &Taken) -> [Vec<f64>; 2] {
    [Hold::BeforeSlide, Hold::AfterSlide].map(|hold| {
        let images = taken.events(|event| match event {
            Event::Image(image) if image.hold == hold => Some(by_taxel(image)),
            _ => None,
        });
        let levels_v = images.last().and_then(|image| {
            image
                .into_iter()
                .map(|pressed| pressed.map(|pressed| f64::from(pressed.level_v)))
                .collect::<Option<Vec<f64>>>()
        });
        levels_v.unwrap_or_default()
    })
}
