//! `pins`: shows a sensor's strains on a display of pins.

use crate::pins::{Grid, Limits, PINS_MAX, Player, Quantity, SILENCE_S, Setup, volts_per_strain};
use anyhow::Result;
use clap::{Args, ValueEnum};
use ridgetone_host::cli::lines::report;
use ridgetone_host::cli::parse::positive;
use ridgetone_host::cli::source::SourceOptions;
use ridgetone_host::feed::{Feed, Requester};
use ridgetone_host::listen::{Heard, Listener};
use ridgetone_host::usage::UsageError;
use ridgetone_host::{output, stop};
use std::time::{Duration, Instant};

/// Interval at which a silent feed is checked.
const LOOK: Duration = Duration::from_millis(50);

#[derive(Debug, Args)]
#[command(after_help = "\
It prints a line for each update of the display: strain in the sensor, forces of the pins, and the strain that a finger on the pins
would feel. A recording needs raw frames: `ridgetone record --raw`.

Examples:
  ridgetone pins --emulated
  ridgetone pins --emulated --once --json
  ridgetone pins --port /dev/ttyUSB0 --pins 10x10 --spacing-mm 1
  ridgetone pins --file touch.rec --update-hz 8 --levels 1")]
pub struct PinsArgs {
    #[command(flatten)]
    source: SourceOptions,
    #[command(flatten)]
    display: DisplayOptions,
    /// Print one JSON object per line instead of text.
    #[arg(long)]
    json: bool,
}

#[derive(Args, Clone, Debug)]
struct DisplayOptions {
    /// Columns and rows of pins, at most 100 in all.
    #[arg(long, value_name = "COLUMNSxROWS", default_value = "4x4", value_parser = columns_and_rows)]
    pins: (usize, usize),
    /// Spacing of the pins, mm.
    #[arg(long, value_name = "MM", default_value_t = 2.0, value_parser = positive)]
    spacing_mm: f64,
    /// Thickness of rubber and skin between the pins and the finger's receptors, mm.
    #[arg(long, value_name = "MM", default_value_t = 2.0, value_parser = positive)]
    depth_mm: f64,
    /// Quantity to match between sensor and finger.
    #[arg(long, value_enum, value_name = "WHAT", default_value_t = Match::Strain)]
    by: Match,
    /// Ratio of strain in the finger to strain in the sensor.
    #[arg(long, value_name = "FACTOR", default_value_t = 1.0, value_parser = positive)]
    gain: f64,
    /// Regularisation: a larger value makes the forces more even and less noisy.
    #[arg(long, value_name = "FRACTION", default_value_t = 0.01, value_parser = positive)]
    regularisation: f64,
    /// Maximum force of a pin, N.
    #[arg(long, value_name = "N", default_value_t = f64::from(Limits::IDEAL.force_n), value_parser = positive)]
    force_n: f64,
    /// Maximum travel of a pin, mm; the finger opposes 0.5 N/mm.
    #[arg(long, value_name = "MM", default_value_t = f64::from(Limits::IDEAL.stroke_mm), value_parser = positive)]
    stroke_mm: f64,
    /// Update rate of the display, Hz.
    #[arg(long, value_name = "HZ", default_value_t = 20.0, value_parser = positive)]
    update_hz: f64,
    /// Number of levels of a pin; with 1 a pin is up or down.
    #[arg(long, value_name = "N", default_value_t = 1000, value_parser = clap::value_parser!(u16).range(1..))]
    levels: u16,
    /// Maximum change of a force, N/s.
    #[arg(long, value_name = "N_S", default_value_t = f64::from(Limits::IDEAL.slew_n_s), value_parser = positive)]
    slew_n_s: f64,
    /// Volts of a channel per unit of strain [default: those of the simulated finger, 0.125].
    #[arg(long, value_name = "V", value_parser = positive)]
    volts_per_strain: Option<f64>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Match {
    /// Normal strain in the paper's thin slices, which expand sideways (plane stress).
    Strain,
    /// Normal strain in a half space: an even touch hardly strains rubber, so it needs more force.
    HalfSpace,
    /// Normal stress.
    Stress,
}

fn columns_and_rows(text: &str) -> Result<(usize, usize), String> {
    let (columns, rows) = text
        .split_once('x')
        .ok_or("write COLUMNSxROWS, such as 4x4")?;
    let number = |text: &str| {
        text.parse::<usize>()
            .ok()
            .filter(|n| (1..=100).contains(n))
            .ok_or("1 to 100")
    };
    let (columns, rows) = (number(columns)?, number(rows)?);
    if columns * rows > PINS_MAX {
        return Err(format!("{} pins: at most {}", columns * rows, PINS_MAX));
    }
    Ok((columns, rows))
}

impl DisplayOptions {
    fn setup(&self) -> Result<Setup> {
        let limits = Limits {
            force_n: self.force_n as f32,
            stroke_mm: self.stroke_mm as f32,
            update_hz: self.update_hz as f32,
            levels: self.levels,
            slew_n_s: self.slew_n_s as f32,
            ..Limits::IDEAL
        };
        let quantity = match self.by {
            Match::Strain => Quantity::Strain,
            Match::HalfSpace => Quantity::HalfSpaceStrain,
            Match::Stress => Quantity::Stress,
        };
        Ok(Setup {
            pins: Grid::new(self.pins.0, self.pins.1, self.spacing_mm)?,
            depth_mm: self.depth_mm,
            quantity,
            regularisation: self.regularisation,
            limits,
            gain: self.gain,
            volts_per_strain: self.volts_per_strain.unwrap_or_else(volts_per_strain),
            ..Setup::new()?
        })
    }
}

impl PinsArgs {
    pub(super) fn run(self) -> Result<()> {
        // Impossible values can only come from options.
        let refused = |error: anyhow::Error| UsageError(format!("{error:#}"));
        let setup = self.display.setup().map_err(refused)?;
        let mut player = Player::new(setup).map_err(|error| refused(error.into()))?;
        stop::on_signal()?;
        let feed = self.source.open()?;
        let (feed, done) = run(feed, &mut player, self.json);
        report(feed.counts());
        done
    }
}

/// Follows a feed until it ends or this process is asked to stop, and prints each update, as JSON
/// or text. Returns the feed for its counts.
fn run(feed: Feed, player: &mut Player, is_json: bool) -> (Feed, Result<()>) {
    let mut requester = Requester::default();
    requester.want_raw_if(feed.has_board());
    let mut listener = Listener::new(feed, requester);
    let done = follow(&mut listener, player, is_json);
    (listener.feed, done)
}

fn follow(listener: &mut Listener, player: &mut Player, is_json: bool) -> Result<()> {
    let mut heard_at = Instant::now();
    while !stop::is_requested() {
        let heard = match listener.next(LOOK) {
            Err(_) if stop::is_requested() => break,
            heard => heard?,
        };
        let update = match heard {
            Some(Heard::Packet(packet, _)) => {
                heard_at = Instant::now();
                player.take(&packet)?
            }
            Some(Heard::Over) => break,
            _ if heard_at.elapsed().as_secs_f64() > SILENCE_S => {
                player.silent(LOOK.as_secs_f64())?
            }
            _ => None,
        };
        if let Some(update) = update {
            output::line(&if is_json {
                serde_json::to_string(&update)?
            } else {
                update.text(player.setup().gain)
            })?;
        }
    }
    Ok(())
}
