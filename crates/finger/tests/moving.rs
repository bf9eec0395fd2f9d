//! The event `moving`: its delay after the start of a slide, and its false alarms. `cargo test -p
//! ridgetone-finger --release --test moving -- --ignored --nocapture` prints all figures.

use ridgetone_finger::{Detector, Diagnostics, Outputs, PlainFrame, Ring};
use ridgetone_proto::plan::Plan;
use ridgetone_proto::settings::Settings;
use ridgetone_proto::telemetry::Event;
use std::f64::consts::TAU;

const CHANNELS: usize = 16;
const RATE_HZ: f64 = 241.14;
/// Standard deviation of a channel's noise, volts.
const SIGMA_V: f64 = 30e-6;
/// Amplitude of a tone 20 dB above the noise, RMS over the channels, volts.
const TONE_V: f64 = 14.142 * SIGMA_V;
/// Duration of the ramp to the slide's speed, seconds.
const RAMP_S: f64 = 0.02;
/// First seed that was not used to tune the detector's constants.
const FRESH: u64 = 70_000;

/// Uniform and normal random numbers: SplitMix64, Box and Muller.
struct Random(u64, Option<f64>);

impl Random {
    fn uniform(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ self.0 >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ z >> 31) >> 11) as f64 / (1u64 << 53) as f64
    }

    fn between(&mut self, min: f64, max: f64) -> f64 {
        min + (max - min) * self.uniform()
    }

    /// Log-uniform number.
    fn log(&mut self, min: f64, max: f64) -> f64 {
        min * (max / min).powf(self.uniform())
    }

    fn normal(&mut self) -> f64 {
        if let Some(other) = self.1.take() {
            return other;
        }
        let radius = (-2.0 * (1.0 - self.uniform()).ln()).sqrt();
        let (sin, cos) = (TAU * self.uniform()).sin_cos();
        self.1 = Some(radius * sin);
        radius * cos
    }
}

#[derive(Clone, Copy, Debug)]
enum Noise {
    White,
    /// Sum of first-order processes with doubling time constants: 1/f from 0.02 Hz on.
    Pink,
    /// First-order autoregression with coefficient 0.9.
    Ar,
}

/// Noise of a channel with a variance of one.
struct Channel {
    octaves: Vec<f64>,
    decays: Vec<(f64, f64)>,
}

impl Channel {
    fn new(noise: Noise) -> Self {
        let decays: Vec<f64> = match noise {
            Noise::White => vec![0.0],
            Noise::Pink => (0..12).map(|k| (-1.0 / f64::from(1 << k)).exp()).collect(),
            Noise::Ar => vec![0.9],
        };
        let fraction = 1.0 / decays.len() as f64;
        let decays = decays
            .iter()
            .map(|decay| (*decay, (fraction * (1.0 - decay * decay)).sqrt()));
        Self {
            octaves: vec![0.0; decays.len()],
            decays: decays.collect(),
        }
    }

    fn next(&mut self, random: &mut Random) -> f64 {
        for (octave, (decay, drive)) in self.octaves.iter_mut().zip(&self.decays) {
            *octave = *octave * decay + drive * random.normal();
        }
        self.octaves.iter().sum()
    }
}

/// A slide at constant speed with a ramp at either end.
#[derive(Clone, Copy)]
struct Slide {
    start_s: f64,
    end_s: f64,
    tone_hz: f64,
}

impl Slide {
    /// Number of periods passed by `t_s`.
    fn turns(&self, t_s: f64) -> f64 {
        let ramp = |after_s: f64| {
            let (after_s, ramped_s) = (after_s.max(0.0), after_s.clamp(0.0, RAMP_S));
            0.5 * ramped_s * ramped_s / RAMP_S + after_s - ramped_s
        };
        self.tone_hz * (ramp(t_s - self.start_s) - ramp(t_s - self.end_s))
    }
}

/// A lift of the finger: start and duration of the load's decrease, seconds.
#[derive(Clone, Copy)]
struct Lift {
    start_s: f64,
    fall_s: f64,
}

/// A touch: no contact, contact at 0.6 s, and a hold.
#[derive(Clone, Copy)]
struct Touch {
    noise: Noise,
    slide: Option<Slide>,
    /// Relative amplitude and frequency, hertz, of an oscillation of the load.
    press: Option<(f64, f64)>,
    lift: Option<Lift>,
    end_s: f64,
}

const CONTACT_S: f64 = 0.6;

/// Events reported in a touch.
#[derive(Default)]
struct Reported {
    /// Start of the motion and time of the report, seconds.
    moving_s: Vec<(f64, f64)>,
    contacts: u32,
}

