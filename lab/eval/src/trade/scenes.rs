//! What each part of a scene costs, and what goes wrong where it is left out and is there after all.

use super::setups::{DEFAULT, SCENES, SCENES_S, Setup};
use crate::noise::beside;
use crate::page::{self, Bar, Figures, Table, Tables, percent};
use anyhow::Result;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::path::Path;

pub const TOPIC: &str = "scene";

/// Windows of 1 s of each answer.
const WINDOWS: u32 = 200;
const SEED: u64 = 30_000;

/// A scene's figures.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Row {
    pub name: String,
    /// Instructions of the costliest window of each length on the chip, where they were counted.
    pub instructions: Vec<u32>,
    /// Instructions of the costliest window of 1 s whose tone is expected.
    pub tracked: Option<u32>,
    /// What is in the windows of the answers.
    pub cell: Option<String>,
    /// Answers with this scene, and with the default one.
    pub answers: Vec<Answers>,
}

/// Answers to windows that hold what is left out.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Answers {
    pub windows: u32,
    pub good: u32,
    pub wrong: u32,
    /// Good ones whose 95 % interval holds the mean frequency.
    pub covered: u32,
}

/// The data of the page.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Scenes {
    pub rows: Vec<Row>,
    pub bars: Vec<Bar>,
}

/// Answers here. Instructions and bars are those of `before`.
pub fn measure(before: Scenes) -> Result<Scenes> {
    let row = |setup: &Setup| {
        let counted = before.rows.iter().find(|row| row.name == setup.name);
        let answers = |setup: &Setup, cell| {
            let scene = ridgetone_finger::scene(&setup.declared, setup.harmonics);
            let [answers, _] = beside(cell, WINDOWS, SEED, &scene)?;
            Ok(Answers {
                windows: answers.windows,
                good: answers.good,
                wrong: answers.wrong,
                covered: answers.covered,
            })
        };
        let both = setup.cell.map(|cell| {
            let both = [setup, &DEFAULT].map(|setup| answers(setup, cell));
            both.into_iter().collect::<Result<Vec<_>>>()
        });
        Ok(Row {
            name: setup.name.into(),
            instructions: counted.map_or_else(Vec::new, |row| row.instructions.clone()),
            tracked: counted.and_then(|row| row.tracked),
            cell: setup.cell.map(str::to_owned),
            answers: both.transpose()?.unwrap_or_default(),
        })
    };
    Ok(Scenes {
        rows: SCENES.iter().map(row).collect::<Result<_>>()?,
        bars: before.bars,
    })
}

/// The page's tables.
pub fn figures(scenes: Scenes) -> Figures<Scenes> {
    Figures {
        tables: Tables::from([
            ("scenes".into(), table(&scenes.rows)),
            ("bars".into(), page::bars(&scenes.bars)),
        ]),
        detail: scenes,
    }
}

/// Writes the figures and the page.
pub fn write(scenes: Scenes, folder: &Path) -> Result<()> {
    page::write(folder, TOPIC, &figures(scenes))
}

/// What was measured last in a folder; nothing where nothing was.
pub fn load(folder: &Path) -> Result<Scenes> {
    page::load(folder, TOPIC).map(|figures| figures.detail)
}

/// A row for each scene.
fn table(rows: &[Row]) -> Table {
    let mut table = Table::new(
        "scene|0.2 s|0.4 s|1 s|3.9 s|1 s, after a good window|in windows with|good, %|good and wrong, %|\
         intervals that hold, %|default: good, %|good and wrong, %|intervals that hold, %",
    );
    for row in rows {
        let mut cells = vec![Value::from(row.name.as_str())];
        let counted = |n: usize| row.instructions.get(n).copied();
        cells.extend((0..SCENES_S.len()).map(|n| counted(n).into()));
        cells.push(row.tracked.into());
        cells.push(row.cell.clone().unwrap_or_default().into());
        for n in 0..2 {
            let Some(answers) = row.answers.get(n) else {
                cells.extend([Value::Null, Value::Null, Value::Null]);
                continue;
            };
            cells.push(percent(answers.good, answers.windows));
            cells.push(percent(answers.wrong, answers.windows));
            cells.push(percent(answers.covered, answers.good));
        }
        table.row(cells);
    }
    table
}
