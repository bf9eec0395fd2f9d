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

/// Most rows: seven minutes at 10 kHz.
const ROWS_MAX: usize = 1 << 22;

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
        let names = all.into_iter().map(|column| rows.names()[column].clone());
        let is_other = |name: &String| *name != self.tangential && *name != self.normal;
        selection.columns = names.filter(is_other).collect();
        ensure!(
            !selection.columns.is_empty(),
            "{}: no column of vibration beside those of --forces",
            rows.file()
        );
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
        let part = Part::read(rows, &selection, ROWS_MAX, &mut |_| ())?;
        let [tangential, normal] = [0, 1].map(|force| part.column(forces[force]));
        let speed_mm_s = f64::from(options.reference.surface.speed_mm_s);
        let first_s = part.times_s.first().copied().unwrap_or(0.0);
        let (mut sums, mut counts) = ([[0.0; 2]; BLOCKS], [0u32; BLOCKS]);
        for (t_s, (f, n)) in part
            .times_s
            .iter()
            .zip(tangential.iter().zip(normal.iter()))
        {
            let block = ((t_s - first_s) * speed_mm_s - FROM_MM) / BLOCK_MM;
            if block < 0.0 || block >= BLOCKS as f64 || f.is_nan() || n.is_nan() {
                continue;
            }
            let block = block as usize;
            sums[block][0] += f;
            sums[block][1] += n;
            counts[block] += 1;
        }
        ensure!(
            counts.iter().all(|count| *count > 0),
            "{file}: M is the mean over 5 to 25 mm of the run, which has forces for {:.1} mm at {speed_mm_s} mm/s",
            (part.times_s.last().copied().unwrap_or(first_s) - first_s) * speed_mm_s
        );
        let ratios = sums.map(|[f, n]| (f / n).abs());
        let [f, n] = [0, 1].map(|force| sums.iter().map(|sum| sum[force]).sum::<f64>());
        let m = (f / n).abs();
        ensure!(m.is_finite(), "{file}: nothing presses in {}", self.normal);
        let mean = ratios.iter().sum::<f64>() / BLOCKS as f64;
        let variance = ratios
            .iter()
            .map(|ratio| (ratio - mean).powi(2))
            .sum::<f64>()
            / (BLOCKS - 1) as f64;
        Ok((m as f32, (variance / BLOCKS as f64).sqrt() as f32))
    }
}
