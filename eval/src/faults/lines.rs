//! Rows of what is damaged on the line, both ways, and of power that is lost while settings are stored. No touch is run for
//! these: the line's receiver, the decoder and the settings' store are asked alone.

use super::row::{Delays, Place, Row};
use crate::bit_errors;
use crate::bit_errors::BitErrors;
use crate::parallel;
use anyhow::Result;
use ridgetone_host::input::Input;
use ridgetone_host::requests::noise;
use ridgetone_host::requests::noise::Heard;
use ridgetone_host::requests::power_cuts::{Cuts, cut_everywhere};

/// Frames of telemetry for each injection into the chip.
const TELEMETRY_FRAMES: u64 = 100;
/// Random bytes for each.
const RANDOM_BYTES: u64 = 1000;
/// Damaged orders for each.
const ORDERS: u64 = 10;
/// Random bytes, and orders, that one board hears.
const BYTES_A_BOARD: u64 = 1_000_000;
const ORDERS_A_BOARD: u64 = 10_000;
/// Injections into the chip for each time that power is cut everywhere, some 1,300 times.
const INJECTIONS_A_CUT: u64 = 2500;
/// Records of settings in a sector of the STM32F405.
const RECORDS: u64 = 128 * 1024 / 96;

/// Names and titles of the rows.
const FLIPS: (&str, &str) = ("telemetry_flips", "bits of telemetry fell over");
const RANDOM: (&str, &str) = ("random_orders", "random bytes as orders");
const DAMAGED: (&str, &str) = ("damaged_orders", "damaged orders");
const CUTS: (&str, &str) = ("power_cuts", "power lost while settings are stored");

/// What the titles of the rows begin with, in their order.
pub const TITLES: [&str; 4] = [FLIPS.1, RANDOM.1, DAMAGED.1, CUTS.1];

/// The rows beside so many injections into the chip: of 100,000 ten million frames and a hundred megabytes. And what became
/// of the frames.
///
/// # Errors
/// The touch whose telemetry is damaged cannot be replayed.
pub fn rows(injections: u64, seed: u64) -> Result<(Vec<Row>, BitErrors)> {
    let flipped = bit_errors::count(Input::default().open()?, injections * TELEMETRY_FRAMES, seed)?;
    let random = batches("random bytes", injections * RANDOM_BYTES / BYTES_A_BOARD, seed, |seed| {
        noise::random_bytes(BYTES_A_BOARD, seed)
    })?;
    let damaged = batches("damaged orders", injections * ORDERS / ORDERS_A_BOARD, seed, |seed| {
        noise::damaged_orders(ORDERS_A_BOARD, seed)
    })?;
    let cut = batches("cuts of power", injections / INJECTIONS_A_CUT, seed, |seed| {
        let mut cuts = cut_everywhere::<96>(0, 5, seed);
        cuts += cut_everywhere::<192>(0, 7, seed);
        cuts += cut_everywhere::<1000>(8, 16, seed);
        Ok(cuts)
    })?;
    let mut cuts = Cuts::default();
    cut.into_iter().for_each(|more| cuts += more);
    cuts += cut_everywhere::<{ 128 * 1024 }>(2 * RECORDS - 1, 2, seed);
    let megabytes = injections * RANDOM_BYTES / BYTES_A_BOARD;
    let random_title = format!("{}, {} MB", RANDOM.1, megabytes.max(1));
    let rows = vec![
        of_flips(&flipped),
        of_orders((RANDOM.0, &random_title), &random),
        of_orders(DAMAGED, &damaged),
        of_cuts(&cuts),
    ];
    Ok((rows, flipped))
}

/// At least one batch, each with a seed of its own.
fn batches<T: Send>(what: &str, count: u64, seed: u64, make: impl Fn(u64) -> Result<T> + Sync) -> Result<Vec<T>> {
    let seeds: Vec<u64> = (seed..seed + count.max(1)).collect();
    parallel::map(what, &seeds, |seed| make(*seed))
}

