//! The sample interrupt: turns the encoder's counter into the converter's next code.
//!
//! A timer triggers the converter and requests the interrupt at the same time. The code of a run is
//! output at the next trigger, exactly on time; it only has to be ready by then.

use super::dac::Dac;
use super::gate::{Gate, State};
use super::message::Position;
use super::parameters::{Parameters, samples};
use super::{REPORT_SAMPLES, SAMPLE_US};
use crate::stimulus::{Prepared, Stimulus};

/// Snapshot of the sampler for other tasks.
#[derive(Clone, Copy, Debug)]
pub struct Look {
    pub position: Position,
    pub state: State,
    /// Amplitude of the fundamental, volts.
    pub amplitude_v: f32,
    /// Samples since start-up.
    pub samples: u32,
    /// Samples since start-up that were not ready in time.
    pub deadlines_missed: u32,
    /// Maximum time from a trigger to the reading of the encoder, microseconds.
    pub latest_reading_us: u32,
}

#[derive(Clone, Copy, Debug)]
pub struct Sampler {
    stimulus: Stimulus,
    gate: Gate,
    dac: Dac,
    /// Latest reading of the encoder's 16-bit counter (RM0090, 18.3.12), and its extension to 32
    /// bits, which works below 32,768 counts between samples: a hand at 1.6 km/s with counts of 5
    /// um.
    counter: u16,
    counts: i32,
    /// Device time of the latest reading, microseconds, and board time of the trigger before it;
    /// `None` before the first run.
    t_us: u64,
    trigger_us: Option<u32>,
    late_us: u32,
    samples: u32,
    until_report: u32,
    deadlines_missed: u32,
    latest_reading_us: u32,
}

impl Default for Sampler {
    fn default() -> Self {
        Self::new()
    }
}

impl Sampler {
    /// Creates a sampler with the default parameters, at rest and without a texture.
    pub fn new() -> Self {
        let parameters = Parameters::DEFAULT;
        // A test ensures that the defaults are possible.
        let stimulus = parameters.stimulus().unwrap_or_default();
        Self {
            stimulus,
            gate: gate(&parameters),
            dac: Dac::new(stimulus.actuator()),
            counter: 0,
            counts: 0,
            t_us: 0,
            trigger_us: None,
            late_us: 0,
            samples: 0,
            until_report: REPORT_SAMPLES,
            deadlines_missed: 0,
            latest_reading_us: 0,
        }
    }

    /// Takes a reading of the encoder's counter. `now_us` is the board time, which wraps, and
    /// `late_us` the time since the latest trigger. Returns the code for the next trigger.
    #[inline]
    pub fn next(&mut self, now_us: u32, late_us: u32, counter: u16) -> u16 {
        let trigger_us = now_us.wrapping_sub(late_us);
        let passed_us = trigger_us.wrapping_sub(
            self.trigger_us
                .unwrap_or(trigger_us.wrapping_sub(SAMPLE_US)),
        );
        // The two counters step at different moments, so the time is a multiple of the period only
        // to within 1 us. Usually there was one trigger since the last run; further ones were
        // missed.
        let triggers = (passed_us.saturating_add(SAMPLE_US / 2) / SAMPLE_US).max(1);
        self.t_us = self
            .t_us
            .wrapping_add(u64::from(passed_us))
            .wrapping_add(late_us.into())
            .wrapping_sub(self.late_us.into());
        (self.trigger_us, self.late_us) = (Some(trigger_us), late_us);
        self.samples = self.samples.wrapping_add(triggers);
        self.deadlines_missed = self.deadlines_missed.saturating_add(triggers - 1);
        self.latest_reading_us = self.latest_reading_us.max(late_us);

        let moved = counter.wrapping_sub(self.counter) as i16;
        (self.counter, self.counts) = (counter, self.counts.wrapping_add(moved.into()));
        self.gate.step(self.counts);
        if self.gate.state() == State::Vibrating {
            self.stimulus.down()
        } else {
            self.stimulus.lift()
        }
        self.dac.next(self.stimulus.next(self.counts))
    }

    /// Takes note that the code was written, after its trigger if `is_late`. Returns true if
    /// `requests` is due.
    #[inline]
    pub fn written(&mut self, is_late: bool) -> bool {
        if is_late {
            self.deadlines_missed = self.deadlines_missed.saturating_add(1);
        }
        self.until_report = self.until_report.saturating_sub(1);
        let is_due = self.until_report == 0;
        if is_due {
            self.until_report = REPORT_SAMPLES;
        }
        is_due
    }

    /// Returns a snapshot after the latest `next`.
    pub fn look(&self) -> Look {
        Look {
            position: Position {
                t_us: self.t_us,
                counts: self.counts,
                speed_mm_s: self.stimulus.speed_mm_s(),
            },
            state: self.gate.state(),
            amplitude_v: self.stimulus.amplitude_v(),
            samples: self.samples,
            deadlines_missed: self.deadlines_missed,
            latest_reading_us: self.latest_reading_us,
        }
    }

    /// Returns the stimulus, to prepare a texture.
    pub fn stimulus(&self) -> Stimulus {
        self.stimulus
    }

    pub fn heard(&mut self) {
        self.gate.heard();
    }

    pub fn texture(&mut self, prepared: &Prepared) {
        self.stimulus.take(prepared);
        self.gate.textured();
    }

    pub fn enable(&mut self, is_enabled: bool) {
        self.gate.enable(is_enabled);
        // Rise only now, when a PC that knows the actuator has set its slew.
        if is_enabled {
            self.dac.rise();
        }
    }

    /// Sets parameters and their stimulus if the output rests.
    pub fn configure(&mut self, parameters: &Parameters, stimulus: &Stimulus) -> bool {
        let rests = self.gate.state() != State::Vibrating && self.stimulus.amplitude_v() == 0.0;
        if rests {
            (self.stimulus, self.gate) = (*stimulus, gate(parameters));
            self.dac = self.dac.with(stimulus.actuator());
        }
        rests
    }
}

fn gate(parameters: &Parameters) -> Gate {
    Gate::new(
        samples(parameters.still_s).max(1),
        samples(parameters.silence_s).max(1),
    )
}
