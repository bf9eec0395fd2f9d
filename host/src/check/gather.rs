//! Talks to the board and collects the observations.

use super::observations::{Exchanged, Inputs, Kept, Lent, Observations, Watched};
use crate::events;
use crate::feed::{Feed, FeedEvent, new_requests, request};
use crate::output::Progress;
use crate::requests::{Requests, encode};
use crate::stop;
use anyhow::{Context, Result, bail, ensure};
use ridgetone_proto::boot::SettingsSource;
use ridgetone_proto::command::{Command, Outcome, Request};
use ridgetone_proto::plan::Plan as Scan;
use ridgetone_proto::settings::{Array, FRAME_RATE_HZ, Settings};
use ridgetone_proto::telemetry::{ConverterState, Event, Health, Hello, Packet, Raw, Starts};
use std::collections::BTreeMap;
use std::time::{Duration, Instant};

/// Options of a check.
#[derive(Clone, Copy, Debug)]
pub struct Plan {
    /// Time to watch for losses, in seconds of the board's clock.
    pub length_s: f64,
    /// True to store settings, restart the board, and restore them.
    pub stores: bool,
    /// Connection of the analog inputs.
    pub inputs: Inputs,
}

/// Time without a message after which a board counts as silent: `health` comes every second.
const SILENCE: Duration = Duration::from_secs(12);
/// Number of `health` messages within which a greeting must come.
const GREETING_HEALTHS: u32 = 12;
/// Longest wait between two checks of [`stop`].
const LOOK: Duration = Duration::from_millis(50);
/// Time for which raw frames are requested beyond the watch, seconds.
const SPARE_S: f64 = 60.0;
/// Stride in seconds to store as a test, and an alternative if the first is already in force.
const STRIDES_S: [f32; 2] = [0.3, 0.35];

/// Talks to the board. Records a failure in [`Observations::ended`], and restores the settings even
/// then.
pub fn gather(feed: &mut Feed, plan: Plan, progress: &mut Progress) -> Observations {
    let mut talk = Talk {
        feed,
        requests: new_requests(),
        seen: Seen::default(),
        own: None,
        progress,
    };
    let mut found = Observations {
        inputs: plan.inputs,
        ..Observations::default()
    };
    if let Err(error) = talk.run(plan, &mut found) {
        found.ended = Some(format!("{error:#}"));
    }
    talk.progress.end();
    found
}

/// The latest packets.
#[derive(Default)]
struct Seen {
    hello: Option<Hello>,
    health: Option<Health>,
    converter: Option<ConverterState>,
    /// True if the board has restarted.
    has_started: bool,
    starts: Starts,
    healths: u32,
    frames: Option<Vec<Raw>>,
    touches_us: Vec<(u64, Option<u64>)>,
}

impl Seen {
    fn take(&mut self, packet: &Packet) {
        if self.starts.take(&packet.event) {
            (self.hello, self.has_started) = (None, true);
        }
        match &packet.event {
            Event::Hello(hello) => self.hello = Some(hello.clone()),
            Event::Health(health) => {
                (self.health, self.healths) = (Some(*health), self.healths + 1);
            }
            Event::Converter(converter) => self.converter = Some(converter.clone()),
            Event::Raw(raw) => self.frames.iter_mut().for_each(|frames| frames.push(*raw)),
            Event::Contact(contact) => self.touches_us.push((contact.t_us, None)),
            Event::Release(release) => {
                self.touches_us
                    .last_mut()
                    .into_iter()
                    .for_each(|last| last.1 = Some(release.t_us));
            }
            _ => {}
        }
    }
}

/// Fails with the reason if the board has refused a command.
fn done(outcome: Outcome) -> Result<()> {
    match outcome {
        Outcome::Done | Outcome::DoneErased => Ok(()),
        refused => bail!("{}", events::outcome(&refused)),
    }
}

