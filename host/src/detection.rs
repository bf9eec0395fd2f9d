//! Touch detection alone over an input: contacts and slides, without any fit.

use crate::input::Opened;
use crate::output::Progress;
use crate::replay::conversions_of;
use crate::stop;
use anyhow::{Result, bail, ensure};
use ridgetone_finger::{Detector, Diagnostics, Outputs, Ring};
use ridgetone_proto::settings::{Settings, Slide, SlideRule};
use ridgetone_proto::telemetry::Event;
use std::cell::Cell;
use std::ops::ControlFlow;

/// Conversions between two reports of progress.
const PROGRESS_EVERY: u64 = 2048;

/// Gives `take` the events of an input until it breaks.
pub fn run(
    input: Opened,
    settings: &Settings,
    take: &mut dyn FnMut(Event) -> ControlFlow<()>,
) -> Result<()> {
    let mut detector = Box::new(Detector::new(*settings));
    let (mut ring, diagnostics) = (Box::new(Ring::new()), Diagnostics::new());
    let is_over = Cell::new(false);
    let mut emit = |event| is_over.set(is_over.get() || take(event).is_break());
    let (mut progress, mut count, end_s) = (Progress::default(), 0u64, input.end_s);
    let conversion_s = f64::from(settings.plan.conversion_ns()) * 1e-9;
    let whole = conversions_of(input, &settings.plan, &mut |timed| {
        ensure!(!stop::is_requested(), "interrupted");
        let outputs = &mut Outputs {
            emit: &mut emit,
            due: &mut |_| {},
        };
        detector.push(timed, &mut ring, &diagnostics, outputs);
        count += 1;
        if count.is_multiple_of(PROGRESS_EVERY) {
            let done_s = count as f64 * conversion_s;
            progress.show(format_args!(
                "looking for a touch: {done_s:.1} of {end_s:.1} s"
            ));
        }
        if is_over.get() {
            bail!("what follows is not needed");
        }
        Ok(())
    });
    progress.end();
    if is_over.get() {
        return Ok(());
    }
    whole?;
    detector.finish(&mut ring, &diagnostics, &mut emit, &mut |_| {});
    Ok(())
}

/// The settings for an input: where no finger touches, all of it is a slide. What the converter
/// would clip is left as it is: nobody knows what touches in it.
pub fn settings_for(input: Opened, settings: Settings) -> Result<Settings> {
    let is_always = settings.slide.rule == SlideRule::Always;
    if is_always || input.warning.is_some() || has_touch(input, &settings)? {
        return Ok(settings);
    }
    // Only a protocol's speed is that of this input.
    let speed_mm_s = match settings.slide.rule {
        SlideRule::Protocol => settings.slide.speed_mm_s,
        _ => 0.0,
    };
    let slide = Slide {
        rule: SlideRule::Always,
        speed_mm_s,
        ..settings.slide
    };
    Ok(Settings { slide, ..settings })
}

/// What to say where [`settings_for`] has changed the rule.
pub const ALWAYS: &str = "no finger touches: all of it is taken as a slide (slide.rule = always)";

/// Whether an input has a contact or a slide.
fn has_touch(input: Opened, settings: &Settings) -> Result<bool> {
    let mut is_found = false;
    run(input, settings, &mut |event| {
        if matches!(event, Event::Contact(_) | Event::Slide(_)) {
            is_found = true;
            return ControlFlow::Break(());
        }
        ControlFlow::Continue(())
    })?;
    Ok(is_found)
}
