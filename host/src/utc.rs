//! Relates a board's clock to UTC, from the times at which its packets arrived on this computer.
//!
//! A packet arrives later than the event that it reports, because of delays on the line, the board,
//! an adapter and the system. Over board time the minimum delays lie on a straight line whose slope
//! is the skew of the clocks. This slope is found from the line below all delays with the smallest
//! sum of distances, which is an edge of the lower convex hull (S. B. Moon, P. Skelly, D. Towsley,
//! *Estimation and removal of clock skew from network delay measurements*, INFOCOM 1999). The
//! height of the line is the minimum delay nearby, so that an error of the slope does not grow with
//! the recording.

use crate::digits::time_s;
use ridgetone_finger::{CONVERSION_NS, FRAME_NS};
use ridgetone_proto::plan::Sampling;
use ridgetone_proto::telemetry::{Event, Packet, Starts, WIRE_MAX, encode};
use serde::Serialize;
use std::cell::Cell;
use std::collections::VecDeque;
use std::time::{SystemTime, UNIX_EPOCH};

/// Length of a block of board time, of which only the minimum delay is kept, seconds.
const BLOCK_S: f64 = 0.25;

/// Board time before and after a moment from which delays are used, seconds. A crystal drifts with
/// temperature more slowly than this.
const REACH_S: f64 = 600.0;

/// Board time around a moment whose delays determine the height of the line, seconds.
const NEAR_S: f64 = 15.0;

/// A slope is significant if it changes the delay over the span of all points by five times the
/// scatter of the minimum delays. At least ten minimum delays are needed, or fewer for a slope
/// steeper than any crystal's. The scatter is the standard deviation of exponential delays with the
/// same median.
const SIGNIFICANT: f64 = 5.0;
const BLOCKS_MIN: usize = 10;
const NO_CRYSTAL: f64 = 1e-3;

/// Time from the first to the last conversion of a frame, seconds.
const FRAME_S: f64 = (FRAME_NS - CONVERSION_NS) as f64 * 1e-9;

/// Length of the intervals of board time in which a slope is reused, seconds.
const SLOPE_S: f64 = 10.0;

/// Time at which bytes were received.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Receipt {
    /// Nanoseconds since 1970.
    pub utc_ns: u64,
    /// Duration of a byte on the line in seconds; 0 if there is no line.
    pub byte_s: f64,
}

impl Receipt {
    pub fn now(byte_s: f64) -> Self {
        let since = SystemTime::now()
            .duration_since(UNIX_EPOCH)
            .unwrap_or_default();
        Self {
            utc_ns: since.as_nanos() as u64,
            byte_s,
        }
    }

    /// Returns the time in seconds since 1970, to a quarter of a microsecond.
    pub fn utc_s(&self) -> f64 {
        self.utc_ns as f64 * 1e-9
    }
}

/// A moment of the board's clock in UTC.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Utc {
    /// Nanoseconds since 1970.
    pub utc_ns: u64,
    /// Standard deviation in seconds; `None` as long as there is only one minimum delay. A delay
    /// common to all packets, such as the minimum delay of an adapter, is not included.
    pub sigma_s: Option<f64>,
    pub relation: Relation,
}

impl Utc {
    /// Returns the time in seconds since 1970, to a quarter of a microsecond.
    pub fn utc_s(&self) -> f64 {
        self.utc_ns as f64 * 1e-9
    }
}

/// The relation of a board's clock to UTC.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct Relation {
    /// With `health`: UTC less board time at board time 0.
    #[serde(rename = "clock_offset_s")]
    pub offset_s: f64,
    /// With `health`: by how much the board's clock is slow.
    #[serde(rename = "clock_skew_ppm")]
    pub skew_ppm: f64,
    /// With `health`: standard deviation of the skew.
    #[serde(rename = "clock_skew_sigma_ppm")]
    pub skew_sigma_ppm: f64,
}

/// The clock of a board from one start to the next.
#[derive(Clone, Debug, Default)]
pub struct UtcClock {
    /// UTC minus board time of the first packet in nanoseconds; delays are relative to this.
    zero_ns: Option<i64>,
    /// Board time and delay of the packet with the minimum delay in each block, seconds.
    min_delays: VecDeque<(f64, f64)>,
    /// Latest slope: index of its interval of `SLOPE_S`, number of blocks, slope and standard
    /// deviation.
    slope: Cell<Option<(i64, usize, f64, f64)>>,
    /// Time from a frame's first to its last conversion with the plan of the latest greeting,
    /// seconds.
    frame_s: Option<f64>,
    starts: Starts,
}

