//! M from a recording of the forces: equation 10 over the part of the run that the paper uses.

use super::measure::Options;
use crate::part::Part;
use crate::samples::Samples;
use crate::table_fit::{Selection, columns};
use anyhow::{Result, ensure};

/// Part of the run that counts, millimetres (section 2.4: from 5 to 25 mm).
const FROM_MM: f64 = 5.0;
const BLOCK_MM: f64 = 5.0;
const BLOCKS: usize = 4;

/// Columns of the two forces.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ForceColumns {
    pub tangential: String,
    pub normal: String,
}

impl ForceColumns {
    /// Takes the forces out of the columns of vibration.
    pub fn exclude(&self, samples: &Samples, selection: &mut Selection) -> Result<()> {
        let rows = &mut *samples.open()?;
        let all = columns(rows, selection)?;
        let mut names: Vec<String> = all.iter().map(|at| rows.names()[*at].clone()).collect();
        names.retain(|name| *name != self.tangential && *name != self.normal);
        ensure!(!names.is_empty(), "{}: no column of vibration", rows.file());
        selection.columns = names;
        Ok(())
    }

    /// M, the mean over 5 to 25 mm of the run, with the standard deviation by the scatter of its
    /// four quarters.
    pub fn ratio(&self, samples: &Samples, options: &Options) -> Result<(f32, f32)> {
        let rows = &mut *samples.open()?;
        let file = rows.file().to_owned();
        let selection = Selection {
            columns: vec![self.tangential.clone(), self.normal.clone()],
            ..options.selection.clone()
        };
        let forces = columns(rows, &selection)?;
        let part = Part::read(rows, &selection, usize::MAX, &mut |_| ())?;
        let [tangential, normal] = [0, 1].map(|force| part.column(forces[force]));
        let speed_mm_s = f64::from(options.reference.surface.speed_mm_s);
        let first_s = part.times_s.first().copied().unwrap_or(0.0);
        let mut sums = [[0.0; 3]; BLOCKS];
        for (t_s, (f, n)) in part
            .times_s
            .iter()
            .zip(tangential.iter().zip(normal.iter()))
        {
            let block = ((t_s - first_s) * speed_mm_s - FROM_MM) / BLOCK_MM;
            if block < 0.0 || block >= BLOCKS as f64 || f.is_nan() || n.is_nan() {
                continue;
            }
            let sum = &mut sums[block as usize];
            *sum = [sum[0] + f, sum[1] + n, sum[2] + 1.0];
        }
        ensure!(
            sums.iter().all(|sum| sum[2] > 0.0),
            "{file}: M is the mean over 5 to 25 mm of the run, which has forces for {:.1} mm at {speed_mm_s} mm/s",
            (part.times_s.last().copied().unwrap_or(first_s) - first_s) * speed_mm_s
        );
        let ratios = sums.map(|[f, n, _]| (f / n).abs());
        let [f, n] = [0, 1].map(|force| sums.iter().map(|sum| sum[force]).sum::<f64>());
        let m = (f / n).abs();
        ensure!(m.is_finite(), "{file}: nothing presses in {}", self.normal);
        let squares: f64 = ratios.iter().map(|ratio| (ratio - m).powi(2)).sum();
        let sigma = (squares / (BLOCKS * (BLOCKS - 1)) as f64).sqrt();
        Ok((m as f32, sigma as f32))
    }
}
