//! Tests scheduled faults: each takes effect at its time, and ends.
mod common;
use common::{chip, next, read, write};
use hal_mock::{Ads1258, Fault, Injection};

/// CONFIG0 with the status byte, CONFIG1 with DRATE 1 and DLY 3: a conversion every 3106 tCLK
/// (SBAS297G, auto-scan: 128 (16 + 4.265625 + 4)).
const SCAN: [u8; 2] = [0x02, 0x31];
/// Time per conversion with [`SCAN`] at 15.72864 MHz, nanoseconds.
const PERIOD_NS: u64 = 197_474;

fn with(fault: Fault, lasts_s: f64) -> Ads1258 {
    let mut chip = chip(|options| {
        options.injections = vec![Injection {
            at_s: 0.002,
            lasts_s,
            fault,
        }]
    });
    write(&mut chip, 0, 0, &SCAN);
    chip.set_start(0, true);
    chip
}

/// Reads a conversion at each edge until `until_ns`. Returns the times, status bytes and codes.
fn serve(chip: &mut Ads1258, until_ns: u64) -> Vec<(u64, u8, i32)> {
    let mut all = Vec::new();
    while let Some(edge_ns) = chip
        .next_drdy_fall_ns()
        .filter(|edge_ns| *edge_ns < until_ns)
    {
        let (status, code) = read(chip, edge_ns);
        all.push((edge_ns, status, code));
    }
    all
}

/// Time at which the injection acted: after the first edge from 2 ms on.
fn begun_ns(chip: &Ads1258) -> u64 {
    let begun_ns = chip.injected()[0].begun_ns.expect("it has acted");
    assert!(
        (2_000_000..2_000_000 + PERIOD_NS).contains(&begun_ns),
        "{begun_ns}"
    );
    begun_ns
}

#[test]
fn lost_edges_cost_their_results() {
    let mut chip = with(Fault::EdgesLost { count: 3 }, 0.0);
    let ids: Vec<u8> = serve(&mut chip, 4_000_000)
        .iter()
        .map(|edge| edge.1)
        .collect();
    // The chip counts conversions whose edge did not arrive as overwritten.
    let counters = chip.counters();
    assert_eq!(
        (counters.conversions - ids.len() as u64, counters.lost),
        (3, 3)
    );
    let gaps: Vec<_> = ids
        .windows(2)
        .filter(|pair| pair[1] != pair[0] + 1 && pair[1] != 0x88)
        .collect();
    assert_eq!(gaps.len(), 1, "{ids:?}");
    assert_eq!(gaps[0][1] - gaps[0][0], 4);
}

#[test]
fn a_repeated_edge_has_nothing_new() {
    let mut chip = with(Fault::EdgeRepeated { after_ns: 50_000 }, 0.0);
    let edges = serve(&mut chip, 4_000_000);
    let old: Vec<_> = edges.iter().filter(|edge| edge.1 & 0x80 == 0).collect();
    assert_eq!(old.len(), 1, "NEW is 0 once");
    assert_eq!(old[0].0, begun_ns(&chip) + 50_000);
    assert_eq!(chip.counters().lost, 0);
}

#[test]
fn a_stuck_pin_has_a_level_and_no_edges() {
    for high in [true, false] {
        let mut chip = with(Fault::DrdyStuck { high }, 0.002);
        serve(&mut chip, 10_000_000);
        let begun_ns = begun_ns(&chip);
        assert_eq!(chip.next_drdy_fall_ns(), None);
        assert_eq!(
            (chip.drdy_high(begun_ns + 50_000), chip.is_drdy_stuck()),
            (high, true)
        );
        chip.advance_to(4_200_000);
        assert!(!chip.is_drdy_stuck() && chip.next_drdy_fall_ns().is_some());
        // About ten conversions in 2 ms.
        assert!(
            (9..=11).contains(&chip.counters().lost),
            "{:?}",
            chip.counters()
        );
    }
}

#[test]
fn a_storm_is_edges_without_results_between_those_with() {
    let mut chip = with(Fault::Storm { period_ns: 10_000 }, 0.001);
    let edges = serve(&mut chip, 5_000_000);
    let (new, old): (Vec<_>, Vec<_>) = edges.into_iter().partition(|edge| edge.1 & 0x80 != 0);
    assert_eq!(new.len() as u64, chip.counters().conversions);
    // One edge every 10 us from the beginning of the storm to its end.
    let expected = (chip.injected()[0].over_ns.expect("it is over") - begun_ns(&chip)) / 10_000;
    assert!(
        (old.len() as u64).abs_diff(expected) <= 1,
        "{} {expected}",
        old.len()
    );
}

#[test]
fn dout_stuck_reads_as_it_and_the_result_is_gone() {
    for (high, all, code) in [(true, 0xFF, -1), (false, 0x00, 0)] {
        let mut chip = with(Fault::DoutStuck { high }, 0.001);
        let edges = serve(&mut chip, 4_000_000);
        let stuck: Vec<_> = edges
            .iter()
            .filter(|edge| edge.1 == all && edge.2 == code)
            .collect();
        assert!((5..=6).contains(&stuck.len()), "{}", stuck.len());
        // From the chip's point of view, all results were read.
        assert_eq!(chip.counters().lost, 0);
    }
}