impl UtcClock {
    /// Takes a packet. The first packet after a start of the board resets the clock.
    pub fn take(&mut self, packet: &Packet, receipt: Receipt) {
        if self.starts.take(&packet.event) {
            let starts = std::mem::take(&mut self.starts);
            *self = Self {
                starts,
                ..Self::default()
            };
        }
        if let Event::Hello(hello) = &packet.event {
            let plan = &hello.settings.plan;
            let steps = match plan.sampling {
                Sampling::InTurn => plan.slots().saturating_sub(1),
                Sampling::AtOnce => 0,
            };
            let steps_ns = u64::from(steps) * u64::from(plan.conversion_ns());
            self.frame_s = Some(steps_ns as f64 * 1e-9);
        }
        let Some(t_s) = time_s(&packet.event) else {
            return;
        };
        // A frame's time is that of its first conversion, but it is sent after the last one.
        let lasts_s = if matches!(packet.event, Event::Raw(_)) {
            self.frame_s.unwrap_or(FRAME_S)
        } else {
            0.0
        };
        let on_line_s = match receipt.byte_s > 0.0 {
            true => receipt.byte_s * encode(packet, &mut [0; WIRE_MAX]).unwrap_or(0) as f64,
            false => 0.0,
        };
        let ahead_ns = ((t_s + lasts_s + on_line_s) * 1e9).round() as i64;
        let off_ns = receipt.utc_ns as i64 - ahead_ns;
        let delay_s = (off_ns - *self.zero_ns.get_or_insert(off_ns)) as f64 * 1e-9;
        match self.min_delays.back_mut() {
            // Ignore packets that are out of order, such as an estimate after newer frames.
            Some((last_s, _)) if t_s < *last_s => {}
            Some((last_s, min_s)) if block(*last_s) == block(t_s) => {
                if delay_s < *min_s {
                    (*last_s, *min_s) = (t_s, delay_s);
                }
            }
            _ => self.min_delays.push_back((t_s, delay_s)),
        }
    }

    /// Converts board time to UTC. Returns `None` before the first packet with a time.
    pub fn utc(&self, t_s: f64) -> Option<Utc> {
        let zero_s = self.zero_ns? as f64 * 1e-9;
        // Far from all packets, use the nearest ones.
        let t_near_s = t_s.clamp(self.min_delays.front()?.0, self.min_delays.back()?.0);
        let within = |reach_s: f64| -> Vec<(f64, f64)> {
            let first = self
                .min_delays
                .partition_point(|(at_s, _)| *at_s < t_near_s - reach_s);
            self.min_delays
                .iter()
                .skip(first)
                .take_while(|(at_s, _)| *at_s <= t_near_s + reach_s)
                .copied()
                .collect()
        };
        let (place, count) = ((t_near_s / SLOPE_S).floor() as i64, self.min_delays.len());
        let (slope, slope_sigma) = match self.slope.get() {
            Some((at, of, slope, sigma)) if (at, of) == (place, count) => (slope, sigma),
            _ => slope(&within(REACH_S)),
        };
        self.slope.set(Some((place, count, slope, slope_sigma)));
        let near = within(NEAR_S);
        let above = |(at_s, delay_s): &(f64, f64)| delay_s - slope * (at_s - t_s);
        let delay_s = near.iter().map(above).fold(f64::INFINITY, f64::min);
        let squares: f64 = near
            .iter()
            .map(|point| (above(point) - delay_s).powi(2))
            .sum();
        let scatter_s = (squares / (near.len() - 1).max(1) as f64)
            .sqrt()
            .max(SCATTER_MIN_S);
        // The minimum delay may belong to any of the nearby points, so use the largest distance.
        let far_s = near
            .iter()
            .map(|(at_s, _)| (at_s - t_s).abs())
            .fold(0.0, f64::max);
        let utc_ns = self.zero_ns? + ((t_s + delay_s) * 1e9).round() as i64;
        Some(Utc {
            utc_ns: utc_ns.max(0) as u64,
            sigma_s: (near.len() > 1).then(|| scatter_s.hypot(far_s * slope_sigma)),
            relation: Relation {
                offset_s: zero_s + delay_s - slope * t_s,
                skew_ppm: 1e6 * slope,
                skew_sigma_ppm: 1e6 * slope_sigma,
            },
        })
    }
}

fn block(t_s: f64) -> i64 {
    (t_s / BLOCK_S).floor() as i64
}

/// Maximum relative difference between two crystals; an unmeasured skew may be as large.
const CRYSTALS: f64 = 100e-6;

