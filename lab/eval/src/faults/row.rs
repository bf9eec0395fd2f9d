//! Rows of the table: the results of all injections of one kind.

use super::counts::Counts;
use super::family::Family;
use super::judge::{ALTERED, Judgement, NOT_REPORTED};
use clap::ValueEnum;
use ridgetone_proto::plan::Plan;
use serde::Serialize;

#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Place {
    /// The firmware's tasks, simulated on the PC.
    Pc,
    /// The firmware's tasks on the PC, with the named scan plan.
    Plan(&'static str),
    /// The firmware's image on the emulated chip.
    Emulator,
}

impl Place {
    pub fn title(self) -> String {
        match self {
            Self::Pc => "PC".into(),
            Self::Plan(name) => format!("PC, plan {name}"),
            Self::Emulator => "emulated chip".into(),
        }
    }

    /// Fraction of windows of a steady tone to which the estimator may give a status other than
    /// `good`. Measured: four of 4,202 windows with the default plan were unsteady or ambiguous, a
    /// third of the allowed number, and four of 140 with `hand`.
    fn false_alarm_rate(self) -> f64 {
        match self {
            Self::Plan(_) => 0.03,
            Self::Pc | Self::Emulator => 0.003,
        }
    }

    /// True if the firmware reads each conversion twice, which reveals a bit error in a code.
    pub fn is_read_twice(self) -> bool {
        match self {
            Self::Plan(name) => Plan::named(name).is_none_or(|plan| plan.is_read_twice()),
            Self::Pc | Self::Emulator => true,
        }
    }
}

/// Number of events, and median and maximum of their delays.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub struct Delays {
    pub count: usize,
    /// Median delay, seconds; NaN, like `longest_s`, if times are not measured.
    pub median_s: f64,
    pub longest_s: f64,
}

impl Delays {
    pub const fn untimed(count: u64) -> Self {
        Self {
            count: count as usize,
            median_s: f64::NAN,
            longest_s: f64::NAN,
        }
    }

    fn of(mut all_s: Vec<f64>) -> Self {
        all_s.sort_by(f64::total_cmp);
        let count = all_s.len();
        let at = |place: usize| all_s.get(place).copied().unwrap_or(0.0);
        Self {
            count,
            median_s: at(count / 2),
            longest_s: at(count.saturating_sub(1)),
        }
    }
}

#[derive(Clone, Debug, Serialize)]
pub struct Row {
    /// Name in the JSON; for a family, the value of `--only`.
    pub name: String,
    pub fault: String,
    pub place: Place,
    /// Number of touches; zero if only the line or the store is tested.
    pub runs: usize,
    pub injected: usize,
    /// Injections followed by a report of the right kind; `None` if there is nothing to report.
    pub detected: Option<Delays>,
    /// Unreported injections that left no sign.
    pub unseen: usize,
    /// Injections after which everything worked again; `None` if there is nothing to recover.
    pub recovered: Option<Delays>,
    pub loss_is_known: bool,
    #[serde(flatten)]
    pub counts: Counts,
    pub complaints: Vec<String>,
}

const COMPLAINTS: usize = 5;

/// True if the fault changes bits that are read only once.
fn may_alter(family: Family, place: Place) -> bool {
    family.alters() && !place.is_read_twice()
}

#[derive(Clone, Copy)]
pub struct Title<'a> {
    pub name: &'a str,
    pub fault: &'a str,
}

impl Row {
    /// Returns the row for the runs of one family; each judgement comes with its seed.
    pub fn of_family(family: Family, place: Place, judgements: &[(u64, Judgement)]) -> Self {
        let mut counts = Counts::default();
        judgements
            .iter()
            .for_each(|(_, judgement)| counts += judgement.counts);
        let fates = || {
            judgements
                .iter()
                .flat_map(|(_, judgement)| &judgement.fates)
        };
        let injected = fates().count();
        let some = |delays: Vec<f64>| (injected > 0).then(|| Delays::of(delays));
        let of_run = |(seed, judgement): &(u64, Judgement)| {
            judgement
                .complaints
                .iter()
                .map(|complaint| (*seed, complaint.clone()))
                .collect::<Vec<_>>()
        };
        let mut complaints: Vec<_> = judgements.iter().flat_map(of_run).collect();
        // Allowed complaints come last: unreported faults in mixed runs, and altered conversions if
        // they are read once.
        complaints.sort_by_key(|(_, complaint)| match complaint {
            complaint if complaint.ends_with(ALTERED) && may_alter(family, place) => 2,
            complaint => u8::from(complaint.starts_with(NOT_REPORTED)),
        });
        let complaints = complaints
            .into_iter()
            .map(|(seed, complaint)| format!("seed {seed}: {complaint}"));
        Self {
            name: family.name(),
            fault: family.title().into(),
            place,
            runs: judgements.len(),
            injected,
            detected: some(fates().filter_map(|fate| fate.detected_s).collect()),
            unseen: fates().filter(|fate| fate.is_unseen).count(),
            recovered: some(fates().filter_map(|fate| fate.recovered_s).collect()),
            loss_is_known: family.loss_is_known(),
            counts,
            complaints: complaints.take(COMPLAINTS).collect(),
        }
    }

    /// Returns the row for injections on the line or into the store, without a touch; `detected`
    /// and `recovered` are numbers of injections.
    pub fn without_touch(
        title: Title<'_>,
        injected: u64,
        detected: u64,
        recovered: Option<u64>,
        counts: Counts,
    ) -> Self {
        Self {
            name: title.name.into(),
            fault: title.fault.into(),
            place: Place::Pc,
            runs: 0,
            injected: injected as usize,
            detected: Some(Delays::untimed(detected)),
            unseen: 0,
            recovered: recovered.map(Delays::untimed),
            loss_is_known: false,
            counts,
            complaints: Vec::new(),
        }
    }

    /// True if every count that must be zero is zero.
    pub fn is_clean(&self) -> bool {
        self.failures().is_empty()
    }

    /// Returns names and values of the counts that must be zero but are not.
    pub fn failures(&self) -> Vec<String> {
        let mut counts = self.counts;
        if self.may_alter() {
            counts.altered = 0;
        }
        let mut failures = counts.failures(self.loss_is_known, self.place.false_alarm_rate());
        let missed = self.missed();
        if missed > 0 {
            failures.push(format!("not_reported {missed}"));
        }
        failures
    }

    /// Number of faults in touches that should have been reported but were not. Mixed runs do not
    /// count, because one fault may hide another.
    fn missed(&self) -> usize {
        if self.runs == 0 || self.name == Family::Mixed.name() {
            return 0;
        }
        let reported = self.detected.map_or(0, |delays| delays.count);
        self.injected.saturating_sub(reported + self.unseen)
    }

    pub fn may_alter(&self) -> bool {
        Family::from_str(&self.name, false).is_ok_and(|family| may_alter(family, self.place))
    }
}
