//! An update: what is pressed becomes forces within the display's limits. The part beside the fit,
//! whose memory it borrows.

use crate::pins::Due;
use crate::pins::strains::{UNIT_PITCH_MM, by_place, of_pressure};
use ads1258::reading;
use heapless::Vec;
use ridgetone_display::{Limits, Pressing, Solution, Square, Steps};
use ridgetone_proto::settings::{PinDisplay, Settings};
use ridgetone_proto::telemetry::{PINS_SIDE_MAX, PINS_SILENCE_US, Pins};

/// Memory that [`Driver::update`] needs, values.
pub const MEMORY: usize = Square::floats(PINS_SIDE_MAX);

/// How much even forces are preferred: as `ridgetone pins` has it.
const REGULARISATION: f32 = 0.01;
/// Systems that an update solves at most, and multiplications behind which it begins no other:
/// whatever is pressed, 10 x 10 pins then stay below 200,000 instructions (`cargo xtask distance
/// --chip` counts), and nearly all updates are optimal.
pub const PIVOTS_MAX: u32 = 8;
/// As above.
pub const MULTIPLY_ADDS_MAX: u32 = 26_000;
/// Microseconds of a time that is kept: a power of two.
const TICK_US: u64 = 1024;
/// Poisson's ratio of the finger on the pins: as rubber, it keeps its volume.
const POISSON: f32 = 0.5;

/// Where the pins are.
#[derive(Clone, Debug)]
pub struct Driver {
    levels: [u8; PINS_SIDE_MAX * PINS_SIDE_MAX],
    /// Force of a level, newtons, and pins on a side; zeros before the first update.
    level_n: f32,
    side: u8,
    /// Device time of the latest update that could move them, in units of [`TICK_US`]: its
    /// difference holds for 50 days.
    latest: u32,
    pressing: Pressing,
}

impl Driver {
    /// Pins that do not press.
    pub const fn new() -> Self {
        Self {
            levels: [0; PINS_SIDE_MAX * PINS_SIDE_MAX],
            level_n: 0.0,
            side: 0,
            latest: 0,
            pressing: Pressing::new(),
        }
    }

    /// The pins where they are by now: a display has released those that have heard nothing for
    /// long, other pins have not pressed yet, and of other levels the force stays. Whether they may
    /// move: not before the time of an update has passed since they last could, which another rate
    /// may ask for, nor where rounding to other levels has moved them.
    #[inline(never)]
    fn go_on(&mut self, t_us: u64, rate_hz: u8, side: u8, level_n: f32) -> bool {
        let now = (t_us / TICK_US) as u32;
        let passed_us = u64::from(now.wrapping_sub(self.latest)) * TICK_US;
        let is_due = (passed_us + TICK_US) * u64::from(rate_hz) >= 1_000_000;
        let mut may_move = is_due;
        if side != self.side || passed_us > PINS_SILENCE_US {
            (*self, may_move) = (Self::new(), true);
        } else if level_n != self.level_n {
            let ratio = self.level_n / level_n;
            // To the nearest, and the highest one if there are not as many: half a level, which the
            // slew allows.
            self.levels
                .iter_mut()
                .for_each(|level| *level = (f32::from(*level) * ratio + 0.5) as u8);
            may_move = false;
        }
        (self.side, self.level_n) = (side, level_n);
        // `new` has forgotten it.
        self.latest = if is_due || self.latest == 0 {
            now
        } else {
            self.latest
        };
        may_move
    }

    /// The forces that the update wants, without the display's limits. It is the part that takes
    /// long.
    #[inline(always)]
    pub fn solve<'a>(
        &mut self,
        due: &Due,
        memory: &'a mut [f32],
        settings: &Settings,
    ) -> Option<Solution<'a>> {
        let PinDisplay {
            side,
            spacing_mm,
            depth_mm,
            mpa_per_v,
            ..
        } = settings.pins;
        let mpa_per_code = reading::volts(1, settings.vref_v) * mpa_per_v;
        // Strain times Young's modulus.
        let wanted =
            by_place(&of_pressure(&due.pressed, due.taxels)).map(|code| code * mpa_per_code);
        let display = Square {
            side: side.into(),
            spacing_mm,
            sensor_spacing_mm: (0.5 * UNIT_PITCH_MM) as f32,
            depth_mm,
            poisson: POISSON,
            regularisation: REGULARISATION,
            pivots_max: PIVOTS_MAX,
            multiply_adds_max: MULTIPLY_ADDS_MAX,
        };
        display.forces(memory, &wanted, &mut self.pressing)
    }

    /// Moves the pins towards what is pressed. They go down where no force can be computed.
    /// `settings.pins` must be on and valid; `memory` has [`MEMORY`] values, whose content does not
    /// matter.
    // Not inlined: it runs between fits, which need the stack.
    #[inline(never)]
    pub fn update(&mut self, due: &Due, memory: &mut [f32], settings: &Settings) -> Pins {
        let PinDisplay { rate_hz, side, .. } = settings.pins;
        let limits = limits(&settings.pins);
        let (steps, greatest_n) = (Steps::new(&limits), limits.greatest_n());
        let may_move = self.go_on(due.t_us, rate_hz, side, steps.quantum_n());
        let solution = self.solve(due, memory, settings);
        let side = usize::from(side);
        let is_optimal = solution
            .as_ref()
            .is_some_and(|solution| solution.is_optimal);
        let forces_n = solution
            .as_ref()
            .map_or(&[][..], |solution| solution.forces);
        let mut pins = Pins {
            t_us: due.t_us,
            taxels: due.taxels,
            limited: 0,
            skipped: due.skipped,
            is_optimal,
            level_n: steps.quantum_n(),
            levels: Vec::new(),
        };
        for (pin, level) in self.levels.iter_mut().take(side * side).enumerate() {
            let wanted_n = forces_n.get(pin).copied().unwrap_or(0.0);
            // Where it is, it may be above a greatest force that is new.
            let next_n = if may_move {
                wanted_n
            } else {
                f32::from(*level) * self.level_n
            };
            *level = steps.towards(u16::from(*level), next_n) as u8;
            pins.limited += u8::from(wanted_n > greatest_n);
            // There is space for every pin.
            let _ = pins.levels.push(*level);
        }
        pins
    }
}

