//! `link`: a finger and a stylus, connected by a network.

use super::actuator::{ActuatorOptions, DelayOptions, HandOptions};
use crate::link::board::{BoardEnd, Line};
use crate::link::simulated::Simulated;
use crate::link::socket::Socket;
use crate::link::{Ends, Hand, Link, Options, run};
use crate::stylus::parameters::Parameters;
use crate::texture::Follower;
use crate::touch::Output;
use anyhow::{Context, Result};
use clap::Args;
use ridgetone_host::cli::firmware::FirmwareOptions;
use ridgetone_host::cli::lines::report;
use ridgetone_host::cli::parse::{number, positive};
use ridgetone_host::note;
use ridgetone_host::port::{self, Wanted};
use ridgetone_host::serve::source::Source;
use ridgetone_host::stop;
use ridgetone_host::usage::UsageError;

#[derive(Debug, Args)]
#[command(after_help = "\
The stylus' end sends the position of its hand 250 times a second; the finger's end sends the texture when its board reports another
one, and four times a second. It prints each second what was sent, lost and late, the texture, and how far the stimulus
is from the surface under the hand. A second without a message, or a silent finger, and the vibration fades.

A stylus' board (the image stylus-f405) has an encoder under a real hand and makes the vibration itself. It gets limits and law of the
actuator first, which the options above say; then textures; and is disabled at the end. A board that is silent for a second is
reported, and stops by itself.

Delay and loss are made here, each way, and come on top of what a real network does. With udp: one end is another
`ridgetone link` elsewhere: what travels is not encrypted, and the finger answers whoever sends it a position.

Examples:
  ridgetone link --emulated
  ridgetone link --emulated --delay-ms 120 --jitter-ms 40 --loss 5%
  ridgetone link --finger /dev/ttyUSB0 --stylus simulated --delay-ms 120
  ridgetone link --finger /dev/ttyUSB0 --stylus /dev/ttyUSB1
  ridgetone link --finger /dev/ttyUSB0 --stylus udp:0.0.0.0:7450
  ridgetone link --finger udp:robot.local:7450 --stylus simulated")]
pub struct LinkArgs {
    /// The finger: a serial port; `emulated`, or `emulated:SCENE.toml`; a recording of telemetry;
    /// or udp:HOST:PORT for a finger on a different computer.
    #[arg(
        long,
        value_name = "SOURCE",
        required_unless_present = "emulated",
        conflicts_with = "emulated"
    )]
    finger: Option<String>,
    /// The stylus: `simulated`, with a simulated hand; the serial port of a stylus' board; or
    /// udp:ADDRESS:PORT, to wait there for a stylus on a different computer.
    #[arg(long, value_name = "STYLUS", default_value = "simulated")]
    stylus: String,
    /// The emulated finger.
    #[arg(long)]
    emulated: bool,
    /// A robot moves the finger as the hand moves: take the period of the surface from the hand's
    /// path, in windows in which the hand does not turn [default: from the finger's report].
    #[arg(long)]
    follows: bool,
    #[command(flatten)]
    delay: DelayOptions,
    /// Messages lost, percent.
    #[arg(long, value_name = "PERCENT", default_value = "0", value_parser = percent, allow_negative_numbers = true)]
    loss: f64,
    /// Seed of the simulated network.
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u64).range(..1 << 60))]
    seed: u64,
    #[command(flatten)]
    hand: HandOptions,
    #[command(flatten)]
    actuator: ActuatorOptions,
    /// Length of one count of the stylus' encoder, all four edges counted, mm [default: the paper's
    /// 0.005].
    #[arg(long, value_name = "MM", value_parser = positive)]
    count_mm: Option<f64>,
    /// Latency after the stylus' converter, such as a filter's, ms.
    #[arg(long, value_name = "MS", default_value_t = 0.0, value_parser = number, allow_negative_numbers = true)]
    latency_ms: f64,
    /// End after this time, s [default: never].
    #[arg(long = "for", value_name = "S", value_parser = positive)]
    seconds: Option<f64>,
    /// Print one JSON object per second instead of text.
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    firmware: FirmwareOptions,
}

