//! What a run showed, fault for fault.

use super::plan::Plan;
use super::task_sim::Ran;
use hal_mock::{Injected, Truth};
use ridgetone_proto::fault::FaultKind;
use ridgetone_proto::telemetry::{Estimate, Event, Health, Status};

/// A frequency is wrong if it is off by more than so many of its standard deviations, and by more than this share.
const SIGMAS: f64 = 5.0;
const SHARE: f64 = 0.005;

/// How the complaint begins that a fault was not told.
pub const NOT_TOLD: &str = "not told";

/// Earlier than an injection acted, nanoseconds: two conversions, by which device time may be stamped otherwise.
const SLACK_NS: u64 = 400_000;

/// What became of one injection.
#[derive(Clone, Copy, Debug, Default)]
pub struct Fate {
    /// From its beginning until the firmware noticed it, seconds of device time; none if it was not told.
    pub detected_s: Option<f64>,
    /// From its end until the next scan without a flaw was through, with the registers right, seconds; none if none came
    /// before the next injection.
    pub recovered_s: Option<f64>,
}

/// What a run showed.
#[derive(Clone, Debug, Default)]
pub struct Judgement {
    /// Of each injection that acted.
    pub fates: Vec<Fate>,
    /// Bouts told of kinds that nothing injected explains: in a run without injections any.
    pub false_alarms: u32,
    /// Estimates that said good, without doubts, and were wrong.
    pub wrong: u32,
    /// Estimates that said good, but with doubts, and were wrong.
    pub wrong_with_doubts: u32,
    /// Estimates that said good, without doubts.
    pub good: u32,
    /// Estimates that said good, but with doubts.
    pub good_with_doubts: u32,
    /// Estimates that said doubtful.
    pub doubtful: u32,
    /// Estimates that said good, with doubts or without, and are off by more than so many of their standard deviations, but
    /// by too small a share to be wrong.
    pub off: u32,
    /// Conversions that the chip made, less those that were taken, less those that telemetry calls lost.
    pub silent: u64,
    /// Conversions that telemetry calls lost beyond those that the chip made and that were not taken.
    pub excess: u64,
    /// Conversions taken that are not what the chip converted.
    pub altered: u64,
    /// What is wrong with the run as a whole.
    pub complaints: Vec<String>,
}

/// A bout of a kind as it was told, nanoseconds of the rig.
struct Bout {
    kind: FaultKind,
    from_ns: u64,
    /// Seen last; none if it was not over at the end.
    until_ns: Option<u64>,
}

/// Judges a run.
pub fn judge(plan: &Plan, truth: &Truth, ran: &Ran) -> Judgement {
    let rig_ns = |device_us: u64| ran.zero_ns + device_us * 1000;
    let mut verdict = Judgement { altered: ran.altered, ..Judgement::default() };
    let (mut episodes, mut health) = (Vec::<Bout>::new(), Health::default());
    for packet in &ran.packets {
        match &packet.event {
            Event::Fault(fault) => match fault.until_us {
                None => episodes.push(Bout { kind: fault.kind, from_ns: rig_ns(fault.from_us), until_ns: None }),
                Some(until_us) => {
                    let open = episodes.iter_mut().rev().find(|bout| bout.kind == fault.kind);
                    if let Some(bout) = open {
                        bout.until_ns = Some(rig_ns(until_us));
                    }
                }
            },
            Event::Estimate(estimate) => weigh(estimate, truth, &mut verdict),
            Event::Health(latest) => health = *latest,
            _ => {}
        }
    }
    let known = ran.delivered + u64::from(health.conversions_lost);
    verdict.silent = ran.chip.conversions.saturating_sub(known);
    verdict.excess = known.saturating_sub(ran.chip.conversions);
    if verdict.silent > 0 || verdict.excess > 0 && plan.family.loss_is_known() {
        let told = health.conversions_lost;
        let (made, taken) = (ran.chip.conversions, ran.delivered);
        verdict.complaints.push(format!("{made} conversions made, {taken} taken, {told} told as lost"));
    }
    if verdict.altered > 0 {
        verdict.complaints.push(format!("{} conversions taken are not what was converted", verdict.altered));
    }
    if plan.injections.is_empty() {
        verdict.false_alarms = episodes.len() as u32;
    }
    if !ran.registers_right {
        verdict.complaints.push("the registers are wrong at the end".into());
    }
    if ran.line != (0, 0) {
        verdict.complaints.push(format!("telemetry: {} packets lost, {} damaged", ran.line.0, ran.line.1));
    }
    for (at, injected) in ran.injected.iter().enumerate() {
        let Injected { begun_ns: Some(begun_ns), over_ns } = *injected else { continue };
        let next_ns = ran.injected.get(at + 1).and_then(|next| next.begun_ns).unwrap_or(ran.end_ns);
        let over_ns = over_ns.unwrap_or(begun_ns).max(begun_ns);
        let told = episodes.iter().filter(|bout| plan.family.expected().contains(&bout.kind)).filter(|bout| {
            // In a mixed run it may go on being told of the one before.
            let seen_since = bout.until_ns.is_none_or(|until_ns| until_ns + SLACK_NS >= begun_ns);
            bout.from_ns < next_ns && seen_since
        });
        let mut told = told.peekable();
        if told.peek().is_none() {
            let injection = plan.injections.get(at).map(|injection| (injection.fault, injection.lasts_s));
            verdict.complaints.push(format!("{NOT_TOLD}: {injection:?}"));
        }
        let whole_ns = ran.whole_ns.iter().find(|whole_ns| **whole_ns > over_ns);
        verdict.fates.push(Fate {
            detected_s: told.map(|bout| bout.from_ns.saturating_sub(begun_ns) as f64 * 1e-9).reduce(f64::min),
            recovered_s: whole_ns.map(|whole_ns| (whole_ns - over_ns) as f64 * 1e-9),
        });
    }
    verdict
}

fn weigh(estimate: &Estimate, truth: &Truth, verdict: &mut Judgement) {
    let off_hz = (f64::from(estimate.frequency) - truth.frequency_hz).abs();
    let is_off = off_hz > SIGMAS * f64::from(estimate.sigma);
    let is_wrong = is_off && off_hz > SHARE * truth.frequency_hz;
    let (is_good, is_sure) = (estimate.status == Status::Good, estimate.faults.is_none());
    verdict.good += u32::from(is_good && is_sure);
    verdict.good_with_doubts += u32::from(is_good && !is_sure);
    verdict.doubtful += u32::from(estimate.status == Status::Doubtful);
    verdict.wrong += u32::from(is_good && is_sure && is_wrong);
    verdict.wrong_with_doubts += u32::from(is_good && !is_sure && is_wrong);
    verdict.off += u32::from(is_good && is_off && !is_wrong);
    if is_good && is_wrong {
        verdict.complaints.push(format!(
            "wrong at {:.3} s: {} +- {} Hz in place of {} Hz, {:?} of {} s, {} frames missing, doubts {:?}",
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
