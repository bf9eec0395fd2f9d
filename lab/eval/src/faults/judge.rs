//! Judges a run: compares telemetry with the state of the simulated chip, for each fault.

use super::counts::Counts;
use super::family::Family;
use super::plan::{Plan, RECOVERY_S};
use super::task_sim::Ran;
use ads1258::Channel;
use hal_mock::{Fault, Injected, Truth};
use ridgetone_proto::fault::FaultKind;
use ridgetone_proto::telemetry::{Estimate, Event, Health, Status};

/// A frequency is wrong if it is off by more than five of its standard deviations and by more than
/// half a percent.
const SIGMAS: f64 = 5.0;
const TOLERANCE: f64 = 0.005;

/// Start of the complaint that a fault was not reported.
pub const NOT_REPORTED: &str = "not reported";

/// End of the complaint about conversions that arrived altered.
pub const ALTERED: &str = "differ from the chip's";

/// Maximum time by which an episode may start before the injection, nanoseconds: two conversions,
/// which is the tolerance of device time.
const SLACK_NS: u64 = 400_000;

/// Time within which the half-second check finds a changed register that conversions do not reveal,
/// nanoseconds. Includes the wait for a conversion.
const CHECK_NS: u64 = 510_000_000;

/// Time within which a bit error in one of the next two reads arrives, nanoseconds.
const BIT_ERROR_NS: u64 = 1_000_000;
/// Maximum time from the start of a reading's conversion to its arrival, nanoseconds.
const READING_NS: u64 = 200_000;
/// Supply voltage below which the chip sets SUPPLY in every status, volts (SBAS297G: 4.3 V).
const SUPPLY_BIT_V: f64 = 4.3;

#[derive(Clone, Copy, Debug, Default)]
pub struct Fate {
    /// Time from the start of the fault to the report, seconds of device time; `None` if there was
    /// no report.
    pub detected_s: Option<f64>,
    /// True if there was no report, and the firmware could see no change except in codes.
    pub is_unseen: bool,
    /// Time from the end of the fault to the end of the next complete scan with correct registers,
    /// seconds; `None` if there was none.
    pub recovered_s: Option<f64>,
}

#[derive(Clone, Debug, Default)]
pub struct Judgement {
    pub fates: Vec<Fate>,
    pub counts: Counts,
    pub complaints: Vec<String>,
}

/// Reported episode of a kind of fault, with times in nanoseconds of the simulation.
struct Episode {
    kind: FaultKind,
    from_ns: u64,
    /// `None` if the fault lasted until the end of the run.
    until_ns: Option<u64>,
}

pub fn judge(plan: &Plan, truth: &Truth, ran: &Ran) -> Judgement {
    let mut judgement = Judgement::default();
    let mut health = Health::default();
    for packet in &ran.packets {
        match &packet.event {
            Event::Estimate(estimate) => judge_estimate(plan, estimate, truth, &mut judgement),
            Event::Health(latest) => health = *latest,
            _ => {}
        }
    }
    judge_conversions(plan, ran, &health, &mut judgement);
    let episodes = episodes(ran);
    if plan.injections.is_empty() {
        judgement.counts.false_alarms = episodes.len() as u64;
        for Episode { kind, from_ns, .. } in &episodes {
            let from_s = from_ns.saturating_sub(ran.zero_ns) as f64 * 1e-9;
            judgement
                .complaints
                .push(format!("false alarm: {kind:?} at {from_s:.3} s"));
        }
    }
    if plan.injections.is_empty() {
        judge_control(ran, &mut judgement);
    }
    if !ran.registers_right {
        judgement.counts.wrong_registers = 1;
        judgement
            .complaints
            .push("the registers are wrong at the end".into());
    }
    judge_telemetry(ran, &health, &mut judgement);
    for number in 0..ran.injected.len() {
        let Some(fate) = fate(plan, ran, &episodes, number) else {
            continue;
        };
        if fate.detected_s.is_none() && !fate.is_unseen {
            let injection = plan
                .injections
                .get(number)
                .map(|injection| (injection.at_s, injection.fault, injection.lasts_s));
            judgement
                .complaints
                .push(format!("{NOT_REPORTED}: {injection:?}"));
        }
        if !fate
            .recovered_s
            .is_some_and(|after_s| after_s <= RECOVERY_S)
        {
            judgement.counts.not_recovered += 1;
            let injection = plan.injections.get(number);
            judgement.complaints.push(format!(
                "not set up again within {RECOVERY_S} s: {injection:?}"
            ));
        }
        judgement.fates.push(fate);
    }
    judgement
}

