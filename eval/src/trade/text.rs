//! The trade in short, for a terminal: the whole of it is in the document.

use super::{BarResult, Trade, tables};
use crate::baselines::Method;
use crate::bench::{HARMONICS, WINDOWS_S};
use ridgetone_proto::settings::TAXELS;
use std::fmt;

impl fmt::Display for Trade {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [.., most] = HARMONICS;
        writeln!(
            f,
            "RMS error in percent of the frequency, 20 dB, a grating with overtones, by length of the window:"
        )?;
        write!(f, "{:<24}", "window, s")?;
        WINDOWS_S.iter().try_for_each(|window_s| write!(f, " {window_s:>9}"))?;
        let mut line = |name: &str, of: &dyn Fn(f64) -> String| {
            write!(f, "\n{name:<24}")?;
            WINDOWS_S.iter().try_for_each(|window_s| write!(f, " {:>9}", of(*window_s)))
        };
        let ours = |window_s: f64, channels| self.ridgetone(window_s, most, most, channels);
        for channels in [TAXELS as u8, 4, 2, 1] {
            let name = format!("Ridgetone, {channels} channels");
            line(&name, &|window_s| ours(window_s, channels).map_or_else(String::new, tables::percent))?;
        }
        for method in Method::ALL {
            line(method.name(), &|window_s| {
                self.baseline(window_s, most, method).next().map_or_else(String::new, tables::percent)
            })?;
        }
        writeln!(f, "\n")?;
        for BarResult { bar, limit, measured, met } in self.bars.verdicts() {
            writeln!(f, "{}: {bar}: {limit}; {measured}", if met { "met" } else { "NOT MET" })?;
        }
        let above = self.bars.cells.iter().filter(|cell| cell.is_above());
        above.into_iter().try_for_each(|cell| match cell.accuracy.error {
            Some(error) => writeln!(f, "  above: {}: {:.3} +- {:.3}", cell.setting, error.ratio, error.ratio_sigma),
            None => writeln!(f, "  above: {}: no estimate", cell.setting),
        })
    }
}
