//! The commands: arguments in, output out.

mod board;

use crate::calibrate;
use crate::calibrate::CalibrateArgs;
use crate::cli::{Cli, Command, DemoArgs, EmulateArgs, FitArgs, InputOptions, LineOptions, ReplayArgs, SceneArgs};
use crate::input::{Opened, Source, check_length, frame_rate_hz};
use crate::output;
use crate::output::Progress;
use crate::picture::Recording;
use crate::speed;
use crate::speed::Column;
use crate::table_fit;
use crate::table_fit::Selection;
use crate::{demo, emulator, fit_report, picture, recording, replay, settings_form, stop};
use anyhow::{Result, bail};
use board::{line_quality, printer};
use hal_mock::{SlidingScene, Table, write_csv};
use ridgetone_proto::telemetry::Packet;
use serde::Serialize;

/// Does what the command line says.
///
/// # Errors
/// One line that says what is wrong; [`crate::cli::Senseless`] where it is the command itself.
pub fn run(cli: Cli) -> Result<()> {
    match cli.command {
        Command::Fit(args) => fit(&args),
        Command::Replay(args) => run_replay(&args),
        Command::Calibrate(args) => run_calibrate(&args),
        Command::Emulate(args) => emulate(&args),
        Command::Ports(args) => board::ports(&args),
        Command::Monitor(args) => board::monitor(&args),
        Command::View(args) => board::view(&args),
        Command::Record(args) => board::record(&args),
        Command::Export(args) => board::export(&args),
        Command::Settings(args) => board::settings(&args),
        Command::Command(args) => board::command(&args),
        Command::Listen(args) => board::listen(args),
        Command::Demo(args) => run_demo(&args),
        Command::Scene(args) => scene(&args),
    }
}

/// Share by which a given rate and the time stamps may differ without a word.
const RATES_DIFFER: f64 = 0.01;

fn fit(args: &FitArgs) -> Result<()> {
    let settings = args.settings.as_deref().map(settings_form::load).transpose()?;
    let table = Table::load(&args.file)?;
    let selection = Selection {
        rate_hz: args.rate,
        from_s: args.from,
        to_s: args.to,
        columns: args.columns.clone(),
        harmonics: args.harmonics.or(settings.map(|settings| settings.harmonics)),
        place: args.position_column.clone().map(Column::Position).or(args.speed_column.clone().map(Column::Speed)),
        interferer_hz: args.mains.or(settings.map(|settings| settings.interferer_hz.into()).filter(|hz| *hz > 0.0)),
    };
    if let (Some(rate_hz), Some([first, .., last])) = (args.rate, table.time_s()) {
        let by_stamps_hz = (table.rows().len() - 1) as f64 / (last - first);
        if (rate_hz / by_stamps_hz - 1.0).abs() > RATES_DIFFER {
            eprintln!("ridgetone: warning: --rate {rate_hz} Hz is taken, though time_s says {by_stamps_hz:.4} Hz");
        }
    }
    let fit = table_fit::fit(&table, &selection)?;
    if args.json {
        output::line(&fit_report::json(table.file(), &fit)?)
    } else {
        output::line(fit_report::text(&fit).trim_end())
    }
}

const CHOOSE_SHORTER: &str = ": choose a shorter --window";

fn run_replay(args: &ReplayArgs) -> Result<()> {
    stop::on_signal()?;
    if let Some(file) = &args.input.file
        // What cannot be read is told by who reads tables.
        && recording::is_telemetry(file).unwrap_or(false)
    {
        return board::replay(args, file);
    }
    let settings = args.settings.settings()?;
    let after = speed::after(args.profile_repeats);
    let profile = args.profile.as_ref().map(|path| speed::profile(path, after)).transpose()?;
    let input = open(&args.input, settings.window_s, CHOOSE_SHORTER)?;
    let mut progress = Progress::default();
    let outcome = replay::run(input, settings, profile, &mut printer(args.lines), &mut |done_s, total_s| {
        progress.tell(done_s, total_s);
    });
    progress.end();
    let outcome = outcome?;
    line_quality(outcome.received, outcome.missing, outcome.damaged);
    Ok(())
}

fn run_calibrate(args: &CalibrateArgs) -> Result<()> {
    let found = calibrate::run(args.gratings()?, args.nominal)?;
    if args.json { output::line(&serde_json::to_string(&found)?) } else { output::line(found.to_string().trim_end()) }
}