struct Talk<'a> {
    feed: &'a mut Feed,
    requests: Requests,
    seen: Seen,
    /// The greeting with the board's own settings, kept while the default plan is in force.
    own: Option<Hello>,
    progress: &'a mut Progress,
}

impl Talk<'_> {
    fn run(&mut self, plan: Plan, found: &mut Observations) -> Result<()> {
        self.progress.show(format_args!("greeting the board"));
        let greeted = self.request(Command::Greet);
        // Even if the board does not answer, it may send telemetry that describes it.
        let is_heard = greeted.is_ok() || self.feed.counts().received > 0;
        let is_known =
            |seen: &Seen| seen.hello.is_some() && seen.health.is_some() && seen.converter.is_some();
        let heard = if is_heard {
            self.listen(is_known)
        } else {
            Ok(())
        };
        (found.hello, found.health) = (self.seen.hello.clone(), self.seen.health);
        found.converter = self.seen.converter.clone();
        if greeted.is_err() && is_heard {
            let (commands, sends) = (1, self.requests.sends);
            found.exchanged = Some(Exchanged {
                commands,
                sends,
                ..Exchanged::default()
            });
        }
        let (bytes, packets) = (self.feed.bytes(), self.feed.counts().received);
        greeted.with_context(|| format!("{bytes} bytes received, {packets} packets understood"))?;
        heard?;
        self.lend_plan(found)?;
        let done = self.examine(plan, found);
        // Restore the plan even after a failure or Ctrl-C.
        self.return_plan(found);
        done
    }

    /// Puts the default plan in force if the board has a different one: frames, noise and mains are
    /// judged for it.
    fn lend_plan(&mut self, found: &mut Observations) -> Result<()> {
        let has_another = |hello: &&Hello| hello.settings.plan != found.judged();
        let Some(own) = found.hello.as_ref().filter(has_another) else {
            return Ok(());
        };
        let settings = own.settings.with_plan(found.judged());
        (self.seen.hello, self.own) = (None, Some(own.clone()));
        self.progress.show(format_args!("another scan plan"));
        let outcome = self.set(settings, false)?;
        done(outcome).context("the default scan plan is refused")?;
        // The first report after the change may still count conversions of the old plan.
        let from = self.seen.healths;
        self.listen(|seen| seen.healths > from + 1)?;
        found.health = self.seen.health;
        Ok(())
    }

    /// Puts the board's own settings in force again.
    fn return_plan(&mut self, found: &mut Observations) {
        let Some(Hello { settings, .. }) = self.own.take() else {
            return;
        };
        let is_back = self
            .seen
            .hello
            .as_ref()
            .is_some_and(|hello| hello.settings == settings);
        let returned = if is_back {
            Ok(())
        } else {
            self.set(settings, false).and_then(done)
        };
        let failed = returned.err().map(|error| format!("{error:#}"));
        found.lent = Some(Lent {
            plan: settings.plan,
            failed,
        });
    }

    /// Watches the board with the default plan in force.
    fn examine(&mut self, plan: Plan, found: &mut Observations) -> Result<()> {
        // Keep telemetry running as in normal use.
        self.request_frames(plan.length_s)?;
        let exchanged = found.exchanged.insert(Exchanged::default());
        self.exchange(exchanged)?;
        found.watched = Some(self.watch(plan.length_s)?);
        found.converter = self.seen.converter.clone();
        self.request(Command::Raw { frames: 0 })?;
        if plan.stores {
            found.kept = Some(self.keep()?);
        }
        not_interrupted()
    }

    fn request(&mut self, command: Command) -> Result<Outcome> {
        let Self {
            feed,
            requests,
            seen,
            ..
        } = self;
        request(feed, requests, command, &mut |packet| seen.take(packet))
    }

    fn set(&mut self, settings: Settings, keep: bool) -> Result<Outcome> {
        self.request(Command::Set { settings, keep })
    }

    /// Requests raw frames for `length_s` plus [`SPARE_S`] seconds.
    fn request_frames(&mut self, length_s: f64) -> Result<Outcome> {
        let frames = (length_s + SPARE_S) * f64::from(FRAME_RATE_HZ);
        self.request(Command::Raw {
            frames: frames as u32,
        })
    }

    /// Reads packets until `is_done`.
    fn listen(&mut self, is_done: impl Fn(&Seen) -> bool) -> Result<()> {
        let mut heard = Instant::now();
        while !is_done(&self.seen) {
            not_interrupted()?;
            match self.feed.next(LOOK)? {
                Some(FeedEvent::Data(packet)) => {
                    heard = Instant::now();
                    self.seen.take(&packet);
                }
                Some(FeedEvent::Disconnected(name, why)) => bail!("{name}: {why}"),
                Some(FeedEvent::Over) => bail!("{}: no more data", self.feed.name()),
                Some(FeedEvent::Connected(_)) | None => {}
            }
            let (bytes, packets) = (self.feed.bytes(), self.feed.counts().received);
            if let Some(what) = self.feed.strangers() {
                bail!("{}: {what}", self.feed.name());
            }
            ensure!(
                heard.elapsed() <= SILENCE,
                "the board is silent: {bytes} bytes received, {packets} packets"
            );
        }
        Ok(())
    }

    /// Sends commands of many lengths that change nothing on the board: it must refuse all except
    /// the greeting.
    fn exchange(&mut self, exchanged: &mut Exchanged) -> Result<()> {
        let (probes, sends) = (probes()?, self.requests.sends);
        exchanged.commands = probes.len() as u32;
        exchanged.shortest_bytes = probes.keys().next().copied().unwrap_or_default();
        exchanged.longest_bytes = probes.keys().next_back().copied().unwrap_or_default();
        let count = probes.len() as u64;
        for (command, number) in probes.into_values().zip(1u64..) {
            self.progress
                .show_count("commands of many lengths", number, count);
            let is_refused = command != Command::Greet;
            let outcome = self.request(command);
            exchanged.sends = self.requests.sends - sends;
            exchanged.answered += u32::from(matches!(outcome?, Outcome::Setting(_)) == is_refused);
            not_interrupted()?;
        }
        Ok(())
    }

    /// Listens for a while. Counts `health` messages, one a second, because device time stands
    /// still without conversions.
    fn watch(&mut self, length_s: f64) -> Result<Watched> {
        self.request_frames(length_s)?;
        // Wait for counters that include the last command.
        let heard = self.seen.healths;
        self.listen(|seen| seen.healths > heard)?;
        let before = self.seen.health.unwrap_or_default();
        let counts_before = self.feed.counts();
        (self.seen.frames, self.seen.has_started) = (Some(Vec::new()), false);
        let (from, seconds) = (self.seen.healths, length_s.ceil() as u32);
        for second in 1..=seconds {
            self.progress
                .show(format_args!("watching for losses: {second} of {seconds} s"));
            self.listen(|seen| seen.healths >= from + second)?;
        }
        Ok(Watched {
            before,
            after: self.seen.health.unwrap_or_default(),
            counts_before,
            counts_after: self.feed.counts(),
            frames: self.seen.frames.take().unwrap_or_default(),
            touches_us: self.seen.touches_us.clone(),
            has_restarted: self.seen.has_started,
        })
    }

    /// Stores changed settings, restarts the board, checks that they are in force, and restores
    /// both the stored settings and those in force.
    fn keep(&mut self) -> Result<Kept> {
        self.progress.show(format_args!("storing settings"));
        let in_force = self.own.clone().or(self.seen.hello.clone());
        let in_force = in_force.context("the board did not greet")?;
        // If the settings in force were only sent, those in the flash are known only after a
        // restart.
        let stored = match in_force.source {
            SettingsSource::Sent => self.restart()?,
            _ => in_force.clone(),
        };
        let [usual, other] = STRIDES_S;
        let stride_s = if usual == stored.settings.stride_s {
            other
        } else {
            usual
        };
        let changed = Settings {
            stride_s,
            ..stored.settings
        };
        let mut kept = Kept {
            sent: Some(changed),
            ..Kept::default()
        };
        let failed = self.store(changed, &mut kept).err();
        kept.failed = failed.map(|error| format!("{error:#}"));
        let not_restored = self
            .restore(&stored, &in_force, kept.may_have_changed)
            .err();
        kept.not_restored = not_restored.map(|error| format!("{error:#}"));
        Ok(kept)
    }

    fn store(&mut self, settings: Settings, kept: &mut Kept) -> Result<()> {
        // Restore the settings even if no answer comes.
        kept.may_have_changed = true;
        let outcome = self.set(settings, true)?;
        kept.has_erased = outcome == Outcome::DoneErased;
        kept.may_have_changed = matches!(outcome, Outcome::Done | Outcome::DoneErased);
        done(outcome)?;
        let hello = self.restart()?;
        kept.found = (hello.source == SettingsSource::Stored).then_some(hello.settings);
        Ok(())
    }

    /// Sends the request that restores the flash first, without waiting for anything else, so that
    /// it is sent even after Ctrl-C.
    fn restore(&mut self, stored: &Hello, in_force: &Hello, may_have_changed: bool) -> Result<()> {
        let was_stored = stored.source.is_stored();
        if may_have_changed {
            done(match was_stored {
                true => self.set(stored.settings, true)?,
                false => self.request(Command::Forget)?,
            })?;
        }
        if !stop::is_requested() {
            let found = self.restart()?;
            let is_restored =
                found.settings == stored.settings && found.source.is_stored() == was_stored;
            ensure!(is_restored, "after a restart other settings are in force");
        }
        if in_force.source == SettingsSource::Sent {
            self.set(in_force.settings, false)?;
        }
        Ok(())
    }

    /// Resets the board and returns its first greeting.
    fn restart(&mut self) -> Result<Hello> {
        (self.seen.hello, self.seen.has_started) = (None, false);
        self.request(Command::Restart)?;
        self.progress.show(format_args!("the board restarts"));
        // The greeting may be lost; the next one comes after ten `health` messages.
        let from = self.seen.healths;
        self.listen(|seen| {
            seen.hello.is_some() && (seen.has_started || seen.healths > from + GREETING_HEALTHS)
        })?;
        self.seen.hello.clone().context("the board did not greet")
    }
}

