//! The stylus' end on a board of its own, the image `stylus-f405`: positions of its encoder come from
//! it, textures and parameters go to it, and the vibration is made there.

use super::message::{Body, Message, Receiver};
use super::requests::StylusRequests;
use super::stylus::SILENT_S;
use crate::stimulus::Texture;
use crate::stylus::gate::State;
use crate::stylus::message::{Command, Decoder, Event, Mark, PROTOCOL, Packet, Request};
use crate::stylus::parameters::Parameters;
use crate::touch::Output;
use anyhow::{Result, bail};
use ridgetone_host::feed::{FeedEvent, Source};
use ridgetone_host::names::name;
use ridgetone_host::note;
use ridgetone_proto::command::REQUEST_WIRE_MAX;
use ridgetone_proto::framing;
use ridgetone_proto::telemetry::Starts;
use serde::Serialize;
use std::collections::VecDeque;
use std::time::Duration;

/// State and counts of the board, in a report.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Doing {
    /// `disabled`, `line_silent`, `no_texture`, `hand_still` or `vibrating`; none while nothing is
    /// heard of it.
    pub state: Option<State>,
    /// Samples that were not there in time, since its start.
    pub deadlines_missed: u32,
    /// Packets of it that were lost or damaged.
    pub packets_lost: u32,
    pub packets_damaged: u32,
    /// Times that it fell silent.
    pub silences: u32,
}

pub struct BoardEnd {
    pub receiver: Receiver,
    line: Box<dyn Source>,
    decoder: Decoder,
    requests: StylusRequests,
    output: Output,
    count_mm: f64,
    run: u32,
    number: u32,
    due: VecDeque<Message>,
    /// Counts of the latest position, and those since the first one, which do not wrap.
    counts: Option<i32>,
    travelled: i64,
    /// When the finger's end was heard, and the board; none: it is silent.
    link_heard_s: Option<f64>,
    heard_s: Option<f64>,
    is_lost: bool,
    starts: Starts,
    doing: Doing,
}

impl BoardEnd {
    /// A board on a line. `parameters` come from the caller but for the actuator and the law, which
    /// are `output`'s.
    pub fn new(
        line: Box<dyn Source>,
        output: Output,
        parameters: Parameters,
        run: u32,
    ) -> Result<Self> {
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
            is_lost: false,
            starts: Starts::new(),
            doing: Doing {
                state: None,
                deadlines_missed: 0,
                packets_lost: 0,
                packets_damaged: 0,
                silences: 0,
            },
        })
    }

    /// State and counts of the board.
    pub fn doing(&self) -> Doing {
        let (packets_lost, packets_damaged) = (self.decoder.missing, self.decoder.damaged);
        Doing {
            packets_lost,
            packets_damaged,
            ..self.doing
        }
    }

    /// The texture that the board has been given, if it is felt as soon as the hand moves.
    pub fn texture(&self) -> Option<Texture> {
        self.requests.texture.filter(|_| self.requests.is_done())
    }

    pub fn is_felt(&self) -> bool {
        self.doing.state == Some(State::Vibrating)
    }

    /// Latest position of the hand, millimetres from where it was first; none before.
    pub fn position_mm(&self) -> Option<f64> {
        self.counts.map(|_| self.travelled as f64 * self.count_mm)
    }

    /// The next position that was not sent yet.
    pub fn due(&mut self) -> Option<Message> {
        self.due.pop_front()
    }

    /// Takes what has arrived of the finger's end.
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

    /// Takes what the board has sent by now, and sends what is due. Times must not decrease.
    pub fn step(&mut self, t_s: f64) -> Result<()> {
        while let Some(event) = self.line.next(Duration::ZERO)? {
            match event {
                FeedEvent::Data(bytes) => self.hear(t_s, &bytes)?,
                FeedEvent::Disconnected(name, why) => {
                    self.lose(&format!("{name}: {why}; waiting for the stylus"))
                }
                FeedEvent::Connected(_) => {}
                FeedEvent::Over => bail!("{}: the stylus' line is over", self.line.name()),
            }
        }
        if self.heard_s.is_some_and(|heard_s| t_s - heard_s > SILENT_S) {
            let name = self.line.name();
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

    /// Lets the output go down softly: gives whether it is at rest, or nobody can know.
    pub fn stop_softly(&mut self) -> bool {
        (self.link_heard_s, self.requests.texture) = (None, None);
        self.requests.is_at_rest() || self.heard_s.is_none()
    }

    fn hear(&mut self, t_s: f64, bytes: &[u8]) -> Result<()> {
        for byte in bytes {
            let Some(packet) = self.decoder.push(*byte) else {
                if let Some(protocol) = self.decoder.foreign {
                    let name = self.line.name();
                    bail!(
                        "{name}: the stylus speaks protocol {protocol}, this command {PROTOCOL}: build both from one version"
                    );
                }
                continue;
            };
            if std::mem::take(&mut self.is_lost) {
                note!("{}: the stylus is back", self.line.name());
            }
            self.heard_s = Some(t_s);
            self.take_packet(t_s, packet)?;
        }
        Ok(())
    }

    fn take_packet(&mut self, t_s: f64, Packet { event, .. }: Packet) -> Result<()> {
        if self.starts.take(&event) {
            // Its encoder counts from 0, and the hand is where it was.
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
                Some((_, why)) => bail!(
                    "{}: the stylus refuses its parameters: {why}",
                    self.line.name()
                ),
                None => {}
            },
            Event::Damaged(_) => {}
        }
        Ok(())
    }

    fn is_now(&mut self, state: State) {
        self.doing.state = Some(state);
        self.requests.is_now(state);
    }

    /// Nothing is heard of the board any more. It is disabled, if it still hears, and gets no sign
    /// of life.
    fn lose(&mut self, why: &str) {
        if self.heard_s.take().is_some() {
            note!("{why}");
            (self.is_lost, self.doing.state) = (true, None);
            self.doing.silences += 1;
            self.requests.forget();
        }
    }

    fn send(&mut self, number: u16, command: Command) {
        let mut wire = [0; REQUEST_WIRE_MAX];
        // The longest fits, and what a line that is away does not take is sent again.
        if let Ok(used) = framing::encode(
            &Request {
                number,
                command: Mark(command),
            },
            &mut wire,
        ) {
            let _ = self.line.send(&wire[..used]);
        }
    }
}

