//! By how much the tone in one column of units lags behind that in the other.
//!
//! The units stand in two columns, one pitch apart along the motion. Piezoresistors that respond alike (the same one of
//! every unit) see the same wave in both columns, earlier or later: the difference of their phases is the wave's, while
//! that of unlike ones is mostly their own. So phases are averaged among the alike ones of each column, each weighted by
//! the inverse of its variance, and the columns' differences are averaged in turn. With Gaussian noise that is the
//! maximum of the likelihood; a dead or noisy channel has next to no weight.

use crate::abscissa::Fitted;
use crate::phase::{cos_sin, from_turns};
use crate::settings::{Array, TAXELS};
use core::f32::consts::PI;

/// Scatter of the channels, in standard deviations of its chi-squared, from which they disagree by more than noise.
const DISAGREE: f32 = 4.0;

/// A lag and its uncertainty.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lag {
    /// How far the column in front lags behind the other, turns, -0.5 to 0.5: positive if a wave that is longer than
    /// two pitches comes to it later.
    pub turns: f32,
    /// Standard deviation, turns.
    pub sigma: f32,
}

/// A weighted sum of phases as a vector: its angle is their mean, and what it is shorter than `weight` is half of their
/// chi-squared about that.
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
        libm::sqrtf(self.cos * self.cos + self.sin * self.sin)
    }
}

/// The lag between the columns of `array`, the slots of the scan accounted for ([`Fitted::turns`]). Where the channels
/// disagree by more than their noise, the uncertainty is that of their scatter. None if no two channels that respond
/// alike have the tone in both columns.
#[inline(never)]
pub fn lag(fitted: &Fitted, array: &Array) -> Option<Lag> {
    let (mut total, mut short, mut freedom) = (Sum::default(), 0.0, -1.0);
    for alike in array.alike {
        let mut columns = [Sum::default(); 2];
        let mut channels = 0.0;
        for taxel in 0..TAXELS {
            let bit = alike & fitted.fit.usable & 1 << taxel;
            let sigma_rad = fitted.fit.channels[taxel].phase_sigma_rad;
            if bit == 0 || !(sigma_rad > 0.0) || !sigma_rad.is_finite() {
                continue;
            }
            let (cos, sin) = cos_sin(from_turns(fitted.turns(taxel)));
            columns[(array.front & bit != 0) as usize].add(cos, sin, 1.0 / (sigma_rad * sigma_rad));
            channels += 1.0;
        }
        let [rear, front] = columns;
        let lengths = rear.length() * front.length();
        if !(lengths > 0.0) {
            continue;
        }
        let weight = rear.weight * front.weight / (rear.weight + front.weight);
        let cos = (rear.cos * front.cos + rear.sin * front.sin) / lengths;
        let sin = (rear.sin * front.cos - rear.cos * front.sin) / lengths;
        total.add(cos, sin, weight);
        short += rear.weight - rear.length() + front.weight - front.length();
        freedom += channels - 1.0;
    }
    if !(total.weight > 0.0) {
        return None;
    }
    let scatter = 2.0 * (short + total.weight - total.length());
    let mut variance = 1.0 / total.weight;
    if scatter > freedom + DISAGREE * libm::sqrtf(2.0 * freedom) && freedom > 0.0 {
        variance *= scatter / freedom;
    }
    let turn = 2.0 * PI;
    Some(Lag { turns: libm::atan2f(total.sin, total.cos) / turn, sigma: libm::sqrtf(variance) / turn })
}
