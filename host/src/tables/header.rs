//! The names of the columns, above the first row.

use super::cells::Kind;
use super::head_line::HeadLine;
use super::refused::Refused;
use super::units::per_second;
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
    if let Some(titled) = titles(&lines[..first], width) {
        return Ok(titled);
    }
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

/// The names of a line such as `ChannelTitle=`, a tab, and a name for each column but the time.
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

/// True if a line of another length than the rows is a header: words alone, and no remark or pairs
/// of a key and its value.
fn is_words(line: &HeadLine) -> bool {
    let is_pair = |cell: &String| {
        let mut words = cell.split([' ', '=', ':']).filter(|word| !word.is_empty());
        let is_number = |word: &str| word.parse::<f64>().is_ok();
        words.clone().count() > 1 && words.any(is_number) || cell.ends_with(['=', ':'])
    };
    let has_value = line.count(Kind::Number) + line.count(Kind::Clock) > 0;
    !line.is_comment() && !has_value && !line.cells.iter().any(is_pair)
}

/// The names that a line gives to so many columns. LabVIEW has one more, for comments, and a
/// separator at the end of each row makes one without a name.
fn fitting(line: &HeadLine, width: usize) -> Option<Vec<String>> {
    if line.cells[0].ends_with('=') {
        return None;
    }
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

/// True if a line under the names gives units, or repeats one word: in brackets, of a time, or with
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
