//! Tests the whole path from SPI bytes to a texture, which is reported once per touch, and again if
//! the grating changes.

#[allow(dead_code, reason = "every test file uses a part of it")]
mod support;

use hal_mock::{Scene, Sliding, SlidingScene};
use ridgetone_proto::plan::Plan;
use ridgetone_proto::settings::{Settings, Slide, SlideRule};
use ridgetone_proto::telemetry::{Event, Hold, Texture};
use support::{all, outcome, run};

const SPEED_MM_S: f64 = 30.0;
const SLIDE_MM: f64 = 120.0;

fn sliding(period_mm: f64) -> Sliding {
    Sliding {
        period_mm,
        slide_mm: SLIDE_MM,
        speed_mm_s: SPEED_MM_S,
        ..Sliding::default()
    }
}

/// A slide that begins on one grating and ends on another.
struct Changing {
    gratings: [SlidingScene; 2],
    changes_s: f64,
}

impl Changing {
    /// Creates a slide whose grating changes in the middle from `first` to `second`.
    fn new(first: Sliding, second: Sliding) -> Self {
        let gratings = [first, second].map(|grating| SlidingScene::new(grating).expect("a scene"));
        let changes_s = gratings[0].truth().slide_start_s + 0.5 * SLIDE_MM / SPEED_MM_S;
        Self {
            gratings,
            changes_s,
        }
    }
}

impl Scene for Changing {
    fn volts(&mut self, input: u8, t_s: f64) -> f64 {
        // Advance both scenes, because each has internal state.
        let [first, second] = self
            .gratings
            .each_mut()
            .map(|grating| grating.volts(input, t_s));
        if t_s < self.changes_s { first } else { second }
    }

    fn end_s(&self) -> f64 {
        self.gratings[0].end_s()
    }
}

/// Settings that declare the speed, the start of the slide and its length.
fn known_speed() -> Settings {
    let mut settings = Settings::DEFAULT;
    settings.slide = Slide {
        rule: SlideRule::Protocol,
        delay_s: 1.0,
        speed_mm_s: SPEED_MM_S as f32,
        length_mm: SLIDE_MM as f32,
    };
    settings
}

fn textures(scene: impl Scene + 'static, settings: Settings) -> (Vec<Texture>, Vec<Event>) {
    let events = run(scene, settings, all);
    (outcome(&events).textures, events)
}

fn assert_is(texture: &Texture, period_mm: f64) {
    let off_mm = f64::from(texture.period_mm) - period_mm;
    assert!(
        off_mm.abs() < 4.0 * f64::from(texture.period_sigma_mm),
        "{period_mm}: {texture:?}"
    );
    assert!(
        texture.period_sigma_mm > 0.0 && texture.power_sigma_v2 > 0.0,
        "{texture:?}"
    );
}

#[test]
fn a_grating_that_stays_is_reported_once() {
    for seed in 1..=5 {
        let scene = Sliding {
            seed,
            ..sliding(3.6)
        };
        let scene = SlidingScene::new(scene).expect("a scene");
        let (textures, events) = textures(scene, known_speed());
        let out = outcome(&events);
        assert!(
            out.window_fits.len() > 10 && textures.len() == 1,
            "seed {seed}: {textures:?}"
        );
        assert_is(&textures[0], 3.6);
        // The texture follows the estimate that it is based on, and has the same time.
        let at = events
            .iter()
            .position(|event| matches!(event, Event::Texture(_)))
            .expect("a texture");
        let Event::Estimate(estimate) = &events[at - 1] else {
            panic!("{:?}", events[at - 1])
        };
        assert_eq!(
            (textures[0].t_us, textures[0].plan),
            (estimate.t_us, Plan::PAPER)
        );
        // Computed from the definitions, in f64.
        let squares: f64 = estimate
            .channels
            .iter()
            .map(|channel| f64::from(channel.amplitude_v).powi(2))
            .sum();
        let power_v2 = 0.5 * squares / estimate.channels.len() as f64;
        assert!(
            (f64::from(textures[0].power_v2) / power_v2 - 1.0).abs() < 1e-5,
            "{power_v2} {textures:?}"
        );
        let image = out
            .images
            .iter()
            .find(|image| image.hold == Hold::BeforeSlide)
            .expect("an image");
        let mean: f64 = image
            .taxels
            .iter()
            .map(|taxel| f64::from(taxel.level_v))
            .sum::<f64>()
            / image.taxels.len() as f64;
        let level_v = f64::from(textures[0].level_v.expect("a level"));
        assert!(
            (level_v - mean).abs() < 1e-6 * mean.abs().max(1e-3),
            "{level_v} {mean}"
        );
    }
}

