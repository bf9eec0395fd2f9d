//! Applies the paper's equations in the crate `ridgetone-feel` to amplitude spectra from NumPy.

use pyo3::buffer::PyBuffer;
use pyo3::prelude::*;
use ridgetone_feel::{
    Absent, Firing, Indices, MeanFiring, Measured, PAPER_WINDOW_S, ROUGH, Receptor, Reference,
    SOFT, Score, SpectralLine, Windows,
};

/// Name, value and standard deviation, or the reason why there is none.
type Row = (&'static str, Option<(f32, f32)>, Option<String>);

/// Amplitude spectra by window and channel.
struct Spectra {
    values: Vec<f32>,
    channels: usize,
    bins: usize,
    windows: Windows,
}

impl Spectra {
    fn new(spectra: &Bound<'_, PyAny>, measured_s: f32) -> PyResult<Self> {
        let buffer = PyBuffer::<f32>::get(spectra)?;
        let &[_, channels, bins] = buffer.shape() else {
            return Err(crate::UsageError::new_err(
                "spectra have three dimensions: windows, channels and bins",
            ));
        };
        Ok(Self {
            values: buffer.to_vec(spectra.py())?,
            channels,
            bins,
            windows: Windows {
                measured_s,
                wanted_s: PAPER_WINDOW_S,
            },
        })
    }

    /// Iterates over windows; each yields the spectra of all channels.
    fn by_window(&self) -> impl Iterator<Item = std::slice::ChunksExact<'_, f32>> {
        let windows = self.values.chunks_exact((self.channels * self.bins).max(1));
        windows.map(|window| window.chunks_exact(self.bins.max(1)))
    }
}

fn pair(measured: Measured) -> (f32, f32) {
    (measured.value, measured.sigma)
}

/// Returns the intensities of the four receptors and the two scores, from spectra in um peak to
/// peak.
#[pyfunction]
pub fn feel(
    spectra_um: &Bound<'_, PyAny>,
    measured_s: f32,
    sigma_fraction: f32,
    m: Option<(f32, f32)>,
) -> PyResult<Vec<Row>> {
    let spectra = Spectra::new(spectra_um, measured_s)?;
    let mut firing = MeanFiring::default();
    for window in spectra.by_window() {
        let channels: Vec<Firing> = window
            .map(|spectrum| Firing::new(spectrum, spectra.windows))
            .collect();
        firing.push(&Firing::mean(channels.iter()));
    }
    let indices = Indices::new(
        &firing,
        sigma_fraction,
        m.map(|(value, sigma)| Measured { value, sigma }),
    );
    let receptor = |receptor: Receptor| -> Row {
        let absent = Firing::absent(receptor, spectra.bins, spectra.windows.bin_hz());
        let found = indices.get(receptor as usize).map(pair);
        (receptor.name(), found, absent.map(reason))
    };
    let score = |name, score: Score| -> Row {
        let missing = score.missing(&indices).map(|index| {
            Receptor::ALL
                .get(index)
                .map_or("needs m".to_owned(), |r| format!("needs {}", r.name()))
        });
        (name, score.of(&indices).map(pair), missing)
    };
    let scores = [score("soft", SOFT), score("rough", ROUGH)];
    Ok(Receptor::ALL
        .map(receptor)
        .into_iter()
        .chain(scores)
        .collect())
}

fn reason(absent: Absent) -> String {
    match absent {
        Absent::RateTooLow(hz) => format!("needs more than {hz} rows a second"),
        Absent::WindowTooShort => "needs a longer window".to_owned(),
    }
}

/// A surface of known roughness, from a `dict` with these keys.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct Surface {
    ra_um: f32,
    ra_sigma_um: f32,
    rsm_mm: f32,
    speed_mm_s: f32,
}

/// Returns each channel's conversion factor with its standard deviation; `None` without a line at
/// the reference's frequency. `amplitudes` are those at this frequency, by window and channel.
#[pyfunction]
pub fn volts_per_um(
    amplitudes: Vec<Vec<f32>>,
    spectra: &Bound<'_, PyAny>,
    measured_s: f32,
    surface: Surface,
) -> PyResult<Vec<Option<(f32, f32)>>> {
    let spectra = Spectra::new(spectra, measured_s)?;
    let reference = Reference {
        ra_um: Measured {
            value: surface.ra_um,
            sigma: surface.ra_sigma_um,
        },
        rsm_mm: surface.rsm_mm,
        speed_mm_s: surface.speed_mm_s,
    };
    let cycles = reference.frequency_hz() * measured_s;
    let mut lines = vec![Vec::new(); spectra.channels];
    for (window, amplitudes) in spectra.by_window().zip(&amplitudes) {
        for ((spectrum, amplitude), lines) in window.zip(amplitudes).zip(&mut lines) {
            lines.push(SpectralLine::new(*amplitude, spectrum, cycles));
        }
    }
    let conversion = |lines: &Vec<SpectralLine>| {
        SpectralLine::mean(lines, spectra.windows)
            .map(|amplitude| pair(reference.per_um(amplitude)))
    };
    Ok(lines.iter().map(conversion).collect())
}
