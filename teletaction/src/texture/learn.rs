//! A texture from recordings of a slide at a known speed.

use anyhow::{Result, bail, ensure};
use ridgetone_host::harmonics::{Harmonic, fit as fit_harmonics};
use ridgetone_host::names::name;
use ridgetone_host::part::Part;
use ridgetone_host::samples::Samples;
use ridgetone_host::table_fit::{Selection, columns};
use ridgetone_host::touch_part;
use ridgetone_proto::telemetry::Status;
use ridgetone_stimulus::{HARMONICS_MAX, Texture};
use std::f64::consts::{PI, TAU};

/// Speed over the surface with its standard deviation, millimetres per second.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Speed {
    pub mm_s: f64,
    pub sigma_mm_s: f64,
}

/// A texture, and what it was learned from.
#[derive(Clone, Debug, PartialEq)]
pub struct Learned {
    pub texture: Texture,
    pub recordings: usize,
    /// Scatter of the recordings' periods over what their standard deviations allow; 0 of one.
    pub scatter: f64,
}

/// One recording's part.
struct One {
    period_mm: f64,
    /// Standard deviation without the speed's, which all recordings share.
    sigma_mm: f64,
    power: f64,
    /// Products of each overtone with the fundamental, real and imaginary, and the fundamental's
    /// square.
    overtones: [(f64, f64); HARMONICS_MAX - 1],
    fundamental: f64,
}

/// Learns from recordings of one texture at one speed. `force_n` is 0 if it is unknown. A fit that
/// is not good is refused unless any is accepted.
///
/// The period is the mean of the recordings, weighted by their uncertainties; if they scatter more
/// than these allow, sigma grows with the scatter. Power is half of the squared amplitude, the mean
/// of the channels, in the square of the recording's unit.
pub fn learn(
    files: &[Samples],
    selection: &Selection,
    speed: Speed,
    force_n: f64,
    accepts_any: bool,
) -> Result<Learned> {
    ensure!(!files.is_empty(), "no recording: give at least one");
    let all = files
        .iter()
        .map(|file| one(file, selection, speed.mm_s, accepts_any))
        .collect::<Result<Vec<_>>>()?;
    let weight = |one: &One| one.sigma_mm.max(1e-9).powi(-2);
    let weights: f64 = all.iter().map(weight).sum();
    let period_mm = all
        .iter()
        .map(|one| weight(one) * one.period_mm)
        .sum::<f64>()
        / weights;
    let freedom = all.len() as f64 - 1.0;
    let squares: f64 = all
        .iter()
        .map(|one| weight(one) * (one.period_mm - period_mm).powi(2))
        .sum();
    let scatter = if freedom > 0.0 {
        (squares / freedom).sqrt()
    } else {
        0.0
    };
    let own = weights.powf(-0.5) * scatter.max(1.0);
    let by_speed = period_mm * speed.sigma_mm_s / speed.mm_s;
    let mut texture = Texture {
        period_sigma_mm: own.hypot(by_speed) as f32,
        power: (all.iter().map(|one| one.power).sum::<f64>() / all.len() as f64) as f32,
        force_n: force_n as f32,
        ..Texture::new(period_mm as f32)
    };
    let fundamental: f64 = all.iter().map(|one| one.fundamental).sum();
    for (n, overtone) in texture.overtones.iter_mut().enumerate() {
        let (re, im) = all.iter().fold((0.0, 0.0), |(re, im), one| {
            (re + one.overtones[n].0, im + one.overtones[n].1)
        });
        let amplitude = re.hypot(im) / fundamental;
        ensure!(
            amplitude <= 1.0,
            "harmonic {} has {amplitude:.2} times the amplitude of the first: the period is not that of the texture; give the sliding part with --from and --to",
            n + 2
        );
        overtone.amplitude = amplitude as f32;
        overtone.phase_cycles = (im.atan2(re) / TAU) as f32;
    }
    texture.check()?;
    Ok(Learned {
        texture,
        recordings: all.len(),
        scatter,
    })
}

