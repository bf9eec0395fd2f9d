//! Noise of real recordings, which stay outside of the repository.

use super::process::Noise;
use anyhow::{Context, Result, ensure};
use ridgetone_proto::settings::TAXELS;
use std::fs;
use std::path::{Path, PathBuf};

/// The noise of some recordings; none of none.
pub fn noise(paths: &[PathBuf]) -> Result<Option<Noise>> {
    let recordings = paths
        .iter()
        .map(|path| read(path).with_context(|| path.display().to_string()));
    let recordings = recordings.collect::<Result<Vec<_>>>()?;
    // The cells of a run refer to them until it ends.
    Ok((!paths.is_empty()).then(|| Noise::Real(Box::leak(recordings.into_boxed_slice()) as &_)))
}

/// The last sixteen columns of a table with a heading. Its rows count as frames, whatever their
/// rate is.
fn read(path: &Path) -> Result<Vec<[f64; TAXELS]>> {
    let text = fs::read_to_string(path)?;
    let row = |(number, line): (usize, &str)| {
        let cells: Vec<f64> = line
            .split(',')
            .map(|cell| cell.trim().parse().unwrap_or(f64::NAN))
            .collect();
        let channels = cells
            .last_chunk::<TAXELS>()
            .with_context(|| format!("row {number}: fewer than {TAXELS} columns"))?;
        ensure!(
            channels.iter().all(|value| value.is_finite()),
            "row {number}: a cell is not a number"
        );
        Ok(*channels)
    };
    text.lines().enumerate().skip(1).map(row).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_table_of_sixteen_channels_is_read_and_others_are_refused() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("noise.csv");
        let channels: Vec<String> = (0..TAXELS).map(|c| c.to_string()).collect();
        let table = |cells: &str| format!("time_s,channels\n0.5,{cells}\n");
        fs::write(&path, table(&channels.join(","))).expect("written");
        assert_eq!(
            read(&path).expect("a table"),
            [std::array::from_fn(|c| c as f64)]
        );
        for cells in ["1,2,3", &channels.join(",").replace("7", "x")] {
            fs::write(&path, table(cells)).expect("written");
            assert!(read(&path).is_err(), "{cells}");
        }
        assert_eq!(noise(&[]).expect("none"), None);
    }
}
