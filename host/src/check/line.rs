//! The line, the settings, and what was lost or faulty while the board was watched.

use super::observations::{Lent, Observations, Watched};
use super::verdict::{Check, PLANS, TELEMETRY, TROUBLESHOOTING, Verdict, graded};
use crate::names::name;
use ridgetone_proto::boot::SettingsSource;
use ridgetone_proto::fault::FaultKind;
use serde_json::json;

/// Name of the plan that is judged.
const DEFAULT: &str = "paper";

pub fn checks(seen: &Observations) -> Vec<Check> {
    let mut checks = vec![commands(seen), settings(seen), losses(seen), faults(seen)];
    checks.extend(seen.lent.as_ref().map(plan));
    checks
}

/// Whether the board has its own plan again. It is checked with the default plan, which may be
/// another one.
fn plan(Lent { plan, failed }: &Lent) -> Check {
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
    Check::new("plan", PLANS, verdict, finding, values)
}

fn commands(seen: &Observations) -> Check {
    let Some(exchanged) = &seen.exchanged else {
        return Check::skipped("commands", TROUBLESHOOTING, seen.why());
    };
    // Between the first `health` and the one behind the last command.
    let grown = |count: fn(&ridgetone_proto::telemetry::Health) -> u32| {
        let (before, after) = (seen.health?, seen.watched.as_ref()?.before);
        Some(count(&after).wrapping_sub(count(&before)))
    };
    let damaged = grown(|health| health.requests_damaged);
    let overrun = grown(|health| health.bytes_overrun);
    let values = json!({
        "commands": exchanged.commands, "answered": exchanged.answered, "sends": exchanged.sends,
        "shortest_bytes": exchanged.shortest_bytes, "longest_bytes": exchanged.longest_bytes,
        "requests_damaged": damaged, "bytes_overrun": overrun,
    });
    let mut finding = format!(
        "{} of {} answered, {} to {} bytes, sent {} times",
        exchanged.answered,
        exchanged.commands,
        exchanged.shortest_bytes,
        exchanged.longest_bytes,
        exchanged.sends
    );
    if let (Some(damaged), Some(overrun)) = (damaged, overrun) {
        finding += &format!("; {damaged} arrived damaged, {overrun} bytes overrun");
    } else {
        finding += &format!("; {}", seen.why());
    }
    let fails = exchanged.answered < exchanged.commands || overrun.is_some_and(|bytes| bytes > 0);
    let warns = damaged.is_none_or(|requests| requests > 0);
    Check::new(
        "commands",
        TROUBLESHOOTING,
        graded(warns, fails),
        finding,
        values,
    )
}

fn settings(seen: &Observations) -> Check {
    let source = seen.hello.as_ref().map(|hello| hello.source);
    let was_damaged = matches!(
        source,
        Some(SettingsSource::Damaged | SettingsSource::StoredBefore)
    );
    let before = source.map_or_else(String::new, |source| format!("; before: {}", name(source)));
    let check = |verdict, finding, values| {
        Check::new("settings", TROUBLESHOOTING, verdict, finding, values)
    };
    let Some(kept) = &seen.kept else {
        return match was_damaged {
            true => check(
                Verdict::Warn,
                format!("what was stored last cannot be read{before}"),
                json!({}),
            ),
            false => Check::skipped(
                "settings",
                TELEMETRY,
                seen.ended
                    .clone()
                    .unwrap_or_else(|| "not stored: --no-store".into()),
            ),
        };
    };
    let are_kept = kept.failed.is_none() && kept.found == kept.sent;
    let values = json!({
        "kept": are_kept, "restored": kept.not_restored.is_none(), "erased": kept.has_erased,
        "source_before": source.map(name),
    });
    let problem = match (&kept.not_restored, &kept.failed) {
        (Some(why), _) => format!("what was stored before is not restored: {why}"),
        (None, Some(why)) => format!("not stored: {why}"),
        (None, None) if !are_kept => {
            "after a restart the stored settings are not in force".to_owned()
        }
        (None, None) if was_damaged => {
            format!("stored, found after a restart, and stored anew{before}")
        }
        (None, None) => {
            return check(
                Verdict::Pass,
                format!("stored, found after a restart, restored{before}"),
                values,
            );
        }
    };
    let fails = kept.not_restored.is_some() || !are_kept;
    check(graded(true, fails), problem, values)
}

