//! The runs that pages look back at, by their numbers, and their files.

use super::reading::Reading;
use super::run::{Run, Summary};
use super::work::Allowance;
use crate::settings_form;
use anyhow::{Context, Result, ensure};
use ridgetone_proto::settings::Settings;
use serde::Serialize;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use tempfile::NamedTempFile;

/// Runs kept at a time.
const MOST: usize = 8;

pub struct Runs {
    folder: PathBuf,
    list: Mutex<List>,
}

#[derive(Default)]
struct List {
    next: u64,
    runs: Vec<(u64, Arc<Run>)>,
}

impl List {
    /// Refuses one run more than there may be.
    fn check(&self) -> Result<()> {
        let is_full = self.runs.len() >= MOST;
        ensure!(!is_full, "{MOST} runs are open: close one first");
        Ok(())
    }
}

/// How a file becomes a run.
#[derive(Clone, Debug, Default)]
pub struct How {
    pub reading: Reading,
    /// Settings in place of those of its board.
    pub settings: Option<Settings>,
}

/// A run's number, and what is in it.
#[derive(Clone, Debug, Serialize)]
pub struct Numbered {
    pub id: u64,
    #[serde(flatten)]
    pub summary: Summary,
}

impl Runs {
    /// No run yet. Files go to a folder whose owner removes it: a thread that serves a page may
    /// hold this until the process ends, and then nothing is dropped.
    pub fn new(folder: &Path) -> Self {
        Self {
            folder: folder.to_owned(),
            list: Mutex::default(),
        }
    }

    /// A new file in the folder.
    pub fn new_path(&self) -> PathBuf {
        let mut list = self.lock();
        list.next += 1;
        self.folder.join(list.next.to_string())
    }

    /// A new file in the folder, which goes unless it becomes a run.
    pub fn new_file(&self) -> Result<NamedTempFile> {
        NamedTempFile::new_in(&self.folder).context("the temporary folder")
    }

    /// Opens such a file as a run, and keeps it.
    pub fn add(&self, name: &str, file: NamedTempFile, allowance: &Allowance) -> Result<Numbered> {
        let path = file.into_temp_path();
        let opened = self.open(name, &path, How::default(), allowance)?;
        path.keep()?;
        Ok(opened)
    }

    /// Opens a file as a run.
    pub fn open(
        &self,
        name: &str,
        path: &Path,
        how: How,
        allowance: &Allowance,
    ) -> Result<Numbered> {
        self.lock().check()?;
        let How { reading, settings } = how;
        let run = Arc::new(Run::open(name, path, reading, settings, allowance)?);
        let summary = run.summary();
        let mut list = self.lock();
        // Others may have been opened meanwhile.
        list.check()?;
        list.next += 1;
        let id = list.next;
        list.runs.push((id, run));
        Ok(Numbered { id, summary })
    }

    /// Runs the library over a run's frames again, with some settings in place of its own.
    pub fn again(&self, id: u64, json: &str, allowance: &Allowance) -> Result<Numbered> {
        let run = self.get(id)?;
        let settings = settings_form::with_json(&run.settings(), json)?;
        self.replace(id, run.reading.clone(), Some(settings), allowance)
    }

    /// Reads a run's table again with another column as the time.
    pub fn with_time(&self, id: u64, text: &str, allowance: &Allowance) -> Result<Numbered> {
        let run = self.get(id)?;
        let reading = run
            .reading
            .with_time(&run.summary().time_columns, text.trim())?;
        self.replace(id, reading, None, allowance)
    }

    fn replace(
        &self,
        id: u64,
        reading: Reading,
        settings: Option<Settings>,
        allowance: &Allowance,
    ) -> Result<Numbered> {
        let run = self.get(id)?;
        let (name, path) = (&run.name, &run.path);
        let run = Arc::new(Run::open(name, path, reading, settings, allowance)?);
        let summary = run.summary();
        self.lock()
            .runs
            .iter_mut()
            .filter(|(known, _)| *known == id)
            .for_each(|(_, known)| *known = Arc::clone(&run));
        Ok(Numbered { id, summary })
    }

    pub fn get(&self, id: u64) -> Result<Arc<Run>> {
        let list = self.lock();
        let found = list
            .runs
            .iter()
            .find(|(known, _)| *known == id)
            .context("this run is closed")?;
        Ok(Arc::clone(&found.1))
    }

    /// Forgets a run; its file too if it is in the folder.
    pub fn close(&self, id: u64) -> Result<()> {
        let run = self.get(id)?;
        self.lock().runs.retain(|(known, _)| *known != id);
        if run.path.starts_with(&self.folder) {
            std::fs::remove_file(&run.path)?;
        }
        Ok(())
    }

    pub fn list(&self) -> Vec<Numbered> {
        self.lock()
            .runs
            .iter()
            .map(|(id, run)| Numbered {
                id: *id,
                summary: run.summary(),
            })
            .collect()
    }

    fn lock(&self) -> MutexGuard<'_, List> {
        // A panic under the lock leaves a list that can still be shown.
        self.list.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
