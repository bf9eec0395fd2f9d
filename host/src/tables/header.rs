//! The names of the columns, above the first row.

use super::cells::Kind;
use super::head_line::HeadLine;
use super::refused::Refused;
use super::time_column::per_second;
use hal_mock::escaped;

/// LabVIEW's column without numbers.
pub const COMMENT: &str = "Comment";

/// The names of the columns and the line that they stand on. It may be a comment, and a row of
/// units may follow it.
pub fn names(
    lines: &[HeadLine],
    first: usize,
) -> Result<(Option<Vec<String>>, Option<usize>), Refused> {
    let width = lines[first].cells.len();
    let mut at = first;
    while let Some(above) = at.checked_sub(1) {
        at = above;
        let Some(names) = fitting(&lines[above], width) else {
            break;
        };
        let next = above.checked_sub(1).map(|next| &lines[next]);
        let has_names_above = next.is_some_and(|next| fitting(next, width).is_some());
        if has_names_above && is_units(&lines[above]) {
            continue;
        }
        return Ok((Some(names), Some(above)));
    }
    match first.checked_sub(1).map(|above| &lines[above]) {
        Some(above) if above.cells.len() > 1 && !above.is_comment() => {
            let found = above.cells.len();
            let way_out = if width == 2 * found {
                "; if commas are decimals, separate columns by semicolons"
            } else {
                ""
            };
            let why = format!("{width} columns, the header has {found}{way_out}");
            Err(Refused::new(Some(lines[first].number), why))
        }
        _ => Ok((None, None)),
    }
}

/// The names that a line gives to so many columns. LabVIEW has one more, for comments, and a
/// separator at the end of each row makes one without a name.
fn fitting(line: &HeadLine, width: usize) -> Option<Vec<String>> {
    // They go into results, which people look at on a terminal.
    let mut names: Vec<String> = (line.cells.iter())
        .map(|name| escaped(name).into_owned())
        .collect();
    if let Some(first) = names.first_mut()
        && let Some(comment) = first.strip_prefix('#').or(first.strip_prefix("% "))
    {
        *first = comment.trim_start_matches(['#', ' ']).to_owned();
        // After a mark that stands alone.
        if first.is_empty() && names.len() == width + 1 {
            names.remove(0);
        }
    }
    if names.len() == width + 1
        && names
            .last()
            .is_some_and(|last| last == COMMENT || last.is_empty())
    {
        names.pop();
    }
    if names.len() + 1 == width && width > 2 {
        names.push(String::new());
    }
    (names.len() == width && line.count(Kind::Text) > 0).then_some(names)
}

/// Whether a line under the names gives units, or repeats one word: in brackets, of a time, or with
/// numbers.
fn is_units(line: &HeadLine) -> bool {
    let mut cells = line.cells.iter().filter(|cell| !cell.is_empty());
    let is_bracketed = |cell: &String| cell.starts_with(['(', '[']) && cell.ends_with([')', ']']);
    let is_all_bracketed = cells.clone().all(is_bracketed);
    let has_time_unit = cells.clone().any(|cell| per_second(cell).is_some());
    let has_number = line.count(Kind::Number) > 0;
    let repeats = cells
        .next()
        .is_some_and(|first| cells.clone().count() > 0 && cells.all(|cell| cell == first));
    is_all_bracketed || has_time_unit || has_number || repeats
}

/// The line of units between header and first row.
pub fn unit_row(lines: &[HeadLine], first: usize, header: Option<u64>) -> Option<&HeadLine> {
    let above = &lines[first.checked_sub(1)?];
    let width = lines[first].cells.len();
    (header.is_some_and(|header| header < above.number) && above.cells.len() == width)
        .then_some(above)
}