/// Returns the load relative to the hold's, and the contact spike.
fn load(touch: &Touch, t_s: f64, press_phase: f64) -> (f64, f64) {
    let held_s = t_s - CONTACT_S;
    if held_s <= 0.0 {
        return (0.0, 0.0);
    }
    let mut load = 1.0 - (-held_s / 0.004).exp();
    let spiked = load * (-held_s / 0.03).exp();
    if let Some((fraction, hz)) = touch.press {
        let begun = ((held_s - 0.5) / 0.1).clamp(0.0, 1.0);
        load *= 1.0 + begun * fraction * (TAU * hz * held_s + press_phase).sin();
    }
    if let Some(Lift { start_s, fall_s }) = touch.lift {
        load *= 0.5 + 0.5 * (0.5 * TAU * ((t_s - start_s) / fall_s).clamp(0.0, 1.0)).cos();
    }
    (load, spiked)
}

fn run(touch: Touch, seed: u64) -> Reported {
    let mut random = Random(seed, None);
    let plan = Plan::of_frames(RATE_HZ as f32, CHANNELS).unwrap();
    let settings = Settings {
        vref_v: 2.5,
        ..Settings::DEFAULT.with_plan(plan)
    };
    let (mut detector, mut ring) = (Box::new(Detector::new(settings)), Box::new(Ring::new()));
    let (diagnostics, mut reported) = (Diagnostics::new(), Reported::default());
    let mut noises: Vec<Channel> = (0..CHANNELS).map(|_| Channel::new(touch.noise)).collect();
    // Level, load, exponent of its growth, spike relative to the load, amplitude and phase of the
    // tone.
    let load_v = random.log(2.0, 20.0) * TONE_V;
    let channels: Vec<[f64; 6]> = (0..CHANNELS)
        .map(|_| {
            let sign = if random.uniform() < 0.5 { -1.0 } else { 1.0 };
            [
                random.between(-0.5, 0.5),
                sign * random.log(0.4, 1.2) * load_v,
                random.between(0.8, 1.2),
                random.between(0.2, 0.9),
                random.between(0.3, 1.7),
                random.between(0.0, TAU),
            ]
        })
        .collect();
    let mean_square = channels.iter().map(|c| c[4] * c[4]).sum::<f64>() / CHANNELS as f64;
    let press_phase = random.between(0.0, TAU);
    let frames = (touch.end_s * RATE_HZ) as u64;
    for frame in 0..frames {
        let t_us = (frame as f64 * 1e6 / RATE_HZ) as u64;
        let t_s = frame as f64 / RATE_HZ;
        let values: [f32; CHANNELS] = std::array::from_fn(|c| {
            // A scan samples one channel after another.
            let t_s = t_s + c as f64 / (21.0 * RATE_HZ);
            let (load, spiked) = load(&touch, t_s, press_phase);
            let turns = touch.slide.map_or(0.0, |slide| slide.turns(t_s));
            let [level, full, power, spike, gain, phase] = channels[c];
            let tone = TONE_V * gain / mean_square.sqrt() * (TAU * turns + phase).sin();
            let loaded = full * (load.powf(power) + spike * spiked);
            let tone = tone * load.min(1.0);
            (level + loaded + tone + SIGMA_V * noises[c].next(&mut random)) as f32
        });
        let now_s = t_us as f64 * 1e-6;
        let frame = PlainFrame {
            t_us,
            readings: &values,
        };
        let outputs = &mut Outputs {
            emit: &mut |event| match event {
                Event::Moving(moving) => {
                    let begun_s = moving.t_us as f64 * 1e-6;
                    let after_s = f64::from(moving.reported_after_us) * 1e-6;
                    // A plain frame is complete with its last input.
                    assert!((begun_s + after_s - now_s).abs() < 0.0045, "{after_s}");
                    reported.moving_s.push((begun_s, begun_s + after_s));
                }
                Event::Contact(_) => reported.contacts += 1,
                _ => {}
            },
            due: &mut |_| (),
        };
        detector.push_frame(frame, &mut ring, &diagnostics, outputs);
    }
    reported
}

/// Returns the fraction of slides reported within 60 ms, and the median and 95 % quantile of the
/// delays, seconds.
fn delays(slides: u64, seed: u64) -> (f64, [f64; 2]) {
    let mut delays: Vec<f64> = (0..slides)
        .map(|n| {
            let mut random = Random(seed + n, None);
            let (start_s, hz) = (random.between(1.1, 2.6), random.log(5.0, 100.0));
            let reported = run(
                Touch {
                    noise: Noise::White,
                    slide: Some(Slide {
                        start_s,
                        end_s: f64::INFINITY,
                        tone_hz: hz,
                    }),
                    press: None,
                    lift: None,
                    end_s: start_s + 0.2,
                },
                seed + n,
            );
            assert_eq!(reported.contacts, 1, "seed {}", seed + n);
            match reported.moving_s[..] {
                // Exactly once, and not before the slide.
                [(begun_s, at_s)] if begun_s > start_s - 0.02 => at_s - start_s,
                _ => f64::INFINITY,
            }
        })
        .collect();
    delays.sort_by(f64::total_cmp);
    let soon = delays.iter().filter(|delay| **delay <= 0.06).count();
    let quantile = |fraction: f64| delays[(fraction * (delays.len() - 1) as f64) as usize];
    (
        soon as f64 / delays.len() as f64,
        [quantile(0.5), quantile(0.95)],
    )
}

