//! A row of the table: what became of all injections of one family.

use super::family::Family;
use super::judge::{Judgement, NOT_TOLD};
use serde::Serialize;

/// Where the firmware ran.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Place {
    /// Its task_sim on the PC.
    Pc,
    /// Its image on the emulated chip.
    Emulator,
}

impl Place {
    /// For people.
    pub const fn title(self) -> &'static str {
        match self {
            Self::Pc => "PC",
            Self::Emulator => "emulated chip",
        }
    }
}

/// Delays, seconds: of how many, and what they were.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub struct Delays {
    /// How many there are.
    pub count: usize,
    /// Half of them are shorter; not a number where no time is taken.
    pub median_s: f64,
    /// The longest; likewise.
    pub longest_s: f64,
}

impl Delays {
    /// So many, of which no time is taken.
    pub const fn untimed(count: u64) -> Self {
        Self { count: count as usize, median_s: f64::NAN, longest_s: f64::NAN }
    }

    /// Of these.
    pub fn of(mut all_s: Vec<f64>) -> Self {
        all_s.sort_by(f64::total_cmp);
        let count = all_s.len();
        let at = |place: usize| all_s.get(place).copied().unwrap_or(0.0);
        Self { count, median_s: at(count / 2), longest_s: at(count.saturating_sub(1)) }
    }
}

/// A row. Whoever injects something else than into the chip makes rows of this kind too.
#[derive(Clone, Debug, Serialize)]
pub struct Row {
    /// Its name, for programs: of a family, what `--only` takes.
    pub name: String,
    /// What was injected.
    pub fault: String,
    /// Where.
    pub place: Place,
    /// Touches; none where the line or the store is asked alone.
    pub runs: usize,
    /// Injections.
    pub injected: usize,
    /// Those noticed by the right kind, and how soon; none where there is nothing to notice.
    pub detected: Option<Delays>,
    /// Those after which all was well again, and how soon; none where there is nothing to mend.
    pub recovered: Option<Delays>,
    /// Estimates that said good, without doubts.
    pub good: u64,
    /// Estimates that said good, but with doubts.
    pub good_with_doubts: u64,
    /// Estimates that said doubtful.
    pub doubtful: u64,
    /// Estimates that said good and are off by more than five of their standard deviations, but by less than 0.5 %.
    pub off: u64,
    /// Wrong ones among those that said good without doubts. Must be zero.
    pub wrong: u64,
    /// Wrong ones among those that said good but with doubts. Must be zero.
    pub wrong_with_doubts: u64,
    /// Conversions, frames or orders lost silently. Must be zero.
    pub silent: u64,
    /// Conversions told as lost beyond those that were.
    pub excess: u64,
    /// Whether it is known to the conversion how many were lost: then that must be zero.
    pub loss_is_known: bool,
    /// Conversions that arrived other than they were converted; packets, orders or settings that nobody sent. Must be zero.
    pub altered: u64,
    /// Bouts told in runs without injections. Must be zero.
    pub false_alarms: u64,
    /// What else is wrong, the first few.
    pub complaints: Vec<String>,
}

/// How many complaints a row keeps.
const COMPLAINTS: usize = 5;

impl Row {
    /// Of the runs of one family.
    pub fn of_family(family: Family, place: Place, verdicts: &[(u64, Judgement)]) -> Self {
        let loss_is_known = family.loss_is_known();
        Self { loss_is_known, ..Self::of(&family.name(), family.title(), place, verdicts) }
    }

    /// Of these runs.
    pub fn of(name: &str, fault: &str, place: Place, verdicts: &[(u64, Judgement)]) -> Self {
        let sum = |of: fn(&Judgement) -> u64| verdicts.iter().map(|(_, verdict)| of(verdict)).sum::<u64>();
        let fates = || verdicts.iter().flat_map(|(_, verdict)| &verdict.fates);
        let injected = fates().count();
        let some = |delays: Vec<f64>| (injected > 0).then(|| Delays::of(delays));
        let mut complaints: Vec<_> = verdicts
            .iter()
            .flat_map(|(seed, verdict)| verdict.complaints.iter().map(move |complaint| (seed, complaint)))
            .collect();
        // What must not be comes first.
        complaints.sort_by_key(|(_, complaint)| complaint.starts_with(NOT_TOLD));
        let complaints = complaints.into_iter().map(|(seed, complaint)| format!("seed {seed}: {complaint}"));
        Self {
            name: name.into(),
            fault: fault.into(),
            place,
            runs: verdicts.len(),
            injected,
            detected: some(fates().filter_map(|fate| fate.detected_s).collect()),
            recovered: some(fates().filter_map(|fate| fate.recovered_s).collect()),
            good: sum(|verdict| verdict.good.into()),
            good_with_doubts: sum(|verdict| verdict.good_with_doubts.into()),
            doubtful: sum(|verdict| verdict.doubtful.into()),
            off: sum(|verdict| verdict.off.into()),
            wrong: sum(|verdict| verdict.wrong.into()),
            wrong_with_doubts: sum(|verdict| verdict.wrong_with_doubts.into()),
            silent: sum(|verdict| verdict.silent),
            excess: sum(|verdict| verdict.excess),
            loss_is_known: false,
            altered: sum(|verdict| verdict.altered),
            false_alarms: sum(|verdict| verdict.false_alarms.into()),
            complaints: complaints.take(COMPLAINTS).collect(),
        }
    }

    /// Whether all is zero that must be.
    pub fn is_clean(&self) -> bool {
        let exact = !self.loss_is_known || self.excess == 0;
        exact && [self.wrong, self.wrong_with_doubts, self.silent, self.altered, self.false_alarms] == [0; 5]
    }
}
