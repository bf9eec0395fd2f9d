//! Fits subsets of a table's channels: groups, if the estimator cannot take all channels at once,
//! and all channels but one, if that channel lacks the common tone.

use super::{ChannelResult, TableFit, TableHead, fit_group, joined};
use crate::digits::significant;
use crate::part::{Part, Selection};
use crate::tone::WithSigma;
use anyhow::Result;
use ridgetone_proto::settings::TAXELS;
use ridgetone_proto::telemetry::{OtherTone, Status};

/// Difference above which two groups count as having different tones, standard deviations.
const SAME: f64 = 4.0;

/// Fits groups of neighbouring channels and joins the results. The frequency is the mean of the
/// groups that agree, weighted by variance. Noise may be correlated between groups, so sigma is the
/// weighted mean of the groups' sigmas, and is not reduced by averaging.
pub fn fit(
    table: &TableHead,
    part: &Part,
    columns: &[usize],
    selection: &Selection,
) -> Result<TableFit> {
    let count = columns.len().div_ceil(TAXELS);
    let size = columns.len().div_ceil(count);
    let groups = columns.chunks(size);
    let fits: Vec<TableFit> = groups
        .map(|group| fit_group(table, part, group, selection))
        .collect::<Result<_>>()?;
    let rank = |fit: &TableFit| {
        let sigma = fit
            .tone
            .frequency()
            .map_or(f64::INFINITY, |tone| tone.sigma);
        (fit.status != Status::Good, sigma)
    };
    let best = fits.iter().min_by(|a, b| {
        let ((a, a_sigma), (b, b_sigma)) = (rank(a), rank(b));
        a.cmp(&b).then(a_sigma.total_cmp(&b_sigma))
    });
    let Some(best) = best.cloned() else {
        return fit_group(table, part, columns, selection);
    };
    let mut joint = best.clone();
    let mut remarks = vec![format!(
        "{} channels are fitted in {count} groups of at most {size}: the estimator takes {TAXELS} at once",
        columns.len()
    )];
    if let Some(tone) = best.tone.frequency() {
        let (mut weights, mut sum, mut sigmas) = (0.0, 0.0, 0.0);
        for fit in &fits {
            let names = || {
                let names: Vec<&str> = fit
                    .channels
                    .iter()
                    .map(|channel| channel.name.as_str())
                    .collect();
                format!("{} to {}", names[0], names[names.len() - 1])
            };
            let Some(found) = fit.tone.frequency() else {
                remarks.push(format!("channels {} have no tone", names()));
                continue;
            };
            let apart = (found.value - tone.value).abs();
            if apart > SAME * found.sigma.hypot(tone.sigma) {
                let hz = significant(found.value, 5);
                remarks.push(format!(
                    "channels {} have another tone, {hz} {}",
                    names(),
                    fit.domain.unit()
                ));
                if fit.status == Status::Good {
                    joint.status = Status::Ambiguous;
                    joint.tone = joint.tone.beside(OtherTone {
                        frequency: found.value as f32,
                        fraction: 1.0,
                    });
                }
                continue;
            }
            let weight = found.sigma.max(f64::MIN_POSITIVE).powi(-2);
            weights += weight;
            sum += weight * (found.value - tone.value);
            sigmas += weight * found.sigma;
        }
        joint.tone = joint.tone.with_frequency(WithSigma {
            value: tone.value + sum / weights,
            sigma: sigmas / weights,
        });
    }
    joint.groups = count;
    joint.readings_missing = fits.iter().map(|fit| fit.readings_missing).sum();
    let all = fits.into_iter().flat_map(|fit| fit.channels);
    joint.channels = all.collect::<Vec<ChannelResult>>();
    joint.guessed = joined([joint.guessed, Some(remarks.join("; "))]);
    Ok(joint)
}

/// If all channels have no common tone, or an unsteady one, looks for a good tone common to all
/// channels but one.
pub fn without_one(
    table: &TableHead,
    part: &Part,
    columns: &[usize],
    selection: &Selection,
    found: &TableFit,
) -> Result<Option<String>> {
    let is_open = matches!(found.status, Status::NoTone | Status::Unsteady);
    if !is_open || !(3..=TAXELS).contains(&columns.len()) {
        return Ok(None);
    }
    // Try first without the channel whose tone is weakest.
    let ratio = |at: &usize| {
        let channel = &found.channels[*at];
        channel
            .amplitude
            .zip(channel.residual)
            .map_or(0.0, |(amplitude, residual)| amplitude / residual)
    };
    let mut order: Vec<usize> = (0..columns.len())
        .filter(|at| found.channels[*at].usable)
        .collect();
    order.sort_by(|a, b| ratio(a).total_cmp(&ratio(b)));
    for at in order {
        let column = &columns[at];
        let others: Vec<usize> = columns
            .iter()
            .copied()
            .filter(|other| other != column)
            .collect();
        let fit = fit_group(table, part, &others, selection)?;
        if let (Status::Good, Some(tone)) = (fit.status, fit.tone.frequency()) {
            let names: Vec<&str> = fit
                .channels
                .iter()
                .map(|channel| channel.name.as_str())
                .collect();
            return Ok(Some(format!(
                "channel {} does not share it: the others have a good tone of {} +- {} {} (--columns {})",
                found.channels[at].name,
                significant(tone.value, 5),
                significant(tone.sigma, 2),
                fit.domain.unit(),
                names.join(",")
            )));
        }
    }
    Ok(None)
}
