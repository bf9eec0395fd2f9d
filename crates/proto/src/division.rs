//! Division of 64 bits by 32: the chip has no instruction for it, and the compiler's routine, for
//! any divisor, takes a kilobyte of flash.

/// Returns quotient and remainder; both are zero if `by` is zero. A value of more than 32 bits
/// takes some 300 instructions.
// Never inlined, to keep a single copy of 150 bytes.
#[inline(never)]
pub const fn divide(value: u64, by: u32) -> (u64, u32) {
    if by == 0 {
        return (0, 0);
    }
    let (high, mut low) = ((value >> 32) as u32, value as u32);
    if high == 0 {
        return ((low / by) as u64, low % by);
    }
    // Long division, bit by bit: each step shifts the top bit out of `low` and a bit of the
    // quotient in.
    let (mut rest, mut bits) = ((high % by) as u64, 32);
    while bits > 0 {
        rest = rest << 1 | (low >> 31) as u64;
        low <<= 1;
        if rest >= by as u64 {
            rest -= by as u64;
            low |= 1;
        }
        bits -= 1;
    }
    (((high / by) as u64) << 32 | low as u64, rest as u32)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Compares with the processor's own division, for values and divisors of every length.
    #[test]
    fn it_is_a_division() {
        let mut state = 1u64;
        let mut draw = || {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            state ^ state >> 32
        };
        for bits in 0..64 {
            for by_bits in 0..32 {
                let (value, by) = (draw() >> bits, (draw() as u32 >> by_bits).max(1));
                assert_eq!(
                    divide(value, by),
                    (value / u64::from(by), (value % u64::from(by)) as u32),
                    "{value} {by}"
                );
            }
        }
    }

    #[test]
    fn extremes_divide() {
        for (value, by) in [
            (u64::MAX, 1),
            (u64::MAX, u32::MAX),
            (u64::from(u32::MAX) + 1, u32::MAX),
            (0, 7),
            (1 << 32, 1 << 31),
        ] {
            assert_eq!(
                divide(value, by),
                (value / u64::from(by), (value % u64::from(by)) as u32),
                "{value} {by}"
            );
        }
        assert_eq!(divide(5, 0), (0, 0));
    }
}
