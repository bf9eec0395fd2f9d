//! The simulated converter in volts.

use ridgetone_finger::converter::Ads1258Plan;
use ridgetone_host::input::REFERENCE_V;
use ridgetone_proto::plan::Plan;

/// Volts of one code (SBAS297G: VREF / 780000h).
pub(crate) const CODE_V: f64 = REFERENCE_V / 7_864_320.0;

/// Noise of a conversion by DRATE 0 to 3, microvolts rms (SBAS297G, noise performance).
const NOISE_UV: [f64; 4] = [2.8, 4.5, 7.9, 12.0];
/// CHOP divides it by this (SBAS297G).
const CHOP_FACTOR: f64 = 1.4;

/// Noise of a conversion of the ADS1258 in a plan, volts rms.
pub fn converter_noise_v(plan: &Plan) -> f64 {
    let own = Ads1258Plan::of(plan);
    let chopped = if own.chop { CHOP_FACTOR } else { 1.0 };
    1e-6 * NOISE_UV[usize::from(own.data_rate & 3)] / chopped
}
