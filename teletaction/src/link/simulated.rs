//! A simulated stylus, which runs the image's tasks in this process and in the link's time, under a
//! simulated hand; and the error of its stimulus against the texture under the finger.

use crate::stimulus::Texture;
use crate::stylus::gate::State;
use crate::stylus::message::{Event, Mark, Packet};
use crate::stylus::parameters::Parameters;
use crate::stylus::reports::Reports;
use crate::stylus::sampler::Sampler;
use crate::stylus::{SAMPLE_HZ, SAMPLE_US, dac::CODE_MAX};
use crate::touch::Output;
use ridgetone_finger::tasks::{Outbox, Platform, Received, RequestInbox, Shared, Task, receive};
use ridgetone_proto::boot::Boot;
use ridgetone_proto::framing;
use ridgetone_proto::plan::Plan;
use ridgetone_proto::telemetry::WIRE_MAX;
use rtic_core::Exclusive;
use std::f64::consts::TAU;

/// Fraction of the wanted amplitude below which a vibration is not compared, because it is fading
/// in or out.
const COMPARED_FROM: f32 = 0.98;

/// A hand: steady, or moving to and fro as in Okamoto et al., section IV-A.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hand {
    /// Mean speed, millimetres per second.
    pub speed_mm_s: f64,
    /// Cycles to and fro per second; at 0 the hand never turns.
    pub turns_hz: f64,
}

impl Hand {
    /// The paper's hand at its mean speed.
    pub const OKAMOTO: Self = Self {
        speed_mm_s: 125.4,
        turns_hz: 1.07,
    };

    /// Position at `t_s`, millimetres, from 0 at the start.
    pub fn position_mm(&self, t_s: f64) -> f64 {
        if self.turns_hz <= 0.0 {
            return self.speed_mm_s * t_s;
        }
        // The mean of a rectified sine is 2 / pi of its peak.
        let peak_mm_s = self.speed_mm_s * TAU / 4.0;
        let turn = TAU * self.turns_hz;
        peak_mm_s / turn * (1.0 - (turn * t_s).cos())
    }
}

/// Error of the stimulus against the texture under the finger, as sums of squares.
#[derive(Clone, Copy, Debug, Default)]
pub struct Error {
    squares: f64,
    late_squares: f64,
    count: u64,
}

impl Error {
    /// Returns RMS errors relative to the amplitude, percent: of the stimulus, and of a transmitted
    /// vibration, which the mean delay would shift. `None` if nothing was felt.
    pub fn percent(&self) -> Option<(f64, f64)> {
        let rms = |squares: f64| 100.0 * (squares / self.count as f64).sqrt();
        (self.count > 0).then(|| (rms(self.squares), rms(self.late_squares)))
    }
}

/// Platform on which tasks are called where an interrupt would start them.
struct Called;

impl Platform for Called {
    fn pend(_: &Shared<Self>, _: Task) {}

    fn now_us(&self) -> u32 {
        0
    }
}

pub struct Tasks {
    pub sampler: Sampler,
    reports: Reports,
    inbox: RequestInbox,
    outbox: Outbox<Mark<Event>>,
    shared: Shared<Called>,
}

impl Default for Tasks {
    fn default() -> Self {
        Self {
            sampler: Sampler::new(),
            reports: Reports::new(Boot::UNKNOWN),
            inbox: RequestInbox::new(),
            outbox: Outbox::new(),
            shared: Shared::new(Called, Plan::PAPER),
        }
    }
}

impl Tasks {
    /// Takes bytes of requests. Returns the packets that are sent.
    pub fn receive(&mut self, bytes: &[u8]) -> Vec<Packet> {
        let mut packets = Vec::new();
        for byte in bytes {
            receive(&mut self.inbox, Received::Byte(*byte), &self.shared);
            packets.extend(self.run_requests());
        }
        packets
    }

    fn run_requests(&mut self) -> impl Iterator<Item = Packet> {
        self.reports.run(
            &mut Exclusive(&mut self.sampler),
            &mut Exclusive(&mut self.inbox),
            &mut Exclusive(&mut self.outbox),
            &self.shared,
        );
        std::iter::from_fn(|| self.outbox.take())
    }

    pub fn requests_damaged(&self) -> u32 {
        self.shared.diagnostics.requests_damaged.get()
    }
}

pub struct Simulated {
    pub error: Error,
    /// True if the stylus sends nothing, but still receives.
    pub is_mute: bool,
    /// Latest code of the converter, and the largest step between two codes.
    pub code: u16,
    pub steepest: u16,
    tasks: Tasks,
    hand: Hand,
    output: Output,
    count_mm: f64,
    latency_s: f64,
    /// Delay that a transmitted vibration would have, seconds.
    delay_s: f64,
    samples: u64,
    /// Counts of the hand at the latest sample, and at the latest start.
    counts: i64,
    zero: i64,
    /// Period of the stimulus, the position at which this period began (millimetres), and the phase
    /// there (cycles).
    period_mm: f32,
    anchor: (f64, f64),
    sent: Vec<u8>,
}

