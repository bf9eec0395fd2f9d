//! The line, the settings, and what was lost or faulty while the board was watched.

use super::observations::{Lent, Observations, Watched};
use super::table::{Judged, Verdict, graded};
use crate::names::name;
use ridgetone_proto::boot::SettingsSource;
use ridgetone_proto::fault::FaultKind;
use ridgetone_proto::telemetry::Health;
use serde_json::{Map, Value, json};

/// Name of the plan that is judged.
const DEFAULT: &str = "paper";

/// Whether the board has its own plan again.
pub fn plan(Lent { plan, failed }: &Lent) -> Judged {
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
    Judged::new(verdict, finding, values)
}

pub fn commands(seen: &Observations) -> Judged {
    let Some(sent) = &seen.exchanged else {
        return Judged::skipped(seen.why());
    };
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
    Judged::new(graded(damaged != Some(0), fails), finding, values)
}

pub fn settings(seen: &Observations) -> Judged {
    let source = seen.hello.as_ref().map(|hello| hello.source);
    let was_damaged = matches!(
        source,
        Some(SettingsSource::Damaged | SettingsSource::StoredBefore)
    );
    let before = source.map_or_else(String::new, |source| format!("; before: {}", name(source)));
    let Some(kept) = &seen.kept else {
        return if was_damaged {
            let finding = format!("what was stored last cannot be read{before}");
            Judged::new(Verdict::Warn, finding, json!({}))
        } else {
            Judged::skipped(seen.ended.as_deref().unwrap_or("not stored: --no-store"))
        };
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
    Judged::new(verdict, finding, values)
}

/// Judges what was lost while the board was watched.
pub fn losses(watched: &Watched) -> Judged {
    let Watched {
        before,
        after,
        counts_before,
        counts_after,
        ..
    } = watched;
    let packets = |count: fn(&crate::live::Counts) -> u32| {
        count(counts_after).wrapping_sub(count(counts_before))
    };
    let reported = |count: fn(&Health) -> u32| count(after).wrapping_sub(count(before));
    let lost = [
        (
            "packets_lost",
            "packets lost",
            packets(|counts| counts.missing),
        ),
        (
            "packets_damaged",
            "packets damaged",
            packets(|counts| counts.damaged),
        ),
        (
            "packets_repeated",
            "steps back of the packets' numbers",
            packets(|counts| counts.stepped_back),
        ),
        (
            "conversions_lost",
            "conversions lost",
            reported(|health| health.conversions_lost),
        ),
        (
            "conversions_doubtful",
            "conversions doubtful",
            reported(|health| health.conversions_doubtful),
        ),
        (
            "messages_dropped",
            "messages dropped",
            reported(|health| health.messages_dropped),
        ),
        ("overruns", "overruns", reported(|health| health.overruns)),
        (
            "restarts",
            "restarts of the board",
            u32::from(watched.has_restarted),
        ),
    ];
    let (length_s, frames) = (watched.length_s(), reported(|health| health.frames));
    let packets = counts_after.received - counts_before.received;
    let mut values: Map<_, _> = lost
        .iter()
        .map(|(key, _, count)| ((*key).to_owned(), json!(count)))
        .collect();
    values.insert("length_s".into(), json!(length_s));
    values.insert("frames".into(), json!(frames));
    values.insert("packets".into(), json!(packets));
    values.insert(
        "conversions_lost_before".into(),
        json!(before.conversions_lost),
    );
    let named: Vec<String> = lost
        .iter()
        .filter(|(.., count)| *count > 0)
        .map(|(_, what, count)| format!("{count} {what}"))
        .collect();
    let finding = if named.is_empty() {
        format!("none in {length_s:.1} s: {packets} packets, {frames} frames")
    } else {
        format!("in {length_s:.1} s: {}", named.join(", "))
    };
    Judged::new(
        graded(false, !named.is_empty()),
        finding,
        Value::Object(values),
    )
}

/// Judges the faults that the board has counted, before and while it was watched.
pub fn faults(watched: &Watched) -> Judged {
    let count = |of: fn(&Watched, usize) -> u32| -> Vec<(&'static str, u32)> {
        let counts = FaultKind::ALL.map(|kind| (name(kind), of(watched, kind as usize)));
        counts.into_iter().filter(|(_, count)| *count > 0).collect()
    };
    let within =
        count(|watched, at| watched.after.faults[at].wrapping_sub(watched.before.faults[at]));
    let earlier = count(|watched, at| watched.before.faults[at]);
    let list = |counts: &[(&str, u32)]| {
        let words: Vec<_> = counts
            .iter()
            .map(|(kind, count)| format!("{kind} {count}"))
            .collect();
        words.join(", ")
    };
    let as_json = |counts: &[(&str, u32)]| -> Map<String, Value> {
        counts
            .iter()
            .map(|(kind, count)| ((*kind).to_owned(), json!(count)))
            .collect()
    };
    let values = json!({ "while_watched": as_json(&within), "earlier": as_json(&earlier) });
    let finding = if !within.is_empty() {
        format!("while watched: {}", list(&within))
    } else if !earlier.is_empty() {
        format!("none while watched; earlier: {}", list(&earlier))
    } else {
        "none since the start".to_owned()
    };
    Judged::new(
        graded(!earlier.is_empty(), !within.is_empty()),
        finding,
        values,
    )
}
