//! Times of the touches in a recording.

use crate::digits::seconds;
use ridgetone_proto::telemetry::Event;
use serde::{Deserialize, Serialize};

/// A slide in the recording's own time, seconds.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct SlideTimes {
    pub start_s: f64,
    pub end_s: f64,
}

/// Times of contacts, completed slides and releases, seconds.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Touches {
    pub contacts_s: Vec<f64>,
    pub slides: Vec<SlideTimes>,
    pub releases_s: Vec<f64>,
}

/// Fields of the three events in JSON.
#[derive(Deserialize)]
struct JsonEvent {
    r#type: String,
    t_s: Option<f64>,
    start_s: Option<f64>,
    end_s: Option<f64>,
}

impl Touches {
    /// Adds a touch event; ignores other events.
    pub fn take(&mut self, event: &Event) {
        match event {
            Event::Contact(contact) => self.contacts_s.push(seconds(contact.t_us)),
            Event::Release(release) => self.releases_s.push(seconds(release.t_us)),
            Event::Slide(slide) => self.slides.extend(slide.end_us.map(|end_us| SlideTimes {
                start_s: seconds(slide.start_us),
                end_s: seconds(end_us),
            })),
            _ => {}
        }
    }

    /// Adds a touch event from a JSON object; ignores other events.
    pub fn take_json(&mut self, text: &str) -> serde_json::Result<()> {
        let is_touch = ["contact", "slide", "release"]
            .iter()
            .any(|name| text.contains(&format!(r#""type":"{name}""#)));
        if !is_touch {
            return Ok(());
        }
        let found: JsonEvent = serde_json::from_str(text)?;
        match (found.r#type.as_str(), found.t_s, found.start_s, found.end_s) {
            ("contact", Some(t_s), ..) => self.contacts_s.push(t_s),
            ("release", Some(t_s), ..) => self.releases_s.push(t_s),
            ("slide", _, Some(start_s), Some(end_s)) => {
                self.slides.push(SlideTimes { start_s, end_s });
            }
            _ => {}
        }
        Ok(())
    }

    /// Returns the touches with `by_s` added to all times.
    #[must_use]
    pub fn later(self, by_s: f64) -> Self {
        let later = |times: Vec<f64>| times.into_iter().map(|t_s| t_s + by_s).collect();
        Self {
            contacts_s: later(self.contacts_s),
            slides: self
                .slides
                .into_iter()
                .map(|slide| SlideTimes {
                    start_s: slide.start_s + by_s,
                    end_s: slide.end_s + by_s,
                })
                .collect(),
            releases_s: later(self.releases_s),
        }
    }
}
