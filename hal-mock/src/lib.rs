//! Simulated hardware for a PC, so that firmware code can be tested without a board: an ADS1258 that answers SPI byte
//! for byte in virtual time, scenes (the voltages that a finger gives) and traces (CSV).
//!
//! The crate has its own register map and depends on neither the driver nor the firmware: driver and simulator check
//! each other. Everything is deterministic for a seed, on every platform.
//!
//! # The modules, in the order of a signal
//! - [`scene`]: volts as a function of input and time; constants and added noise.
//! - [`sliding`]: the scene of the paper's protocol, with its truth: drawn channels, or a physical finger.
//! - [`scene_file`]: such a scene from a short TOML file.
//! - [`trace`]: scenes from and to CSV.
//! - [`chip`]: the ADS1258, with faults to inject.
//! - [`board`]: the chip's pins as embedded-hal 1.0 traits on one virtual clock; async with the feature `async`.
//! - [`bridge`]: how the firmware in an emulator reaches the chip. All that is left without the feature `simulator`.
//!
//! ```
//! use embedded_hal::{digital::OutputPin, spi::SpiDevice};
//! use hal_mock::{Options, SimulatedBoard, Sliding, SlidingScene};
//!
//! let scene = SlidingScene::new(Sliding::default())?;
//! let board = SimulatedBoard::new(scene, Options::default());
//! let (mut spi, mut start) = (board.spi(), board.start_pin());
//! spi.write(&[0x70, 0x02, 0x31])?; // CONFIG0: status byte; CONFIG1: DRATE 1, DLY 3
//! start.set_high()?;
//! let drdy_ns = board.wait_for_drdy().expect("the scene has begun");
//! let mut read = [0x30, 0, 0, 0, 0]; // read by command: status and 24 bits
//! spi.transfer_in_place(&mut read)?;
//! assert_eq!(read[1], 0x88); // new data from AIN0
//! assert_eq!(drdy_ns, 167_083); // 128 (16 + 4) + 68 cycles of 15.72864 MHz
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # What is modelled, and its sources
//! From the datasheet SBAS297G unless stated otherwise:
//! - registers with reset values, read-only and reserved bits; GPIO levels;
//! - commands, single and multiple register access ending after 09h, read by command (safe across DRDY, repeatable
//!   with NEW = 0) and direct read (3 or 4 bytes by STAT; a DRDY edge in its middle mixes old and new bytes; zeros
//!   after it until CS or the time-out), pulse convert, reset;
//! - commands one after the other without toggling CS, but no direct read behind a command;
//! - the SPI time-out, on the gaps between bytes;
//! - auto-scan in ascending CHID, resumed by START, put back to its top by a write to MUXDIF, MUXSG0, MUXSG1 or
//!   SYSRED; fixed channel; internal readings and their scalings;
//! - rates, the first conversion's delay, DRDY with its pulse of 1 tCLK over unread data, lost data;
//! - code width VREF / 780000h, clipping, OVF beyond 1.06 VREF, SUPPLY below 4.3 V, BYPAS with nothing connected;
//! - noise of the data rate, white and Gaussian; offset, gain and clock error.
//!
//! A conversion uses the settings that it began with; a register write acts on the next one.
//!
//! A [`Finger`] is modelled after Oddo et al., *Artificial Roughness Encoding with a Bio-inspired MEMS-based Tactile
//! Sensor Array*, Sensors 9 (2009), and Moy et al., *Human Psychophysics for Teletaction System Design*:
//! - 2 x 2 units at 2.3 mm, four piezoresistors each, of which 1 and 3 respond to shear with opposite signs;
//! - the strain that line loads, normal and tangential, make at the sensors' depth in an elastic half plane: overtones,
//!   phases between units and the cover's low-pass follow from the grating's geometry;
//! - creep as a Kelvin body; friction, and with it the stronger leading edge;
//! - the bridge's offset, its RC pole of 388 Hz, its thermal noise. What is faster than half the frame rate aliases.
//!
//! The phase between the units is that of the pitch only under a long contact. The load falls off towards its ends and
//! pulls the units' phases together: pressure p(s) cos(k s) is a wave whose number has an imaginary part, -p'/p, of
//! which the cover's low-pass makes a phase. The effect is physical. It is 0.24 to 0.32 rad for periods of 2.6 to
//! 4.1 mm under 8 mm with friction, and up to 1.13 rad under 5 mm.
//!
//! # Where the sources leave it open
//! A driver must not rely on these. [`Options`] choose: DOUT where it is undefined, CHID in fixed-channel mode, what CHOP
//! does to the readings that it excludes, whether DLY delays the first conversion, the time to wake from sleep, the
//! power-up time, all but bit 4 of ID.
//!
//! These cannot be chosen and could be otherwise: an unread result keeps DRDY low across START; reading registers
//! does not move DRDY; reserved bits read as 0; pulse convert while converting does nothing; a direct read of a result
//! that was read before gives it again with NEW = 0 if CS was toggled; data before the first conversion are zero.
//!
//! # Not modelled
//! - The filter's frequency response: each conversion is one sample at the middle of the aperture, so everything up to
//!   any frequency aliases; unsettled results after an input step in fixed-channel mode.
//! - The signal path: the RC filter of the board (a [`Finger`] has one), source impedance, multiplexer settling and
//!   crosstalk, sensor bias current (SBCS), integral nonlinearity, drift, input range limits of the pins, analogue
//!   overload recovery.
//! - Electrical timing: SCLK against tCLK, CS set-up and hold, the width of RESET pulses, SPI modes other than 0,
//!   anything finer than a byte (a byte acts at its first SCLK; a frame cut within a byte; an SCLK so slow that the
//!   time-out strikes within a byte).
//! - Power: PWDN, supply ramps, currents; CLKSEL and CLKENB pins and crystal start-up; jitter and drift of the clock.
//! - The ADS1158 (16 bits).
//! - In scenes of drawn channels: everything but the protocol. The numbers of their channels are plausible, not measured,
//!   as are those of the [`Finger`] that are marked so.
//! - Of the [`Finger`]: whatever is not linear (large strain, a contact that grows with the load, ridges that sink in
//!   up to the groove's floor, the bridge's 0.5 % of distortion); the stiff chip under the cover (it is a half plane),
//!   the thin film on it, its end; the round shape but for the contact's length and lean; anything that varies across
//!   the motion; stick and slip, waves, fingerprints; temperature, wear. A ridge presses evenly over its width, and its
//!   load depends on its place in the contact alone: the force's control does not follow the ridges that enter and
//!   leave, which changes the whole force by some percent. Friction follows the speed without delay, and its effect is
//!   reversed with the motion.
//! - Of the stimulator: errors of place, vibration, a tilted grating. Its ripple is a single sine in time.

#![cfg_attr(not(feature = "simulator"), no_std)]
#![forbid(unsafe_code)]
#![warn(missing_docs)]

#[cfg(feature = "simulator")]
pub mod board;
pub mod bridge;
#[cfg(feature = "simulator")]
pub mod chip;
#[cfg(feature = "simulator")]
mod file_error;
#[cfg(feature = "simulator")]
mod random;
#[cfg(feature = "simulator")]
pub mod scene;
#[cfg(feature = "simulator")]
pub mod scene_file;
#[cfg(feature = "simulator")]
pub mod sliding;
#[cfg(feature = "simulator")]
pub mod trace;

#[cfg(feature = "simulator")]
pub use self::{
    board::SimulatedBoard,
    chip::{Ads1258, Analog, Counters, Fault, Injected, Injection, Options},
    file_error::FileError,
    scene::{Constant, Noisy, Scene},
    scene_file::{load_scene, parse_scene},
    sliding::{Finger, Hand, ParameterError, Sliding, SlidingScene, Stimulator, TABLE_2, Truth},
    trace::{Table, Trace, write_csv},
};
