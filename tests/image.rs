//! Compares the pressure map of each hold with the scene's loads.

#[allow(dead_code, reason = "every test file uses a part of it")]
mod support;

use ads1258::Status;
use hal_mock::{Finger, Options, Scene, SimulatedBoard, Sliding, SlidingScene, load_scene};
use ridgetone_finger::TimedConversion;
use ridgetone_proto::settings::{FRAME_RATE_HZ, Settings, TAXELS};
use ridgetone_proto::telemetry::{Hold, Image};
use std::f64::consts::TAU;
use support::{all, in_the_air, outcome, run, run_on};

/// Returns the pressure maps of a scene, with converter noise from `seed`.
fn images(scene: impl Scene + 'static, seed: u64) -> Vec<Image> {
    let board = SimulatedBoard::new(
        scene,
        Options {
            seed,
            ..Options::default()
        },
    );
    outcome(&run_on(board, Settings::default(), all)).images
}

fn holds(images: &[Image]) -> Vec<Hold> {
    images.iter().map(|image| image.hold).collect()
}

/// Returns the mean load of each taxel over a map's frames, in volts above its value at time zero,
/// without noise.
fn pressed_v(mut scene: SlidingScene, image: &Image) -> [f64; TAXELS] {
    let untouched: [f64; TAXELS] = std::array::from_fn(|taxel| scene.volts(taxel as u8, 0.0));
    let (start_s, length_s) = (
        image.start_us as f64 * 1e-6,
        (image.end_us - image.start_us) as f64 * 1e-6,
    );
    let mut sums = [0.0; TAXELS];
    for frame in 0..image.frames {
        let t_s = start_s + length_s * frame as f64 / image.frames as f64;
        for (taxel, sum) in sums.iter_mut().enumerate() {
            *sum += scene.volts(taxel as u8, t_s) - untouched[taxel];
        }
    }
    sums.map(|sum| sum / image.frames as f64)
}

fn alive(image: &Image) -> Vec<u8> {
    image.taxels.iter().map(|found| found.taxel).collect()
}

fn without_noise(sliding: &Sliding) -> SlidingScene {
    let finger = sliding.finger.map(|finger| Finger {
        noise_uv: 0.0,
        ..finger
    });
    SlidingScene::new(Sliding {
        snr_db: None,
        finger,
        ..sliding.clone()
    })
    .unwrap()
}

#[test]
fn both_holds_are_imaged_with_their_standard_error() {
    let file = |number: usize| {
        let name = format!("hal-mock/scenes/c{number}.toml");
        load_scene(name, FRAME_RATE_HZ as f64).unwrap()
    };
    let snr_db = Some(20.0);
    let clean = (1..=10).map(file);
    let noisy = (1..=10).map(|number| Sliding {
        snr_db,
        ..file(number)
    });
    let papers = (1..=10).map(|seed| Sliding {
        snr_db,
        seed,
        ..Sliding::default()
    });
    let (mut squares, mut count) = (0.0, 0);
    for (number, sliding) in clean.chain(noisy).chain(papers).enumerate() {
        let scene = SlidingScene::new(sliding.clone()).unwrap();
        let truth = scene.truth();
        let images = images(scene, number as u64);
        assert_eq!(
            holds(&images),
            [Hold::BeforeSlide, Hold::AfterSlide],
            "{sliding:?}"
        );
        let within = [
            (truth.contact_s, truth.slide_start_s),
            (truth.slide_end_s, truth.release_s),
        ];
        for (image, (from_s, to_s)) in images.iter().zip(within) {
            let (start_s, end_s) = (image.start_us as f64 * 1e-6, image.end_us as f64 * 1e-6);
            assert!(
                from_s < start_s && end_s < to_s,
                "{image:?} in {from_s} s to {to_s} s"
            );
            // The spike takes 0.3 s of a one-second hold. The last blocks are left out because they
            // may contain the start of a motion.
            assert!(end_s - start_s > 0.5, "{image:?}");
            let frames_s = image.frames as f64 / FRAME_RATE_HZ as f64;
            assert!((end_s - start_s - frames_s).abs() < 1e-4, "{image:?}");
            let pressed_v = pressed_v(without_noise(&sliding), image);
            assert_eq!(alive(image), (0..TAXELS as u8).collect::<Vec<_>>());
            for (found, pressed_v) in image.taxels.iter().zip(pressed_v) {
                let off = (found.level_v as f64 - pressed_v) / found.sigma_v as f64;
                assert!(off.abs() < 5.0, "{found:?}: {off} sigma from {pressed_v} V");
                (squares, count) = (squares + off * off, count + 1);
            }
        }
    }
    // Both maps of a touch share the level before it, so their errors are correlated: 960 are worth
    // 480.
    let spread = (squares / count as f64).sqrt();
    assert!((spread - 1.0).abs() < 0.1, "{spread} of {count}");
}