/// Without a fault there must be estimates, and they must be good.
fn judge_control(ran: &Ran, judgement: &mut Judgement) {
    let mut estimates = 0;
    for packet in &ran.packets {
        let Event::Estimate(estimate) = &packet.event else {
            continue;
        };
        estimates += 1;
        let (is_good, has_faults) = (estimate.status == Status::Good, !estimate.faults.is_none());
        if estimate.status == Status::Doubtful || has_faults {
            judgement.counts.not_good += 1;
        } else if !is_good {
            judgement.counts.not_plain += 1;
        }
        if !is_good || has_faults {
            let at_s = estimate.t_us as f64 * 1e-6;
            judgement.complaints.push(format!(
                "not good without a fault: {:?} at {at_s:.3} s",
                estimate.status
            ));
        }
    }
    if estimates == 0 {
        judgement.counts.not_good += 1;
        judgement
            .complaints
            .push("no estimate, though without a fault".into());
    }
}

/// These runs have a lossless line, so the lost packets must be exactly those that the board
/// reports as dropped.
fn judge_telemetry(ran: &Ran, health: &Health, judgement: &mut Judgement) {
    let (lost, damaged) = ran.line;
    let unreported = lost.abs_diff(health.messages_dropped) + damaged;
    judgement.counts.packets_unreported = unreported.into();
    if unreported > 0 {
        judgement.complaints.push(format!(
            "telemetry: {lost} packets lost, {} reported as dropped, {damaged} damaged",
            health.messages_dropped
        ));
    }
}

fn episodes(ran: &Ran) -> Vec<Episode> {
    let to_ns = |device_us: u64| ran.zero_ns + device_us * 1000;
    let mut episodes = Vec::<Episode>::new();
    for packet in &ran.packets {
        let Event::Fault(fault) = &packet.event else {
            continue;
        };
        match fault.until_us {
            None => episodes.push(Episode {
                kind: fault.kind,
                from_ns: to_ns(fault.from_us),
                until_ns: None,
            }),
            Some(until_us) => {
                if let Some(open) = episodes
                    .iter_mut()
                    .rev()
                    .find(|episode| episode.kind == fault.kind)
                {
                    open.until_ns = Some(to_ns(until_us));
                }
            }
        }
    }
    episodes
}

/// Returns the fate of an injection, or `None` if it did not take effect.
fn fate(plan: &Plan, ran: &Ran, episodes: &[Episode], number: usize) -> Option<Fate> {
    let Injected {
        begun_ns: Some(begun_ns),
        over_ns,
    } = *ran.injected.get(number)?
    else {
        return None;
    };
    let next_ns = ran
        .injected
        .get(number + 1)
        .and_then(|next| next.begun_ns)
        .unwrap_or(ran.end_ns);
    let over_ns = over_ns.unwrap_or(begun_ns).max(begun_ns);
    // In a mixed run, the next injection may take effect before the check.
    let is_flip = plan
        .injections
        .get(number)
        .is_some_and(|one| matches!(one.fault, Fault::RegisterFlip { .. }));
    let reported = episodes.iter().filter(|episode| {
        // In a mixed run, the previous injection's episode may still last.
        let seen_since = episode
            .until_ns
            .is_none_or(|until_ns| until_ns + SLACK_NS >= begun_ns);
        let by_check = is_flip
            && episode.kind == FaultKind::Registers
            && episode.from_ns < begun_ns + CHECK_NS;
        plan.family.expects(episode.kind, plan.scan.is_read_twice())
            && (episode.from_ns < next_ns || by_check)
            && seen_since
    });
    let detected_s = reported
        .map(|episode| episode.from_ns.saturating_sub(begun_ns) as f64 * 1e-9)
        .reduce(f64::min);
    let whole_ns = ran.whole_ns.iter().find(|whole_ns| **whole_ns > over_ns);
    Some(Fate {
        detected_s,
        is_unseen: detected_s.is_none()
            && leaves_no_sign(plan.injections[number].fault, begun_ns, over_ns, ran),
        recovered_s: whole_ns.map(|whole_ns| (whole_ns - over_ns) as f64 * 1e-9),
    })
}

