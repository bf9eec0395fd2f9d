//! Events of a board, for people and for programs.
//!
//! | step | where |
//! |---|---|
//! | what a message holds: fields, units, meaning | [`view`] |
//! | as one JSON object per line | `json` |
//! | JSON schemas, made from the views and checked in | [`schema`] |
//! | as rows of a table | `rows` |
//! | as lines of text | `text` |

mod json;
pub mod rows;
pub mod schema;
mod text;
pub mod view;

#[cfg(test)]
mod generated;

pub use json::{JsonLines, json, serializable};
pub use text::{Columns, given, outcome, text, text_of_columns};