/// Minimum scatter: the resolution of a receipt's time, seconds.
const SCATTER_MIN_S: f64 = 1e-6;

/// Returns the slope of the line below all delays and its standard deviation; the slope is 0 unless
/// significant.
fn slope(points: &[(f64, f64)]) -> (f64, f64) {
    let hull = lower_hull(points);
    let (count, mean_s) = (
        points.len(),
        points.iter().map(|(t_s, _)| t_s).sum::<f64>() / points.len() as f64,
    );
    let Some(edge) = hull.windows(2).find(|edge| mean_s <= edge[1].0) else {
        return (0.0, CRYSTALS);
    };
    let slope = (edge[1].1 - edge[0].1) / (edge[1].0 - edge[0].0);
    let above = |(t_s, delay_s): &(f64, f64)| delay_s - edge[0].1 - slope * (t_s - edge[0].0);
    // Use the median and not the RMS: a computer that is busy for half a second delays one or two
    // blocks by milliseconds, which would hide a slope that all other blocks show.
    let mut heights_s: Vec<f64> = points.iter().map(above).collect();
    heights_s.sort_by(f64::total_cmp);
    let scatter_s = (heights_s[count / 2] / std::f64::consts::LN_2).max(SCATTER_MIN_S);
    let span_s = points[count - 1].0 - points[0].0;
    // The slope of a short edge is uncertain. Its length counts as at least the span over the root
    // of the number of points.
    let sigma = scatter_s / (edge[1].0 - edge[0].0).max(span_s / (count as f64).sqrt());
    let is_enough = count >= BLOCKS_MIN || slope.abs() > NO_CRYSTAL && count > 2;
    let counts = is_enough && slope.abs() * span_s > SIGNIFICANT * scatter_s;
    if counts {
        (slope, sigma)
    } else {
        (
            0.0,
            if count >= BLOCKS_MIN {
                sigma.min(CRYSTALS)
            } else {
                CRYSTALS
            },
        )
    }
}