impl Doing {
    /// A line for people.
    pub fn text(&self) -> String {
        let Self {
            deadlines_missed,
            packets_lost,
            packets_damaged,
            silences,
            ..
        } = self;
        format!(
            "stylus {}; {deadlines_missed} samples late, {packets_lost} packets lost, {packets_damaged} damaged, silent {silences} times",
            self.state.map_or("silent", name)
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stimulus::Actuator;
    use crate::stylus::SAMPLE_HZ;
    use crate::stylus::message::{Hello, Position};
    use ridgetone_proto::boot::Boot;
    use ridgetone_proto::telemetry::WIRE_MAX;

    /// A line that says nothing by itself.
    struct Silent;

    impl Source for Silent {
        fn name(&self) -> String {
            "a line".into()
        }

        fn next(&mut self, _: Duration) -> Result<Option<FeedEvent<Vec<u8>>>> {
            Ok(None)
        }

        fn send(&mut self, _: &[u8]) -> Result<()> {
            Ok(())
        }
    }

    fn hear(end: &mut BoardEnd, sequence: u16, event: Event) {
        let mut wire = [0; WIRE_MAX];
        let used = framing::encode(
            &Packet {
                sequence,
                event: Mark(event),
            },
            &mut wire,
        )
        .expect("it fits");
        end.hear(1.0, &wire[..used]).expect("heard");
    }

    /// Counts of the hand after a position at 9 s, then a greeting under number 0 at `t_us` and a position
    /// of `counts` counts.
    fn counts(t_us: u64, counts: i32) -> Option<f64> {
        let output = Output::new(Actuator::PIEZO, None).expect("an output");
        let mut end =
            BoardEnd::new(Box::new(Silent), output, Parameters::DEFAULT, 1).expect("an end");
        let position = |t_us, counts| {
            Event::Position(Position {
                t_us,
                counts,
                speed_mm_s: 0.0,
            })
        };
        hear(&mut end, u16::MAX - 1, position(8_900_000, 0));
        hear(&mut end, u16::MAX, position(9_000_000, 1000));
        let (version, parameters, boot) = ([0; 3], Parameters::DEFAULT, Boot::UNKNOWN);
        hear(
            &mut end,
            0,
            Event::Hello(Hello {
                protocol: PROTOCOL,
                version,
                sample_hz: SAMPLE_HZ,
                parameters,
                boot,
                t_us,
            }),
        );
        hear(&mut end, 1, position(t_us + 1000, counts));
        end.position_mm().map(|mm| (mm / end.count_mm).round())
    }

    /// The encoder of a board that has started counts from 0, where the hand is; that of one whose
    /// number wraps goes on.
    #[test]
    fn a_number_that_wraps_is_no_restart() {
        assert_eq!(counts(9_001_000, 1200), Some(1200.0));
        assert_eq!(counts(10_000, 200), Some(1200.0));
    }
}
