//! The stimulus for an AudioWorklet, as WebAssembly: all functions take numbers, so neither side
//! touches the other's memory.
//!
//! `cargo xtask worklet` builds `teletaction/assets/touch/stimulus.wasm` from this file. The
//! command embeds the result, so building it does not need the target `wasm32-unknown-unknown`. A
//! test of the page compares the samples with the crate's, bit for bit.
//!
//! Each instance has one vibration. A function that can fail returns 1 on success, and 0 if the
//! numbers are impossible, in which case nothing has changed.
// Exporting a name is unsafe only because two names could be equal.
#![allow(unsafe_code)]

use crate::stimulus::{Actuator, AmplitudeLaw, Delay, Harmonic, Texture, Vibration};
use std::cell::RefCell;

/// Positions kept: one second of a pointer at 1000 Hz, which covers the paper's delays.
pub const POSITIONS: usize = 1024;

thread_local! {
    static VIBRATION: RefCell<Option<Vibration<POSITIONS>>> = const { RefCell::new(None) };
}

/// Runs `work` on the vibration; returns 1 if there is one and `work` succeeded.
fn with(work: impl FnOnce(&mut Vibration<POSITIONS>) -> bool) -> i32 {
    get(work).unwrap_or(false).into()
}

/// Runs `work` on the vibration, if any. Cannot panic: the code that prints panics would make up
/// most of the file.
fn get<T>(work: impl FnOnce(&mut Vibration<POSITIONS>) -> T) -> Option<T> {
    VIBRATION
        .try_with(|cell| {
            cell.try_borrow_mut()
                .ok()
                .and_then(|mut vibration| vibration.as_mut().map(work))
        })
        .ok()?
}

/// Starts a vibration: maximum voltage, cut-off in hertz, slew in volts per second, fade in
/// seconds; samples per second.
#[unsafe(no_mangle)]
pub extern "C" fn begin(
    voltage_v: f32,
    cutoff_hz: f32,
    slew_v_s: f32,
    fade_s: f32,
    rate_hz: f32,
) -> i32 {
    let actuator = Actuator {
        voltage_v,
        cutoff_hz,
        slew_v_s,
        fade_s,
        ..Actuator::PIEZO
    };
    // The command has applied the amplitude law, so here a texture's power is the amplitude
    // fraction.
    let law = AmplitudeLaw {
        power_max: 1.0,
        ..AmplitudeLaw::OKAMOTO
    };
    let Ok(made) = Vibration::new(actuator, law, rate_hz) else {
        return 0;
    };
    let set = VIBRATION.try_with(|cell| {
        cell.try_borrow_mut()
            .map(|mut vibration| *vibration = Some(made))
            .is_ok()
    });
    set.unwrap_or(false).into()
}

/// Sets a texture: period in millimetres, fraction of the maximum amplitude above 0 up to 1, then
/// for harmonics 2 to 4 the amplitude relative to the first, and the phase in cycles.
#[unsafe(no_mangle)]
#[allow(clippy::too_many_arguments, reason = "numbers are all that crosses")]
pub extern "C" fn texture(
    period_mm: f32,
    fraction: f32,
    a2: f32,
    p2: f32,
    a3: f32,
    p3: f32,
    a4: f32,
    p4: f32,
) -> i32 {
    let overtones = [(a2, p2), (a3, p3), (a4, p4)];
    let overtones = overtones.map(|(amplitude, phase_cycles)| Harmonic {
        amplitude,
        phase_cycles,
    });
    let texture = Texture {
        power: fraction,
        overtones,
        ..Texture::new(period_mm)
    };
    with(|vibration| fraction > 0.0 && fraction <= 1.0 && vibration.set_texture(&texture).is_ok())
}

/// Sets the delay, its standard deviation, and the wait for the next position, seconds.
#[unsafe(no_mangle)]
pub extern "C" fn delay(mean_s: f32, sigma_s: f32, wait_s: f32) -> i32 {
    with(|vibration| {
        Delay::new(mean_s, sigma_s, 1).is_ok_and(|delay| vibration.set_delay(delay, wait_s).is_ok())
    })
}

/// Sets the carrier, hertz; 0 for none.
#[unsafe(no_mangle)]
pub extern "C" fn carrier(frequency_hz: f32) -> i32 {
    let wanted = (frequency_hz != 0.0).then_some(frequency_hz);
    with(|vibration| vibration.set_carrier(wanted).is_ok())
}

/// Puts the hand down at a time in seconds and a position in millimetres.
#[unsafe(no_mangle)]
pub extern "C" fn down(t_s: f64, position_mm: f64) -> i32 {
    with(|vibration| {
        vibration.down(t_s, position_mm);
        true
    })
}

#[unsafe(no_mangle)]
pub extern "C" fn moved(t_s: f64, position_mm: f64) -> i32 {
    with(|vibration| vibration.moved(t_s, position_mm))
}

#[unsafe(no_mangle)]
pub extern "C" fn lift() -> i32 {
    with(|vibration| {
        vibration.lift();
        true
    })
}

/// Returns the next sample, -1 to 1.
#[unsafe(no_mangle)]
pub extern "C" fn sample(t_s: f64) -> f32 {
    get(|vibration| vibration.next(t_s)).unwrap_or(0.0)
}

/// Number of samples for which the hand's next position was not known.
#[unsafe(no_mangle)]
pub extern "C" fn late() -> u32 {
    get(|vibration| vibration.late()).unwrap_or(0)
}

/// Current amplitude as a fraction of the maximum.
#[unsafe(no_mangle)]
pub extern "C" fn amplitude() -> f32 {
    get(|vibration| vibration.amplitude()).unwrap_or(0.0)
}
