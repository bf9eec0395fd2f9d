//! Special registers: MRS, MSR, CPS (DDI 0403E, B5.2).

use super::op::Op;
use super::state::Cpu;
use crate::bus::Bus;
use crate::stop::Stop;

const MSP: u8 = 8;
const PRIMASK: u8 = 16;
const BASEPRI: u8 = 17;
const BASEPRI_MAX: u8 = 18;
const FAULTMASK: u8 = 19;
const CONTROL: u8 = 20;

impl Cpu {
    pub(super) fn apsr(&self) -> u32 {
        u32::from(self.n) << 31
            | u32::from(self.z) << 30
            | u32::from(self.c) << 29
            | u32::from(self.v) << 28
            | u32::from(self.q) << 27
    }

    pub(super) fn set_apsr(&mut self, bits: u32) {
        let flag = |at: u32| bits >> at & 1 != 0;
        (self.n, self.z, self.c, self.v, self.q) =
            (flag(31), flag(30), flag(29), flag(28), flag(27));
    }

    pub(super) fn special(&mut self, op: Op, bus: &mut Bus) -> Result<(), Stop> {
        match op {
            Op::ReadSpecial(d, number) => {
                self.r[usize::from(d)] = match number {
                    0..=3 => self.apsr() | if number & 1 != 0 { self.ipsr.into() } else { 0 },
                    5 => self.ipsr.into(),
                    MSP => self.r[13],
                    PRIMASK => self.primask.into(),
                    BASEPRI | BASEPRI_MAX => self.basepri.into(),
                    FAULTMASK => self.faultmask.into(),
                    CONTROL => u32::from(self.fpca) << 2,
                    _ => return Err(bus.unmodelled("a special register", number.into())),
                };
            }
            Op::WriteSpecial(n, number) => {
                let value = self.r[usize::from(n)];
                // Priorities have four bits.
                let priority = (value & 0xF0) as u8;
                match number {
                    0..=3 => self.set_apsr(value),
                    MSP => self.r[13] = value & !3,
                    PRIMASK => self.primask = value & 1 != 0,
                    BASEPRI => self.basepri = priority,
                    BASEPRI_MAX
                        if priority != 0 && (self.basepri == 0 || priority < self.basepri) =>
                    {
                        self.basepri = priority;
                    }
                    BASEPRI_MAX => {}
                    FAULTMASK => self.faultmask = value & 1 != 0,
                    CONTROL if value & 3 == 0 => self.fpca = value & 4 != 0,
                    _ => return Err(bus.unmodelled("a special register", number.into())),
                }
                bus.attend();
            }
            Op::Mask(primask, faultmask, set) => {
                if primask {
                    self.primask = set;
                }
                if faultmask {
                    self.faultmask = set;
                }
                bus.attend();
            }
            _ => {}
        }
        Ok(())
    }
}
