//! Touch at a distance: the bars of what a paper's text gives.

use super::{from_root, read};
use crate::distance::gratings::{Indices, PERIODS_MM, figure_17d};
use crate::distance::layers::{Filter, crossing, figure_12, figure_16};
use crate::distance::{self, matching};
use crate::page::{self, Bar, Figures};

fn near(value: f64, wanted: f64, most: f64) -> bool {
    (value - wanted).abs() <= most
}

#[test]
fn every_bar_is_met_but_four_of_figure_16() {
    let bars = distance::bars::bars().expect("bars");
    let missed: Vec<_> = bars.iter().filter(|bar| !bar.met).collect();
    let is_known = |bar: &&&Bar| bar.bar.starts_with("Figure 16, shear is of no use from");
    let known = missed.iter().filter(is_known).count();
    assert!(
        bars.len() > 30 && missed.len() == 4 && known == 4,
        "{missed:?}"
    );
}

/// Maxima by hand: (0.5 + 1.5 u) exp(-u) is greatest at u = 2/3.
#[test]
fn figure_12_is_its_closed_form() {
    let u = 2.0 / 3.0f64;
    let (with, without) = figure_12(u / 2.7 / std::f64::consts::TAU);
    assert!(
        near(with, 3.0 * (-u).exp(), 1e-9) && near(with, 1.540, 1e-3),
        "{with}"
    );
    assert!(without < with);
    let (with, without) = figure_12(0.25);
    assert!(
        near(with, 0.198, 1e-3) && near(without, 0.333, 1e-3),
        "{with} {without}"
    );
    // Without shear more of the high frequencies arrives (section 2.4).
    assert!(
        (13..80).all(|n| figure_12(0.005 * f64::from(n)).1 > figure_12(0.005 * f64::from(n)).0)
    );
}

#[test]
fn figure_16_has_its_limit_and_its_crossing() {
    for filter in Filter::ALL {
        let dense = figure_16(0.05, filter, false);
        assert!(near(dense, 15.9, 0.2), "{filter:?}: {dense}");
        let crossing = crossing(filter);
        println!("{filter:?} {dense} {crossing:?}");
        match filter {
            Filter::LowPass => assert!(crossing.is_none_or(|ratio| ratio > 1.6), "{crossing:?}"),
            _ => assert!(
                crossing.is_some_and(|ratio| (0.9..1.6).contains(&ratio)),
                "{filter:?} {crossing:?}"
            ),
        }
    }
}

#[test]
fn figures_17_to_19_are_within_their_bars() {
    let (_, mean) = figure_17d(4.0);
    let at = Indices::of;
    assert!(
        near(mean, 0.22, 0.02) && near(at(4.0).strain.0, 0.18, 0.02),
        "{mean}"
    );
    for period_mm in [3.4, 3.6] {
        assert!(
            (0.10..=0.15).contains(&at(period_mm).strain.0),
            "{period_mm}"
        );
    }
    for pair in PERIODS_MM.windows(2) {
        let (fine, coarse) = (at(pair[0]), at(pair[1]));
        assert!(
            fine.strain.0 < coarse.strain.0 && fine.stress.0 < coarse.stress.0,
            "{pair:?}"
        );
        // Shear stress makes gratings harder to feel (section 4.2).
        assert!(
            fine.strain.0 < fine.strain.1 && fine.stress.0 < fine.stress.1,
            "{pair:?}"
        );
    }
}

#[test]
fn figure_8_matches_and_its_forces_are_noisy() {
    let figure = matching::block().expect("a figure");
    let [any_sign, pressing, regular] = &figure.ways[..] else {
        panic!("{:?}", figure.ways)
    };
    for way in &figure.ways {
        assert!(way.error < 0.05, "{}: {}", way.name, way.error);
    }
    println!(
        "{} {} {} condition {}",
        any_sign.error, pressing.error, regular.error, figure.condition
    );
    // Forces of any sign are the best of all, and none of the others pulls.
    assert!(any_sign.error <= pressing.error + 1e-4 && pressing.error <= regular.error);
    assert!(
        pressing
            .forces
            .iter()
            .chain(&regular.forces)
            .all(|force| *force >= 0.0)
    );
    assert!(any_sign.forces.iter().any(|force| *force < 0.0));
    // The sum of all forces is the load's.
    let sum: f64 = any_sign.forces.iter().sum();
    assert!(near(sum, 4.0, 0.1), "{sum}");
}

/// Okamoto et al., figures 12 and 13: what is late is felt worse, and the S-shape. That jitter is
/// worse still does not follow from this observer; the paper has no test of it either, but of
/// conditions 1 and 3.
#[test]
fn delays_make_answers_worse() {
    let outcomes = distance::experiment::outcomes().expect("outcomes");
    let [at_once, late, jittered] = &outcomes[..] else {
        panic!("{outcomes:?}")
    };
    for (condition, outcome) in &outcomes {
        println!("{}: {outcome:?}", condition.name);
    }
    let r = |(_, outcome): &(_, distance::experiment::Outcome)| outcome.correlation.0;
    assert!(
        r(at_once) > r(late) + 0.03 && r(at_once) > r(jittered) + 0.03,
        "{outcomes:?}"
    );
    // Without delay the vibration is the surface, but for the coming of the vibration and the noise
    // of the encoder.
    assert!(
        at_once.1.surface_percent < 2.0 && late.1.surface_percent > 90.0,
        "{outcomes:?}"
    );
    assert!(at_once.1.error_percent < 2.0, "{outcomes:?}");
    // The law has its local peak at 1.4 mm: beyond it answers grow less, or fall (section V-D).
    let slope = |from: usize, to: usize| at_once.1.answers_mm[to] - at_once.1.answers_mm[from];
    assert!(
        slope(3, 5) < 0.5 * slope(1, 3) && slope(5, 6) > slope(3, 5) / 2.0,
        "{outcomes:?}"
    );
}

#[test]
fn the_figures_are_what_is_computed() {
    let shipped: Figures<page::None> =
        page::load(&from_root("docs/results"), "distance").expect("the figures");
    let computed = distance::tables::tables().expect("tables");
    assert!(
        shipped.tables == computed,
        "run `cargo xtask distance --write`"
    );
    assert!(
        read("docs/results/distance.svg") == distance::tables::picture(),
        "run `cargo xtask distance --write`"
    );
}
