//! The screen as a moving picture: what it showed in a run, at the run's own speed.

use super::screen;
use super::shapes::{Grid, is_shape, shapes};
use super::view::View;
use crate::chart::Svg;
use crate::feed::{Feed, Following};
use crate::live::Connection;
use crate::stop;
use anyhow::{Result, ensure};
use ratatui::Terminal;
use ratatui::backend::TestBackend;
use ratatui::buffer::Buffer;
use ratatui::style::{Color, Modifier};
use std::time::Duration;

/// Columns and rows of the screen: the least with a row for each strip and with the log.
const SIZE: (u16, u16) = (100, 40);

/// Device time between two images, seconds.
const STEP_S: f64 = 0.2;

/// Most images: half a minute. What comes later is not shown.
const IMAGES_MAX: usize = 150;

/// How long the last image stays before the first one comes again, seconds.
const REST_S: f64 = 6.0;

/// A cell of the screen and the margin around all, pixels. At 12.46 px a character of DejaVu Sans Mono
/// is as wide as a cell, also in programs that ignore `textLength`.
const CELL: (f64, f64) = (7.5, 16.0);
const MARGIN: f64 = 12.0;

/// Follows a feed to its end, to [`IMAGES_MAX`] images, or until this process is to stop. Gives the
/// feed back, for its counts, and the picture as SVG. A reader who wants no motion, and a program
/// that knows none, gets the last image.
pub fn draw(feed: Feed, has_colour: bool) -> (Feed, Result<String>) {
    let mut following = Following::new(feed, None);
    let images = images(&mut following, has_colour);
    (
        following.finish(),
        images.and_then(|images| picture(&images)),
    )
}

fn images(following: &mut Following, has_colour: bool) -> Result<Vec<Buffer>> {
    let mut live = following.live();
    let mut view = View::new(following.raw.clone(), has_colour);
    let mut terminal = Terminal::new(TestBackend::new(SIZE.0, SIZE.1))?;
    let mut images = Vec::new();
    let mut due_s = None;
    while !stop::is_requested() && images.len() < IMAGES_MAX {
        let event = following.next(Duration::from_millis(50))?;
        following.fold(event.as_ref(), &mut live);
        view.raw = following.raw.clone();
        let is_over = live.now.connection == Connection::Over;
        let Some(now_s) = live.now.now_s else {
            continue;
        };
        let due_s = due_s.get_or_insert(now_s);
        if !is_over && now_s < *due_s {
            continue;
        }
        // The screen stood still meanwhile.
        while now_s - *due_s >= STEP_S
            && images.len() < IMAGES_MAX
            && let Some(latest) = images.last().cloned()
        {
            images.push(latest);
            *due_s += STEP_S;
        }
        terminal.draw(|frame| screen::draw(frame, &live, &view))?;
        images.push(terminal.backend().buffer().clone());
        *due_s += STEP_S;
        if is_over {
            break;
        }
    }
    images.truncate(IMAGES_MAX);
    Ok(images)
}

/// All images below each other, moved past a window of one image.
fn picture(images: &[Buffer]) -> Result<String> {
    ensure!(
        !images.is_empty(),
        "nothing was received: there is no picture to draw"
    );
    let (width, height) = (
        CELL.0 * f64::from(SIZE.0) + 2.0 * MARGIN,
        CELL.1 * f64::from(SIZE.1) + 2.0 * MARGIN,
    );
    let last = images.len() - 1;
    let moves_s = STEP_S * last as f64;
    let whole_s = moves_s + STEP_S + REST_S;
    // One keyframe for each time: of two Firefox takes the second, Chromium both.
    let (steps, moves) = (last.max(1), 100.0 * moves_s / whole_s);
    let end = -height * last as f64;
    let style = format!(
        "text{{font:12.46px 'DejaVu Sans Mono',Menlo,Consolas,monospace;fill:#222;white-space:pre}}.card{{fill:#fff;stroke:#bbb}}\
         path{{fill:none;stroke:#222}}.bar{{fill:#222;stroke:none}}.dot{{stroke-width:2;stroke-linecap:round}}\
         .bold{{font-weight:700}}.alarm{{fill:#b00020;font-weight:700}}\
         @media(prefers-color-scheme:dark){{text{{fill:#e4e6ea}}.card{{fill:#16191e;stroke:#444}}path{{stroke:#e4e6ea}}.bar{{fill:#e4e6ea}}.alarm{{fill:#ff8a80}}}}\
         .film{{transform:translateY({end}px);animation:film {whole_s:.1}s infinite}}\
         @keyframes film{{0%{{transform:none;animation-timing-function:steps({steps})}}\
         {moves:.3}%,100%{{transform:translateY({end}px)}}}}\
         @media(prefers-reduced-motion:reduce){{.film{{animation:none}}}}"
    );
    let mut svg = Svg::new(
        width,
        height,
        "The terminal's screen of ridgetone monitor during a touch",
        &style,
    );
    // The style's `white-space` says so to browsers alone.
    svg.push("<g class=\"film\" xml:space=\"preserve\">");
    for (number, image) in images.iter().enumerate() {
        let grid = Grid {
            left: MARGIN,
            top: height * number as f64 + MARGIN,
            cell: CELL,
        };
        shapes(image, grid).iter().for_each(|path| svg.push(path));
        for row in 0..SIZE.1 {
            let y = grid.top + CELL.1 * (f64::from(row) + 0.8);
            for (column, class, text) in runs(image, row) {
                svg.cells(
                    [MARGIN + CELL.0 * f64::from(column), y],
                    CELL.0,
                    class,
                    &text,
                );
            }
        }
    }
    svg.push("</g>");
    Ok(svg.finish())
}

/// The texts of a row that have one style: column, class and text. Blanks around them and shapes are
/// left out.
fn runs(image: &Buffer, row: u16) -> Vec<(u16, &'static str, String)> {
    let mut runs: Vec<(u16, &'static str, String)> = Vec::new();
    let mut goes_on = false;
    for column in 0..SIZE.0 {
        let cell = &image[(column, row)];
        let class = match cell {
            cell if cell.fg == Color::Red => "alarm",
            cell if cell
                .modifier
                .intersects(Modifier::BOLD | Modifier::REVERSED) =>
            {
                "bold"
            }
            _ => "text",
        };
        match runs.last_mut() {
            _ if is_shape(cell.symbol()) => goes_on = false,
            Some((_, last, text)) if goes_on && *last == class => text.push_str(cell.symbol()),
            _ if cell.symbol() == " " => goes_on = false,
            _ => {
                runs.push((column, class, cell.symbol().into()));
                goes_on = true;
            }
        }
    }
    runs
}
