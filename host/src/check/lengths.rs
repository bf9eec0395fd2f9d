//! Commands of every length, none of which changes anything on the board.

use crate::requests::encode;
use anyhow::Result;
use ridgetone_proto::command::{Command, KNOTS_A_COMMAND, Outcome, Part, Request};
use ridgetone_proto::plan::Plan;
use ridgetone_proto::profile::Knot;
use ridgetone_proto::settings::{Array, Settings, SlideRule};

/// Number of a request whose length stands for all: two of three numbers take three bytes.
const NUMBER: u16 = u16::MAX;

/// Bytes that a knot's time takes besides its first, at most.
const TIME_MORE_BYTES: usize = 4;

/// Masks of taxels in settings, and bytes that each takes besides its first, at most.
const MASKS: usize = 6;
const MASK_MORE_BYTES: usize = 2;

/// A command, its length on the wire, bytes, and whether an outcome is the one that it must have.
pub struct Probe {
    pub command: Command,
    pub length_bytes: usize,
    pub is_right: fn(&Outcome) -> bool,
}

impl Probe {
    fn new(command: Command, is_right: fn(&Outcome) -> bool) -> Result<Self> {
        let request = Request {
            number: NUMBER,
            command,
        };
        let length_bytes = encode(&request)?.len();
        Ok(Self {
            command: request.command,
            length_bytes,
            is_right,
        })
    }
}

/// A greeting; parts of a speed profile that is never completed, 1 to 8 knots with times of 1 to 5
/// bytes; settings that the board must refuse, with masks of 1 to 3 bytes. In the order of their
/// lengths.
pub fn probes() -> Result<Vec<Probe>> {
    let is_done = |outcome: &Outcome| *outcome == Outcome::Done;
    let mut probes = vec![Probe::new(Command::Greet, is_done)?];
    for count in 1..=KNOTS_A_COMMAND {
        for more_bytes in 0..=count * TIME_MORE_BYTES {
            // A time takes one byte for each seven bits; the first knots have the longest ones.
            let more = |at: usize| {
                more_bytes
                    .saturating_sub(at * TIME_MORE_BYTES)
                    .min(TIME_MORE_BYTES)
            };
            let t_us = |at: usize| if more(at) > 0 { 1 << (7 * more(at)) } else { 0 };
            let knots = (0..count)
                .map(|at| Knot {
                    t_us: t_us(at),
                    speed_mm_s: 30.0,
                })
                .collect();
            probes.push(Probe::new(
                Command::Follow(Part {
                    first: 0,
                    knots,
                    last: None,
                }),
                is_done,
            )?);
        }
    }
    let slide = SlideRule::Protocol {
        delay_s: 1.0,
        speed_mm_s: 30.0,
        length_mm: 55.0,
    };
    for slide in [SlideRule::Found, slide] {
        for more_bytes in 0..=MASKS * MASK_MORE_BYTES {
            // Seven bits a byte.
            let more = |at: usize| {
                more_bytes
                    .saturating_sub(at * MASK_MORE_BYTES)
                    .min(MASK_MORE_BYTES)
            };
            let mask = |at: usize| u16::MAX >> (7 * (MASK_MORE_BYTES - more(at)));
            let [alike @ .., front, inputs] = std::array::from_fn::<u16, MASKS, _>(mask);
            let (array, plan) = (
                Array {
                    front,
                    alike,
                    ..Array::DEFAULT
                },
                Plan {
                    inputs,
                    ..Plan::PAPER
                },
            );
            let settings = Settings {
                window_s: 0.0,
                slide,
                array,
                plan,
                ..Settings::DEFAULT
            };
            let is_refused = |outcome: &Outcome| matches!(outcome, Outcome::Setting(_));
            probes.push(Probe::new(
                Command::Set {
                    settings,
                    keep: false,
                },
                is_refused,
            )?);
        }
    }
    probes.sort_by_key(|probe| probe.length_bytes);
    probes.dedup_by_key(|probe| {
        (
            probe.length_bytes,
            matches!(probe.command, Command::Set { .. }),
        )
    });
    Ok(probes)
}

#[cfg(test)]
mod tests {
    use super::*;
    use ridgetone_proto::command::REQUEST_WIRE_MAX;

    #[test]
    fn every_length_that_a_command_can_have_occurs() {
        let probes = probes().unwrap();
        let lengths: Vec<usize> = probes.iter().map(|probe| probe.length_bytes).collect();
        let (shortest, longest) = (lengths[0], lengths[lengths.len() - 1]);
        // Of parts of a profile, and of settings: the longest part is shorter than the shortest
        // settings, and nothing lies between.
        for is_settings in [false, true] {
            let of_kind = probes
                .iter()
                .skip(1)
                .filter(|probe| matches!(probe.command, Command::Set { .. }) == is_settings);
            let of_kind: Vec<usize> = of_kind.map(|probe| probe.length_bytes).collect();
            assert!(
                (of_kind[0]..=of_kind[of_kind.len() - 1]).all(|length| of_kind.contains(&length)),
                "{lengths:?}"
            );
        }
        // The number, the command's, four bytes of checksum, one of stuffing, the zero.
        assert_eq!(shortest, 3 + 1 + 4 + 1 + 1);
        assert!((80..=REQUEST_WIRE_MAX).contains(&longest), "{longest}");
    }
}