/// True if ids, statuses and times show no sign of the fault: it changed only a code that was read
/// once, or it changed the reference or (above the chip's own limit) the supply only between two
/// readings.
fn leaves_no_sign(fault: Fault, begun_ns: u64, over_ns: u64, ran: &Ran) -> bool {
    let has_no_reading = |reading| {
        // A reading that only partly overlaps the fault may be right.
        let within = begun_ns + READING_NS..=over_ns;
        !ran.readings_ns
            .iter()
            .any(|(read, at_ns)| *read == reading && within.contains(at_ns))
    };
    match fault {
        Fault::DoutFlip { .. } | Fault::DinFlip { .. } => ran
            .unseen_ns
            .iter()
            .any(|at_ns| (begun_ns..begun_ns + BIT_ERROR_NS).contains(at_ns)),
        Fault::Supply { volts } => volts >= SUPPLY_BIT_V && has_no_reading(Channel::Vcc),
        Fault::Reference { .. } => has_no_reading(Channel::Ref),
        _ => false,
    }
}

fn judge_conversions(plan: &Plan, ran: &Ran, health: &Health, judgement: &mut Judgement) {
    let (made, taken, lost) = (
        ran.chip.conversions,
        ran.delivered,
        u64::from(health.conversions_lost),
    );
    let counts = &mut judgement.counts;
    counts.silent = made.saturating_sub(taken + lost);
    counts.excess = (taken + lost).saturating_sub(made);
    counts.altered = ran.altered;
    if counts.silent > 0 || counts.excess > 0 && plan.family.loss_is_known() {
        judgement.complaints.push(format!(
            "{made} conversions made, {taken} taken, {lost} reported as lost"
        ));
    }
    if ran.altered > 0 {
        judgement
            .complaints
            .push(format!("{} conversions {ALTERED}", ran.altered));
    }
}

fn judge_estimate(plan: &Plan, estimate: &Estimate, truth: &Truth, judgement: &mut Judgement) {
    // If a window includes the slide's end, its frequency may be the mean including the standstill,
    // the tone's, or any value in between, because the fit tracks a stopping phase only roughly.
    let until_s = estimate.t_us as f64 * 1e-6;
    let still_s = (until_s - truth.slide_end_s).clamp(0.0, f64::from(estimate.window_s));
    let min_hz = truth.frequency_hz * (1.0 - still_s / f64::from(estimate.window_s));
    let frequency_hz = f64::from(estimate.frequency);
    let off_hz = (frequency_hz - frequency_hz.clamp(min_hz, truth.frequency_hz)).abs();
    let is_off = off_hz > SIGMAS * f64::from(estimate.sigma);
    // The oscillator's error exceeds any sigma, so no estimate may be good.
    let is_never_good = plan.family == Family::Oscillator;
    let is_wrong = is_never_good || is_off && off_hz > TOLERANCE * truth.frequency_hz;
    let counts = &mut judgement.counts;
    if estimate.status != Status::Good {
        counts.doubtful += u64::from(estimate.status == Status::Doubtful);
        return;
    }
    let (good, wrong) = match estimate.faults.is_none() {
        true => (&mut counts.good, &mut counts.wrong),
        false => (&mut counts.good_with_faults, &mut counts.wrong_with_faults),
    };
    *good += 1;
    *wrong += u64::from(is_wrong);
    counts.off += u64::from(is_off && !is_wrong);
    if is_wrong {
        judgement.complaints.push(format!(
            "wrong at {:.3} s: {} +- {} Hz in place of {} Hz, {:?} of {} s, {} frames missing, faults {:?}",
            estimate.t_us as f64 * 1e-6,
            estimate.frequency,
            estimate.sigma,
            truth.frequency_hz,
            estimate.span,
            estimate.window_s,
            estimate.frames_missing,
            estimate.faults.iter().collect::<Vec<_>>()
        ));
    }
}

