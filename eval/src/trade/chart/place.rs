//! Labels beside lines, out of the way of everything that is drawn and of each other.

use super::marks::{HALF, Look, marker};
use ridgetone_host::svg::{Anchor, Svg};

/// Height of a label's line, pixels.
pub const LABEL_HEIGHT: f64 = 14.0;
/// Above and below a label.
const LEAD: f64 = 2.0;
/// Room for a marker in front of a label.
const KEY: f64 = 20.0;
/// Between what is drawn and a label.
const GAP: f64 = 4.0;
/// Steps along a line at which it is in the way.
const STEP: f64 = 4.0;

/// Left, top, right, bottom.
type Rect = (f64, f64, f64, f64);

/// What is taken of the picture.
pub struct Places {
    within: Rect,
    taken: Vec<Rect>,
}

impl Places {
    /// Labels stay within a rectangle.
    pub fn new(within: Rect) -> Self {
        Self { within, taken: Vec::new() }
    }

    /// A marker is in the way.
    pub fn take_marker(&mut self, (x, y): (f64, f64)) {
        let half = 1.2 * HALF + GAP;
        self.taken.push((x - half, y - half, x + half, y + half));
    }

    /// A line is in the way.
    pub fn take_line(&mut self, (x1, y1): (f64, f64), (x2, y2): (f64, f64)) {
        let steps = ((x2 - x1).hypot(y2 - y1) / STEP).ceil().max(1.0);
        for step in 0..=steps as u32 {
            let share = f64::from(step) / steps;
            let (x, y) = (x1 + share * (x2 - x1), y1 + share * (y2 - y1));
            self.taken.push((x - 1.0, y - 1.0, x + 1.0, y + 1.0));
        }
    }

    /// Writes a label at one of some points, near it where there is room; a bit further off, with a thin line to its
    /// point, where there is none. A method's label has its marker in front.
    pub fn label(&mut self, svg: &mut Svg, points: &[(f64, f64)], text: &str, look: Option<&Look>) {
        let key = look.map_or(0.0, |_| KEY);
        let width = key + 4.0 + text.chars().map(width_of).sum::<f64>();
        for reach in 0..12 {
            let off = f64::from(reach) * 8.0;
            // The line's ends first: there it is alone.
            let ends = points.last().into_iter().chain(points.first()).chain(points);
            for &(x, y) in ends {
                let (side, above) = (1.2 * HALF + GAP + off, 1.2 * HALF + GAP + 0.5 * LABEL_HEIGHT + off);
                let corners = [
                    (x + side, y, Anchor::Start),
                    (x, y - above, Anchor::Middle),
                    (x, y + above, Anchor::Middle),
                    (x - side, y, Anchor::End),
                    (x + side, y - above, Anchor::Start),
                    (x + side, y + above, Anchor::Start),
                    (x - side, y - above, Anchor::End),
                    (x - side, y + above, Anchor::End),
                ];
                for (at, middle, anchor) in corners {
                    let left = match anchor {
                        Anchor::Start => at,
                        Anchor::Middle => at - 0.5 * width,
                        Anchor::End => at - width,
                    };
                    let rect = (left, middle - 0.5 * LABEL_HEIGHT, left + width, middle + 0.5 * LABEL_HEIGHT);
                    if self.is_free(rect) {
                        if reach > 1 {
                            svg.line((x, y), (at, middle), "axis");
                        }
                        let (background, class) = if look.is_some() { ("label", "name") } else { ("bare", "small") };
                        svg.rect(left, rect.1 - 1.0, width, LABEL_HEIGHT + 2.0, background);
                        if let Some(look) = look {
                            marker(svg, look, (left + 0.5 * KEY + 1.0, middle));
                        }
                        svg.text(left + key + 2.0, middle + 4.0, Anchor::Start, class, text);
                        self.taken.push((rect.0 - GAP, rect.1 - LEAD, rect.2 + GAP, rect.3 + LEAD));
                        return;
                    }
                }
            }
        }
    }

    fn is_free(&self, (left, top, right, bottom): Rect) -> bool {
        let within = self.within;
        let inside = left >= within.0 && top >= within.1 && right <= within.2 && bottom <= within.3;
        inside
            && self.taken.iter().all(|taken| left >= taken.2 || right <= taken.0 || top >= taken.3 || bottom <= taken.1)
    }
}

/// Width of a character of a label, pixels, on the safe side.
fn width_of(character: char) -> f64 {
    match character {
        'i' | 'l' | ' ' | ',' | '.' => 4.6,
        'f' | 'j' | 'r' | 't' | '-' => 6.2,
        'm' | 'w' | 'M' | 'W' => 12.6,
        _ => 8.6,
    }
}

#[cfg(test)]
mod tests {
    use super::super::marks::LOOKS;
    use super::*;

    #[test]
    fn labels_keep_off_lines_markers_and_each_other() {
        let mut places = Places::new((0.0, 0.0, 200.0, 100.0));
        let mut svg = Svg::new(200.0, 100.0, "", "");
        let points = [(20.0, 50.0), (150.0, 50.0)];
        places.take_line(points[0], points[1]);
        points.iter().for_each(|point| places.take_marker(*point));
        let drawn = places.taken.len();
        ["first", "second", "third"].iter().for_each(|text| places.label(&mut svg, &points, text, LOOKS.first()));
        let labels = places.taken.split_off(drawn);
        assert_eq!(labels.len(), 3);
        for (left, top, right, bottom) in labels {
            let label = (left + GAP, top + LEAD, right - GAP, bottom - LEAD);
            assert!(places.is_free(label), "{label:?} is on something");
            places.taken.push(label);
        }
    }
}
