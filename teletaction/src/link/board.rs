//! The stylus' end: a board (image `stylus-f405`), or a simulated one. The board sends its
//! encoder's positions, receives textures and parameters, and makes the vibration.

use super::message::{Body, Message, Receiver};
use super::requests::StylusRequests;
use super::simulated::Simulated;
use crate::stimulus::Texture;
use crate::stylus::gate::State;
use crate::stylus::message::{Command, Decoder, Event, Mark, PROTOCOL, Packet, Request};
use crate::stylus::parameters::Parameters;
use crate::touch::Output;
use anyhow::{Result, bail};
use ridgetone_host::feed::{FeedEvent, Source};
use ridgetone_host::note;
use ridgetone_proto::command::REQUEST_WIRE_MAX;
use ridgetone_proto::framing;
use ridgetone_proto::telemetry::Starts;
use serde::Serialize;
use std::collections::VecDeque;
use std::time::Duration;

/// Time without a message after which the link counts as dead and the vibration fades, seconds:
/// four messages are missing.
const SILENT_S: f64 = 1.0;

pub enum Line {
    Port(Box<dyn Source>),
    Simulated(Box<Simulated>),
}

/// State and counts of the board in a report.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Doing {
    /// `disabled`, `line_silent`, `no_texture`, `hand_still` or `vibrating`; `None` while the board
    /// is silent.
    pub state: Option<State>,
    /// Late samples since the board's start.
    pub deadlines_missed: u32,
    /// Packets from the board that were lost or damaged.
    pub packets_lost: u32,
    pub packets_damaged: u32,
    /// Number of times that the board fell silent.
    pub silences: u32,
}

pub struct BoardEnd {
    pub receiver: Receiver,
    line: Line,
    decoder: Decoder,
    requests: StylusRequests,
    output: Output,
    count_mm: f64,
    run: u32,
    number: u32,
    due: VecDeque<Message>,
    /// Latest position in counts; `travelled` is the total since the first position and does not
    /// wrap.
    counts: Option<i32>,
    travelled: i64,
    /// Times when the finger's end and the board were last heard; `None` if silent.
    link_heard_s: Option<f64>,
    heard_s: Option<f64>,
    starts: Starts,
    doing: Doing,
}

impl BoardEnd {
    /// Connects a board on a line. Actuator and law come from `output`, all other `parameters` from
    /// the caller.
    pub fn new(line: Line, output: Output, parameters: Parameters, run: u32) -> Result<Self> {
        let parameters = Parameters {
            actuator: output.actuator,
            law: output.law(),
            ..parameters
        };
        parameters.stimulus()?;
        Ok(Self {
            receiver: Receiver::default(),
            line,
            decoder: Decoder::new(),
            requests: StylusRequests::new(parameters, run as u16),
            output,
            count_mm: parameters.count_mm.into(),
            run,
            number: 0,
            due: VecDeque::new(),
            counts: None,
            travelled: 0,
            link_heard_s: None,
            heard_s: Some(0.0),
            starts: Starts::new(),
            doing: Doing::default(),
        })
    }

    pub fn doing(&self) -> Doing {
        let (packets_lost, packets_damaged) = (self.decoder.missing, self.decoder.damaged);
        Doing {
            packets_lost,
            packets_damaged,
            ..self.doing
        }
    }

    /// Returns the texture that is felt as soon as the hand moves, if the board has it.
    pub fn texture(&self) -> Option<Texture> {
        self.requests.texture.filter(|_| self.requests.is_done())
    }

    pub fn is_felt(&self) -> bool {
        self.doing.state == Some(State::Vibrating)
    }

    /// Latest position of the hand relative to the first, millimetres; `None` before the first.
    pub fn position_mm(&self) -> Option<f64> {
        self.counts.map(|_| self.travelled as f64 * self.count_mm)
    }

    pub fn due(&mut self) -> Option<Message> {
        self.due.pop_front()
    }

    pub fn take(&mut self, t_s: f64, bytes: &[u8]) {
        if let Some(Message {
            body: Body::Texture(texture),
            ..
        }) = self.receiver.take(bytes)
        {
            self.link_heard_s = Some(t_s);
            self.requests.texture = texture.map(|texture| self.output.counted(&texture));
        }
    }

    pub fn simulated(&mut self) -> Option<&mut Simulated> {
        match &mut self.line {
            Line::Simulated(stylus) => Some(stylus),
            Line::Port(_) => None,
        }
    }

    fn name(&self) -> String {
        match &self.line {
            Line::Port(port) => port.name(),
            Line::Simulated(_) => "the simulated stylus".into(),
        }
    }