/// Counts false alarms in holds of five minutes without a motion.
fn false_alarms(noise: Noise, hours: u64, seed: u64) -> usize {
    let touches = 12 * hours;
    let alarms = (0..touches).map(|n| {
        let touch = Touch {
            noise,
            slide: None,
            press: None,
            lift: None,
            end_s: CONTACT_S + 300.0,
        };
        let reported = run(touch, seed + n);
        assert_eq!(reported.contacts, 1, "{noise:?}, seed {}", seed + n);
        reported.moving_s.len()
    });
    alarms.sum()
}

/// Counts the touches with an alarm among `touches` in which only the load changes.
fn presses(touches: u64, seed: u64) -> usize {
    let alarms = (0..touches).filter(|n| {
        let mut random = Random(seed + n, None);
        let press = Some((random.between(0.1, 0.5), random.log(0.5, 5.0)));
        let end_s = random.between(2.5, 4.5);
        let touch = Touch {
            noise: Noise::White,
            slide: None,
            press,
            lift: Some(Lift {
                start_s: end_s - 0.6,
                fall_s: random.log(0.01, 0.1),
            }),
            end_s,
        };
        !run(touch, seed + n).moving_s.is_empty()
    });
    alarms.count()
}

/// Counts the lifts reported as a motion among `touches`, which have a slide before the hold if
/// `slides` is true.
fn lifts(touches: u64, slides: bool, seed: u64) -> usize {
    let alarms = (0..touches).filter(|n| {
        let mut random = Random(seed + n, None);
        let slide = Slide {
            start_s: random.between(1.1, 1.6),
            end_s: random.between(2.0, 2.6),
            tone_hz: random.log(5.0, 100.0),
        };
        let lift = Lift {
            start_s: slide.end_s + random.between(0.25, 1.0),
            fall_s: random.log(0.01, 0.1),
        };
        let touch = Touch {
            noise: Noise::White,
            slide: slides.then_some(slide),
            press: None,
            lift: Some(lift),
            end_s: lift.start_s + 0.6,
        };
        let moving_s = run(touch, seed + n).moving_s;
        moving_s.iter().any(|(_, at_s)| *at_s >= lift.start_s)
    });
    alarms.count()
}

#[test]
fn a_slide_shows_within_60_ms() {
    let (soon, delays_s) = delays(200, FRESH);
    assert!(soon >= 0.95, "{soon}: {delays_s:?}");
}

#[test]
fn a_hold_without_motion_has_at_most_one_alarm_an_hour() {
    for noise in [Noise::White, Noise::Pink, Noise::Ar] {
        let alarms = false_alarms(noise, 1, FRESH + 1000);
        assert!(alarms <= 1, "{noise:?}: {alarms}");
    }
}

#[test]
fn a_load_that_changes_is_no_motion() {
    let alarms = presses(200, FRESH + 2000);
    assert!(alarms <= 2, "{alarms} of 200");
}

#[test]
fn a_lift_is_no_motion() {
    for slides in [true, false] {
        let alarms = lifts(200, slides, FRESH + 3000);
        assert!(
            alarms <= 1,
            "{alarms} of 200; a slide before the hold: {slides}"
        );
    }
}

/// Prints all figures, for seeds that were not used in tuning.
#[test]
#[ignore = "takes minutes"]
fn figures() {
    let seed = FRESH + 10_000;
    let (soon, delays_s) = delays(2000, seed);
    println!("{soon:.4} of 2000 slides within 60 ms; 50 and 95 % {delays_s:.4?} s");
    assert!(soon >= 0.95);
    println!(
        "{} of 2000 touches in which the load changes",
        presses(2000, seed + 3000)
    );
    for slides in [true, false] {
        let alarms = lifts(2000, slides, seed + 20_000);
        println!("{alarms} of 2000 lifts; a slide before the hold: {slides}");
    }
    std::thread::scope(|scope| {
        for noise in [Noise::White, Noise::Pink, Noise::Ar] {
            scope.spawn(move || {
                let alarms = false_alarms(noise, 10, seed + 6000);
                println!("{noise:?}: {alarms} alarms in 10 hours");
                assert!(alarms <= 10, "{noise:?}");
            });
        }
    });
}