/// Parses a percentage as a fraction, 0 to 1.
fn percent(text: &str) -> Result<f64, String> {
    let percent = number(text.trim_end_matches('%').trim_end())?;
    if (0.0..=100.0).contains(&percent) {
        Ok(percent / 100.0)
    } else {
        Err("choose 0 to 100 %".into())
    }
}

impl LinkArgs {
    pub(super) fn run(self) -> Result<()> {
        let output = self.actuator.output()?;
        self.delay.check()?;
        let hand = self.hand.hand(Hand::OKAMOTO)?;
        let DelayOptions {
            delay_ms,
            jitter_ms,
        } = self.delay;
        let mut bytes = [0; 4];
        getrandom::fill(&mut bytes).map_err(|error| anyhow::anyhow!("random numbers: {error}"))?;
        let options = Options {
            delay_ms,
            jitter_ms,
            loss: self.loss,
            seed: self.seed,
            run: u32::from_le_bytes(bytes),
            follows: self.follows,
        };
        let finger = self.finger.as_deref().unwrap_or("emulated");
        let ends = match (
            finger.strip_prefix("udp:"),
            self.stylus.strip_prefix("udp:"),
        ) {
            (None, Some(address)) => {
                let socket = Socket::at(address)?;
                note!("a stylus finds this finger at udp:{}", socket.address()?);
                Ends::Finger(socket)
            }
            (Some(_), Some(_)) => {
                return Err(UsageError(
                    "one end must be here: --stylus simulated, or a port".into(),
                )
                .into());
            }
            (Some(_), None) if self.follows => {
                return Err(UsageError(
                    "--follows is for the finger's end: give it there, where --finger is a serial port".into(),
                )
                .into());
            }
            (Some(address), None) => Ends::Stylus(Socket::to(address)?),
            (None, None) => Ends::Here,
        };
        let stylus = match ends {
            Ends::Finger(_) => None,
            _ => Some(self.stylus(output, hand, &options)?),
        };
        stop::on_signal()?;
        let mut finger = match &ends {
            Ends::Stylus(_) => None,
            _ => Some(Follower::new(self.open(finger)?)),
        };
        let mut link = Link::new(&options, ends, stylus)?;
        let done = run(&mut finger, &mut link, self.json, self.seconds);
        link.stop_softly();
        if let Some(finger) = finger {
            report(finger.into_feed().counts());
        }
        done
    }

    fn stylus(&self, output: Output, hand: Hand, options: &Options) -> Result<BoardEnd> {
        let parameters = Parameters {
            count_mm: self
                .count_mm
                .map_or(Parameters::DEFAULT.count_mm, |mm| mm as f32),
            latency_s: (self.latency_ms / 1e3) as f32,
            ..Parameters::DEFAULT
        };
        let line = if self.stylus == "simulated" {
            let delay_s = options.delay_ms / 1e3;
            Line::Simulated(Box::new(Simulated::new(hand, output, &parameters, delay_s)))
        } else {
            let port = port::Link::open(port::System, Wanted::Name(self.stylus.clone()))
                .context("--stylus: simulated, udp:ADDRESS:PORT or a serial port")?;
            Line::Port(Box::new(port))
        };
        BoardEnd::new(line, output, parameters, options.run)
            .map_err(|error| UsageError(format!("{error:#}")).into())
    }

    fn open(&self, finger: &str) -> Result<ridgetone_host::feed::Feed> {
        let source = Source::of(finger)?;
        if self.follows && !matches!(source, Source::Port(_)) {
            return Err(UsageError(format!(
                "--follows: {finger} moves by itself and does not follow a hand: give a serial port to --finger"
            ))
            .into());
        }
        let firmware = matches!(source, Source::Emulated(_))
            .then(|| self.firmware.image())
            .transpose()?;
        source.open(firmware.as_ref())
    }
}
