//! Property of all settings, including those from the serial line: they are refused, or the
//! pipeline runs.

#[path = "touch.rs"]
pub mod touch;

use ridgetone_finger::Pipeline;
use ridgetone_proto::settings::Settings;
use ridgetone_proto::telemetry::{Event, Packet, Status, WIRE_MAX, encode};

/// Reads settings from postcard `bytes` and, if they are valid, runs a touch with them. Panics if
/// anything is wrong. Returns true if the settings were valid.
pub fn try_settings(bytes: &[u8]) -> bool {
    let Ok(settings) = postcard::from_bytes::<Settings>(bytes) else {
        return false;
    };
    if settings.validate().is_err() {
        return false;
    }
    let mut pipeline = Box::new(Pipeline::new(settings));
    let mut sequence = 0;
    let mut check = |event: Event| {
        look_at(&event);
        encode(&Packet { sequence, event }, &mut [0; WIRE_MAX])
            .expect("every event fits a message");
        sequence += 1;
    };
    check(pipeline.hello());
    for conversion in (0..touch::SCANS).flat_map(|scan| touch::scan(scan, scan, 0)) {
        pipeline.push(conversion, &mut check);
    }
    pipeline.finish(&mut check);
    true
}

fn look_at(event: &Event) {
    if let Event::Estimate(fit) = event {
        let channels = fit
            .channels
            .iter()
            .flat_map(|c| [c.offset_v, c.amplitude_v, c.phase_rad, c.residual_v]);
        let travel = &fit.travel;
        let period = [travel.spatial_period_mm, travel.spatial_period_sigma_mm];
        let speed = [travel.speed_mm_s, travel.speed_sigma_mm_s];
        let all = [fit.window_s, fit.frequency, fit.sigma]
            .into_iter()
            .chain(channels)
            .chain(period)
            .chain(speed);
        assert!(all.into_iter().all(f32::is_finite), "{fit:?}");
        assert!(
            fit.status != Status::Good || fit.sigma > 0.0 && fit.frequency > 0.0,
            "{fit:?}"
        );
    }
}
