//! Finds the names of the columns above the first row.

use super::cells::Kind;
use super::head_line::HeadLine;
use super::look::is_counter;
use super::refused::Refused;
use super::time_column::named;
use super::units::{is_unit, per_second};
use hal_mock::escaped;

/// Name of LabVIEW's column of comments.
pub const COMMENT: &str = "Comment";

/// Returns the names of the columns and the line on which they begin. This line may be a comment,
/// and a line of units or descriptions may follow. Repeated names are prefixed with group names
/// from the lines above.
pub fn names(
    lines: &[HeadLine],
    first: usize,
) -> Result<(Option<Vec<String>>, Option<usize>), Refused> {
    let width = lines[first].cells.len();
    if let Some(titled) = titles(&lines[..first], width) {
        return Ok(titled);
    }
    let mut at = first;
    while let Some(above) = at.checked_sub(1) {
        at = above;
        let Some(mut names) = fitting(&lines[above], width) else {
            break;
        };
        let next = above.checked_sub(1).map(|next| &lines[next]);
        if let Some(next) = next.filter(|next| fitting(next, width).is_some())
            && (is_units(&lines[above]) || is_described(next, &lines[above]))
        {
            continue;
        }
        let rows: Vec<&HeadLine> = lines[first..]
            .iter()
            .filter(|line| line.is_data() && line.cells.len() == width)
            .collect();
        // pandas and R print row numbers without a name.
        if lines[above].cells.len() + 1 == width
            && is_counter("", &rows, 0)
            && !is_counter(&names[0], &rows, 0)
            && rows.iter().any(|row| row.kinds[width - 1] == Kind::Number)
        {
            names.rotate_right(1);
        }
        let at = name_by_group(&mut names, &lines[..above], above);
        return Ok((Some(names), Some(at)));
    }
    match first.checked_sub(1).map(|above| &lines[above]) {
        Some(above) if above.cells.len() > 1 && is_words(above) => {
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

/// Returns the names in a line such as `ChannelTitle=`, followed by a tab and a name for each
/// column but the time.
fn titles(lines: &[HeadLine], width: usize) -> Option<(Option<Vec<String>>, Option<usize>)> {
    let is_title = |line: &HeadLine| {
        let key = line.cells[0].to_lowercase();
        key.ends_with('=')
            && (key.contains("title") || key.contains("name"))
            && line.cells.len() == width
    };
    let at = lines.iter().position(is_title)?;
    let names = lines[at].cells[1..]
        .iter()
        .map(|name| escaped(name).into_owned());
    let names = std::iter::once("column_1".to_owned()).chain(names);
    Some((Some(names.collect()), Some(at)))
}

/// True if a line whose length differs from that of the rows is a header: only words, but no remark
/// and no keys with values.
fn is_words(line: &HeadLine) -> bool {
    let is_pair = |cell: &String| {
        let mut words = cell.split([' ', '=', ':']).filter(|word| !word.is_empty());
        let is_number = |word: &str| word.parse::<f64>().is_ok();
        words.clone().count() > 1 && words.any(is_number) || cell.ends_with(['=', ':'])
    };
    let has_value = line.count(Kind::Number) + line.count(Kind::Clock) > 0;
    !line.is_comment() && !has_value && !line.cells.iter().any(is_pair)
}

/// Returns the names in a line for `width` columns. LabVIEW adds a column for comments, and a
/// separator at the end of each row adds a column without a name.
fn fitting(line: &HeadLine, width: usize) -> Option<Vec<String>> {
    if line.cells[0].ends_with('=') {
        return None;
    }
    // Names are printed on terminals, so escape control characters.
    let mut names: Vec<String> = (line.cells.iter())
        .map(|name| escaped(name).into_owned())
        .collect();
    if let Some(first) = names.first_mut()
        && let Some(comment) = first.strip_prefix('#').or(first.strip_prefix("% "))
    {
        *first = comment.trim_start_matches(['#', ' ']).to_owned();
        // The comment mark has a cell of its own.
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

/// True if a line under the names has units or repeats a single word.
fn is_units(line: &HeadLine) -> bool {
    let mut cells = line.cells.iter().filter(|cell| !cell.is_empty());
    let is_bracketed = |cell: &String| cell.starts_with(['(', '[']) && cell.ends_with([')', ']']);
    let is_all_bracketed = cells.clone().all(is_bracketed);
    let is_all_known = cells.clone().all(|cell| is_unit(cell));
    let has_time_unit = cells.clone().any(|cell| per_second(cell).is_some());
    let has_number = line.count(Kind::Number) > 0;
    let repeats = cells
        .next()
        .is_some_and(|first| cells.clone().count() > 0 && cells.all(|cell| cell == first));
    is_all_bracketed || is_all_known || has_time_unit || has_number || repeats
}

/// True if `line` describes the columns that `above` names: `above` must have distinct names for
/// all columns, and either name a time or have at least three columns while `line` names no time.
fn is_described(above: &HeadLine, line: &HeadLine) -> bool {
    let names_time = |line: &HeadLine| line.cells.iter().any(|cell| named(cell, false).is_some());
    let width = above.cells.len();
    let is_complete = above.count(Kind::Text) == width && is_names(above);
    let is_header = names_time(above) || width > 2 && !names_time(line);
    is_complete && is_header && (0..width).all(|at| !is_repeated(&above.cells, at))
}

/// True if a line has names: no values, and no remark or keys.
fn is_names(line: &HeadLine) -> bool {
    let has_value = line.count(Kind::Number) + line.count(Kind::Clock) > 0;
    !line.is_comment() && !has_value && !line.cells.iter().any(|cell| cell.ends_with(['=', ':']))
}

/// True if another column has the same name.
fn is_repeated(names: &[String], at: usize) -> bool {
    let mut others = names.iter().enumerate().filter(|(other, _)| *other != at);
    others.any(|(_, name)| *name == names[at])
}

/// Prefixes repeated names with group names, and replaces missing names by group names. A group
/// extends up to the next group's name. Returns the line on which the names begin.
fn name_by_group(names: &mut [String], lines_above: &[HeadLine], mut at: usize) -> usize {
    for line in lines_above.iter().rev() {
        let is_open: Vec<bool> = (0..names.len())
            .map(|column| is_repeated(names, column))
            .collect();
        let is_groups = fitting(line, names.len()).is_some() && is_names(line);
        if !is_groups || !is_open.contains(&true) {
            break;
        }
        at -= 1;
        let mut group = "";
        for ((name, cell), is_open) in names.iter_mut().zip(&line.cells).zip(is_open) {
            if !cell.is_empty() {
                group = cell;
            }
            if is_open && group != name {
                let joined = format!("{} {name}", escaped(group));
                joined.trim().clone_into(name);
            }
        }
    }
    at
}

/// Returns the line of units between header and first row, if there is one.
pub fn unit_row(lines: &[HeadLine], first: usize, header: Option<u64>) -> Option<&HeadLine> {
    let above = &lines[first.checked_sub(1)?];
    let width = lines[first].cells.len();
    let is_below = header.is_some_and(|header| header < above.number);
    (is_below && above.cells.len() == width && is_units(above)).then_some(above)
}
