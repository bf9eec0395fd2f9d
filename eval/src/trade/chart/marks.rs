//! How each method looks: a marker's shape, filled or hollow, a dash, and a colour.

use ridgetone_host::svg::Svg;

/// Half the size of a marker, pixels.
pub const HALF: f64 = 5.0;

/// A look. Colours are those of Okabe and Ito, which most eyes can tell apart.
pub struct Look {
    corners: &'static [(f64, f64)],
    filled: bool,
    colour: &'static str,
    dash: &'static str,
    width: f64,
}

const SQUARE: &[(f64, f64)] = &[(-0.85, -0.85), (0.85, -0.85), (0.85, 0.85), (-0.85, 0.85)];
const DIAMOND: &[(f64, f64)] = &[(0.0, -1.2), (1.2, 0.0), (0.0, 1.2), (-1.2, 0.0)];
const UP: &[(f64, f64)] = &[(0.0, -1.1), (1.1, 0.85), (-1.1, 0.85)];
const DOWN: &[(f64, f64)] = &[(0.0, 1.1), (1.1, -0.85), (-1.1, -0.85)];
const CROSS: &[(f64, f64)] = &[
    (-1.0, -0.4),
    (-0.4, -0.4),
    (-0.4, -1.0),
    (0.4, -1.0),
    (0.4, -0.4),
    (1.0, -0.4),
    (1.0, 0.4),
    (0.4, 0.4),
    (0.4, 1.0),
    (-0.4, 1.0),
    (-0.4, 0.4),
    (-1.0, 0.4),
];
const SAND_GLASS: &[(f64, f64)] = &[(-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0), (1.0, 1.0)];
const OCTAGON: &[(f64, f64)] =
    &[(-0.4, -1.0), (0.4, -1.0), (1.0, -0.4), (1.0, 0.4), (0.4, 1.0), (-0.4, 1.0), (-1.0, 0.4), (-1.0, -0.4)];

const fn look(
    corners: &'static [(f64, f64)],
    filled: bool,
    colour: &'static str,
    dash: &'static str,
    width: f64,
) -> Look {
    Look { corners, filled, colour, dash, width }
}

/// Of as many methods as there are; Ridgetone's first.
pub const LOOKS: [Look; 9] = [
    look(OCTAGON, true, "#d1490c", "none", 2.4),
    look(OCTAGON, false, "#d1490c", "6 3", 2.0),
    look(SQUARE, true, "#555555", "none", 1.4),
    look(SQUARE, false, "#0072b2", "5 3", 1.4),
    look(DIAMOND, true, "#009e73", "none", 1.4),
    look(UP, false, "#8a1c4a", "8 3", 1.4),
    look(DOWN, true, "#0072b2", "none", 1.4),
    look(CROSS, true, "#8a1c4a", "2 2", 1.4),
    look(SAND_GLASS, false, "#222222", "9 3 2 3", 1.4),
];

impl Look {
    /// The line through a method's points.
    pub fn line(&self, svg: &mut Svg, points: &[(f64, f64)]) {
        let Self { colour, dash, width, .. } = self;
        svg.styled_path(points, &format!("stroke:{colour};stroke-width:{width};stroke-dasharray:{dash}"));
    }
}

/// A marker.
pub fn marker(svg: &mut Svg, look: &Look, (x, y): (f64, f64)) {
    let Look { corners, filled, colour, .. } = look;
    let closed = corners.iter().chain(corners.first());
    let points: Vec<(f64, f64)> = closed.map(|(dx, dy)| (x + HALF * dx, y + HALF * dy)).collect();
    let fill = if *filled { colour } else { "#fff" };
    svg.styled_path(&points, &format!("stroke:{colour};stroke-width:1.4;fill:{fill}"));
}