/// What was lost while the board was watched.
fn lost(watched: &Watched) -> [(&'static str, &'static str, u32); 8] {
    let Watched {
        before,
        after,
        counts_before,
        counts_after,
        ..
    } = watched;
    let grown = |after: u32, before: u32| after.wrapping_sub(before);
    [
        (
            "packets_lost",
            "packets lost",
            grown(counts_after.missing, counts_before.missing),
        ),
        (
            "packets_damaged",
            "packets damaged",
            grown(counts_after.damaged, counts_before.damaged),
        ),
        (
            "packets_repeated",
            "steps back of the packets' numbers",
            grown(counts_after.stepped_back, counts_before.stepped_back),
        ),
        (
            "conversions_lost",
            "conversions lost",
            grown(after.conversions_lost, before.conversions_lost),
        ),
        (
            "conversions_doubtful",
            "conversions doubtful",
            grown(after.conversions_doubtful, before.conversions_doubtful),
        ),
        (
            "messages_dropped",
            "messages dropped",
            grown(after.messages_dropped, before.messages_dropped),
        ),
        (
            "hops_skipped",
            "hops skipped",
            grown(after.hops_skipped, before.hops_skipped),
        ),
        (
            "restarts",
            "restarts of the board",
            u32::from(watched.has_restarted),
        ),
    ]
}

fn losses(seen: &Observations) -> Check {
    let Some(watched) = &seen.watched else {
        return Check::skipped("losses", TROUBLESHOOTING, seen.why());
    };
    let (lost, length_s) = (lost(watched), watched.length_s());
    let frames = watched.after.frames.wrapping_sub(watched.before.frames);
    let packets = watched.counts_after.received - watched.counts_before.received;
    let mut values: serde_json::Map<_, _> = lost
        .iter()
        .map(|(key, _, count)| ((*key).to_owned(), json!(count)))
        .collect();
    values.insert("length_s".into(), json!(length_s));
    values.insert("frames".into(), json!(frames));
    values.insert("packets".into(), json!(packets));
    values.insert(
        "conversions_lost_before".into(),
        json!(watched.before.conversions_lost),
    );
    let named: Vec<String> = lost
        .iter()
        .filter(|(.., count)| *count > 0)
        .map(|(_, what, count)| format!("{count} {what}"))
        .collect();
    let finding = match named.as_slice() {
        [] => format!("none in {length_s:.1} s: {packets} packets, {frames} frames"),
        named => format!("in {length_s:.1} s: {}", named.join(", ")),
    };
    Check::new(
        "losses",
        TROUBLESHOOTING,
        graded(false, !named.is_empty()),
        finding,
        values.into(),
    )
}

fn faults(seen: &Observations) -> Check {
    let Some(watched) = &seen.watched else {
        return Check::skipped("faults", TROUBLESHOOTING, seen.why());
    };
    let counts = FaultKind::ALL.map(|kind| {
        let at = kind as usize;
        (
            name(kind),
            watched.after.faults[at].wrapping_sub(watched.before.faults[at]),
            watched.before.faults[at],
        )
    });
    let list = |counts: Vec<(&str, u32)>| {
        counts
            .iter()
            .map(|(kind, count)| format!("{kind} {count}"))
            .collect::<Vec<_>>()
            .join(", ")
    };
    let within: Vec<_> = counts
        .iter()
        .map(|(kind, within, _)| (*kind, *within))
        .filter(|(_, count)| *count > 0)
        .collect();
    let earlier: Vec<_> = counts
        .iter()
        .map(|(kind, _, before)| (*kind, *before))
        .filter(|(_, count)| *count > 0)
        .collect();
    let as_json = |counts: &[(&str, u32)]| -> serde_json::Value {
        counts
            .iter()
            .map(|(kind, count)| ((*kind).to_owned(), json!(count)))
            .collect::<serde_json::Map<_, _>>()
            .into()
    };
    let values = json!({ "while_watched": as_json(&within), "earlier": as_json(&earlier) });
    let verdict = graded(!earlier.is_empty(), !within.is_empty());
    let finding = match (within.is_empty(), earlier.is_empty()) {
        (true, true) => "none since the start".to_owned(),
        (true, false) => format!("none while watched; earlier: {}", list(earlier)),
        (false, _) => format!("while watched: {}", list(within)),
    };
    Check::new("faults", TROUBLESHOOTING, verdict, finding, values)
}
