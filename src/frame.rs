//! Conversions in, 16-channel frames out (stub: assembled in the next commit).

/// One conversion with the time of its DRDY edge.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TimedConversion {
    /// Time of the falling edge of DRDY on the board's microsecond counter, wrapping.
    pub t_us: u32,
    /// Status byte and 24-bit code as read.
    pub conversion: ads1258::Conversion,
}
