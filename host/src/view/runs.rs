//! The runs that pages can look back at, by number, and their files.

use super::run::{How, Run, Summary};
use crate::settings_form;
use anyhow::{Context, Result, ensure};
use serde::Serialize;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use tempfile::NamedTempFile;

/// Maximum number of open runs.
const RUNS_MAX: usize = 32;

/// Maximum length of a note, characters.
const NOTE_MAX: usize = 200;

pub struct Runs {
    folder: PathBuf,
    list: Mutex<List>,
}

#[derive(Default)]
struct List {
    next: u64,
    runs: Vec<Kept>,
}

struct Kept {
    id: u64,
    run: Arc<Run>,
    how: How,
    note: String,
    is_unsaved: bool,
}

impl List {
    fn kept(&mut self, id: u64) -> Result<&mut Kept> {
        let found = self.runs.iter_mut().find(|kept| kept.id == id);
        found.context("this run is closed")
    }

    /// Fails if the maximum number of runs are open.
    fn check(&self) -> Result<()> {
        let is_full = self.runs.len() >= RUNS_MAX;
        ensure!(!is_full, "{RUNS_MAX} runs are open: close one first");
        Ok(())
    }
}

/// A run's number and summary.
#[derive(Clone, Debug, Serialize)]
pub struct Numbered {
    pub id: u64,
    pub note: String,
    /// True if the run was recorded here and has not been saved yet.
    pub is_unsaved: bool,
    /// True if the file is outside the command's folder, so that it may change.
    pub can_reload: bool,
    #[serde(flatten)]
    pub summary: Summary,
}

impl Runs {
    /// Creates an empty list. Files go to `folder`, which its owner must remove: a thread that
    /// serves a page may keep the list until the process ends, so it may never be dropped.
    pub fn new(folder: &Path) -> Self {
        Self {
            folder: folder.to_owned(),
            list: Mutex::default(),
        }
    }

    pub fn new_path(&self) -> PathBuf {
        let mut list = self.lock();
        list.next += 1;
        self.folder.join(list.next.to_string())
    }

    /// Creates a file in the folder, which is removed unless it becomes a run.
    pub fn new_file(&self) -> Result<NamedTempFile> {
        NamedTempFile::new_in(&self.folder).context("the temporary folder")
    }

    /// Opens a file of [`new_file`](Self::new_file) as a run, and keeps the file.
    pub fn add(&self, name: &str, file: NamedTempFile, how: How) -> Result<Numbered> {
        let path = file.into_temp_path();
        let opened = self.open(name, &path, how)?;
        path.keep()?;
        Ok(opened)
    }

    pub fn open(&self, name: &str, path: &Path, how: How) -> Result<Numbered> {
        self.lock().check()?;
        let run = Arc::new(Run::open(name, path, &how)?);
        let mut list = self.lock();
        // Check again: more runs may have been opened in the meantime.
        list.check()?;
        list.next += 1;
        let kept = Kept {
            id: list.next,
            run,
            is_unsaved: how.is_recorded,
            how,
            note: String::new(),
        };
        let numbered = self.numbered(&kept);
        list.runs.push(kept);
        Ok(numbered)
    }

    /// Runs the library over a run's frames again, with some settings changed.
    pub fn again(&self, id: u64, json: &str) -> Result<Numbered> {
        let run = self.get(id)?;
        let settings = settings_form::with_json(&run.settings(), json)?;
        let how = How {
            settings: Some(settings),
            ..self.lock().kept(id)?.how.clone()
        };
        self.replace(id, &how)
    }

    /// Reads a run's file again, with the original options.
    pub fn reload(&self, id: u64) -> Result<Numbered> {
        let how = self.lock().kept(id)?.how.clone();
        self.replace(id, &how)
    }

    pub fn note(&self, id: u64, text: &str) -> Result<()> {
        let text = text.trim();
        ensure!(
            text.chars().count() <= NOTE_MAX,
            "the note is longer than {NOTE_MAX} characters: shorten it"
        );
        text.clone_into(&mut self.lock().kept(id)?.note);
        Ok(())
    }

    pub fn saved(&self, id: u64) -> Result<()> {
        self.lock().kept(id)?.is_unsaved = false;
        Ok(())
    }

    fn replace(&self, id: u64, how: &How) -> Result<Numbered> {
        let run = self.get(id)?;
        let run = Arc::new(Run::open(&run.name, &run.path, how)?);
        let mut list = self.lock();
        let kept = list.kept(id)?;
        kept.run = run;
        Ok(self.numbered(kept))
    }

    fn numbered(&self, kept: &Kept) -> Numbered {
        Numbered {
            id: kept.id,
            note: kept.note.clone(),
            is_unsaved: kept.is_unsaved,
            can_reload: !kept.run.path.starts_with(&self.folder),
            summary: kept.run.summary(),
        }
    }

    pub fn get(&self, id: u64) -> Result<Arc<Run>> {
        Ok(Arc::clone(&self.lock().kept(id)?.run))
    }

    /// Closes a run, and removes its file if it is in the folder.
    pub fn close(&self, id: u64) -> Result<()> {
        let run = self.get(id)?;
        self.lock().runs.retain(|kept| kept.id != id);
        if run.path.starts_with(&self.folder) {
            std::fs::remove_file(&run.path)?;
        }
        Ok(())
    }

    pub fn list(&self) -> Vec<Numbered> {
        let list = self.lock();
        list.runs.iter().map(|kept| self.numbered(kept)).collect()
    }

    fn lock(&self) -> MutexGuard<'_, List> {
        // A panic under the lock leaves a list that can still be shown.
        self.list.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