/// A load proportional to the taxel's number, and a tone during slides.
struct Steps {
    touched_s: (f64, f64),
    slides_s: &'static [(f64, f64)],
    end_s: f64,
}

impl Scene for Steps {
    fn volts(&mut self, input: u8, t_s: f64) -> f64 {
        if !(self.touched_s.0..self.touched_s.1).contains(&t_s) || input as usize >= TAXELS {
            return 2.5;
        }
        let slid_s: f64 = self
            .slides_s
            .iter()
            .map(|(from, to)| (t_s - from).clamp(0.0, to - from))
            .sum();
        2.5 + 1e-3 * (input as f64 - 7.5)
            + 1e-3 * (TAU * (8.0 * slid_s + input as f64 / 16.0)).sin()
    }

    fn end_s(&self) -> f64 {
        self.end_s
    }
}

/// Asserts a load of 1 mV per taxel plus the tone at its initial phase, to which it returns after
/// slides of whole cycles.
fn assert_steps(image: &Image) {
    assert_eq!(alive(image), (0..TAXELS as u8).collect::<Vec<_>>());
    for found in &image.taxels {
        let expected_v =
            1e-3 * (found.taxel as f64 - 7.5) + 1e-3 * (TAU * found.taxel as f64 / 16.0).sin();
        let off_v = found.level_v as f64 - expected_v;
        assert!(
            off_v.abs() < 5.0 * found.sigma_v as f64,
            "{found:?}: {off_v} V off"
        );
    }
}

/// Each hold gets a pressure map, with or without slides before or after it, even if the recording
/// ends during the hold.
#[test]
fn each_hold_of_a_touch_is_imaged() {
    use Hold::{AfterSlide, BeforeSlide};
    for (slides_s, lifted_s, end_s, expected) in [
        (&[][..], 6.0, 7.0, &[BeforeSlide][..]),
        (
            &[(2.0, 3.0), (4.0, 5.0)],
            6.0,
            7.0,
            &[BeforeSlide, AfterSlide, AfterSlide],
        ),
        (&[(2.0, 3.0)], 9.0, 4.0, &[BeforeSlide, AfterSlide]),
    ] {
        let images = images(
            Steps {
                touched_s: (1.0, lifted_s),
                slides_s,
                end_s,
            },
            1,
        );
        assert_eq!(holds(&images), expected);
        images.iter().for_each(assert_steps);
    }
}

#[test]
fn a_hold_that_is_too_short_has_no_image() {
    // The spike takes at least 0.1 s of 0.3 s. The last blocks are left out because they may
    // contain the start of a slide.
    for hold_before_s in [0.15, 0.2] {
        let scene = SlidingScene::new(Sliding {
            hold_before_s,
            ..Sliding::default()
        })
        .unwrap();
        assert_eq!(
            holds(&images(scene, 1)),
            [Hold::AfterSlide],
            "{hold_before_s} s"
        );
    }
}

#[test]
fn a_finger_in_the_air_has_no_image() {
    assert_eq!(images(in_the_air(5.0), 1), []);
}

#[test]
fn dead_taxels_are_marked() {
    let steps = || Steps {
        touched_s: (1.0, 4.0),
        slides_s: &[(2.0, 3.0)],
        end_s: 5.0,
    };
    // AIN0 has the channel id 8 (datasheet, table 9).
    let of_taxel = |timed: &TimedConversion, taxel: u8| timed.status().0 & 0x1f == 8 + taxel;
    let out = outcome(&run(steps(), Settings::default(), |_, mut timed| {
        if of_taxel(&timed, 3) {
            timed = timed.with_code(0x7f_ffff); // clipped
        }
        if of_taxel(&timed, 12) {
            timed = timed.with_code(123_456); // stuck
        }
        if of_taxel(&timed, 14) {
            timed = timed.with_status(Status(timed.status().0 | 1 << 6)); // overflow
        }
        Some(timed)
    }));
    assert_eq!(out.images.len(), 2, "{out:?}");
    for image in &out.images {
        assert_eq!(alive(image), [0, 1, 2, 4, 5, 6, 7, 8, 9, 10, 11, 13, 15]);
    }
}
