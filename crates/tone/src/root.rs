//! The square root.

/// The square root of `x`, rounded to the nearest; NaN below zero. On an Arm processor with a
/// floating-point unit it is that unit's instruction, which `libm` does not use.
#[inline(always)]
pub fn sqrt(x: f32) -> f32 {
    #[cfg(all(target_arch = "arm", target_abi = "eabihf"))]
    return by_instruction(x);
    #[cfg(not(all(target_arch = "arm", target_abi = "eabihf")))]
    return libm::sqrtf(x);
}

/// A function of its own, which has the number in S0 (AAPCS, 6.1.2.1): stable Rust gives no register
/// of the floating-point unit to an instruction amid others.
#[cfg(all(target_arch = "arm", target_abi = "eabihf"))]
#[unsafe(naked)]
#[allow(unsafe_code, reason = "an instruction without a safe function")]
extern "C" fn by_instruction(x: f32) -> f32 {
    core::arch::naked_asm!(".fpu fpv4-sp-d16", "vsqrt.f32 s0, s0", "bx lr")
}