/// Returns the lower convex hull of points that are ordered by time.
fn lower_hull(points: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let mut hull: Vec<(f64, f64)> = Vec::new();
    for point in points {
        while let [.., a, b] = hull[..]
            && (b.0 - a.0) * (point.1 - a.1) <= (b.1 - a.1) * (point.0 - a.0)
        {
            hull.pop();
        }
        hull.push(*point);
    }
    hull
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand_chacha::ChaCha8Rng;
    use rand_chacha::rand_core::{Rng, SeedableRng};
    use ridgetone_proto::telemetry::{Raw, Release};

    const EPOCH_NS: f64 = 1.769_862_605e18;

    #[test]
    fn a_single_minimum_delay_has_no_known_uncertainty() {
        let sigma_s = |lasts_s: f64| clock(0.0, 0.0, lasts_s, 1).utc(0.0).unwrap().sigma_s;
        assert_eq!([sigma_s(0.01), sigma_s(0.24)], [None; 2]);
        assert!(sigma_s(1.0).is_some_and(|sigma_s| sigma_s > SCATTER_MIN_S));
    }

    /// Returns a clock that has taken the frames of a board that is slow by `slow` and started at
    /// `begun_s`. Delays are exponential with a mean of a millisecond, and sometimes 16 ms longer.
    fn clock(slow: f64, begun_s: f64, lasts_s: f64, seed: u64) -> UtcClock {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let mut clock = UtcClock::default();
        for number in 0..(lasts_s * 241.0) as u32 {
            let t_us = (f64::from(number) * 1e6 / 241.0) as u64;
            let happens_s = begun_s + (1.0 + slow) * (t_us as f64 * 1e-6 + FRAME_S);
            let fraction = (f64::from(random.next_u32()) + 0.5) / 4_294_967_296.0;
            let late_s = -fraction.ln() * 1e-3
                + if random.next_u32() > u32::MAX / 10 * 9 {
                    16e-3
                } else {
                    0.0
                };
            let raw = Raw {
                t_us,
                number,
                present: 0,
                good: 0,
                codes: [0; 16],
            };
            let utc_ns = (EPOCH_NS + (happens_s + late_s) * 1e9) as u64;
            let packet = Packet {
                sequence: 1,
                event: Event::Raw(raw),
            };
            clock.take(
                &packet,
                Receipt {
                    utc_ns,
                    byte_s: 0.0,
                },
            );
        }
        clock
    }

    #[test]
    fn two_boards_of_skewed_clocks_agree_within_a_millisecond() {
        for lasts_s in [3.0, 20.0, 300.0] {
            let boards = [(80e-6, 3.0, 1), (-80e-6, -700.25, 2)];
            for fraction in [0.01, 0.5, 0.99] {
                // A moment at which both boards run.
                let moment_s = 3.0 + fraction * lasts_s;
                let [one, other] = boards.map(|(slow, begun_s, seed)| {
                    let clock = clock(slow, begun_s, lasts_s + 703.25, seed);
                    clock
                        .utc((moment_s - begun_s) / (1.0 + slow))
                        .expect("a time")
                });
                let off_s = |utc: Utc| utc.utc_s() - EPOCH_NS * 1e-9 - moment_s;
                assert!(
                    (one.utc_s() - other.utc_s()).abs() < 1e-3,
                    "{lasts_s} s: {} {}",
                    off_s(one),
                    off_s(other)
                );
                for utc in [one, other] {
                    assert!(
                        off_s(utc).abs() < 3.0 * utc.sigma_s.unwrap() + 1e-6,
                        "{lasts_s} s, {fraction}: {} +- {:?}, {:?}",
                        off_s(utc),
                        utc.sigma_s,
                        utc.relation
                    );
                }
            }
        }
    }

    #[test]
    fn a_skew_is_found_with_its_uncertainty_and_none_where_a_recording_is_short() {
        let long = clock(80e-6, 0.0, 300.0, 3)
            .utc(150.0)
            .expect("a time")
            .relation;
        assert!(
            (long.skew_ppm - 80.0).abs() < 3.0 * long.skew_sigma_ppm && long.skew_sigma_ppm < 3.0,
            "{long:?}"
        );
        // The error of an internal oscillator is a few percent, which is detected at once.
        let internal = clock(0.03, 0.0, 4.0, 4).utc(2.0).expect("a time").relation;
        assert!((internal.skew_ppm - 3e4).abs() < 300.0, "{internal:?}");
        let short = clock(80e-6, 0.0, 2.0, 5).utc(1.0).expect("a time").relation;
        assert_eq!((short.skew_ppm, short.skew_sigma_ppm), (0.0, 100.0));
        assert!(UtcClock::default().utc(0.0).is_none());
    }

    /// Adds a release at board time `t_us` that arrives at `utc_s`.
    fn release(clock: &mut UtcClock, t_us: u64, utc_s: f64) {
        let packet = Packet {
            sequence: 1,
            event: Event::Release(Release {
                t_us,
                reported_after_us: 0,
            }),
        };
        clock.take(
            &packet,
            Receipt {
                utc_ns: (EPOCH_NS + utc_s * 1e9) as u64,
                byte_s: 0.0,
            },
        );
    }

    /// The slope must be found: without it, messages at one end would be off by 0.9 ms.
    #[test]
    fn two_blocks_that_are_late_hide_no_slope_of_short_recordings() {
        for late_at_s in [[0.6, 1.1], [2.0, 2.3], [3.6, 4.2]] {
            let mut clock = UtcClock::default();
            for frame in 0..1080u32 {
                let t_s = f64::from(frame) / 241.0;
                let late = late_at_s.iter().any(|at_s| block(*at_s) == block(t_s));
                let late_s = if late {
                    5e-3
                } else {
                    60e-6 + 40e-6 * f64::from(frame % 7)
                };
                release(
                    &mut clock,
                    (t_s * 1e6) as u64,
                    (1.0 - 200e-6) * t_s + late_s,
                );
            }
            let found = clock.utc(2.0).expect("a time").relation;
            assert!(
                (found.skew_ppm + 200.0).abs() < 4.0 * found.skew_sigma_ppm,
                "{late_at_s:?}: {found:?}"
            );
            assert!(found.skew_sigma_ppm < 40.0, "{late_at_s:?}: {found:?}");
        }
    }

    #[test]
    fn a_drift_over_an_hour_is_followed() {
        // Two halves of 40 minutes with different skews: the middle of each must follow its own
        // skew.
        let mut clock = UtcClock::default();
        let mut utc_s = 0.0;
        for second in 0..4800u64 {
            release(&mut clock, second * 1_000_000, utc_s);
            utc_s += 1.0 + if second < 2400 { 50e-6 } else { -50e-6 };
        }
        for (t_s, skew_ppm) in [(1200.0, 50.0), (3600.0, -50.0)] {
            let found = clock.utc(t_s).expect("a time").relation.skew_ppm;
            assert!((found - skew_ppm).abs() < 1.0, "{found}");
        }
    }
}
