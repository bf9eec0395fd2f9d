//! Rows of line damage in both directions, and of power loss while settings are stored. They test
//! only the line's receiver, the decoder and the store of settings, without a touch.

use super::bit_errors::{self, BitErrors};
use super::counts::Counts;
use super::line_noise::{self, Heard};
use super::power_cuts::{Cuts, cut_everywhere};
use super::row::{Row, Title};
use crate::parallel;
use anyhow::Result;
use ridgetone_host::input::Input;
use ridgetone_proto::store::RECORD_BYTES;

const TELEMETRY_FRAMES: u64 = 100;
const RANDOM_BYTES: u64 = 1000;
const REQUESTS: u64 = 10;
/// Numbers of random bytes and requests per board.
const BYTES_A_BOARD: u64 = 1_000_000;
const REQUESTS_A_BOARD: u64 = 10_000;
/// Number of injections into the chip per sweep over all power cuts; a sweep has about 1,300 cuts.
const INJECTIONS_A_CUT: u64 = 2500;
/// Records of settings per sector of the STM32F405.
const RECORDS: u64 = 128 * 1024 / RECORD_BYTES as u64;

/// Names and titles of the rows.
const BIT_ERRORS: Title<'static> = Title {
    name: "telemetry_bit_errors",
    fault: "bit errors in telemetry",
};
const RANDOM: Title<'static> = Title {
    name: "random_requests",
    fault: "random bytes as requests",
};
const DAMAGED: Title<'static> = Title {
    name: "damaged_requests",
    fault: "damaged requests",
};
const CUTS: Title<'static> = Title {
    name: "power_cuts",
    fault: "power lost while settings are stored",
};

/// Titles of the rows, in order.
#[cfg(test)]
pub const TITLES: [&str; 4] = [BIT_ERRORS.fault, RANDOM.fault, DAMAGED.fault, CUTS.fault];

/// Returns rows and frame counts for `injections` injections into the chip. 100,000 correspond to
/// ten million frames and 100 MB.
pub fn rows(injections: u64, seed: u64) -> Result<(Vec<Row>, BitErrors)> {
    let errors = bit_errors::count(
        Input::default().open()?,
        injections * TELEMETRY_FRAMES,
        seed,
    )?;
    let random = batches(
        "random bytes",
        injections * RANDOM_BYTES / BYTES_A_BOARD,
        seed,
        |seed| line_noise::random_bytes(BYTES_A_BOARD, seed),
    )?;
    let damaged = batches(
        "damaged requests",
        injections * REQUESTS / REQUESTS_A_BOARD,
        seed,
        |seed| line_noise::damaged_requests(REQUESTS_A_BOARD, seed),
    )?;
    let cut = batches(
        "cuts of power",
        injections / INJECTIONS_A_CUT,
        seed,
        |seed| {
            let mut cuts = cut_everywhere::<{ RECORD_BYTES as u32 }>(0, 5, seed);
            cuts += cut_everywhere::<{ 2 * RECORD_BYTES as u32 }>(0, 7, seed);
            cuts += cut_everywhere::<{ 8 * RECORD_BYTES as u32 + 104 }>(8, 16, seed);
            Ok(cuts)
        },
    )?;
    let mut cuts = Cuts::default();
    cut.into_iter().for_each(|more| cuts += more);
    cuts += cut_everywhere::<{ 128 * 1024 }>(2 * RECORDS - 1, 2, seed);
    let megabytes = injections * RANDOM_BYTES / BYTES_A_BOARD;
    let random_title = format!("{}, {} MB", RANDOM.fault, megabytes.max(1));
    let rows = vec![
        of_bit_errors(&errors),
        of_requests(
            Title {
                fault: &random_title,
                ..RANDOM
            },
            &random,
        ),
        of_requests(DAMAGED, &damaged),
        of_cuts(&cuts),
    ];
    Ok((rows, errors))
}

/// Runs `count` batches, at least one, with consecutive seeds.
fn batches<T: Send>(
    what: &str,
    count: u64,
    seed: u64,
    make: impl Fn(u64) -> Result<T> + Sync,
) -> Result<Vec<T>> {
    let seeds: Vec<u64> = (seed..seed + count.max(1)).collect();
    parallel::map(what, &seeds, |seed| make(*seed))
}

