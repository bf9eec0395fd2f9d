//! The stylus' end: a simulated hand, its encoder, the voltage of an actuator, and the error of the
//! stimulus against the texture.

use super::hand::Hand;
use super::message::{Body, Message, Receiver};
use crate::stimulus::{Encoder, Stimulus, Texture};
use crate::touch::Output;
use anyhow::Result;
use std::f64::consts::TAU;

/// Positions that are sent a second.
const POSITIONS_HZ: f64 = 250.0;

/// Time without a message after which the link is dead, and the vibration fades, seconds: four of
/// them are missing.
pub const SILENT_S: f64 = 1.0;

/// Length of what a phase is measured over, seconds.
const STRETCH_S: f64 = 0.02;

/// Fraction of the wanted amplitude below which a vibration is not compared: it comes, or goes.
const COMPARED_FROM: f32 = 0.98;

/// Sums of a stretch: of sine and cosine of the true phase, and of the voltage times them.
#[derive(Clone, Copy, Debug, Default)]
struct Sums {
    ss: f64,
    sc: f64,
    cc: f64,
    ys: f64,
    yc: f64,
    count: u32,
}

/// Error of the stimulus against the texture under the finger.
#[derive(Clone, Copy, Debug, Default)]
pub struct Error {
    squares: f64,
    late_squares: f64,
    count: u64,
    phase_squares: f64,
    phases: u64,
}

impl Error {
    /// Root mean square of the voltage's error over the amplitude, percent; none if nothing was
    /// felt.
    pub fn percent(&self) -> Option<f64> {
        (self.count > 0).then(|| 100.0 * (self.squares / self.count as f64).sqrt())
    }

    /// Error of a vibration that would have travelled, later by the mean delay.
    pub fn late_percent(&self) -> Option<f64> {
        (self.count > 0).then(|| 100.0 * (self.late_squares / self.count as f64).sqrt())
    }

    /// Root mean square of the phase's error in stretches of 20 ms, cycles.
    pub fn cycles(&self) -> Option<f64> {
        (self.phases > 0).then(|| (self.phase_squares / self.phases as f64).sqrt())
    }
}

pub struct StylusEnd {
    pub receiver: Receiver,
    pub error: Error,
    /// Largest step of the voltage so far, as a fraction of the slew.
    pub steepest: f32,
    pub texture: Option<Texture>,
    stimulus: Stimulus,
    output: Output,
    hand: Hand,
    delay_s: f64,
    run: u32,
    samples: u64,
    number: u32,
    heard_s: Option<f64>,
    is_down: bool,
    volts: f32,
    /// Counts of the encoder at the latest sample.
    counts: i32,
    /// Position at which the texture began, millimetres, and its phase there, cycles.
    anchor: (f64, f64),
    sums: Sums,
}

impl StylusEnd {
    /// `delay_s` is the mean delay, to say what a vibration would have felt like that had to
    /// travel.
    pub fn new(output: Output, hand: Hand, delay_s: f64, run: u32) -> Result<Self> {
        let stimulus = Stimulus::new(output.actuator, Encoder::OKAMOTO, output.law())?;
        Ok(Self {
            receiver: Receiver::default(),
            error: Error::default(),
            steepest: 0.0,
            texture: None,
            stimulus,
            output,
            hand,
            delay_s,
            run,
            samples: 0,
            number: 0,
            heard_s: None,
            is_down: false,
            volts: output.actuator.bias_v(),
            counts: 0,
            anchor: (0.0, 0.0),
            sums: Sums::default(),
        })
    }

    /// Voltage now against the bias, -1 to 1.
    pub fn level(&self) -> f32 {
        self.volts / self.output.actuator.bias_v() - 1.0
    }

    pub fn is_felt(&self) -> bool {
        self.is_down
    }

    /// Position of the hand at a time, millimetres.
    pub fn position_mm(&self, t_s: f64) -> f64 {
        self.hand.position_mm(t_s)
    }

    /// Takes what has arrived.
    pub fn take(&mut self, t_s: f64, bytes: &[u8]) {
        let Some(Message {
            body: Body::Texture(texture),
            ..
        }) = self.receiver.take(bytes)
        else {
            return;
        };
        self.heard_s = Some(t_s);
        let Some(texture) = texture else {
            self.lift();
            return;
        };
        if self.texture != Some(texture)
            && self
                .stimulus
                .set_texture(&self.output.counted(&texture))
                .is_ok()
        {
            (self.texture, self.sums) = (Some(texture), Sums::default());
            // The phase goes on where it is: no hand feels where a texture began. Half a count is
            // of the new period.
            self.anchor = (
                (f64::from(self.counts) + 0.5) * count_mm(),
                self.phase_cycles(),
            );
        }
        if self.texture.is_some() {
            self.stimulus.down();
            self.is_down = true;
        }
    }

    fn lift(&mut self) {
        self.stimulus.lift();
        (self.is_down, self.sums) = (false, Sums::default());
    }

