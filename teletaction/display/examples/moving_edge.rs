//! A ridge moves over 4 x 4 sensors; a display of 6 x 4 pins follows at 10 updates a second. Prints
//! the pins, a row a line.
//!
//! `cargo run -p ridgetone-display --example moving_edge`

use ridgetone_display::{Error, Grid, Limits, Matching, Pins, Quantity};

fn main() -> Result<(), Error> {
    let (sensors, grid) = (Grid::new(4, 4, 1.5)?, Grid::new(6, 4, 1.2)?);
    let mut memory = [0.0; Matching::floats(24, 16)];
    let map = sensors.map(&grid, 1.5, 0.5, Quantity::Stress)?;
    let mut matching = Matching::new(&mut memory, grid.count(), sensors.count(), 0.01, map)?;
    let mut forces_n = [0.0; 24];
    let limits = Limits {
        update_hz: 10.0,
        levels: 9,
        ..Limits::IDEAL
    };
    let mut pins = Pins::new(limits, &mut forces_n)?;
    for frame in 0..40 {
        let ridge_mm = -4.0 + 0.2 * f64::from(frame);
        let wanted: [f32; 16] = core::array::from_fn(|n| {
            let off_mm = sensors.place_mm(n).0 - ridge_mm;
            0.3 * libm::exp(-off_mm * off_mm) as f32
        });
        let forces = matching.forces(&wanted)?.forces;
        if pins.advance(0.05, forces)?.is_some() {
            println!("ridge at {ridge_mm:+.1} mm");
            for row in pins.forces_n().chunks_exact(grid.columns()) {
                let cells: Vec<String> = row.iter().map(|n| format!("{n:5.2}")).collect();
                println!("  {}", cells.join(" "));
            }
        }
    }
    Ok(())
}