impl Default for Driver {
    fn default() -> Self {
        Self::new()
    }
}

/// The limits of a display, as the crate `ridgetone-display` has them.
pub fn limits(display: &PinDisplay) -> Limits {
    Limits {
        force_n: display.force_n,
        stroke_mm: display.stroke_mm,
        stiffness_n_mm: PinDisplay::STIFFNESS_N_MM,
        update_hz: f32::from(display.rate_hz),
        levels: u16::from(display.levels),
        slew_n_s: display.slew_n_s,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ridgetone_proto::settings::TAXELS;
    extern crate std;
    use std::vec;
    use std::vec::Vec;

    /// Forces of each update, newtons.
    fn run(display: PinDisplay, dues: impl Iterator<Item = ([f32; TAXELS], u16)>) -> Vec<Vec<f32>> {
        let settings = Settings {
            pins: display,
            ..Settings::DEFAULT
        };
        let (mut driver, mut memory) = (Driver::new(), vec![f32::NAN; MEMORY]);
        dues.enumerate()
            .map(|(n, (pressed, taxels))| {
                let due = Due::new(50_000 * n as u64, taxels, pressed);
                driver
                    .update(&due, &mut memory, &settings)
                    .forces_n()
                    .collect()
            })
            .collect()
    }

    /// A bump of `codes` codes at its top, under the middle.
    fn bump(codes: f32) -> [f32; TAXELS] {
        let mut pressed = [0.0; TAXELS];
        for (place, taxel) in crate::pins::strains::PLACES
            .as_flattened()
            .iter()
            .enumerate()
        {
            let [x, y] = [place % 4, place / 4].map(|n| n as f32 - 1.5);
            pressed[*taxel] = codes * libm::expf(-0.5 * (x * x + y * y));
        }
        pressed
    }

    /// Whatever comes: no force below 0, none above the greatest, no step above the slew. What is
    /// no number lets the pins go.
    #[test]
    fn forces_are_within_limits_and_slew_whatever_comes() {
        for side in 4..=10 {
            let display = PinDisplay {
                rate_hz: 20,
                side,
                stroke_mm: 1.5,
                slew_n_s: 4.0,
                ..PinDisplay::DEFAULT
            };
            let mut wrong = bump(2e4);
            wrong[3] = f32::NAN;
            let dues = (0..100).map(|n| match n {
                0..10 => ([0.0; TAXELS], u16::MAX),
                10..40 => (bump(1e6), u16::MAX),
                40..50 => (wrong, u16::MAX),
                50..60 => (wrong, !(1 << 3)),
                60..70 => (bump(1e6), 0),
                70..80 => (bump(f32::MAX), u16::MAX),
                80..85 => (bump(-1e6), u16::MAX),
                _ => ([0.0; TAXELS], u16::MAX),
            });
            let found = run(display, dues);
            let most = |n: usize| found[n].iter().fold(0.0f32, |most, n| most.max(*n));
            assert!(
                found
                    .iter()
                    .all(|forces_n| forces_n.len() == usize::from(side * side))
            );
            assert!(
                found.iter().flatten().all(|n| (0.0..=0.7501).contains(n)),
                "{side}: {found:?}"
            );
            for pair in found.windows(2) {
                let step = pair[1]
                    .iter()
                    .zip(&pair[0])
                    .map(|(now, before)| (now - before).abs())
                    .fold(0.0, f32::max);
                assert!(step <= 0.2001, "{side}: {pair:?}");
            }
            // 0.75 N in steps of 0.2 N.
            assert!(
                most(9) == 0.0 && most(10) <= 0.2001 && most(39) > 0.74,
                "{side}: {:?}",
                found[39]
            );
            assert!(
                most(49) == 0.0 && most(59) > 0.01 && most(69) == 0.0 && most(99) == 0.0,
                "{side}"
            );
        }
    }

    /// Another rate falls due at other frames, which may follow at once: pins do not move before an
    /// update of that rate is over.
    #[test]
    fn another_rate_is_no_step_beyond_the_slew() {
        let settings = |rate_hz| {
            let pins = PinDisplay {
                rate_hz,
                levels: 250,
                slew_n_s: 4.0,
                ..PinDisplay::DEFAULT
            };
            Settings {
                pins,
                ..Settings::DEFAULT
            }
        };
        for (first, then) in [(50, 8), (8, 50), (20, 21)] {
            let (mut driver, mut memory) = (Driver::new(), vec![0.0; MEMORY]);
            let mut most_n = |t_us, rate_hz| {
                let due = Due::new(t_us, u16::MAX, bump(1e6));
                driver
                    .update(&due, &mut memory, &settings(rate_hz))
                    .forces_n()
                    .fold(0.0, f32::max)
            };
            let (mut t_us, mut before_n) = (1_000_000, 0.0);
            for n in 0..20 {
                let rate_hz = if n < 5 { first } else { then };
                // The first update of the other rate comes 4.1 ms after the last one.
                t_us += if n == 5 {
                    4_147
                } else {
                    1_000_000u64.div_ceil(u64::from(rate_hz))
                };
                let now_n = most_n(t_us, rate_hz);
                let passed_s = if n == 5 {
                    4.147e-3
                } else {
                    1.0 / f32::from(rate_hz)
                };
                let level_n = 0.0081;
                assert!(
                    now_n - before_n <= 4.0 * passed_s + level_n,
                    "{first} {then} {n}: {before_n} {now_n}"
                );
                before_n = now_n;
            }
            assert!(before_n > 0.5, "{before_n}");
        }
    }

    /// What a display does while nothing is heard of it, and what other settings mean for where its
    /// pins are.
    #[test]
    fn pins_go_on_from_where_they_are() {
        let display = PinDisplay {
            rate_hz: 20,
            levels: 200,
            force_n: 2.0,
            slew_n_s: 20.0,
            ..PinDisplay::DEFAULT
        };
        let (mut driver, mut memory) = (Driver::new(), vec![0.0; MEMORY]);
        let mut most_n = |t_us, pins| {
            let due = Due::new(t_us, u16::MAX, bump(1e6));
            let found = driver.update(
                &due,
                &mut memory,
                &Settings {
                    pins,
                    ..Settings::DEFAULT
                },
            );
            found.forces_n().fold(0.0, f32::max)
        };
        for n in 0..10 {
            most_n(n * 50_000, display);
        }
        assert_eq!(most_n(500_000, display), 2.0);
        // A tenth of the levels, at the same force; more levels; and a lower greatest force at
        // once.
        assert_eq!(
            most_n(
                550_000,
                PinDisplay {
                    levels: 20,
                    ..display
                }
            ),
            2.0
        );
        assert_eq!(
            most_n(
                600_000,
                PinDisplay {
                    levels: 250,
                    ..display
                }
            ),
            2.0
        );
        assert_eq!(
            most_n(
                650_000,
                PinDisplay {
                    force_n: 0.5,
                    ..display
                }
            ),
            0.5
        );
        // Back, it stays for an update, and rises by no more than the slew: 1 N an update.
        assert!((most_n(700_000, display) - 0.5).abs() < 0.0051);
        let risen_n = most_n(750_000, display);
        assert!((1.4..=1.5051).contains(&risen_n), "{risen_n}");
        // What has heard nothing for more than half a second does not press, and neither do other
        // pins.
        assert!(most_n(1_300_000, display) <= 1.0001);
        most_n(1_350_000, display);
        assert!(most_n(1_400_000, PinDisplay { side: 5, ..display }) <= 1.0001);
    }

    /// The least slew that settings may have is that of a display which can move, by both crates'
    /// greatest force.
    #[test]
    fn greatest_forces_are_those_of_the_settings() {
        for (force_n, stroke_mm) in [(2.0, 4.0), (2.0, 1.5), (0.3, 4.0), (100.0, 1e-3)] {
            let display = PinDisplay {
                force_n,
                stroke_mm,
                ..PinDisplay::DEFAULT
            };
            assert_eq!(limits(&display).greatest_n(), display.greatest_n());
        }
    }

    /// Twice the strain, twice the forces, in whole levels; and the modulus is a factor too.
    #[test]
    fn forces_are_proportional_to_strain_and_modulus() {
        let display = PinDisplay {
            rate_hz: 8,
            levels: 250,
            slew_n_s: 1e3,
            ..PinDisplay::DEFAULT
        };
        let of = |display, codes| run(display, core::iter::once((bump(codes), u16::MAX))).remove(0);
        let single = of(display, 1e4);
        let sum: f32 = single.iter().sum();
        assert!(sum > 0.05, "{single:?}");
        for other in [
            of(display, 2e4),
            of(
                PinDisplay {
                    mpa_per_v: 2.0 * display.mpa_per_v,
                    ..display
                },
                1e4,
            ),
        ] {
            for (one, two) in single.iter().zip(&other) {
                assert!(
                    (two - 2.0 * one).abs() <= 1.6 * 0.008,
                    "{single:?} {other:?}"
                );
            }
        }
    }
}
