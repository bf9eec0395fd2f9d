//! Turns a board's packets into display forces, update by update.

use super::Error;
use super::grid::{Grid, Layer, Quantity};
use super::limits::{Limits, Pins};
use super::matching::Matching;
use super::skin::{Skin, strains, volts_per_strain};
use hal_mock::Finger;
use ridgetone_host::frame::Frame;
use ridgetone_host::static_image::{SIDE, UNIT_PITCH_MM};
use ridgetone_proto::settings::{Settings, TAXELS};
use ridgetone_proto::telemetry::{Event, Packet, Starts};
use serde::Serialize;

/// Number of sensors: the points of the pressure map.
const SENSORS: usize = SIDE * SIDE;

/// Maximum time between frames before the pins are released, seconds.
pub const SILENCE_S: f64 = 0.5;

/// The display, the finger on it, and the conversion of strains to forces.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Setup {
    pub pins: Grid,
    /// Thickness of the layer over the finger's receptors, millimetres.
    pub depth_mm: f64,
    pub quantity: Quantity,
    pub regularisation: f64,
    pub limits: Limits,
    /// Ratio of strain in the finger to strain in the sensor.
    pub gain: f64,
    pub volts_per_strain: f64,
    /// Young's modulus of both sensor and finger, MPa, as in the paper.
    pub modulus_mpa: f64,
}

impl Setup {
    /// Creates a setup of 4 x 4 pins, 2 mm apart, under 2 mm of rubber.
    pub fn new() -> Result<Self, Error> {
        Ok(Self {
            pins: Grid::new(4, 4, 2.0)?,
            depth_mm: 2.0,
            quantity: Quantity::Strain,
            regularisation: 0.01,
            limits: Limits {
                update_hz: 20.0,
                ..Limits::IDEAL
            },
            gain: 1.0,
            volts_per_strain: volts_per_strain(),
            modulus_mpa: Finger::default().modulus_mpa,
        })
    }
}

/// One update of the display. Strains have no unit; if stresses are matched, they are stresses
/// divided by Young's modulus.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(tag = "type", rename = "pins")]
pub struct Update {
    pub t_s: f64,
    pub rows: usize,
    pub columns: usize,
    /// Forces row by row, newtons.
    pub forces_n: Vec<f32>,
    pub level_n: f32,
    /// Number of pins whose target force exceeds the display's limits.
    pub limited: usize,
    pub is_optimal: bool,
    /// Bit k: taxel k is used.
    pub taxels: u16,
    /// Strain in the sensor, 4 x 4 row by row.
    pub sensor_strain: Vec<f32>,
    /// Strain in the finger at the same positions.
    pub felt_strain: Vec<f32>,
}

impl Update {
    /// RMS difference between the felt strain and the sensor's.
    pub fn error(&self, gain: f64) -> f64 {
        let off =
            |(felt, sensor): (&f32, &f32)| (f64::from(*felt) - gain * f64::from(*sensor)).powi(2);
        let sum: f64 = self
            .felt_strain
            .iter()
            .zip(&self.sensor_strain)
            .map(off)
            .sum();
        (sum / self.felt_strain.len() as f64).sqrt()
    }

    pub fn text(&self, gain: f64) -> String {
        let max = |values: &[f32]| f64::from(values.iter().copied().fold(f32::MIN, f32::max));
        let limited = match self.limited {
            0 => String::new(),
            limited => format!(", {limited} pins at their limit"),
        };
        format!(
            "{:8.3} s  sensor {} %  finger {} %, error {:.2} % rms; pins: {:.2} N max, {:.2} N total{limited}",
            self.t_s,
            number(100.0 * gain * max(&self.sensor_strain)),
            number(100.0 * max(&self.felt_strain)),
            100.0 * self.error(gain),
            max(&self.forces_n),
            self.forces_n.iter().sum::<f32>(),
        )
    }
}

/// Formats a number, without a minus sign for zero.
fn number(value: f64) -> String {
    let shown = format!("{value:.2}");
    match shown.strip_prefix('-') {
        Some(zero) if zero.parse() == Ok(0.0f64) => zero.to_owned(),
        _ => shown,
    }
}

pub struct Player {
    setup: Setup,
    matching: Matching,
    display: Pins,
    skin: Skin,
    vref_v: f32,
    /// Sum (volts) and number of each taxel's readings since the last update.
    sums: [(f64, u32); TAXELS],
    updated_s: Option<f64>,
    starts: Starts,
}