fn of_bit_errors(errors: &BitErrors) -> Row {
    let counts = Counts {
        silent: errors.next_lost,
        altered: errors.accepted_damaged,
        ..Counts::default()
    };
    Row::without_touch(
        BIT_ERRORS,
        errors.sent,
        errors.refused,
        Some(errors.sent - errors.next_lost),
        counts,
    )
}

fn of_requests(title: Title<'_>, boards: &[Heard]) -> Row {
    let sum = |of: fn(&Heard) -> u64| boards.iter().map(of).sum::<u64>();
    let (frames, damaged) = (sum(|heard| heard.frames), sum(|heard| heard.damaged));
    let deaf = sum(|heard| u64::from(!heard.obeys));
    let altered = sum(|heard| heard.answered + u64::from(heard.changed));
    let counts = Counts {
        silent: frames.saturating_sub(damaged) + deaf,
        altered,
        ..Counts::default()
    };
    // If a board stopped answering, it is unknown which frame caused it, so recoveries are not
    // counted.
    Row::without_touch(
        title,
        frames,
        damaged,
        (deaf == 0).then_some(frames),
        counts,
    )
}

fn of_cuts(cuts: &Cuts) -> Row {
    let counts = Counts {
        altered: cuts.wrong,
        ..Counts::default()
    };
    // Settings that were stored completely, or not at all, need no report.
    Row::without_touch(
        CUTS,
        cuts.injected,
        cuts.reported,
        Some(cuts.old + cuts.new + cuts.defaults),
        counts,
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    const NO_TITLE: Title<'static> = Title {
        name: "",
        fault: "",
    };

    #[test]
    fn nothing_damaged_is_taken_and_all_of_it_is_reported() {
        let (rows, bit_errors) = rows(1000, 1).expect("rows");
        assert!(
            rows.iter()
                .map(|row| &row.fault)
                .zip(TITLES)
                .all(|(row, title)| row.starts_with(title)),
            "{rows:?}"
        );
        assert_eq!(
            (rows.len(), rows[0].injected as u64),
            (TITLES.len(), bit_errors.sent)
        );
        for row in &rows {
            println!("{row:?}");
            assert!(row.is_clean() && row.injected > 1000, "{row:?}");
            assert_eq!(
                row.recovered.map(|delays| delays.count),
                Some(row.injected),
                "{row:?}"
            );
        }
        let reported: Vec<_> = rows
            .iter()
            .filter_map(|row| row.detected)
            .map(|delays| delays.count)
            .collect();
        assert_eq!(
            reported[..3],
            [rows[0].injected, rows[1].injected, rows[2].injected]
        );
        assert!(
            reported[3] > 100 && reported[3] < rows[3].injected,
            "{reported:?}"
        );
    }

    #[test]
    fn what_goes_wrong_is_not_clean() {
        let heard = Heard {
            frames: 10,
            damaged: 10,
            obeys: true,
            ..Heard::default()
        };
        assert!(of_requests(NO_TITLE, &[heard]).is_clean());
        assert!(
            !of_requests(
                NO_TITLE,
                &[Heard {
                    damaged: 9,
                    ..heard
                }]
            )
            .is_clean()
        );
        assert!(
            !of_requests(
                NO_TITLE,
                &[
                    heard,
                    Heard {
                        obeys: false,
                        ..heard
                    }
                ]
            )
            .is_clean()
        );
        assert!(
            !of_requests(
                NO_TITLE,
                &[
                    heard,
                    Heard {
                        answered: 1,
                        ..heard
                    }
                ]
            )
            .is_clean()
        );
        assert!(
            !of_requests(
                NO_TITLE,
                &[
                    heard,
                    Heard {
                        changed: true,
                        ..heard
                    }
                ]
            )
            .is_clean()
        );
        let bit_errors = BitErrors {
            sent: 10,
            refused: 10,
            ..BitErrors::default()
        };
        assert!(of_bit_errors(&bit_errors).is_clean());
        assert!(
            !of_bit_errors(&BitErrors {
                accepted_damaged: 1,
                ..bit_errors
            })
            .is_clean()
        );
        assert!(
            !of_bit_errors(&BitErrors {
                next_lost: 1,
                ..bit_errors
            })
            .is_clean()
        );
        assert!(
            !of_cuts(&Cuts {
                wrong: 1,
                ..Cuts::default()
            })
            .is_clean()
        );
    }
}
