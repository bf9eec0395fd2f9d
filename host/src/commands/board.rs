//! The commands that have to do with a board, real or emulated, and with what was recorded of one.

use crate::cli::{
    BoardCommand, BoardOptions, ExportArgs, LineOptions, ListenArgs, MonitorArgs, PortsArgs, RecordArgs, ReplayArgs,
    Senseless, SettingsCommand, SettingsGetArgs, SettingsSetArgs, ViewArgs,
};
use crate::client::Client;
use crate::export::{Format, Kind};
use crate::feed::{Asking, Feed, Source};
use crate::live::Counts;
use crate::monitor::Monitor;
use crate::port::{Link, PortError, Ports, System, Wanted};
use crate::recording::Recorded;
use crate::teleplot::Teleplot;
use crate::{events, listen, names, output, record, settings_form, speed, stop, view};
use anyhow::Result;
use ridgetone_proto::command::Command;
use ridgetone_proto::settings::Settings;
use ridgetone_proto::telemetry::Packet;
use std::io::{IsTerminal, Write};
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

/// `ports`
pub fn ports(args: &PortsArgs) -> Result<()> {
    let found = System.list().map_err(PortError::List)?;
    if found.is_empty() {
        eprintln!("ridgetone: there is no serial port");
    }
    for port in found {
        output::line(&if args.json { serde_json::to_string(&port)? } else { port.to_string() })?;
    }
    Ok(())
}

/// `listen`
pub fn listen(args: ListenArgs) -> Result<()> {
    let wanted = match (args.port, args.usb_serial) {
        (Some(name), _) => Wanted::Name(name),
        (None, Some(number)) => Wanted::UsbSerial(number),
        (None, None) => return Err(Senseless("say which board: --port or --usb-serial".into()).into()),
    };
    stop::on_signal()?;
    print_lines(Feed::new(Link::open(System, wanted)?), Asking::default(), args.lines)
}

/// `monitor`
pub fn monitor(args: &MonitorArgs) -> Result<()> {
    let settings = load(args.settings.as_ref())?;
    stop::on_signal()?;
    let feed = args.source.open()?;
    let LineOptions { json, teleplot } = args.lines;
    if args.plain || json || teleplot || !std::io::stdout().is_terminal() {
        return print_lines(feed, asking(settings), args.lines);
    }
    let (feed, shown) = Monitor::new(feed, settings).run();
    tell_counts(feed.counts());
    shown
}

/// `view`
pub fn view(args: &ViewArgs) -> Result<()> {
    let settings = load(args.settings.as_ref())?;
    stop::on_signal()?;
    let (feed, served) = view::run(args.source.open()?, settings, args.listen);
    tell_counts(feed.counts());
    served
}

/// `record`
pub fn record(args: &RecordArgs) -> Result<()> {
    let mut asking = asking(load(args.settings.as_ref())?);
    if args.raw {
        asking.want_raw(true);
    }
    stop::on_signal()?;
    // An order takes a moment: a board that runs away from it would have said much until then.
    let pace = (args.raw || args.settings.is_some()).then_some(1.0);
    let feed = args.board.open(Some(&args.input), pace, false)?;
    let (feed, heard) = record::run(feed, &args.output, asking, args.length)?;
    tell_counts(feed.counts());
    heard
}

/// `replay` of a recording of telemetry: what the board said.
pub fn replay(args: &ReplayArgs, file: &Path) -> Result<()> {
    if args.settings.settings()? != Settings::DEFAULT || args.profile.is_some() || args.input.rate.is_some() {
        let file = file.display();
        let why = format!(
            "{file}: what the board said has its settings already; for others replay its frames: `ridgetone export {file} --format csv --table frames -o frames.csv`, `ridgetone replay frames.csv`"
        );
        return Err(Senseless(why).into());
    }
    print_lines(Feed::new(Recorded::open(file)?), Asking::default(), args.lines)
}

/// `export`
pub fn export(args: &ExportArgs) -> Result<()> {
    if args.table.is_some() && args.format != Format::Csv {
        return Err(Senseless("--table is for --format csv: the others hold everything".into()).into());
    }
    stop::on_signal()?;
    let kind = args.table.unwrap_or(Kind::Estimates);
    let mut counts = Counts::default();
    match &args.output {
        Some(path) => output::whole_file(path, |file| {
            counts = crate::export::run(&args.file, args.format, kind, file)?;
            Ok(())
        })?,
        None => {
            let stdout = std::io::stdout().lock();
            if args.format == Format::Mcap && stdout.is_terminal() {
                return Err(Senseless("MCAP is not for a terminal: write it to a file with -o".into()).into());
            }
            let mut out = std::io::BufWriter::new(stdout);
            counts = crate::export::run(&args.file, args.format, kind, &mut out)?;
            out.flush()?;
        }
    }
    tell_counts(counts);
    Ok(())
}

