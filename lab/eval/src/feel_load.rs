//! What the benchmark of `feel` works on: frames of a scan plan and their window, the same on the
//! chip and here.

use ridgetone_finger::Ring;
use ridgetone_finger::Window;
use ridgetone_finger::internals::feel;
use ridgetone_proto::plan::{Converters, Plan};
use ridgetone_proto::settings::{Feeling, Settings};
use ridgetone_proto::telemetry::Feel;
use ridgetone_tone::Values;
use ridgetone_tone::phase::{cos_sin, from_turns};

/// The named plan of a number.
fn plan(number: u8) -> Option<Plan> {
    let mut plans = Plan::usual(Converters::ADS1258);
    plans.nth(usize::from(number)).map(|(_, plan)| plan)
}

/// Fills a ring with frames of a plan: as many as it holds. None without such a plan.
pub fn fill(ring: &mut Ring, number: u8) -> Option<()> {
    let plan = plan(number)?;
    ring.change(&plan, 0);
    for frame in 0..plan.ring_frames() {
        ring.push(&values(frame), plan.inputs, 0);
    }
    Some(())
}

/// A wave of twenty frames with an overtone, and a number that hardly repeats in place of noise,
/// codes.
fn values(frame: u32) -> Values {
    let (cos, sin) = cos_sin(from_turns(0.05 * (frame % 20) as f32));
    core::array::from_fn(|taxel| {
        let mixed = (frame << 4 | taxel as u32).wrapping_mul(2_654_435_761);
        1000.0 * cos + 300.0 * sin * cos + (mixed >> 24) as f32
    })
}

/// What a finger feels at the end of that ring, with the default settings of the plan and a
/// conversion of 1 mV a micrometre.
pub fn feels(ring: &Ring, number: u8, memory: &mut [f32]) -> Option<Feel> {
    let plan = plan(number)?;
    let feeling = Feeling {
        volts_per_um: 1e-3,
        sigma_fraction: 0.1,
        force_ratio: 0.3,
    };
    let settings = Settings {
        feel: feeling,
        ..Settings::DEFAULT.with_plan(plan)
    };
    let frames = plan.ring_frames();
    let window = Window::new(plan, frames);
    feel(&window, &mut &*ring, memory, &settings).ok()?
}

/// The bits of what was found, added up.
pub fn bits(feel: &Feel) -> u32 {
    let scores = [feel.soft, feel.rough]
        .into_iter()
        .chain(feel.per_hz)
        .flatten();
    let levels = feel.levels_db.iter().fold(0u32, |sum, level| {
        sum.wrapping_mul(31).wrapping_add(*level as u8 as u32)
    });
    scores.fold(levels, |sum, found| {
        sum.wrapping_mul(31)
            .wrapping_add(found.value.to_bits())
            .wrapping_mul(31)
            .wrapping_add(found.sigma.to_bits())
    })
}
