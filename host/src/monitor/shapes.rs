//! Frames, bars and dots of a screen as shapes: as characters they have gaps between rows and
//! columns, and where a browser takes them from another font, they are not as wide as a cell.

use ratatui::buffer::Buffer;
use std::fmt::Write;

/// Ways out of the middle of a cell.
const LEFT: u8 = 1;
const RIGHT: u8 = 2;
const UP: u8 = 4;
const DOWN: u8 = 8;

/// The ways that the lines of a frame's character go.
fn ways(symbol: char) -> u8 {
    match symbol {
        '─' => LEFT | RIGHT,
        '│' => UP | DOWN,
        '┌' => RIGHT | DOWN,
        '┐' => LEFT | DOWN,
        '└' => RIGHT | UP,
        '┘' => LEFT | UP,
        _ => 0,
    }
}

/// Eighths of a cell that a bar fills.
fn eighths(symbol: char) -> u32 {
    match symbol {
        '▁'..='█' => u32::from(symbol) - u32::from('▁') + 1,
        _ => 0,
    }
}

/// Share of a row that a full bar fills: the rows stay apart.
const BAR: f64 = 0.9;

/// Dots of a Braille character, two columns of four: bits in Unicode's order.
fn dots(symbol: char) -> u32 {
    match symbol {
        '⠀'..='⣿' => u32::from(symbol) - u32::from('⠀'),
        _ => 0,
    }
}

/// Column and row in a cell of each bit of a Braille character.
const DOTS: [(f64, f64); 8] = [
    (0.0, 0.0),
    (0.0, 1.0),
    (0.0, 2.0),
    (1.0, 0.0),
    (1.0, 1.0),
    (1.0, 2.0),
    (0.0, 3.0),
    (1.0, 3.0),
];

/// Whether a cell is drawn as a shape.
pub fn is_shape(symbol: &str) -> bool {
    symbol
        .chars()
        .any(|symbol| ways(symbol) != 0 || eighths(symbol) != 0 || dots(symbol) != 0)
}

/// The cells of an image, from its top left corner on, pixels.
#[derive(Clone, Copy, Debug)]
pub struct Grid {
    pub left: f64,
    pub top: f64,
    pub cell: (f64, f64),
}

/// Paths of class `frame`, `bar` and `dot`; those without anything are left out.
pub fn shapes(image: &Buffer, grid: Grid) -> Vec<String> {
    let (columns, rows) = (image.area.width, image.area.height);
    let symbol = |column, row| image[(column, row)].symbol().chars().next().unwrap_or(' ');
    let x = |columns: f64| grid.left + grid.cell.0 * columns;
    let y = |rows: f64| grid.top + grid.cell.1 * rows;
    let (mut frame, mut bar, mut dot) = (String::new(), String::new(), String::new());
    // Writing to a string cannot fail.
    for row in 0..rows {
        let at = f64::from(row);
        for (from, to) in lines(columns, |column| ways(symbol(column, row)), [LEFT, RIGHT]) {
            let (middle, from, to) = (y(at + 0.5), x(from), x(to));
            let _ = write!(frame, "M{from:.1} {middle:.1}H{to:.1}");
        }
        let mut height = 0;
        // One column more, where the last bar ends.
        for column in 0..=columns {
            let next = if column < columns {
                eighths(symbol(column, row))
            } else {
                0
            };
            let left = x(f64::from(column));
            if height == 0 && next != 0 {
                let _ = write!(bar, "M{left:.1} {:.1}", y(at + 1.0));
            }
            if height != next {
                let top = y(at + 1.0 - BAR * f64::from(next) / 8.0);
                let _ = write!(bar, "H{left:.1}V{top:.1}");
            }
            height = next;
        }
        for column in 0..columns {
            let bits = dots(symbol(column, row));
            for (bit, (across, down)) in DOTS.into_iter().enumerate() {
                if bits >> bit & 1 == 1 {
                    let from_left = x(f64::from(column) + 0.25 + across / 2.0);
                    let from_top = y(at + 0.125 + down / 4.0);
                    let _ = write!(dot, "M{from_left:.1} {from_top:.1}h0");
                }
            }
        }
    }
    for column in 0..columns {
        for (from, to) in lines(rows, |row| ways(symbol(column, row)), [UP, DOWN]) {
            let (middle, from, to) = (x(f64::from(column) + 0.5), y(from), y(to));
            let _ = write!(frame, "M{middle:.1} {from:.1}V{to:.1}");
        }
    }
    [("frame", frame), ("bar", bar), ("dot", dot)]
        .into_iter()
        .filter(|(_, d)| !d.is_empty())
        .map(|(class, d)| format!("<path class=\"{class}\" d=\"{d}\"/>"))
        .collect()
}

/// Ends of the lines along so many cells, in cells. A line goes on where the next cell's comes from
/// it, and ends in the middle of a cell or at its edge.
fn lines(count: u16, ways: impl Fn(u16) -> u8, [back, on]: [u8; 2]) -> Vec<(f64, f64)> {
    let (mut lines, mut begun) = (Vec::new(), None);
    for cell in 0..count {
        let (comes, goes) = (ways(cell) & back != 0, ways(cell) & on != 0);
        if !comes && !goes {
            continue;
        }
        let at = f64::from(cell);
        let from = *begun.get_or_insert(if comes { at } else { at + 0.5 });
        if goes && cell + 1 < count && ways(cell + 1) & back != 0 {
            continue;
        }
        lines.push((from, if goes { at + 1.0 } else { at + 0.5 }));
        begun = None;
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_frame_a_bar_and_a_dot_are_three_paths_without_gaps() {
        let image = Buffer::with_lines(["┌─ a ┐", "│▁▁█ │", "│ ⠁  │", "└────┘"]);
        let grid = Grid {
            left: 0.0,
            top: 0.0,
            cell: (10.0, 20.0),
        };
        assert_eq!(
            shapes(&image, grid),
            [
                "<path class=\"frame\" d=\"M5.0 10.0H20.0M50.0 10.0H55.0M5.0 70.0H55.0M5.0 10.0V70.0M55.0 10.0V70.0\"/>",
                "<path class=\"bar\" d=\"M10.0 40.0H10.0V37.8H30.0V22.0H40.0V40.0\"/>",
                "<path class=\"dot\" d=\"M22.5 42.5h0\"/>",
            ]
        );
    }

    #[test]
    fn letters_are_no_shapes() {
        assert!(["│", "▄", "⣀"].into_iter().all(is_shape));
        assert!(!["a", " ", "•", "±"].into_iter().any(is_shape));
    }
}