/// `settings`
pub fn settings(command: &SettingsCommand) -> Result<()> {
    match command {
        SettingsCommand::Get(args) => get(args),
        SettingsCommand::Set(args) => set(args),
        SettingsCommand::Forget(args) => {
            let mut feed = args.board.open(None, Some(1.0), true)?;
            let erased = Client::new(&mut feed).request(Command::Forget)?;
            told_done("forgotten: the defaults are in force", erased)
        }
    }
}

fn get(args: &SettingsGetArgs) -> Result<()> {
    let mut feed = args.board.open(None, Some(1.0), true)?;
    let hello = Client::new(&mut feed).hello()?;
    eprintln!("ridgetone: {}: settings {}", feed.name(), names::name(hello.source));
    output::line(settings_form::toml(&hello.settings)?.trim_end())
}

fn set(args: &SettingsSetArgs) -> Result<()> {
    let from_file = load(args.settings.as_ref())?;
    // Without a file what is wrong shows before a board is asked, too.
    settings_form::change(&from_file.unwrap_or_default(), &args.changes)?;
    let mut feed = args.board.open(None, Some(1.0), true)?;
    let mut board = Client::new(&mut feed);
    let base = match from_file {
        Some(settings) => settings,
        None => board.hello()?.settings,
    };
    let settings = settings_form::change(&base, &args.changes)?;
    let erased = board.request(Command::Set { settings, keep: args.keep })?;
    told_done(if args.keep { "in force and stored" } else { "in force until the next start" }, erased)
}

/// `order`
pub fn command(command: &BoardCommand) -> Result<()> {
    let open = |board: &BoardOptions| board.open(None, Some(1.0), true);
    let (board, request, done) = match command {
        BoardCommand::Start(board) => (board, Command::Start, "it begins anew"),
        BoardCommand::Stop(board) => (board, Command::Stop, "it tells nothing but health until `command start`"),
        BoardCommand::Restart(board) => (board, Command::Restart, "it restarts"),
        BoardCommand::Unfollow(board) => (board, Command::Unfollow, "estimates come by time"),
        BoardCommand::Follow(args) => {
            let after = speed::after(args.repeats);
            let knots = speed::knots(&args.file, after)?;
            let mut feed = open(&args.board)?;
            Client::new(&mut feed).follow(&knots, after)?;
            eprintln!("ridgetone: {}: estimates come by place, in cycles per mm", feed.name());
            return Ok(());
        }
    };
    let mut feed = open(board)?;
    Client::new(&mut feed).request(request)?;
    eprintln!("ridgetone: {}: {done}", feed.name());
    Ok(())
}

fn told_done(what: &str, erased: bool) -> Result<()> {
    let erased = if erased { "; the flash was erased for it, which cost a second or two of conversions" } else { "" };
    eprintln!("ridgetone: {what}{erased}");
    Ok(())
}

fn load(path: Option<&PathBuf>) -> Result<Option<Settings>> {
    path.map(|path| settings_form::load(path)).transpose()
}

fn asking(settings: Option<Settings>) -> Asking {
    let mut asking = Asking::default();
    if let Some(settings) = settings {
        asking.give(Command::Set { settings, keep: false });
    }
    asking
}

/// Prints what comes, line by line, and at the end what was received and what was not.
fn print_lines<S: Source>(mut feed: Feed<S>, mut asking: Asking, lines: LineOptions) -> Result<()> {
    let mut print = printer(lines);
    let heard = listen::run(&mut feed, &mut asking, &mut |packet| print(packet).map(ControlFlow::Continue));
    tell_counts(feed.counts());
    heard
}

fn tell_counts(counts: Counts) {
    line_quality(counts.received, counts.missing, counts.damaged);
}

/// Tells standard error what was received and what was not.
pub fn line_quality(received: u64, missing: u32, damaged: u32) {
    eprintln!("ridgetone: {received} telemetry frames received, {missing} lost, {damaged} damaged");
}

/// Prints packets as they come, in one of three kinds of lines.
pub fn printer(lines: LineOptions) -> impl FnMut(&Packet) -> Result<()> {
    let mut teleplot = lines.teleplot.then(Teleplot::default);
    move |packet| match teleplot.as_mut().map(|teleplot| teleplot.lines(packet)) {
        Some(lines) if lines.is_empty() => Ok(()),
        Some(lines) => output::line(&lines),
        None if lines.json => output::line(&events::json(packet)?),
        None => output::line(&events::text(packet)),
    }
}