#[test]
fn another_grating_in_the_same_touch_is_reported_again() {
    for (first_mm, second_mm) in [(3.6, 2.8), (2.6, 2.7), (3.1, 4.1)] {
        let scene = Changing::new(sliding(first_mm), sliding(second_mm));
        let (textures, _) = textures(scene, known_speed());
        println!("{textures:?}");
        assert!(textures.len() >= 2, "{first_mm} {second_mm}: {textures:?}");
        assert_is(&textures[0], first_mm);
        assert!(textures.iter().skip(1).any(|texture| {
            (f64::from(texture.period_mm) - second_mm).abs()
                < 4.0 * f64::from(texture.period_sigma_mm)
        }));
    }
}

/// A scene that plays three times.
struct Again(SlidingScene);

impl Scene for Again {
    fn volts(&mut self, input: u8, t_s: f64) -> f64 {
        self.0.volts(input, t_s % self.0.end_s())
    }

    fn end_s(&self) -> f64 {
        3.0 * self.0.end_s()
    }
}

#[test]
fn each_touch_reports_its_texture() {
    let scene = SlidingScene::new(sliding(3.6)).expect("a scene");
    let (textures, events) = textures(Again(scene), known_speed());
    assert_eq!(
        (outcome(&events).contacts_s.len(), textures.len()),
        (3, 3),
        "{textures:?}"
    );
    textures.iter().for_each(|texture| assert_is(texture, 3.6));
}

/// Over many runs in white noise, the scatter of the power must agree with its sigma.
#[test]
fn the_power_s_sigma_is_its_scatter() {
    const RUNS: u64 = 50;
    let first = |seed| {
        let scene = Sliding {
            seed,
            snr_db: Some(20.0),
            period_mm: 3.6,
            slide_mm: 40.0,
            ..Sliding::physical()
        };
        let scene = SlidingScene::new(scene).expect("a scene");
        textures(scene, known_speed()).0.first().copied()
    };
    let all: Vec<Texture> = (1..=RUNS).filter_map(first).collect();
    assert_eq!(all.len() as u64, RUNS);
    let mean =
        |value: &dyn Fn(&Texture) -> f64| all.iter().map(value).sum::<f64>() / all.len() as f64;
    let power_v2 = mean(&|texture| texture.power_v2.into());
    let scatter_v2 = mean(&|texture| (f64::from(texture.power_v2) - power_v2).powi(2)).sqrt();
    let sigma_v2 = mean(&|texture| texture.power_sigma_v2.into());
    println!("scatter {scatter_v2:e} sigma {sigma_v2:e} of {power_v2:e} V^2");
    // The scatter of 50 values is known to 10 %.
    assert!(
        (scatter_v2 / sigma_v2 - 1.0).abs() < 0.35,
        "scatter {scatter_v2:e} sigma {sigma_v2:e}"
    );
}

#[test]
fn without_a_speed_there_is_no_texture() {
    let textures = |mut settings: Settings| {
        (settings.array.period_min_mm, settings.array.period_max_mm) = (1.2, 9.0);
        textures(SlidingScene::new(sliding(3.6)).expect("a scene"), settings)
    };
    let (none, events) = textures(Settings::DEFAULT);
    assert!(outcome(&events).window_fits.len() > 10);
    assert_eq!(none, []);
    let (found, _) = textures(known_speed());
    assert_eq!(found.len(), 1, "{found:?}");
}