fn emulate(args: &EmulateArgs) -> Result<()> {
    stop::on_signal()?;
    let elf = args.firmware.image()?;
    let settings = args.settings.settings()?;
    let input = open(&args.input, settings.window_s, CHOOSE_SHORTER)?;
    let mut options = args.firmware.options(&elf);
    options.settings = settings;
    options.keep_conversions = args.svg.is_some();
    options.keep_serial = args.serial_out.is_some();
    options.log = args.log.then_some(|line| eprintln!("log: {line}"));
    let mut progress = Progress::default();
    let mut print = printer(LineOptions { json: args.json, teleplot: false });
    let mut packets = Vec::new();
    let mut sink = |packet: &Packet| {
        if args.svg.is_some() {
            packets.push(packet.clone());
        }
        print(packet)
    };
    let outcome = emulator::run(input, options, &mut sink, &mut |done_s, total_s| progress.tell(done_s, total_s));
    progress.end();
    let outcome = outcome?;
    for line in outcome.messages.lines() {
        eprintln!("firmware: {line}");
    }
    if let Some(path) = &args.serial_out {
        output::whole_file(path, |file| Ok(file.write_all(&outcome.serial)?))?;
    }
    if let Some(path) = &args.svg {
        let svg = picture::draw(&Recording::new(&outcome.conversions, &packets), None);
        output::whole_file(path, |file| Ok(file.write_all(svg.as_bytes())?))?;
    }
    line_quality(outcome.received, outcome.missing, outcome.damaged);
    Ok(())
}

fn run_demo(args: &DemoArgs) -> Result<()> {
    let scene = args.scene.as_ref().map(|path| hal_mock::load_scene(path, frame_rate_hz())).transpose()?;
    if scene.as_ref().is_some_and(|scene| scene.hand.is_some()) {
        bail!("a hand has no one speed to compare with: use `ridgetone emulate --scene`");
    }
    let elf = args.firmware.image()?;
    let mut options = args.firmware.options(&elf);
    if let Some(path) = &args.settings {
        options.settings = settings_form::load(path)?;
    }
    let mut progress = Progress::default();
    let demo = demo::run(scene.unwrap_or_default(), options, &mut |done_s, total_s| progress.tell(done_s, total_s));
    progress.end();
    let demo = demo?;
    if let Some(path) = &args.svg {
        output::whole_file(path, |file| Ok(file.write_all(demo.svg().as_bytes())?))?;
    }
    output::line(demo.summary.to_string().trim_end())
}

#[derive(Serialize)]
struct TruthJson<'a> {
    r#type: &'static str,
    file: &'a str,
    rows: u64,
    rate_hz: f64,
    contact_s: f64,
    slide_start_s: f64,
    slide_end_s: f64,
    release_s: f64,
    end_s: f64,
    frequency_hz: f64,
}

fn scene(args: &SceneArgs) -> Result<()> {
    let mut scene = SlidingScene::new(args.scene.sliding()?)?;
    let (truth, rate_hz, mut rows) = (scene.truth(), frame_rate_hz(), 0);
    check_length("the scene", truth.end_s)?;
    output::whole_file(&args.output, |file| {
        rows = write_csv(&mut scene, rate_hz, file)?;
        Ok(())
    })?;
    let file = args.output.display().to_string();
    eprintln!(
        "{file}: {rows} rows at {rate_hz:.2} Hz; contact {:.3} s, slide {:.3} to {:.3} s, release {:.3} s, end {:.3} s, tone {:.4} Hz",
        truth.contact_s, truth.slide_start_s, truth.slide_end_s, truth.release_s, truth.end_s, truth.frequency_hz
    );
    if args.json {
        output::line(&serde_json::to_string(&TruthJson {
            r#type: "truth",
            file: &file,
            rows,
            rate_hz,
            contact_s: truth.contact_s,
            slide_start_s: truth.slide_start_s,
            slide_end_s: truth.slide_end_s,
            release_s: truth.release_s,
            end_s: truth.end_s,
            frequency_hz: truth.frequency_hz,
        })?)?;
    }
    Ok(())
}

/// Opens an input that has to fill a window, and tells what is wrong with it but no reason to stop.
fn open(options: &InputOptions, window_s: f32, remedy: &str) -> Result<Opened> {
    let input = options.input()?;
    let file = match &input.source {
        Source::Trace { path, .. } => Some(path.display().to_string()),
        Source::Scene(_) => None,
    };
    let input = input.open()?;
    if let Some(file) = file.filter(|_| input.end_s < f64::from(window_s)) {
        bail!("{file}: {:.3} s of data do not fill a window of {window_s} s{remedy}", input.end_s);
    }
    if let Some(warning) = &input.warning {
        eprintln!("ridgetone: warning: {warning}");
    }
    Ok(input)
}
