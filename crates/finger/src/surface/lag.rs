//! Lag of the tone between the two columns of units.
//!
//! The units stand in two columns, one pitch apart along the motion. Corresponding piezoresistors
//! of all units respond alike, so the difference of their phases between the columns is due to the
//! wave; other piezoresistors differ in phase by themselves. So phases are averaged over each
//! column's corresponding piezoresistors, weighted by their inverse variances; then the differences
//! between the columns are averaged over all groups of piezoresistors. With Gaussian noise this is
//! the maximum-likelihood estimate. A dead or noisy channel has almost no weight.

use crate::fit::Fitted;
use core::f32::consts::PI;
use ridgetone_proto::settings::{Array, TAXELS};
use ridgetone_tone::phase::{cos_sin, from_turns};

/// Excess of chi-squared over its mean, in its standard deviations, above which the channels
/// disagree by more than their noise.
const DISAGREE: f32 = 4.0;

/// A lag and its uncertainty.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lag {
    /// Lag of the front column behind the rear one (turns, -0.5 to 0.5). It is positive if a wave
    /// that is longer than two pitches reaches the front column later.
    pub turns: f32,
    /// Standard deviation, turns.
    pub sigma: f32,
}

/// Weighted sum of unit vectors, one in the direction of each phase. The sum's angle is the mean
/// phase; `weight` minus its length is half of the phases' chi-squared about the mean.
#[derive(Clone, Copy, Default)]
struct Sum {
    cos: f32,
    sin: f32,
    weight: f32,
}

impl Sum {
    fn add(&mut self, cos: f32, sin: f32, weight: f32) {
        self.cos += weight * cos;
        self.sin += weight * sin;
        self.weight += weight;
    }

    fn length(&self) -> f32 {
        ridgetone_tone::sqrt(self.cos * self.cos + self.sin * self.sin)
    }
}

fn column(fitted: &Fitted, taxels: u16) -> Sum {
    let mut sum = Sum::default();
    for taxel in 0..TAXELS {
        let weight = 1.0 / fitted.fit.channels[taxel].phase_variance;
        // This excludes zero, infinity and NaN.
        if taxels & 1 << taxel != 0 && weight > 0.0 && weight < f32::INFINITY {
            let (cos, sin) = cos_sin(from_turns(fitted.turns(taxel)));
            sum.add(cos, sin, weight);
        }
    }
    sum
}

/// Lag between the columns of `array`, corrected for the slots of the scan ([`Fitted::turns`]). If
/// the channels disagree by more than their noise, their scatter determines the uncertainty. `None`
/// if no corresponding piezoresistors have the tone in both columns.
pub fn lag(fitted: &Fitted, array: &Array) -> Option<Lag> {
    let (mut total, mut short, mut freedom) = (Sum::default(), 0.0, -1.0);
    for alike in array.alike.iter().map(|alike| alike & fitted.fit.usable) {
        let (rear, front) = (
            column(fitted, alike & !array.front),
            column(fitted, alike & array.front),
        );
        let (rear_length, front_length) = (rear.length(), front.length());
        let lengths = rear_length * front_length;
        if !(lengths > 0.0) {
            continue;
        }
        let weight = rear.weight * front.weight / (rear.weight + front.weight);
        let cos = (rear.cos * front.cos + rear.sin * front.sin) / lengths;
        let sin = (rear.sin * front.cos - rear.cos * front.sin) / lengths;
        total.add(cos, sin, weight);
        short += rear.weight - rear_length + front.weight - front_length;
        freedom += alike.count_ones() as f32 - 1.0;
    }
    if !(total.weight > 0.0) {
        return None;
    }
    let scatter = 2.0 * (short + total.weight - total.length());
    let mut variance = 1.0 / total.weight;
    // A single pair leaves no degree of freedom.
    if freedom > 0.0 && scatter > freedom + DISAGREE * ridgetone_tone::sqrt(2.0 * freedom) {
        variance *= scatter / freedom;
    }
    Some(Lag {
        turns: libm::atan2f(total.sin, total.cos) / (2.0 * PI),
        sigma: ridgetone_tone::sqrt(variance) / (2.0 * PI),
    })
}