#[test]
fn nothing_reaches_the_chip_over_a_cut_bus() {
    let mut chip = with(Fault::BusCut { high: true }, 0.001);
    let edges = serve(&mut chip, 4_000_000);
    let cut = edges.iter().filter(|edge| edge.1 == 0xFF).count() as u64;
    // No result was read: each was overwritten by the next, except the last, which may still be
    // unread.
    assert!(
        cut >= 5 && (cut - 1..=cut).contains(&chip.counters().lost),
        "{cut} {:?}",
        chip.counters()
    );
}

#[test]
fn a_bit_of_the_command_makes_another_command() {
    // With bit 6 inverted, 30h (read by command) becomes 70h, a register write from 00h: it writes
    // the zeros that follow.
    let command = |mask| Fault::DinFlip {
        bytes_ahead: 0,
        mask,
    };
    let mut chip = with(command(0x40), 0.0);
    serve(&mut chip, 2_500_000);
    assert_eq!(chip.registers()[..4], [0, 0, 0, 0]);
    // With bit 5 inverted, it becomes 10h, a direct read: the status comes one byte early.
    let mut chip = with(command(0x20), 0.0);
    let edges = serve(&mut chip, 4_000_000);
    let number = edges
        .iter()
        .position(|edge| edge.0 == begun_ns(&chip))
        .expect("an edge");
    // The byte read as the status is the code's high byte: AIN9 is at 0.9 V, 1B80h codes of 256 at
    // a reference of 4.096 V.
    let code = (number as f64 * 0.1 / 4.096 * 7_864_320.0).round() as i32;
    assert_eq!(i32::from(edges[number].1), code >> 16);
}

#[test]
fn a_chip_that_resets_itself_scans_as_its_defaults_say() {
    let mut chip = with(Fault::Reset, 0.0);
    let edges = serve(&mut chip, 4_000_000);
    assert_eq!(
        chip.registers(),
        [0x0A, 0x83, 0x00, 0x00, 0xFF, 0xFF, 0x00, 0xFF, 0x00, 0x8B]
    );
    let behind: Vec<_> = edges
        .iter()
        .filter(|edge| edge.0 > begun_ns(&chip))
        .collect();
    // Sixteen inputs, no internal readings, DRATE 3 without delay: 128 (1 + 4.265625) tCLK are
    // 42.85 us.
    assert!(behind.iter().all(|edge| (0x88..=0x97).contains(&edge.1)));
    assert_eq!(behind[0].1, 0x88);
    assert!(
        behind[1..]
            .windows(2)
            .all(|pair| (42_840..42_860).contains(&(pair[1].0 - pair[0].0)))
    );
}

#[test]
fn another_clock_from_a_moment_on_and_back() {
    let mut chip = with(
        Fault::Clock {
            error_ppm: -10_000.0,
        },
        0.002,
    );
    let edges = serve(&mut chip, 7_000_000);
    let from_ns = begun_ns(&chip);
    let over_ns = chip.injected()[0].over_ns.expect("it is over");
    for pair in edges.windows(2) {
        let slow = pair[0].0 >= from_ns && pair[1].0 <= over_ns;
        let expected_ns = PERIOD_NS as f64 * if slow { 1.0 / 0.99 } else { 1.0 };
        let apart_ns = (pair[1].0 - pair[0].0) as f64;
        assert!(
            (apart_ns - expected_ns).abs() < 100.0,
            "{apart_ns} {expected_ns}"
        );
    }
    // Nothing is sampled twice or skipped.
    assert_eq!(edges.len() as u64, chip.counters().conversions);
}

#[test]
fn supply_reference_and_inputs_are_what_they_were_afterwards() {
    for (fault, flagged) in [
        // Below 4.3 V SUPPLY is set with every result.
        (Fault::Supply { volts: 4.0 }, None),
        (Fault::Supply { volts: 4.5 }, Some(0)),
        (Fault::Reference { volts: 3.9 }, Some(0)),
        // AIN12 is converted once in these 5 or 6 conversions: OVF beyond 1.06 of the reference.
        (
            Fault::Input {
                input: 12,
                volts: 5.0,
            },
            Some(1),
        ),
    ] {
        let mut chip = with(fault, 0.001);
        let edges = serve(&mut chip, 12_000_000);
        let from_ns = begun_ns(&chip);
        let over_ns = chip.injected()[0].over_ns.expect("it is over");
        let (during, others): (Vec<_>, Vec<_>) = edges
            .into_iter()
            .partition(|edge| edge.0 > from_ns && edge.0 <= over_ns);
        let odd = |edges: &[(u64, u8, i32)]| edges.iter().filter(|edge| edge.1 & 0x60 != 0).count();
        assert_eq!(odd(&during), flagged.unwrap_or(during.len()));
        assert_eq!(odd(&others), 0);
        assert_eq!(chip.options().analog, common::chip(|_| ()).options().analog);
    }
}

#[test]
fn a_converter_that_stood_still_goes_on_with_the_next_input() {
    let mut chip = with(Fault::Stall, 0.001);
    let mut before = None;
    while chip.next_drdy_fall_ns().is_some() {
        before = Some(next(&mut chip));
    }
    let (stopped_ns, status, _) = before.expect("conversions");
    assert_eq!(stopped_ns, begun_ns(&chip));
    chip.advance_to(3_100_000);
    let (edge_ns, after, _) = next(&mut chip);
    // The running conversion is lost; SBAS297G: the first result is 128 (16 + 4) + 68 tCLK after
    // the start condition.
    assert_eq!(after, status + 2);
    assert_eq!(
        edge_ns,
        chip.injected()[0].over_ns.expect("it is over") + 167_083
    );
}