    /// Phase half a count ahead of the latest count, where the hand is.
    fn phase_cycles(&self) -> f64 {
        let period_mm = self
            .texture
            .map_or(1.0, |texture| f64::from(texture.period_mm));
        f64::from(self.stimulus.phase_cycles()) + 0.5 * count_mm() / period_mm
    }

    /// Makes the samples up to a time. `found` is what the finger has under it now, for the error;
    /// none if nobody here knows.
    pub fn advance(&mut self, t_s: f64, found: Option<Texture>) {
        let rate_hz = f64::from(Encoder::OKAMOTO.rate_hz);
        let slew_v = self.output.actuator.slew_v_s / Encoder::OKAMOTO.rate_hz;
        while self.samples as f64 / rate_hz < t_s {
            let now_s = self.samples as f64 / rate_hz;
            if self.is_down
                && self
                    .heard_s
                    .is_some_and(|heard_s| now_s - heard_s > SILENT_S)
            {
                self.lift();
            }
            self.counts = (self.hand.position_mm(now_s) / count_mm()).floor() as i64 as i32;
            let volts = self.stimulus.next(self.counts);
            self.steepest = self.steepest.max((volts - self.volts).abs() / slew_v);
            self.volts = volts;
            self.compare(now_s, found);
            self.samples += 1;
        }
    }

    /// Compares a sample with the texture under the finger at the true position of the hand, in f64.
    fn compare(&mut self, now_s: f64, found: Option<Texture>) {
        let Some(found) = found.filter(|_| self.is_down) else {
            return;
        };
        let bias_v = self.output.actuator.bias_v();
        // With overtones the peak is at most the actuator's.
        let peak = 1.0
            + found
                .overtones
                .iter()
                .map(|overtone| overtone.amplitude)
                .sum::<f32>();
        let wanted_v = f64::from(bias_v * self.output.fraction(&found) / peak);
        if f64::from(self.stimulus.amplitude_v()) < f64::from(COMPARED_FROM) * wanted_v
            || wanted_v <= 0.0
        {
            return;
        }
        let latency_s = f64::from(Encoder::OKAMOTO.latency_s);
        let phase = |t_s: f64| {
            let (from_mm, cycles) = self.anchor;
            TAU * (cycles + (self.hand.position_mm(t_s) - from_mm) / f64::from(found.period_mm))
        };
        let y = f64::from(self.volts - bias_v) / wanted_v;
        let now = phase(now_s + latency_s);
        let ((s, c), overtones) = (now.sin_cos(), overtones(&found, now));
        let late = phase(now_s + latency_s - self.delay_s);
        self.error.squares += (y - s - overtones).powi(2);
        self.error.late_squares += (wave(&found, late) - s - overtones).powi(2);
        self.error.count += 1;
        // The phase is that of the fundamental.
        let y = y - overtones;
        let sums = &mut self.sums;
        (sums.ss, sums.sc, sums.cc) = (sums.ss + s * s, sums.sc + s * c, sums.cc + c * c);
        (sums.ys, sums.yc, sums.count) = (sums.ys + y * s, sums.yc + y * c, sums.count + 1);
        if f64::from(sums.count) < STRETCH_S * f64::from(Encoder::OKAMOTO.rate_hz) {
            return;
        }
        let Sums {
            ss,
            sc,
            cc,
            ys,
            yc,
            count,
        } = std::mem::take(sums);
        let det = ss * cc - sc * sc;
        // A stretch in which the hand turns has too little of a cycle for a phase.
        if det > 0.05 * f64::from(count).powi(2) {
            let error = (yc * ss - ys * sc).atan2(ys * cc - yc * sc) / TAU;
            self.error.phase_squares += error * error;
            self.error.phases += 1;
        }
    }

    /// The position that is due.
    pub fn due(&mut self, t_s: f64) -> Option<Message> {
        if f64::from(self.number) / POSITIONS_HZ > t_s {
            return None;
        }
        let number = self.number;
        self.number = number.wrapping_add(1);
        let t_s = f64::from(number) / POSITIONS_HZ;
        Some(Message {
            run: self.run,
            number,
            t_s,
            body: Body::Position(self.hand.position_mm(t_s)),
        })
    }
}

/// A texture's overtones over its fundamental's amplitude, at a phase of that, radians.
fn overtones(texture: &Texture, phase: f64) -> f64 {
    let overtones = (2..).zip(&texture.overtones);
    overtones
        .map(|(n, of)| {
            f64::from(of.amplitude)
                * (f64::from(n) * phase + TAU * f64::from(of.phase_cycles)).sin()
        })
        .sum()
}

/// Fundamental and overtones.
fn wave(texture: &Texture, phase: f64) -> f64 {
    phase.sin() + overtones(texture, phase)
}

fn count_mm() -> f64 {
    f64::from(Encoder::OKAMOTO.count_mm)
}