impl Simulated {
    pub fn new(hand: Hand, output: Output, parameters: &Parameters, delay_s: f64) -> Self {
        Self {
            error: Error::default(),
            is_mute: false,
            code: 0,
            steepest: 0,
            tasks: Tasks::default(),
            hand,
            output,
            count_mm: parameters.count_mm.into(),
            latency_s: parameters.whole_latency_s().into(),
            delay_s,
            samples: 0,
            counts: 0,
            zero: 0,
            period_mm: 0.0,
            anchor: (0.0, 0.0),
            sent: Vec::new(),
        }
    }

    /// Restarts as after a power loss: the encoder counts from 0.
    pub fn restart(&mut self) {
        (self.tasks, self.zero, self.code) = (Tasks::default(), self.counts, 0);
    }

    pub fn state(&self) -> State {
        self.tasks.sampler.look().state
    }

    pub fn hear(&mut self, bytes: &[u8]) {
        let packets = self.tasks.receive(bytes);
        self.send(packets);
        let stimulus = self.tasks.sampler.stimulus();
        if stimulus.period_mm() != self.period_mm {
            // The phase is continuous, because a hand cannot feel where a texture began. The
            // stimulus reports the phase at the count's lower edge, half a count below the anchor.
            self.period_mm = stimulus.period_mm();
            let half = 0.5 * self.count_mm / f64::from(self.period_mm);
            self.anchor = (
                (self.counts as f64 + 0.5) * self.count_mm,
                f64::from(stimulus.phase_cycles()) + half,
            );
        }
    }

    /// Makes the samples up to `t_s`; returns the bytes sent since the last call. `found` is the
    /// texture under the finger, for the error; `None` if unknown here.
    pub fn run(&mut self, t_s: f64, found: Option<Texture>) -> Vec<u8> {
        while self.samples as f64 / f64::from(SAMPLE_HZ) < t_s {
            let now_s = self.samples as f64 / f64::from(SAMPLE_HZ);
            self.samples += 1;
            self.counts = (self.hand.position_mm(now_s) / self.count_mm).floor() as i64;
            let now_us = (self.samples as u32).wrapping_mul(SAMPLE_US);
            let counter = (self.counts - self.zero) as u16;
            let code = self.tasks.sampler.next(now_us, 0, counter);
            self.steepest = self.steepest.max(code.abs_diff(self.code));
            self.code = code;
            self.compare(now_s, found);
            if self.tasks.sampler.written(false) {
                let packets = self.tasks.run_requests().collect();
                self.send(packets);
            }
        }
        std::mem::take(&mut self.sent)
    }

    fn send(&mut self, packets: Vec<Packet>) {
        for packet in packets {
            let mut wire = [0; WIRE_MAX];
            // The longest packet fits.
            if !self.is_mute
                && let Ok(used) = framing::encode(&packet, &mut wire)
            {
                self.sent.extend(&wire[..used]);
            }
        }
    }

    /// Compares a sample with the texture under the finger at the hand's true position, in f64.
    fn compare(&mut self, now_s: f64, found: Option<Texture>) {
        let look = self.tasks.sampler.look();
        let Some(found) = found.filter(|_| look.state == State::Vibrating) else {
            return;
        };
        let bias_v = self.output.actuator.bias_v();
        // With overtones, the peak is limited to the actuator's amplitude.
        let overtones = found.overtones.iter().map(|overtone| overtone.amplitude);
        let wanted_v = bias_v * self.output.fraction(&found) / (1.0 + overtones.sum::<f32>());
        if look.amplitude_v < COMPARED_FROM * wanted_v || wanted_v <= 0.0 {
            return;
        }
        let heard_s = now_s + self.latency_s;
        let surface = |t_s: f64| {
            let (from_mm, cycles) = self.anchor;
            let moved_mm = self.hand.position_mm(t_s) - from_mm;
            wave(
                &found,
                TAU * (cycles + moved_mm / f64::from(found.period_mm)),
            )
        };
        let volts = f64::from(self.code) / f64::from(CODE_MAX) * f64::from(2.0 * bias_v);
        let felt = (volts - f64::from(bias_v)) / f64::from(wanted_v);
        self.error.squares += (felt - surface(heard_s)).powi(2);
        self.error.late_squares += (surface(heard_s - self.delay_s) - surface(heard_s)).powi(2);
        self.error.count += 1;
    }
}

/// Returns a texture's waveform relative to the fundamental's amplitude, at the phase `phase` of
/// the fundamental, radians.
fn wave(texture: &Texture, phase: f64) -> f64 {
    let overtones = (2..).zip(&texture.overtones).map(|(n, of)| {
        let phase = f64::from(n) * phase + TAU * f64::from(of.phase_cycles);
        f64::from(of.amplitude) * phase.sin()
    });
    phase.sin() + overtones.sum::<f64>()
}
