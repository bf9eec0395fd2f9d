//! Corrections of the frames before detection: mains hum of a known frequency, and a drift.

use crate::touch::averages::Averages;
use crate::touch::block::BLOCK_FRAMES;
use crate::touch::values::add_times;
use ridgetone_proto::plan::Plan;
use ridgetone_proto::settings::TAXELS;
use ridgetone_tone::{Values, phase};

/// Minimum gain of the notch at 0 Hz, before it is scaled to one. Hum within 10 Hz of a multiple of
/// the frame rate has less: the scale would raise the noise.
const GAIN_MIN: f32 = 0.07;

/// Estimates of hum and drift.
#[derive(Clone, Debug)]
pub struct Condition {
    /// Weights of a frame and of its neighbours in a filter with a gain of zero at the hum's
    /// frequency and of one at 0 Hz.
    notch: Option<(f32, f32)>,
    /// Frequency of the hum, hertz, until the filter is made for it.
    new_mains_hz: Option<f32>,
    /// Drift, codes, up to frame `latest`; and drift per frame (`rate`), `None` without a drift.
    drifted: Values,
    rate: Option<Values>,
    latest: u32,
    /// True if neither hum nor drift is subtracted.
    is_plain: bool,
    /// Frames per second; and true if frames are averages of the scan's frames.
    rate_hz: f32,
    is_averaged: bool,
}

impl Condition {
    pub const fn new(plan: &Plan) -> Self {
        Self {
            notch: None,
            new_mains_hz: None,
            drifted: [0.0; TAXELS],
            rate: None,
            latest: 0,
            is_plain: true,
            rate_hz: plan.frame_rate_hz() / plan.frames_averaged() as f32,
            is_averaged: plan.frames_averaged() > 1,
        }
    }

    /// True if frames are averages of the scan's frames.
    pub const fn is_averaged(&self) -> bool {
        self.is_averaged
    }

    /// Frames in a time, rounded.
    pub fn frames_in(&self, seconds: f32) -> u32 {
        (seconds * self.rate_hz + 0.5) as u32
    }

    /// Subtracts hum of this frequency; zero: none.
    pub const fn set_mains(&mut self, interferer_hz: f32) {
        // The filter is made at the next frame.
        (self.new_mains_hz, self.is_plain) = (Some(interferer_hz), false);
    }

    /// True if a drift is known.
    pub const fn drifts(&self) -> bool {
        self.rate.is_some()
    }

    /// The latest frame that was processed.
    pub const fn latest(&self) -> u32 {
        self.latest
    }

    /// True if neither hum nor drift is subtracted.
    pub const fn is_plain(&self) -> bool {
        self.is_plain
    }

    /// Sets the rise of the levels per block from now on, if any.
    pub fn set_drift(&mut self, per_block: Option<&Values>) {
        self.rate = per_block.map(|rise| rise.map(|rise| rise * (1.0 / BLOCK_FRAMES as f32)));
        self.is_plain &= self.rate.is_none();
    }

    /// Latest frame that can be filtered if `number` is the latest in the ring: the hum filter
    /// needs the frame after it.
    #[inline(always)]
    pub fn reach(&mut self, number: u32) -> u32 {
        if self.is_plain {
            self.latest = number;
            return number;
        }
        self.reach_cleaned(number)
    }

    fn reach_cleaned(&mut self, number: u32) -> u32 {
        if let Some(mains_hz) = self.new_mains_hz.take() {
            let twice_cos = 2.0 * phase::cos_sin(phase::from_turns(mains_hz / self.rate_hz)).0;
            let gain = 2.0 - twice_cos;
            let is_filtered = mains_hz > 0.0 && gain > GAIN_MIN;
            self.notch = is_filtered.then_some((-twice_cos / gain, 1.0 / gain));
        }
        let number = number.wrapping_sub(self.notch.is_some().into());
        if let Some(rate) = &self.rate {
            let passed = number.wrapping_sub(self.latest) as f32;
            add_times(&mut self.drifted, passed, rate);
        }
        self.latest = number;
        let has_drifted = self.rate.is_some() || self.drifted != [0.0; TAXELS];
        self.is_plain = self.notch.is_none() && !has_drifted;
        number
    }

    /// A frame of the ring without hum and drift, if present with a valid value; `buffer` receives
    /// values that are not in the ring as such.
    #[inline(always)]
    pub fn frame<'a>(
        &self,
        ring: Averages<'a>,
        number: u32,
        buffer: &'a mut Values,
    ) -> Option<&'a Values> {
        if self.is_plain {
            return ring.frame(number, buffer);
        }
        *buffer = self.cleaned(ring, number)?;
        Some(buffer)
    }

    /// A frame's values where hum or drift is subtracted.
    pub fn cleaned(&self, ring: Averages, number: u32) -> Option<Values> {
        let [mut own, mut one, mut other] = [[0.0; TAXELS]; 3];
        let mut values = *ring.frame(number, &mut own)?;
        let (before, behind) = (number.wrapping_sub(1), number.wrapping_add(1));
        // Without both adjacent frames the hum stays.
        if let Some((middle, beside)) = self.notch
            && let Some(before) = ring.frame(before, &mut one)
            && let Some(behind) = ring.frame(behind, &mut other)
        {
            for c in 0..TAXELS {
                values[c] = middle * values[c] + beside * (before[c] + behind[c]);
            }
        }
        add_times(&mut values, -1.0, &self.drifted);
        if let Some(rate) = &self.rate {
            let back = self.latest.wrapping_sub(number) as i32 as f32;
            add_times(&mut values, back, rate);
        }
        Some(values)
    }
}
