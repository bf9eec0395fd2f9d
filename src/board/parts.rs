//! A board's parts for the tasks: each board says of what types they are.

use ridgetone_proto::boot::Boot;

/// As in the table of `mod.rs`.
pub struct Parts<Converter, Drdy, Line, Flash> {
    pub converter: Converter,
    pub drdy: Drdy,
    /// The sending and the receiving side.
    pub line: Line,
    pub boot: Boot,
    pub flash: Flash,
}
