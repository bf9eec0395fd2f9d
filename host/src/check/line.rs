//! Checks the line, the settings, and losses and faults while the board was watched.

use super::observations::{Lent, Observations};
use super::verdict::{Outcome, Verdict, judged, skipped};
use crate::live::Counts;
use crate::names::name;
use ridgetone_proto::boot::SettingsSource;
use ridgetone_proto::fault::FaultKind;
use ridgetone_proto::telemetry::Health;
use serde_json::{Value, json};

use Verdict::{Fail, Pass, Warn};

/// Name of the plan by which boards are judged.
const DEFAULT: &str = "paper";

/// Passes if the board's own plan is in force again.
pub fn plan(seen: &Observations) -> Outcome {
    let Lent { plan, failed } = seen.need(&seen.lent)?;
    let own = plan.name().map(|name| format!("plan `{name}`"));
    let own = own.unwrap_or_else(|| "the board's own plan".to_owned());
    let finding = match failed {
        None => format!("the board was checked with plan `{DEFAULT}`; {own} is in force again"),
        Some(why) => format!("{own} is not in force again, but `{DEFAULT}`: {why}"),
    };
    let values =
        json!({ "plan": plan.name(), "checked_with": DEFAULT, "restored": failed.is_none() });
    Ok(judged(
        Verdict::graded(false, failed.is_some()),
        finding,
        values,
    ))
}

pub fn commands(seen: &Observations) -> Outcome {
    let sent = seen.need(&seen.exchanged)?;
    // Counts between the first `health` and the first one after the last command.
    let grown = |count: fn(&Health) -> u32| {
        let (before, after) = (seen.health.as_ref()?, &seen.watched.as_ref()?.before);
        Some(count(after).wrapping_sub(count(before)))
    };
    let damaged = grown(|health| health.requests_damaged);
    let overrun = grown(|health| health.bytes_overrun);
    let values = json!({
        "commands": sent.commands, "answered": sent.answered, "sends": sent.sends,
        "shortest_bytes": sent.shortest_bytes, "longest_bytes": sent.longest_bytes,
        "requests_damaged": damaged, "bytes_overrun": overrun,
    });
    let counted = damaged
        .zip(overrun)
        .map(|(damaged, overrun)| format!("{damaged} arrived damaged, {overrun} bytes overrun"));
    let finding = format!(
        "{} of {} answered, {} to {} bytes, sent {} times; {}",
        sent.answered,
        sent.commands,
        sent.shortest_bytes,
        sent.longest_bytes,
        sent.sends,
        counted.as_deref().unwrap_or(seen.why())
    );
    let fails = sent.answered < sent.commands || overrun.is_some_and(|bytes| bytes > 0);
    Ok(judged(
        Verdict::graded(damaged != Some(0), fails),
        finding,
        values,
    ))
}

pub fn settings(seen: &Observations) -> Outcome {
    use SettingsSource::{Damaged, StoredBefore};
    let source = seen.hello.as_ref().map(|hello| hello.source);
    let was_damaged = matches!(source, Some(Damaged | StoredBefore));
    let before = source.map_or_else(String::new, |source| format!("; before: {}", name(source)));
    let Some(kept) = &seen.kept else {
        let finding = format!("what was stored last cannot be read{before}");
        return Err(match was_damaged {
            true => judged(Warn, finding, json!({})),
            false => skipped(seen.ended.as_deref().unwrap_or("not stored: --no-store")),
        });
    };
    let are_kept = kept.failed.is_none() && kept.found == kept.sent;
    let values = json!({
        "kept": are_kept, "restored": kept.not_restored.is_none(), "erased": kept.has_erased,
        "source_before": source.map(name),
    });
    let (verdict, finding) = match (&kept.not_restored, &kept.failed) {
        (Some(why), _) => (
            Fail,
            format!("what was stored before is not restored: {why}"),
        ),
        (None, Some(why)) => (Fail, format!("not stored: {why}")),
        _ if !are_kept => (
            Fail,
            "after a restart the stored settings are not in force".into(),
        ),
        _ if was_damaged => (
            Warn,
            format!("stored, found after a restart, and stored anew{before}"),
        ),
        _ => (
            Pass,
            format!("stored, found after a restart, restored{before}"),
        ),
    };
    Ok(judged(verdict, finding, values))
}