fn one(file: &Samples, selection: &Selection, mm_s: f64, accepts_any: bool) -> Result<One> {
    let found = touch_part::fit(file, selection, false, &mut |_| {})?;
    let status = name(found.status);
    let Some(frequency) = found.tone.frequency() else {
        bail!(
            "{}: the fit is `{status}`: it has no tone; give the sliding part with --from and --to",
            file.name()
        )
    };
    ensure!(
        found.status == Status::Good || accepts_any,
        "{}: the fit is `{status}`, and a texture needs a good one: look at it with `ridgetone fit`, give another part with --from and --to, or take it as it is with --accept",
        file.name()
    );
    let selection = &Selection {
        from_s: Some(found.from_s),
        to_s: Some(found.to_s),
        ..selection.clone()
    };
    let (hz, sigma_hz) = (frequency.value, frequency.sigma);
    let mut rows = file.open()?;
    let used = columns(&*rows, selection)?;
    let part = Part::read(&mut *rows, selection, usize::MAX, &mut |_| {})?;
    let (first, last) = (part.times_s[0], part.times_s[part.rows() - 1]);
    let t_s: Vec<f64> = part
        .times_s
        .iter()
        .map(|t_s| t_s - 0.5 * (first + last))
        .collect();
    let interferer_hz = found.tone.interferer_hz.map(f64::from);
    // Overtones beyond half of the rate would be aliases.
    let count = ((0.45 * found.rate_hz / hz) as usize).clamp(1, HARMONICS_MAX);
    let mut one = One {
        period_mm: mm_s / hz,
        sigma_mm: mm_s / hz * sigma_hz / hz,
        power: 0.0,
        overtones: Default::default(),
        fundamental: 0.0,
    };
    let mut channels = 0.0;
    for (column, channel) in used.iter().zip(&found.channels) {
        if !channel.usable {
            continue;
        }
        let values: Vec<Option<f32>> = part
            .column(*column)
            .iter()
            .map(|value| value.is_finite().then_some(*value as f32))
            .collect();
        let Some(fitted) = fit_harmonics(&t_s, &values, hz, count as u8, interferer_hz) else {
            continue;
        };
        let Some(first) = fitted.harmonics.first() else {
            continue;
        };
        channels += 1.0;
        let amplitude = f64::from(first.amplitude_v);
        one.power += 0.5 * amplitude * amplitude;
        one.fundamental += amplitude * amplitude;
        for (n, harmonic) in fitted.harmonics.iter().enumerate().skip(1) {
            let (re, im) = against(first, harmonic, n + 1);
            one.overtones[n - 1].0 += re;
            one.overtones[n - 1].1 += im;
        }
    }
    ensure!(
        channels > 0.0,
        "{}: no channel has enough rows",
        file.name()
    );
    one.power /= channels;
    Ok(one)
}

/// A harmonic times the fundamental's amplitude, with its phase against `number` turns of the
/// fundamental, both as sines.
fn against(first: &Harmonic, harmonic: &Harmonic, number: usize) -> (f64, f64) {
    // cos(k u + p) with cos(u + q) = sin(v): k u + p = k v - k (q + pi/2) + p, and a cosine is a
    // sine a quarter of a turn later.
    let k = number as f64;
    let phase =
        f64::from(harmonic.phase_rad) - k * f64::from(first.phase_rad) - (k - 1.0) * 0.5 * PI;
    let size = f64::from(first.amplitude_v) * f64::from(harmonic.amplitude_v);
    (size * phase.cos(), size * phase.sin())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 16 channels, each with a gain and a phase of its own, of one surface: sin(v) + 0.3 sin(2 v +
    /// 0.1 turns).
    fn samples(name: &str, hz: f64) -> Samples {
        let value = move |row: usize, channel: usize| {
            let turn = TAU * (hz * row as f64 / 500.0 + 0.07 * channel as f64);
            let noise = 1e-4 * ((row * 7919 + channel * 104_729) % 1000) as f64 / 1000.0;
            (1.0 + 0.1 * channel as f64) * (turn.sin() + 0.3 * (2.0 * turn + 0.1 * TAU).sin())
                + noise
        };
        let names = (0..16).map(|channel| format!("c{channel}")).collect();
        Samples::array(name, names, 1000, std::sync::Arc::new(value), None)
    }

    #[test]
    fn period_power_and_overtones_are_found() {
        let selection = Selection {
            rate_hz: Some(500.0),
            ..Selection::default()
        };
        let speed = Speed {
            mm_s: 30.0,
            sigma_mm_s: 0.03,
        };
        let learned = learn(
            &[samples("a", 20.0), samples("b", 20.0)],
            &selection,
            speed,
            0.5,
            false,
        )
        .expect("a texture");
        let texture = learned.texture;
        assert!((texture.period_mm - 1.5).abs() < 1e-4, "{texture:?}");
        // A thousandth of the speed is a thousandth of the period.
        assert!(
            (texture.period_sigma_mm - 0.0015).abs() < 1e-4,
            "{texture:?}"
        );
        let power: f64 = (0..16)
            .map(|c| 0.5 * (1.0 + 0.1 * f64::from(c)).powi(2))
            .sum::<f64>()
            / 16.0;
        assert!(
            (f64::from(texture.power) / power - 1.0).abs() < 1e-3,
            "{texture:?}"
        );
        let [second, third, fourth] = texture.overtones;
        assert!(
            (second.amplitude - 0.3).abs() < 1e-3 && (second.phase_cycles - 0.1).abs() < 1e-3,
            "{second:?}"
        );
        assert!(third.amplitude < 1e-3 && fourth.amplitude < 1e-3);
        assert_eq!((texture.force_n, learned.recordings), (0.5, 2));
    }

    #[test]
    fn recordings_that_disagree_make_sigma_grow() {
        let selection = Selection {
            rate_hz: Some(500.0),
            ..Selection::default()
        };
        let speed = Speed {
            mm_s: 30.0,
            sigma_mm_s: 0.0,
        };
        let learned = learn(
            &[samples("a", 20.0), samples("b", 20.2)],
            &selection,
            speed,
            0.0,
            false,
        )
        .expect("a texture");
        // The periods differ by 15 um: half of it is the standard deviation of their mean.
        assert!(
            (learned.texture.period_sigma_mm - 0.0074).abs() < 1e-3,
            "{learned:?}"
        );
        assert!(learned.scatter > 10.0);
    }
}
