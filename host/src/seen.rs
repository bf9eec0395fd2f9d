//! Explains why a recording has no estimate.

use ridgetone_proto::telemetry::Event;

#[derive(Default)]
pub struct Seen {
    estimates: u64,
    /// Length of the longest slide that has ended, seconds.
    slide_s: Option<f64>,
}

impl Seen {
    pub fn take(&mut self, event: &Event) {
        match event {
            Event::Estimate(_) => self.estimates += 1,
            Event::Slide(slide) => {
                let length_s = |end_us: u64| (end_us - slide.start_us) as f64 * 1e-6;
                let longest_s = self.slide_s.unwrap_or(0.0);
                let ended_s = slide.end_us.map(length_s);
                self.slide_s = ended_s
                    .map(|ended_s| ended_s.max(longest_s))
                    .or(self.slide_s);
            }
            _ => {}
        }
    }

    /// Explains why there is no estimate. `without_slide` is the advice if there was no slide.
    pub fn why_no_estimate(&self, window_s: f32, without_slide: &str) -> Option<String> {
        if self.estimates > 0 {
            return None;
        }
        Some(match self.slide_s {
            Some(slide_s) => format!(
                "its longest slide, {slide_s:.2} s, fills no window of {window_s} s: choose a shorter one (`window_s`)"
            ),
            None => {
                format!("no slide was found: one begins with contact and hold; {without_slide}")
            }
        })
    }
}