/// Judges what was lost while the board was watched.
pub fn losses(seen: &Observations) -> Outcome {
    let watched = seen.need(&seen.watched)?;
    let (before, after) = (&watched.before, &watched.after);
    let here = |count: fn(&Counts) -> u32| {
        count(&watched.counts_after).wrapping_sub(count(&watched.counts_before))
    };
    let there = |count: fn(&Health) -> u32| count(after).wrapping_sub(count(before));
    let (length_s, frames) = (watched.length_s(), there(|health| health.frames));
    let packets = watched.counts_after.received - watched.counts_before.received;
    let mut values = json!({});
    let mut named = Vec::new();
    for (key, words, count) in [
        ("packets_lost", "packets lost", here(|c| c.missing)),
        ("packets_damaged", "packets damaged", here(|c| c.damaged)),
        (
            "packets_repeated",
            "steps back of the packets' numbers",
            here(|c| c.stepped_back),
        ),
        (
            "conversions_lost",
            "conversions lost",
            there(|h| h.conversions_lost),
        ),
        (
            "conversions_doubtful",
            "conversions doubtful",
            there(|h| h.conversions_doubtful),
        ),
        (
            "messages_dropped",
            "messages dropped",
            there(|h| h.messages_dropped),
        ),
        ("overruns", "overruns", there(|h| h.overruns)),
        (
            "restarts",
            "restarts of the board",
            watched.has_restarted.into(),
        ),
    ] {
        values[key] = json!(count);
        named.extend((count > 0).then(|| format!("{count} {words}")));
    }
    values["length_s"] = json!(length_s);
    values["frames"] = json!(frames);
    values["packets"] = json!(packets);
    values["conversions_lost_before"] = json!(before.conversions_lost);
    let finding = match &named[..] {
        [] => format!("none in {length_s:.1} s: {packets} packets, {frames} frames"),
        named => format!("in {length_s:.1} s: {}", named.join(", ")),
    };
    Ok(judged(
        Verdict::graded(false, !named.is_empty()),
        finding,
        values,
    ))
}

/// Judges the faults that the board has counted, before and while it was watched.
pub fn faults(seen: &Observations) -> Outcome {
    let watched = seen.need(&seen.watched)?;
    let (before, after) = (&watched.before.faults, &watched.after.faults);
    let (mut within, mut earlier) = (Vec::new(), Vec::new());
    for kind in FaultKind::ALL {
        let (before, after) = (before[kind as usize], after[kind as usize]);
        for (counts, count) in [
            (&mut earlier, before),
            (&mut within, after.wrapping_sub(before)),
        ] {
            counts.extend((count > 0).then(|| (name(kind), count)));
        }
    }
    let list = |counts: &[(&str, u32)]| {
        let words = counts.iter().map(|(kind, count)| format!("{kind} {count}"));
        words.collect::<Vec<_>>().join(", ")
    };
    let map = |counts: &[(&str, u32)]| {
        let pairs = counts
            .iter()
            .map(|(kind, count)| ((*kind).to_owned(), json!(count)));
        Value::Object(pairs.collect())
    };
    let finding = match (within.is_empty(), earlier.is_empty()) {
        (false, _) => format!("while watched: {}", list(&within)),
        (true, false) => format!("none while watched; earlier: {}", list(&earlier)),
        (true, true) => "none since the start".to_owned(),
    };
    let verdict = Verdict::graded(!earlier.is_empty(), !within.is_empty());
    Ok(judged(
        verdict,
        finding,
        json!({ "while_watched": map(&within), "earlier": map(&earlier) }),
    ))
}