fn not_interrupted() -> Result<()> {
    ensure!(!stop::is_requested(), "interrupted");
    Ok(())
}

/// Returns probe commands by their length on the wire (bytes): a greeting, and settings with a
/// window of zero, which the board must refuse. Six masks of one to three bytes each vary the
/// length.
fn probes() -> Result<BTreeMap<usize, Command>> {
    let mut commands = vec![Command::Greet];
    for mask in [1, 1 << 7, 1 << 14] {
        for long in 0..=6 {
            let masks: [u16; 6] = std::array::from_fn(|at| if at < long { mask } else { 1 });
            let [alike @ .., front, inputs] = masks;
            let settings = Settings {
                window_s: 0.0,
                array: Array {
                    front,
                    alike,
                    ..Array::DEFAULT
                },
                plan: Scan {
                    inputs,
                    ..Scan::PAPER
                },
                ..Settings::DEFAULT
            };
            commands.push(Command::Set {
                settings,
                keep: false,
            });
        }
    }
    let mut probes = BTreeMap::new();
    for command in commands {
        // Use a request number that takes three bytes, as for most requests.
        let request = Request {
            number: u16::MAX,
            command,
        };
        let length_bytes = encode(&request)?.len();
        probes.entry(length_bytes).or_insert(request.command);
    }
    Ok(probes)
}
