//! A small SVG writer: the few shapes a plot needs, coordinates in pixels to a tenth.

use std::fmt::Write;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Anchor {
    Start,
    Middle,
    End,
}

#[derive(Debug)]
pub struct Svg {
    body: String,
}

impl Svg {
    /// A picture of `width` by `height` pixels on a white card, legible on a light and on a dark
    /// page. `title` is for screen readers; `style` is CSS.
    pub fn new(width: f64, height: f64, title: &str, style: &str) -> Self {
        let mut body = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" width=\"{width}\" height=\"{height}\" role=\"img\">\n"
        );
        // Writing to a string cannot fail, here and below.
        let _ = writeln!(
            body,
            "<title>{}</title>\n<style>{style}</style>",
            escape(title)
        );
        let mut svg = Self { body };
        svg.push(&format!(
            "<rect x=\"0.5\" y=\"0.5\" width=\"{}\" height=\"{}\" rx=\"8\" class=\"card\"/>",
            width - 1.0,
            height - 1.0
        ));
        svg
    }

    /// An element as it stands in the file.
    pub fn push(&mut self, element: &str) {
        self.body.push_str(element);
        self.body.push('\n');
    }

    /// A text on one line; `y` is its baseline.
    pub fn text(&mut self, x: f64, y: f64, anchor: Anchor, class: &str, text: &str) {
        let anchor = match anchor {
            Anchor::Start => "start",
            Anchor::Middle => "middle",
            Anchor::End => "end",
        };
        let text = escape(text);
        self.push(&format!("<text x=\"{x:.1}\" y=\"{y:.1}\" text-anchor=\"{anchor}\" class=\"{class}\">{text}</text>"));
    }

    /// A text whose characters are `width` pixels wide each, blanks included; `y` is its baseline.
    /// Blanks at its end are left out.
    pub fn cells(&mut self, x: f64, y: f64, width: f64, class: &str, text: &str) {
        let text = text.trim_end();
        let length = width * text.chars().count() as f64;
        let text = escape(text);
        self.push(&format!(
            "<text x=\"{x:.1}\" y=\"{y:.1}\" textLength=\"{length:.1}\" class=\"{class}\">{text}</text>"
        ));
    }

    pub fn line(&mut self, from: (f64, f64), to: (f64, f64), class: &str) {
        let ((x1, y1), (x2, y2)) = (from, to);
        self.push(&format!(
            "<path d=\"M{x1:.1} {y1:.1}L{x2:.1} {y2:.1}\" class=\"{class}\"/>"
        ));
    }

    pub fn rect(&mut self, x: f64, y: f64, width: f64, height: f64, class: &str) {
        self.push(&format!(
            "<rect x=\"{x:.1}\" y=\"{y:.1}\" width=\"{width:.1}\" height=\"{height:.1}\" class=\"{class}\"/>"
        ));
    }

    pub fn path(&mut self, points: &[(f64, f64)], class: &str) {
        let mut d = String::new();
        for (i, (x, y)) in points.iter().enumerate() {
            let _ = write!(d, "{}{x:.1} {y:.1}", if i == 0 { "M" } else { "L" });
        }
        self.push(&format!("<path d=\"{d}\" class=\"{class}\"/>"));
    }

    /// Dots, as a path of strokes without length and with round ends.
    pub fn dots(&mut self, points: &[(f64, f64)], class: &str) {
        let mut d = String::new();
        for (x, y) in points {
            let _ = write!(d, "M{x:.1} {y:.1}h0");
        }
        self.push(&format!("<path d=\"{d}\" class=\"{class}\"/>"));
    }

    pub fn finish(mut self) -> String {
        self.push("</svg>");
        self.body
    }
}

fn escape(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_is_escaped() {
        let mut svg = Svg::new(10.0, 10.0, "a<b", "");
        svg.text(1.0, 2.0, Anchor::End, "label", "R&D");
        let text = svg.finish();
        assert!(
            text.contains("<title>a&lt;b</title>") && text.contains(">R&amp;D</text>"),
            "{text}"
        );
    }
}
