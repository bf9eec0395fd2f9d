//! The line, the settings, and what was lost or faulty while the board was watched.

use super::observations::Lent;
use super::run::Run;
use super::verdict::{Judged, Verdict};
use crate::live::Counts;
use crate::names::name;
use ridgetone_proto::boot::SettingsSource;
use ridgetone_proto::fault::FaultKind;
use ridgetone_proto::telemetry::Health;
use serde_json::{Map, Value, json};

/// Name of the plan that is judged.
const DEFAULT: &str = "paper";

/// Passes if the board has its own plan again.
pub fn plan(run: &Run<'_>) -> Result<Judged, Judged> {
    let Lent { plan, failed } = run.lent()?;
    let own = plan.name().map_or_else(
        || "the board's own plan".to_owned(),
        |name| format!("plan `{name}`"),
    );
    let (verdict, finding) = match failed {
        None => (
            Verdict::Pass,
            format!("the board was checked with plan `{DEFAULT}`; {own} is in force again"),
        ),
        Some(why) => (
            Verdict::Fail,
            format!("{own} is not in force again, but `{DEFAULT}`: {why}"),
        ),
    };
    let values =
        json!({ "plan": plan.name(), "checked_with": DEFAULT, "restored": failed.is_none() });
    Ok(Judged::new(verdict, finding, values))
}

pub fn commands(run: &Run<'_>) -> Result<Judged, Judged> {
    let seen = run.seen;
    let sent = seen.exchanged.ok_or_else(|| Judged::skipped(seen.why()))?;
    // Between the first `health` and the one behind the last command.
    let grown = |count: fn(&Health) -> u32| {
        let (before, after) = (seen.health?, seen.watched.as_ref()?.before);
        Some(count(&after).wrapping_sub(count(&before)))
    };
    let damaged = grown(|health| health.requests_damaged);
    let overrun = grown(|health| health.bytes_overrun);
    let values = json!({
        "commands": sent.commands, "answered": sent.answered, "sends": sent.sends,
        "shortest_bytes": sent.shortest_bytes, "longest_bytes": sent.longest_bytes,
        "requests_damaged": damaged, "bytes_overrun": overrun,
    });
    let counted = match (damaged, overrun) {
        (Some(damaged), Some(overrun)) => {
            format!("{damaged} arrived damaged, {overrun} bytes overrun")
        }
        _ => seen.why().to_owned(),
    };
    let finding = format!(
        "{} of {} answered, {} to {} bytes, sent {} times; {counted}",
        sent.answered, sent.commands, sent.shortest_bytes, sent.longest_bytes, sent.sends
    );
    let fails = sent.answered < sent.commands || overrun.is_some_and(|bytes| bytes > 0);
    let verdict = Verdict::graded(damaged != Some(0), fails);
    Ok(Judged::new(verdict, finding, values))
}

pub fn settings(run: &Run<'_>) -> Result<Judged, Judged> {
    let seen = run.seen;
    let source = seen.hello.as_ref().map(|hello| hello.source);
    let was_damaged = matches!(
        source,
        Some(SettingsSource::Damaged | SettingsSource::StoredBefore)
    );
    let before = source.map_or_else(String::new, |source| format!("; before: {}", name(source)));
    let Some(kept) = &seen.kept else {
        return Err(if was_damaged {
            let finding = format!("what was stored last cannot be read{before}");
            Judged::new(Verdict::Warn, finding, json!({}))
        } else {
            Judged::skipped(seen.ended.as_deref().unwrap_or("not stored: --no-store"))
        });
    };
    let are_kept = kept.failed.is_none() && kept.found == kept.sent;
    let values = json!({
        "kept": are_kept, "restored": kept.not_restored.is_none(), "erased": kept.has_erased,
        "source_before": source.map(name),
    });
    let (verdict, finding) = match (&kept.not_restored, &kept.failed) {
        (Some(why), _) => (
            Verdict::Fail,
            format!("what was stored before is not restored: {why}"),
        ),
        (None, Some(why)) => (Verdict::Fail, format!("not stored: {why}")),
        (None, None) if !are_kept => (
            Verdict::Fail,
            "after a restart the stored settings are not in force".to_owned(),
        ),
        (None, None) if was_damaged => (
            Verdict::Warn,
            format!("stored, found after a restart, and stored anew{before}"),
        ),
        (None, None) => (
            Verdict::Pass,
            format!("stored, found after a restart, restored{before}"),
        ),
    };
    Ok(Judged::new(verdict, finding, values))
}