/// A row without a touch.
fn row((name, fault): (&str, &str), injected: u64) -> Row {
    Row { injected: injected as usize, ..Row::of(name, fault, Place::Pc, &[]) }
}

fn of_flips(bit_errors: &BitErrors) -> Row {
    Row {
        detected: Some(Delays::untimed(bit_errors.refused)),
        recovered: Some(Delays::untimed(bit_errors.sent - bit_errors.next_lost)),
        silent: bit_errors.next_lost,
        altered: bit_errors.accepted_damaged,
        ..row(FLIPS, bit_errors.sent)
    }
}

fn of_orders(title: (&str, &str), boards: &[Heard]) -> Row {
    let sum = |of: fn(&Heard) -> u64| boards.iter().map(of).sum::<u64>();
    let (frames, damaged) = (sum(|heard| heard.frames), sum(|heard| heard.damaged));
    let deaf = sum(|heard| u64::from(!heard.obeys));
    Row {
        detected: Some(Delays::untimed(damaged)),
        // Frames were not told apart: those that a board heard which does not obey any more.
        recovered: (deaf == 0).then(|| Delays::untimed(frames)),
        silent: frames.saturating_sub(damaged) + deaf,
        altered: sum(|heard| heard.answered + u64::from(heard.changed)),
        ..row(title, frames)
    }
}

fn of_cuts(cuts: &Cuts) -> Row {
    Row {
        // What is whole, or had not begun, needs no word.
        detected: Some(Delays::untimed(cuts.told)),
        recovered: Some(Delays::untimed(cuts.old + cuts.new + cuts.defaults)),
        altered: cuts.wrong,
        ..row(CUTS, cuts.injected)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_damaged_is_taken_and_all_of_it_is_told() {
        let (rows, bit_errors) = rows(1000, 1).expect("rows");
        assert!(rows.iter().map(|row| &row.fault).zip(TITLES).all(|(row, title)| row.starts_with(title)), "{rows:?}");
        assert_eq!((rows.len(), rows[0].injected as u64), (TITLES.len(), bit_errors.sent));
        for row in &rows {
            println!("{row:?}");
            assert!(row.is_clean() && row.injected > 1000, "{row:?}");
            assert_eq!(row.recovered.map(|delays| delays.count), Some(row.injected), "{row:?}");
        }
        let told: Vec<_> = rows.iter().filter_map(|row| row.detected).map(|delays| delays.count).collect();
        assert_eq!(told[..3], [rows[0].injected, rows[1].injected, rows[2].injected]);
        assert!(told[3] > 100 && told[3] < rows[3].injected, "{told:?}");
    }

    /// What must not be shows in the row.
    #[test]
    fn what_goes_wrong_is_not_clean() {
        let heard = Heard { frames: 10, damaged: 10, obeys: true, ..Heard::default() };
        assert!(of_orders(("", ""), &[heard]).is_clean());
        assert!(!of_orders(("", ""), &[Heard { damaged: 9, ..heard }]).is_clean());
        assert!(!of_orders(("", ""), &[heard, Heard { obeys: false, ..heard }]).is_clean());
        assert!(!of_orders(("", ""), &[heard, Heard { answered: 1, ..heard }]).is_clean());
        assert!(!of_orders(("", ""), &[heard, Heard { changed: true, ..heard }]).is_clean());
        let bit_errors = BitErrors { sent: 10, refused: 10, ..BitErrors::default() };
        assert!(of_flips(&bit_errors).is_clean());
        assert!(!of_flips(&BitErrors { accepted_damaged: 1, ..bit_errors }).is_clean());
        assert!(!of_flips(&BitErrors { next_lost: 1, ..bit_errors }).is_clean());
        assert!(!of_cuts(&Cuts { wrong: 1, ..Cuts::default() }).is_clean());
    }
}