#[cfg(test)]
mod tests {
    use super::super::row::{Place, Row};
    use super::super::task_sim;
    use super::*;
    use ridgetone_proto::plan::Plan as Scan;

    /// Returns the failures of a run after `change` has modified its results.
    fn failures(plan: &Plan, ran: &Ran, change: fn(&mut Ran)) -> Vec<String> {
        let (_, truth) = plan.open().expect("a scene");
        let mut ran = ran.clone();
        change(&mut ran);
        let judgement = judge(plan, &truth, &ran);
        Row::of_family(plan.family, Place::Pc, &[(plan.seed, judgement)]).failures()
    }

    #[test]
    fn what_is_owed_after_a_fault_is_judged() {
        let plan = Plan::new(Family::Reset, 1, 1.0, Scan::PAPER);
        let (input, _) = plan.open().expect("a scene");
        let ran = task_sim::run(input, plan.settings(), plan.boot()).expect("a run");
        let injected = plan.injections.len();
        assert_eq!(failures(&plan, &ran, |_| {}), [""; 0]);
        let never = failures(&plan, &ran, |ran| ran.whole_ns.clear());
        assert_eq!(never, [format!("not_recovered {injected}")]);
        let late = failures(&plan, &ran, |ran| {
            let last_ns = ran.injected.last().and_then(|last| last.begun_ns);
            let late_ns = last_ns.expect("a reset") + 5_100_000_000;
            ran.whole_ns.retain(|whole_ns| *whole_ns > late_ns);
        });
        assert_eq!(late, [format!("not_recovered {injected}")]);
        let wrong = failures(&plan, &ran, |ran| ran.registers_right = false);
        assert_eq!(wrong, ["wrong_registers 1"]);
        let lost = failures(&plan, &ran, |ran| ran.line = (2, 1));
        assert_eq!(lost, ["packets_unreported 3"]);
        let reported = failures(&plan, &ran, |ran| {
            ran.line = (2, 0);
            for packet in &mut ran.packets {
                if let Event::Health(health) = &mut packet.event {
                    health.messages_dropped = 2;
                }
            }
        });
        assert_eq!(reported, [""; 0]);
    }

    #[test]
    fn a_control_run_owes_good_estimates() {
        let plan = Plan::new(Family::None, 1, 1.0, Scan::PAPER);
        let (input, _) = plan.open().expect("a scene");
        let ran = task_sim::run(input, plan.settings(), plan.boot()).expect("a run");
        assert_eq!(failures(&plan, &ran, |_| {}), [""; 0]);
        let doubtful = failures(&plan, &ran, |ran| {
            let estimate = ran
                .packets
                .iter_mut()
                .find_map(|packet| match &mut packet.event {
                    Event::Estimate(estimate) => Some(estimate),
                    _ => None,
                });
            estimate.expect("an estimate").status = Status::Doubtful;
        });
        assert_eq!(doubtful, ["not_good 1"]);
        let unsteady = failures(&plan, &ran, |ran| {
            for packet in &mut ran.packets {
                if let Event::Estimate(estimate) = &mut packet.event {
                    estimate.status = Status::Unsteady;
                }
            }
        });
        assert!(unsteady[0].starts_with("not_plain "), "{unsteady:?}");
        let none = failures(&plan, &ran, |ran| {
            ran.packets
                .retain(|packet| !matches!(packet.event, Event::Estimate(_)));
        });
        assert_eq!(none, ["not_good 1"]);
    }
}
