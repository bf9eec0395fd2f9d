//! Power over period for one's own finger: equation 2 of Okamoto et al., fitted again.

use anyhow::{Result, ensure};
use ridgetone_host::harmonics::least_squares;
use ridgetone_stimulus::{AmplitudeLaw, Texture};

/// Unknowns of a polynomial of the fourth order.
const UNKNOWNS: usize = 5;

/// Fits the law to textures of at least five periods. The greatest power is that of the strongest
/// texture, whose vibration is then the actuator's greatest.
pub fn law(textures: &[Texture]) -> Result<AmplitudeLaw> {
    let mut periods: Vec<f32> = textures.iter().map(|texture| texture.period_mm).collect();
    periods.sort_by(f32::total_cmp);
    periods.dedup_by(|a, b| *a - *b < 1e-3 * *b);
    ensure!(
        periods.len() >= UNKNOWNS,
        "{} different periods: a law needs at least {UNKNOWNS}",
        periods.len()
    );
    ensure!(
        textures.iter().all(|texture| texture.power > 0.0),
        "a texture has no power: learn it from a recording"
    );
    let period_mm = (periods[0], periods[periods.len() - 1]);
    let rows: Vec<Vec<f64>> = textures
        .iter()
        .map(|texture| {
            (0..UNKNOWNS)
                .map(|order| f64::from(texture.period_mm).powi(order as i32))
                .collect()
        })
        .collect();
    let powers: Vec<f64> = textures
        .iter()
        .map(|texture| f64::from(texture.power))
        .collect();
    let greatest = powers.iter().copied().fold(0.0, f64::max);
    let (found, _) = least_squares(&rows, powers);
    let mut coefficients = [0.0; UNKNOWNS];
    coefficients
        .iter_mut()
        .zip(found)
        .for_each(|(coefficient, found)| *coefficient = found as f32);
    let law = AmplitudeLaw {
        coefficients,
        period_mm,
        power_max: greatest as f32,
    };
    law.check()?;
    Ok(law)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_papers_law_comes_back() {
        let texture = |period_mm: f32| Texture {
            power: AmplitudeLaw::OKAMOTO.power(period_mm),
            ..Texture::new(period_mm)
        };
        let textures: Vec<Texture> = (4..=10).map(|n| texture(0.2 * n as f32)).collect();
        let found = law(&textures).expect("a law");
        for n in 80..=200 {
            let period_mm = 0.01 * n as f32;
            let (found, wanted) = (
                found.power(period_mm),
                AmplitudeLaw::OKAMOTO.power(period_mm),
            );
            assert!(
                (found - wanted).abs() < 1.0,
                "{period_mm}: {found} {wanted}"
            );
        }
        assert_eq!(found.power_max, texture(2.0).power);
        assert!(law(&textures[..4]).is_err());
        assert!(law(&[textures[0]; 9]).is_err());
    }
}
