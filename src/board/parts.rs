//! A board's parts for the tasks: each board says of what types they are.

use ridgetone_proto::boot::Boot;

/// As in the table of `mod.rs`.
pub struct Parts<Spi, Start, Reset, Drdy, Line, Flash> {
    pub spi: Spi,
    pub start: Start,
    pub reset: Reset,
    pub drdy: Drdy,
    pub line: Line,
    pub boot: Boot,
    pub flash: Flash,
}
