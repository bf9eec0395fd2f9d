//! The first half of the pipeline: turns conversions into events and windows to fit.

mod tracker;

use crate::assembler::{Assembler, Next};
use crate::converter::Facts;
use crate::faults::diagnostics::Diagnostics;
use crate::faults::episodes::{FaultEpisodes, add_flaws};
use crate::frame::{Frame, PlainFrame, TimedConversion};
use crate::health::{HealthReporter, health};
use crate::ring::Ring;
use crate::samples::SampleQueue;
use crate::window::Window;
use crate::wiring::Wiring;
use heapless::String;
use ridgetone_proto::VERSION;
use ridgetone_proto::boot::{Boot, Oscillator, SettingsSource};
use ridgetone_proto::fault::FaultKind;
use ridgetone_proto::plan::Plan;
use ridgetone_proto::settings::Settings;
use ridgetone_proto::telemetry::{ConverterState, Event, Hello, PROTOCOL, Raw};
use tracker::Tracker;

/// Maximum time by which an edge may be ahead of the board's clock, microseconds.
const AHEAD_US: u32 = 1000;

/// Receivers of a [`Detector`]'s results.
pub struct Outputs<'a> {
    /// Takes each event.
    pub emit: &'a mut dyn FnMut(Event),
    /// Takes each window that is to be fitted.
    pub due: &'a mut dyn FnMut(Window),
}

/// The middle task: assembles frames, detects contact, schedules windows.
#[derive(Clone, Debug)]
pub struct Detector {
    settings: Settings,
    converter: &'static Facts,
    /// Plan of the conversions. A different plan in `settings` takes effect with [`Self::begin`];
    /// `None` while conversions of a replaced plan still arrive.
    plan: Option<Plan>,
    /// True if the next look reports the converter; and number of the converter's changes at the
    /// latest report.
    is_converter_due: bool,
    converter_changes: u32,
    source: SettingsSource,
    boot: Boot,
    assembler: Assembler,
    tracker: Tracker,
    episodes: FaultEpisodes,
    health_reporter: HealthReporter,
    /// Device time of the latest `health` while the chip was silent, microseconds; zero without a
    /// silence. A greeting with an earlier time would look like a restart.
    looked_us: u64,
}

impl Detector {
    /// Creates an idle detector. `settings` must have passed [`Settings::validate`].
    pub const fn new(settings: Settings) -> Self {
        Self::wired(settings, Wiring::GUIDE)
    }

    /// Creates an idle detector for a board's wiring.
    pub const fn wired(settings: Settings, wiring: Wiring) -> Self {
        Self {
            settings,
            converter: wiring.converter,
            plan: Some(settings.plan),
            is_converter_due: true,
            converter_changes: 0,
            source: SettingsSource::Default,
            boot: Boot::UNKNOWN,
            assembler: Assembler::new(settings.vref_v, &settings.plan),
            tracker: Tracker::new(&settings),
            episodes: FaultEpisodes::new(settings.vref_v),
            health_reporter: HealthReporter::new(&settings.plan),
            looked_us: 0,
        }
    }

    /// Replaces the settings before the first conversion. Keeps their source and the circumstances
    /// of the start for the greeting.
    pub fn boot(&mut self, settings: Settings, source: SettingsSource, boot: Boot) {
        let Settings { vref_v, plan, .. } = settings;
        (self.settings, self.plan) = (settings, Some(plan));
        (self.source, self.boot) = (source, boot);
        self.assembler = Assembler::new(vref_v, &plan);
        self.episodes = FaultEpisodes::new(vref_v);
        self.health_reporter = HealthReporter::new(&plan);
        self.tracker.begin(&settings);
    }

    /// Greeting to send before anything else.
    pub fn hello(&self) -> Event {
        Event::Hello(Hello {
            protocol: PROTOCOL,
            version: VERSION,
            frame_rate_hz: self.settings.plan.frame_rate_hz(),
            settings: self.settings,
            source: self.source,
            boot: self.boot.clone(),
            t_us: self.assembler.now_us.max(self.looked_us),
        })
    }

    /// Adds faults that persist from the start; `board_us` is now. On the processor's internal
    /// oscillator all times are off by up to a few percent; if it also clocks the converter, no
    /// measurement on the board can detect that.
    pub fn add_standing_faults(&self, board_us: u32, diagnostics: &Diagnostics) {
        if self.boot.oscillator == Oscillator::Internal {
            diagnostics.faults.stand(FaultKind::Clock, board_us);
        }
    }

