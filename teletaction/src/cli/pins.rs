//! `pins`: what the finger feels, on a display of pins; and what such a display must be able to do.

use crate::display::{Grid, Kelvin, Limits, Quantity, SUBJECTS};
use crate::pins::{Design, Memory, Perception, Player, Setup, Show, run, volts_per_strain};
use anyhow::Result;
use clap::{Args, ValueEnum};
use ridgetone_host::cli::lines::report;
use ridgetone_host::cli::parse::positive;
use ridgetone_host::cli::source::SourceOptions;
use ridgetone_host::usage::UsageError;
use ridgetone_host::view::guard::address;
use ridgetone_host::{output, stop};
use std::io::IsTerminal;
use std::net::SocketAddr;

#[derive(Debug, Args)]
#[command(after_help = "\
The screen, or with --page the page, shows the strain in the sensor, the forces of the pins, and the strain that a finger on them would feel. Where standard
output is no terminal, and with --plain or --json, it prints a line for each update of the display. A recording needs raw frames:
`ridgetone record --raw`.

With --design it reads nothing: it says whether people would notice the errors of a display.

Examples:
  ridgetone pins --emulated
  ridgetone pins --emulated --page --open
  ridgetone pins --emulated --once --json
  ridgetone pins --port /dev/ttyUSB0 --pins 10x10 --spacing-mm 1 --subject 2
  ridgetone pins --file touch.rec --update-hz 8 --levels 1
  ridgetone pins --design --spacing-mm 2 --depth-mm 2 --resolution 10%")]
pub struct PinsArgs {
    #[command(flatten)]
    source: SourceOptions,
    #[command(flatten)]
    display: DisplayOptions,
    /// Say what a finger would notice of a display with this spacing, layer and resolution.
    #[arg(long, conflicts_with_all = ["recording", "port", "usb_serial", "emulated"])]
    design: bool,
    /// Error of a pin over the pins' mean height, percent, for --design.
    #[arg(long, value_name = "PERCENT", default_value = "10", value_parser = percent, requires = "design")]
    resolution: f64,
    /// Show a board, which is what it does without --emulated and --file too.
    #[arg(long, conflicts_with_all = ["recording", "emulated", "design"])]
    live: bool,
    /// Show it on a page in a browser instead, at this loopback address.
    #[arg(
        long,
        value_name = "ADDRESS:PORT",
        num_args = 0..=1,
        default_missing_value = "127.0.0.1:8323",
        value_parser = address,
        conflicts_with_all = ["plain", "json", "design"]
    )]
    page: Option<SocketAddr>,
    /// Open the page in the browser.
    #[arg(long, requires = "page")]
    open: bool,
    /// Print lines instead of a screen.
    #[arg(long)]
    plain: bool,
    /// One JSON object a line instead of text.
    #[arg(long)]
    json: bool,
}

