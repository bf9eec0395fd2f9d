//! Touch and tone from plain frames of any converter: three channels in volts at 1 kHz.
//!
//! `cargo run --example plain_frames`

use ridgetone_finger::{Pipeline, PlainFrame};
use ridgetone_proto::plan::Plan;
use ridgetone_proto::settings::Settings;
use std::f64::consts::TAU;

/// Volts at a time, seconds: a load that creeps in from 1 s on, and 37.3 Hz from 2 to 4 s.
fn volts(t_s: f64) -> [f32; 3] {
    let touch = t_s - 1.0;
    let load = if touch > 0.0 {
        0.02 * (1.0 - (-touch / 0.05).exp())
    } else {
        0.0
    };
    let slides = (2.0..4.0).contains(&t_s);
    let tone = if slides {
        2e-3 * (TAU * 37.3 * t_s).sin()
    } else {
        0.0
    };
    // Two tones of much higher frequency stand in for noise.
    let noise = 2e-5 * ((TAU * 397.1 * t_s).sin() + (TAU * 451.7 * t_s).cos());
    [1.0, -0.6, 0.8].map(|gain| (gain * (load + tone) + noise) as f32)
}

/// Prints what is found.
pub fn main() {
    let plan = Plan::of_frames(1000.0, 3).expect("180 to 23,740 Hz and 1 to 16 channels");
    let settings = Settings {
        vref_v: 2.5,
        ..Settings::DEFAULT.with_plan(plan)
    };
    let mut pipeline = Box::new(Pipeline::new(settings));
    for t_us in (0..5_000_000).step_by(1000) {
        let readings = &volts(t_us as f64 * 1e-6);
        pipeline.push_frame(PlainFrame { t_us, readings }, &mut |event| {
            println!("{event:?}")
        });
    }
    pipeline.finish(&mut |event| println!("{event:?}"));
}