impl Player {
    pub fn new(setup: Setup) -> Result<Self, Error> {
        let sensors = Grid::new(SIDE, SIDE, 0.5 * UNIT_PITCH_MM)?;
        let layer = Layer {
            depth_mm: setup.depth_mm,
            // Rubber, as in the simulated finger.
            poisson: Finger::default().poisson,
            quantity: setup.quantity,
        };
        Ok(Self {
            matching: Matching::new(&sensors, &setup.pins, &layer, setup.regularisation)?,
            display: Pins::new(setup.limits, setup.pins.count())?,
            setup,
            skin: Skin::default(),
            vref_v: Settings::DEFAULT.vref_v,
            sums: Default::default(),
            updated_s: None,
            starts: Starts::new(),
        })
    }

    pub fn setup(&self) -> &Setup {
        &self.setup
    }

    /// Takes a packet; returns an update if one is due.
    pub fn take(&mut self, packet: &Packet) -> Result<Option<Update>, Error> {
        if self.starts.take(&packet.event) {
            // The board has restarted, and with it its clock and levels.
            (self.skin, self.updated_s, self.sums) = (Skin::default(), None, Default::default());
        }
        match &packet.event {
            Event::Hello(hello) => {
                self.vref_v = hello.settings.vref_v;
            }
            Event::Contact(_) => self.skin.touched(true),
            Event::Release(_) => self.skin.touched(false),
            Event::Raw(raw) => return self.frame(&Frame::new(raw, self.vref_v)),
            _ => {}
        }
        Ok(None)
    }

    fn frame(&mut self, frame: &Frame) -> Result<Option<Update>, Error> {
        let Some(volts) = self.skin.push(frame) else {
            return Ok(None);
        };
        for ((sum, count), volts) in self.sums.iter_mut().zip(volts) {
            if let Some(volts) = volts {
                (*sum, *count) = (*sum + f64::from(volts), *count + 1);
            }
        }
        let since_s = frame.t_s - *self.updated_s.get_or_insert(frame.t_s);
        if since_s < 0.0 {
            self.updated_s = Some(frame.t_s);
            return Ok(None);
        }
        // Average the frames between updates, because the display shows nothing faster. Updates are
        // whole frames apart, so their rate never exceeds the limit.
        if since_s < 0.999 / f64::from(self.setup.limits.update_hz) {
            return Ok(None);
        }
        let sums = std::mem::take(&mut self.sums);
        let volts = sums.map(|(sum, count)| (count > 0).then(|| (sum / f64::from(count)) as f32));
        self.updated_s = Some(frame.t_s);
        let sensor = strains(&volts, self.setup.volts_per_strain);
        // Matching uses units of stress: newtons per square millimetre.
        let per_strain = self.setup.gain * self.setup.modulus_mpa;
        let target = sensor.map(|strain| per_strain * f64::from(strain));
        let solution = self.matching.forces(&target)?;
        let is_optimal = solution.is_optimal;
        let limited = self
            .display
            .advance(since_s.min(1e3) as f32, solution.forces)?
            .unwrap_or(0);
        let taxels = (0..TAXELS).filter(|taxel| volts[*taxel].is_some());
        Ok(Some(Update {
            limited,
            is_optimal,
            taxels: taxels.fold(0, |bits, taxel| bits | 1 << taxel),
            ..self.now(frame.t_s, sensor)
        }))
    }

    /// Lowers the pins after `dt_s` seconds without packets. Returns updates until they are down.
    pub fn silent(&mut self, dt_s: f64) -> Result<Option<Update>, Error> {
        if self.display.forces_n().iter().all(|n| *n == 0.0) {
            return Ok(None);
        }
        self.display.release(dt_s.clamp(0.0, 1e3) as f32)?;
        let t_s = self.updated_s.unwrap_or(0.0);
        Ok(Some(self.now(t_s, [0.0; SENSORS])))
    }

    /// Current forces of the pins, and the strain under them.
    fn now(&self, t_s: f64, sensor: [f32; SENSORS]) -> Update {
        let Setup { pins, limits, .. } = &self.setup;
        let felt = self.matching.felt(self.display.forces_n()).into_iter();
        Update {
            t_s,
            rows: pins.rows(),
            columns: pins.columns(),
            forces_n: self.display.forces_n().to_vec(),
            level_n: limits.level_n(),
            limited: 0,
            is_optimal: true,
            taxels: 0,
            sensor_strain: sensor.to_vec(),
            felt_strain: felt
                .map(|value| (value / self.setup.modulus_mpa) as f32)
                .collect(),
        }
    }
}