#[derive(Args, Clone, Debug)]
struct DisplayOptions {
    /// Columns and rows of pins, at most 100 in all.
    #[arg(long, value_name = "COLUMNSxROWS", default_value = "4x4", value_parser = columns_and_rows)]
    pins: (usize, usize),
    /// Distance of the pins, mm.
    #[arg(long, value_name = "MM", default_value_t = 2.0, value_parser = positive)]
    spacing_mm: f64,
    /// Rubber, and skin, between the pins and the finger's receptors, mm.
    #[arg(long, value_name = "MM", default_value_t = 2.0, value_parser = positive)]
    depth_mm: f64,
    /// Quantity that sensor and finger should share.
    #[arg(long, value_enum, value_name = "WHAT", default_value_t = Match::Strain)]
    by: Match,
    /// Strain in the finger over that in the sensor.
    #[arg(long, value_name = "FACTOR", default_value_t = 1.0, value_parser = positive)]
    gain: f64,
    /// How much even forces are preferred: more of it, less noise.
    #[arg(long, value_name = "SHARE", default_value_t = 0.01, value_parser = positive)]
    regularisation: f64,
    /// Take the afterimages of this subject of the paper into account, or of your own skin by its
    /// relaxation times for constant strain and stress as `skin fit` finds them [default: of none].
    #[arg(long, value_name = "1-6|S,S", value_parser = subject)]
    subject: Option<Kelvin>,
    /// Greatest force of a pin, N.
    #[arg(long, value_name = "N", default_value_t = f64::from(Limits::IDEAL.force_n), value_parser = positive)]
    force_n: f64,
    /// Longest travel of a pin, mm; the finger opposes 0.5 N/mm.
    #[arg(long, value_name = "MM", default_value_t = f64::from(Limits::IDEAL.stroke_mm), value_parser = positive)]
    stroke_mm: f64,
    /// Updates of the display a second.
    #[arg(long, value_name = "HZ", default_value_t = 20.0, value_parser = positive)]
    update_hz: f64,
    /// Levels of a pin; 1 is up or down.
    #[arg(long, value_name = "N", default_value_t = 1000, value_parser = clap::value_parser!(u16).range(1..))]
    levels: u16,
    /// Greatest change of a force, N/s.
    #[arg(long, value_name = "N_S", default_value_t = f64::from(Limits::IDEAL.slew_n_s), value_parser = positive)]
    slew_n_s: f64,
    /// Volts of a channel per unit of strain [default: those of the simulated finger, 0.125].
    #[arg(long, value_name = "V", value_parser = positive)]
    volts_per_strain: Option<f64>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Match {
    /// Normal strain of the paper's thin slices, which give way across (plane stress).
    Strain,
    /// Normal strain of a half space: a wide even touch hardly strains rubber, and needs more force.
    HalfSpace,
    /// Normal stress.
    Stress,
}

fn percent(text: &str) -> Result<f64, String> {
    positive(text.trim_end_matches('%').trim_end())
}

fn subject(text: &str) -> Result<Kelvin, String> {
    if let Some((relaxation_s, creep_s)) = text.split_once(',') {
        let [relaxation_s, creep_s] = [positive(relaxation_s.trim())?, positive(creep_s.trim())?];
        return Kelvin::new(relaxation_s, creep_s).map_err(|error| error.to_string());
    }
    let number = text.parse::<usize>().ok();
    number
        .and_then(|number| SUBJECTS.get(number.checked_sub(1)?))
        .copied()
        .ok_or_else(|| "write 1 to 6, or two times in seconds such as 1.42,2.14".into())
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
    if columns * rows > crate::display::PINS_MAX {
        return Err(format!(
            "{} pins: at most {}",
            columns * rows,
            crate::display::PINS_MAX
        ));
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
            regularisation: self.regularisation as f32,
            skin: self.subject,
            limits,
            gain: self.gain,
            volts_per_strain: self.volts_per_strain.unwrap_or_else(volts_per_strain),
            ..Setup::new()?
        })
    }
}

impl PinsArgs {
    pub(super) fn run(self) -> Result<()> {
        if self.design {
            let design = Design::new(
                self.display.spacing_mm,
                self.display.depth_mm,
                self.resolution,
            )?;
            return output::line(&if self.json {
                serde_json::to_string(&design)?
            } else {
                text(&design)
            });
        }
        let setup = self
            .display
            .setup()
            .map_err(|error| UsageError(format!("{error:#}")))?;
        let mut memory = Memory::new(&setup);
        // What is impossible is a matter of the options.
        let player =
            Player::new(setup, &mut memory).map_err(|error| UsageError(format!("{error:#}")));
        let mut player = player?;
        stop::on_signal()?;
        let feed = self.source.open()?;
        let show = match (self.json, self.plain || !std::io::stdout().is_terminal()) {
            (true, _) => Show::Json,
            (false, true) => Show::Lines,
            (false, false) => Show::Screen,
        };
        let show = self
            .page
            .map_or(show, |address| Show::Page(address, self.open));
        let (feed, shown) = run(feed, &mut player, show);
        report(feed.counts());
        shown
    }
}

/// What a person wants to know of a design.
fn text(design: &Design) -> String {
    let verdict = |verdict: Perception| match verdict {
        Perception::NotNoticed => "not noticed",
        Perception::JustNoticed => "just noticed",
        Perception::Noticed => "noticed",
    };
    format!(
        "pins {} mm apart under {} mm of rubber, each off by up to {} %\n\
         {:.2} pins a millimetre, {:.2} layers apart: {}\n\
         from pin to pin        index {:.3}  {}\n\
         worst, over {:4.1} mm    index {:.3}  {}\n\
         pins at one height     index {:.3}\n\
         An index of 0.10 to 0.15 is just noticed. Up to {:.1} % no error under a finger pad is noticed.",
        design.spacing_mm,
        design.depth_mm,
        design.resolution_percent,
        design.samples_per_mm,
        design.spacing_mm / design.depth_mm,
        if design.is_dense {
            "dense enough"
        } else {
            "too coarse, the paper has at least 0.5 and less than 2"
        },
        design.index,
        verdict(design.verdict),
        design.worst_period_mm,
        design.worst_index,
        verdict(design.worst_verdict),
        design.pins_index,
        design.resolution_max_percent,
    )
}
