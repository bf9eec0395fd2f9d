//! The square root.

/// Square root of `x`, rounded to the nearest; NaN below zero. On Arm with a floating-point unit
/// this is the `vsqrt` instruction, which `libm` does not use.
#[inline(always)]
pub fn sqrt(x: f32) -> f32 {
    #[cfg(all(target_arch = "arm", target_abi = "eabihf"))]
    return by_instruction(x);
    #[cfg(not(all(target_arch = "arm", target_abi = "eabihf")))]
    return libm::sqrtf(x);
}

/// Naked function with its argument in S0 (AAPCS, 6.1.2.1): inline assembly in stable Rust cannot
/// take a floating-point register.
#[cfg(all(target_arch = "arm", target_abi = "eabihf"))]
#[unsafe(naked)]
#[allow(unsafe_code, reason = "an instruction without a safe function")]
extern "C" fn by_instruction(x: f32) -> f32 {
    core::arch::naked_asm!(".fpu fpv4-sp-d16", "vsqrt.f32 s0, s0", "bx lr")
}
