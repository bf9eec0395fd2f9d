//! The unit of a window's frequency: cycles in time, or by place on the surface.

use crate::scan::Scan;
use crate::surface::profile::Profile;
use crate::window::Window;
use core::f32::consts::PI;
use ridgetone_proto::telemetry::Abscissa;
use ridgetone_tone::{Fit, Fitter, FrameSource, FrameSpan, Overwritten};

/// A fit, and the unit of its frequency.
#[derive(Clone, Debug)]
pub struct Fitted {
    /// The fit.
    pub fit: Fit,
    /// What its frequency is over.
    pub abscissa: Abscissa,
    /// The frequency in hertz or in cycles per millimetre, over that of the fit.
    pub per_unit: f32,
    /// From one slot of the scan to the next, in the fit's unit: frames, or millimetres.
    pub per_slot: f32,
    /// The slot whose moment the fit's phases refer to.
    pub slot: f32,
    /// The scan.
    pub scan: Scan,
}

impl Fitted {
    /// A taxel's phase as if a scan were read at once, turns.
    pub fn turns(&self, taxel: usize) -> f32 {
        // Its slot is later in the scan.
        let ahead = self.fit.frequency * self.per_slot * (self.scan.slot_of(taxel) as f32 - self.slot);
        self.fit.channels.get(taxel).map_or(0.0, |channel| channel.phase_rad / (2.0 * PI)) - ahead
    }

    /// From one frame to the next, in the fit's unit: with a speed profile, millimetres.
    pub fn per_frame(&self) -> f32 {
        self.per_slot * self.scan.slots as f32
    }
}

/// Fits a window by the places that a speed profile leads to; without one, in time. Fails if frames were overwritten.
pub fn fit(
    fitter: &mut Fitter,
    window: &Window,
    source: &mut dyn FrameSource,
    interferer_hz: f32,
    profile: Option<&Profile>,
) -> Result<Fitted, Overwritten> {
    let scan = Scan::new(&window.plan);
    let Scan { channels, slots, conversion_ns, .. } = scan;
    // Frames hold codes.
    let mut span = FrameSpan::new(source, window.first, window.frames).with_quantization(1.0);
    if interferer_hz > 0.0 {
        span = span.with_interferer(interferer_hz / window.frame_rate_hz);
    }
    let Some(profile) = profile else {
        let (per_unit, per_slot) = (window.frame_rate_hz, 1.0 / slots as f32);
        let fit = fitter.fit(&mut span);
        // By reference: a copy would lie on the stack beside it, during the fit.
        let fit = fit.as_ref().map_err(|overwritten| *overwritten)?;
        return Ok(Fitted { fit: fit.clone(), abscissa: Abscissa::Time, per_unit, per_slot, slot: 0.0, scan });
    };
    // By the converter's own clock: a single frame's time stamp has the jitter of its interrupt.
    let frame_us = 1e6 / window.frame_rate_hz;
    let last = window.frames.saturating_sub(1);
    // The middle of the taxels' slots, from the first: by place, all taxels of a frame count as read there. While the speed
    // changes, the error of that has opposite signs in the first and in the last taxels.
    let middle_slot = 0.5 * (channels as f32 - 1.0);
    let middle_us = (middle_slot * conversion_ns as f32 * 1e-3) as u32;
    let start_us =
        window.end_us.saturating_add(middle_us.into()).saturating_sub(((last as f32 * frame_us) as u32).into());
    let way = profile.way_from(start_us);
    let place_mm = |frame: u32| way.place_mm((frame as f32 * frame_us) as u32);
    let per_slot = place_mm(last) / (last.max(1) * slots) as f32;
    let fit = match span.along(&place_mm) {
        Some(mut span) => fitter.fit(&mut span)?,
        None => Fit::at_rest(window.frames),
    };
    Ok(Fitted { fit, abscissa: Abscissa::Place, per_unit: 1.0, per_slot, slot: middle_slot, scan })
}