    /// Reads what the board has sent, and sends what is due. Times must not decrease. `found` is
    /// the texture under the finger, if known here.
    pub fn step(&mut self, t_s: f64, found: Option<Texture>) -> Result<()> {
        if let Line::Simulated(stylus) = &mut self.line {
            let bytes = stylus.run(t_s, found);
            self.hear(t_s, &bytes)?;
        }
        while let Line::Port(port) = &mut self.line
            && let Some(event) = port.next(Duration::ZERO)?
        {
            match event {
                FeedEvent::Data(bytes) => self.hear(t_s, &bytes)?,
                FeedEvent::Disconnected(name, why) => {
                    self.lose(&format!("{name}: {why}; waiting for the stylus"))
                }
                FeedEvent::Connected(_) => {}
                FeedEvent::Over => bail!("{}: the stylus' line is over", self.name()),
            }
        }
        if self.heard_s.is_some_and(|heard_s| t_s - heard_s > SILENT_S) {
            let name = self.name();
            self.lose(&format!(
                "{name}: the stylus is silent; without requests its vibration stops by itself"
            ));
        }
        if self
            .link_heard_s
            .is_some_and(|heard_s| t_s - heard_s > SILENT_S)
        {
            (self.link_heard_s, self.requests.texture) = (None, None);
        }
        if let Some((number, command)) = self.requests.due(t_s) {
            self.send(number, command);
        }
        Ok(())
    }

    /// Lowers the output softly; returns true if the output is at rest, or the board silent.
    pub fn stop_softly(&mut self) -> bool {
        (self.link_heard_s, self.requests.texture) = (None, None);
        self.requests.is_at_rest() || self.heard_s.is_none()
    }

    fn hear(&mut self, t_s: f64, bytes: &[u8]) -> Result<()> {
        for byte in bytes {
            let Some(packet) = self.decoder.push(*byte) else {
                if let Some(protocol) = self.decoder.foreign {
                    let name = self.name();
                    bail!(
                        "{name}: the stylus speaks protocol {protocol}, this command {PROTOCOL}: build both from one version"
                    );
                }
                continue;
            };
            if self.heard_s.replace(t_s).is_none() {
                note!("{}: the stylus is back", self.name());
            }
            self.take_packet(t_s, packet)?;
        }
        Ok(())
    }

    fn take_packet(&mut self, t_s: f64, Packet { event, .. }: Packet) -> Result<()> {
        if self.starts.take(&event) {
            // After the restart the encoder counts from 0, but the hand has not moved.
            self.requests.forget();
            (self.counts, self.doing.state) = (self.counts.map(|_| 0), None);
        }
        let Mark(event) = event;
        match event {
            Event::Hello(hello) => self.requests.has(&hello.parameters),
            Event::Position(position) => {
                let moved = self
                    .counts
                    .map_or(0, |counts| position.counts.wrapping_sub(counts));
                (self.counts, self.travelled) =
                    (Some(position.counts), self.travelled + i64::from(moved));
                let body = Body::Position(self.travelled as f64 * self.count_mm);
                self.due.push_back(Message {
                    run: self.run,
                    number: self.number,
                    t_s,
                    body,
                });
                self.number = self.number.wrapping_add(1);
            }
            Event::State(change) => self.is_now(change.state),
            Event::Health(health) => {
                self.doing.deadlines_missed = health.deadlines_missed;
                self.is_now(health.state);
            }
            Event::Reply(reply) => match self.requests.answered(t_s, &reply) {
                Some((Command::Texture(texture), why)) => {
                    note!(
                        "the stylus refuses the texture of {} mm: {why}",
                        texture.period_mm
                    );
                }
                Some((_, why)) => {
                    bail!("{}: the stylus refuses its parameters: {why}", self.name())
                }
                None => {}
            },
        }
        Ok(())
    }

    fn is_now(&mut self, state: State) {
        self.doing.state = Some(state);
        self.requests.is_now(state);
    }

    /// Handles a board that has fallen silent: disables it, in case it still hears, and sends no
    /// more signs of life.
    fn lose(&mut self, why: &str) {
        if self.heard_s.take().is_some() {
            note!("{why}");
            self.doing.state = None;
            self.doing.silences += 1;
            self.requests.forget();
        }
    }

    fn send(&mut self, number: u16, command: Command) {
        let mut wire = [0; REQUEST_WIRE_MAX];
        // The longest request fits, and a request that a disconnected line refuses is sent again.
        if let Ok(used) = framing::encode(
            &Request {
                number,
                command: Mark(command),
            },
            &mut wire,
        ) {
            match &mut self.line {
                Line::Port(port) => drop(port.send(&wire[..used])),
                Line::Simulated(stylus) => stylus.hear(&wire[..used]),
            }
        }
    }
}