/// Judges what was lost while the board was watched.
pub fn losses(run: &Run<'_>) -> Result<Judged, Judged> {
    let watched = run.watched()?;
    let (before, after) = (&watched.before, &watched.after);
    let here = |count: fn(&Counts) -> u32| {
        count(&watched.counts_after).wrapping_sub(count(&watched.counts_before))
    };
    let there = |count: fn(&Health) -> u32| count(after).wrapping_sub(count(before));
    let lost = [
        ("packets_lost", here(|counts| counts.missing)),
        ("packets_damaged", here(|counts| counts.damaged)),
        ("packets_repeated", here(|counts| counts.stepped_back)),
        ("conversions_lost", there(|health| health.conversions_lost)),
        (
            "conversions_doubtful",
            there(|health| health.conversions_doubtful),
        ),
        ("messages_dropped", there(|health| health.messages_dropped)),
        ("overruns", there(|health| health.overruns)),
        ("restarts", u32::from(watched.has_restarted)),
    ];
    let words = |key: &str| match key {
        "packets_repeated" => "steps back of the packets' numbers".to_owned(),
        "restarts" => "restarts of the board".to_owned(),
        _ => key.replace('_', " "),
    };
    let (length_s, frames) = (watched.length_s(), there(|health| health.frames));
    let packets = watched.counts_after.received - watched.counts_before.received;
    let mut values: Map<String, Value> = lost
        .iter()
        .map(|(key, count)| ((*key).to_owned(), json!(count)))
        .collect();
    for (key, value) in [
        ("length_s", json!(length_s)),
        ("frames", json!(frames)),
        ("packets", json!(packets)),
        ("conversions_lost_before", json!(before.conversions_lost)),
    ] {
        values.insert(key.to_owned(), value);
    }
    let found = lost.iter().filter(|(_, count)| *count > 0);
    let named: Vec<String> = found
        .map(|(key, count)| format!("{count} {}", words(key)))
        .collect();
    let finding = match &named[..] {
        [] => format!("none in {length_s:.1} s: {packets} packets, {frames} frames"),
        named => format!("in {length_s:.1} s: {}", named.join(", ")),
    };
    let verdict = Verdict::graded(false, !named.is_empty());
    Ok(Judged::new(verdict, finding, values.into()))
}

/// Judges the faults that the board has counted, before and while it was watched.
pub fn faults(run: &Run<'_>) -> Result<Judged, Judged> {
    let watched = run.watched()?;
    let (before, after) = (&watched.before.faults, &watched.after.faults);
    let counted = |count: &dyn Fn(usize) -> u32| -> Vec<(&'static str, u32)> {
        let counts = FaultKind::ALL.map(|kind| (name(kind), count(kind as usize)));
        counts.into_iter().filter(|(_, count)| *count > 0).collect()
    };
    let within = counted(&|at| after[at].wrapping_sub(before[at]));
    let earlier = counted(&|at| before[at]);
    let list = |counts: &[(&str, u32)]| {
        let words = counts.iter().map(|(kind, count)| format!("{kind} {count}"));
        words.collect::<Vec<_>>().join(", ")
    };
    let map = |counts: &[(&str, u32)]| -> Map<String, Value> {
        let pairs = counts
            .iter()
            .map(|(kind, count)| ((*kind).to_owned(), json!(count)));
        pairs.collect()
    };
    let finding = match (within.is_empty(), earlier.is_empty()) {
        (false, _) => format!("while watched: {}", list(&within)),
        (true, false) => format!("none while watched; earlier: {}", list(&earlier)),
        (true, true) => "none since the start".to_owned(),
    };
    let verdict = Verdict::graded(!earlier.is_empty(), !within.is_empty());
    let values = json!({ "while_watched": map(&within), "earlier": map(&earlier) });
    Ok(Judged::new(verdict, finding, values))
}