    /// Converter of the board.
    pub const fn converter(&self) -> &'static Facts {
        self.converter
    }

    /// Reports the converter with the next [`Self::look`], as after a change.
    pub const fn tell_converter(&mut self) {
        self.is_converter_due = true;
    }

    fn report_converter(
        &mut self,
        t_us: u64,
        diagnostics: &Diagnostics,
        emit: &mut dyn FnMut(Event),
    ) {
        let changes = diagnostics.converter.changes();
        if self.is_converter_due || changes != self.converter_changes {
            (self.is_converter_due, self.converter_changes) = (false, changes);
            emit(Event::Converter(ConverterState {
                t_us,
                name: String::try_from(self.converter.name).unwrap_or_default(),
                answers: diagnostics.converter.answers(),
                registers: diagnostics.converter.registers(),
            }));
        }
    }

    /// True if the finger touches something.
    pub const fn is_touched(&self) -> bool {
        self.tracker.contact.is_touched()
    }

    /// Takes one conversion. Faults go to `diagnostics`.
    #[inline(always)]
    pub fn push(
        &mut self,
        conversion: TimedConversion,
        ring: &mut Ring,
        diagnostics: &Diagnostics,
        outputs: &mut Outputs<'_>,
    ) {
        if self.assembler.buffer(&conversion) {
            self.scan(ring, diagnostics, outputs);
        }
    }

    /// Moves conversions out of the queue, up to the end of a scan, for [`Self::scan`].
    #[inline(always)]
    pub(crate) fn fill(&mut self, samples: &SampleQueue) -> Next {
        self.assembler.fill(samples)
    }

    /// Takes a plain frame of a different converter, instead of conversions. The settings' plan is
    /// [`Plan::of_frames`]. Frames that are missing according to the times count as lost.
    pub fn push_frame(
        &mut self,
        readings: PlainFrame<'_>,
        ring: &mut Ring,
        diagnostics: &Diagnostics,
        outputs: &mut Outputs<'_>,
    ) {
        let Self {
            assembler, tracker, ..
        } = self;
        let (number, latest_us) = tracker.clock.latest;
        let passed_s = readings.t_us.saturating_sub(latest_us) as f32 * 1e-6;
        let passed = ((passed_s * self.settings.plan.frame_rate_hz() + 0.5) as u32).max(1);
        let is_first = assembler.frames == 0;
        let number = if is_first {
            0
        } else {
            number.wrapping_add(passed)
        };
        if !is_first {
            assembler.lost = assembler.lost.wrapping_add(passed - 1);
        }
        assembler.frames = assembler.frames.wrapping_add(1);
        let frame = readings.frame(number, self.settings.plan.inputs, assembler.vref_v);
        self.push_whole(&frame, ring, diagnostics, outputs);
    }

    /// Takes a frame that a board has reported raw, instead of its conversions. If the settings
    /// have the board's plan and reference, contacts, slides and windows equal the board's to the
    /// bit.
    pub fn push_raw(
        &mut self,
        raw: &Raw,
        ring: &mut Ring,
        diagnostics: &Diagnostics,
        outputs: &mut Outputs<'_>,
    ) {
        self.push_whole(&Frame::from(*raw), ring, diagnostics, outputs);
    }

    fn push_whole(
        &mut self,
        frame: &Frame,
        ring: &mut Ring,
        diagnostics: &Diagnostics,
        outputs: &mut Outputs<'_>,
    ) {
        let Self {
            assembler, tracker, ..
        } = self;
        (assembler.now_us, assembler.board_us) = (frame.t_us, frame.t_us as u32);
        tracker.push(frame, ring, outputs.emit, outputs.due);
        if self.health_reporter.is_due(frame.number) {
            self.report_health(frame.t_us, diagnostics, outputs.emit);
        }
    }

    /// Takes the scan in the assembler's buffer. Not inlined: the task's loop would compute its
    /// addresses before the first scan, and there is often only one.
    #[inline(never)]
    pub(crate) fn scan(
        &mut self,
        ring: &mut Ring,
        diagnostics: &Diagnostics,
        outputs: &mut Outputs<'_>,
    ) {
        let Outputs { emit, due } = outputs;
        let Self {
            assembler, tracker, ..
        } = self;
        if assembler.try_fast_path() {
            tracker.push(&assembler.frame, ring, emit, due);
        } else {
            assembler.slow_path(&mut |frame| tracker.push(frame, ring, emit, due));
            add_flaws(assembler, diagnostics);
        }
        self.episodes.check_supply(&self.assembler, diagnostics);
        let (latest, report) = (self.tracker.clock.latest.0, &mut |fault| {
            emit(Event::Fault(fault))
        });
        self.episodes
            .check(latest, &self.assembler, diagnostics, report);
        if self.health_reporter.is_due(latest) {
            self.report_health(self.assembler.now_us, diagnostics, emit);
            if self.health_reporter.is_greeting_due() {
                emit(self.hello());
                self.is_converter_due = true;
            }
        }
    }

    fn report_health(&mut self, t_us: u64, diagnostics: &Diagnostics, emit: &mut dyn FnMut(Event)) {
        let Self {
            assembler,
            tracker,
            health_reporter,
            looked_us,
            ..
        } = self;
        *looked_us = 0;
        health_reporter.check_rate(assembler, &tracker.clock, diagnostics);
        diagnostics.faults.forget(assembler.board_us);
        emit(Event::Health(health(
            t_us,
            assembler,
            tracker.clock.frame_rate_hz(),
            diagnostics,
        )));
    }

    /// Must be called twice a second; `board_us` is now. While no conversions arrive, reports
    /// faults, and `health` with the greeting as often as usual. After 71.6 minutes of silence
    /// device time jumps back to the start of the silence, as it does when conversions resume (see
    /// `assembler.rs`), which looks like a restart to readers. Device time is zero before the first
    /// conversion.
    pub fn look(&mut self, board_us: u32, diagnostics: &Diagnostics, emit: &mut dyn FnMut(Event)) {
        let Self {
            assembler,
            tracker,
            health_reporter,
            episodes,
            looked_us,
            ..
        } = self;
        health_reporter.check_rate(assembler, &tracker.clock, diagnostics);
        diagnostics.faults.forget(board_us);
        let passed_us = board_us.wrapping_sub(assembler.board_us);
        let passed_us =
            assembler
                .latest_slot
                .is_some()
                .then_some(if passed_us > u32::MAX - AHEAD_US {
                    0
                } else {
                    passed_us
                });
        let t_us = assembler.now_us.wrapping_add(passed_us.unwrap_or(0) as u64);
        episodes.report(t_us, board_us, diagnostics, &mut |fault| {
            emit(Event::Fault(fault))
        });
        if health_reporter.is_silence_due(passed_us) {
            *looked_us = t_us;
            emit(Event::Health(health(
                t_us,
                assembler,
                tracker.clock.frame_rate_hz(),
                diagnostics,
            )));
            if health_reporter.is_greeting_due() {
                emit(self.hello());
                self.is_converter_due = true;
            }
        }
        self.report_converter(t_us, diagnostics, emit);
    }

    /// Ends the signal: ends a slide under way and reports health.
    pub fn finish(
        &mut self,
        ring: &mut Ring,
        diagnostics: &Diagnostics,
        emit: &mut dyn FnMut(Event),
        due: &mut dyn FnMut(Window),
    ) {
        self.close(ring, diagnostics, emit, due);
        self.report_health(self.assembler.now_us, diagnostics, emit);
    }

    /// Ends the scan and the touch under way.
    fn close(
        &mut self,
        ring: &mut Ring,
        diagnostics: &Diagnostics,
        emit: &mut dyn FnMut(Event),
        due: &mut dyn FnMut(Window),
    ) {
        let Self {
            assembler, tracker, ..
        } = self;
        assembler.finish(&mut |frame| tracker.push(frame, ring, emit, due));
        add_flaws(assembler, diagnostics);
        tracker.finish(ring, emit, due);
    }

    /// Applies settings that passed [`Settings::validate`]. A slide under way continues; its
    /// windows get the new length, but none begins before the slide. Returns false for settings
    /// with a different plan, which wait for [`Self::begin`].
    pub fn change(&mut self, settings: &Settings, source: SettingsSource) -> bool {
        self.settings = *settings;
        self.source = source;
        if Some(settings.plan) != self.plan {
            return false;
        }
        self.assembler.vref_v = settings.vref_v;
        self.episodes.set_reference(settings.vref_v);
        self.tracker.change(settings);
        true
    }

    /// Applies the settings that wait for the plan with this [`Plan::mark`]: the next conversions
    /// are of that plan. Anything open is closed; frame numbers and times continue, and the level
    /// without touch is measured again.
    // Not inlined: its addresses would be computed before each scan.
    #[inline(never)]
    pub fn begin(
        &mut self,
        mark: u32,
        ring: &mut Ring,
        diagnostics: &Diagnostics,
        outputs: &mut Outputs<'_>,
    ) {
        self.close(ring, diagnostics, outputs.emit, outputs.due);
        let plan = self.settings.plan;
        // By now another plan may have been requested, whose mark follows.
        self.plan = (plan.mark() == mark).then_some(plan);
        if self.plan.is_none() {
            return;
        }
        self.begin_plan(plan);
        (outputs.emit)(self.hello());
    }

    // Not inlined: the 3,250 bytes of the new state would add to the stack of every scan, and of
    // [`Self::close`].
    #[inline(never)]
    fn begin_plan(&mut self, plan: Plan) {
        let Self {
            settings,
            assembler,
            tracker,
            episodes,
            health_reporter,
            ..
        } = self;
        assembler.change(&plan);
        assembler.vref_v = settings.vref_v;
        episodes.set_reference(settings.vref_v);
        let (number, t_us) = tracker.clock.latest;
        health_reporter.change(&plan, number, t_us);
        tracker.begin(settings);
    }

    /// Settings in use, or waiting for their plan.
    pub const fn settings(&self) -> &Settings {
        &self.settings
    }

    /// Restarts detection as after power-up, or stops it; then only `health`, faults and raw frames
    /// are reported. Frame count and device time continue.
    pub fn restart(&mut self, is_going: bool) {
        self.tracker.restart(is_going, &self.settings);
    }

    /// Also reports the next `frames` frames raw.
    pub fn report_raw(&mut self, frames: u32) {
        self.tracker.raw_frames = frames;
    }
}
