//! Compares SPI bytes with the datasheet.
mod common;
use common::{chip, code, next, read, started, write};
use hal_mock::{Ads1258, Constant, Fault, Options};

/// Time of the first transfer, nanoseconds. At DRATE 3 a conversion takes 663 cycles or more, so
/// one has finished by then, but not two.
const ONE: u64 = 60_000;

fn transfer<const N: usize>(chip: &mut Ads1258, now_ns: u64, mut bytes: [u8; N]) -> [u8; N] {
    chip.transfer(now_ns, &mut bytes);
    bytes
}

/// Register values after reset, by address.
const RESET_VALUES: [u8; 10] = [0x0A, 0x83, 0x00, 0x00, 0xFF, 0xFF, 0x00, 0xFF, 0x00, 0x8B];

/// Sends single frames after reset and compares DOUT.
#[test]
fn commands_answer_as_the_datasheet_says() {
    let all = [&[0xA5][..], &RESET_VALUES].concat();
    let frames: [(&[u8], &[u8]); 7] = [
        (&[0x50, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0], &all),
        (&[0x61, 0x31, 0x00], &[0xA5; 3]),
        (&[0x41, 0, 0], &[0xA5, 0x83, 0xA5]),
        // Several commands.
        (
            &[0x61, 0x31, 0x41, 0, 0x49, 0],
            &[0xA5, 0xA5, 0xA5, 0x31, 0xA5, 0x8B],
        ),
        // GPIOD reads the inputs, and after ID, the last register, a new command follows.
        (&[0x58, 0, 0, 0x40, 0], &[0xA5, 0x00, 0x8B, 0xA5, 0x0A]),
        // There is no register above 09h.
        (&[0x6A, 0x12], &[0xA5; 2]),
        (&[0x4F, 0], &[0xA5; 2]),
    ];
    for (sent, received) in frames {
        let mut bytes = sent.to_vec();
        chip(|_| ()).transfer(0, &mut bytes);
        assert_eq!(bytes, received, "{sent:#x?}");
    }
}

#[test]
fn a_written_register_reads_back_and_no_other_changes() {
    let mut chip = chip(|_| ());
    transfer(&mut chip, 0, [0x61, 0x31, 0x00]);
    assert_eq!(chip.counters().register_writes, 1);
    assert_eq!(transfer(&mut chip, 0, [0x41, 0, 0]), [0xA5, 0x31, 0xA5]);
    let mut expected = RESET_VALUES;
    expected[1] = 0x31;
    assert_eq!(chip.registers(), expected);
    transfer(&mut chip, 0, [0x6A, 0x12]);
    assert_eq!(chip.registers(), expected);
}

/// Writes three values, starting at GPIOD. The third would go to register 0Ah, but is taken as a
/// command instead (here a reserved one).
#[test]
fn multiple_access_ends_after_the_last_register() {
    let mut chip = chip(|_| ());
    write(&mut chip, 0, 0x08, &[0xFF, 0xFF, 0xA0]);
    assert_eq!(
        (
            chip.counters().register_writes,
            chip.counters().odd_commands
        ),
        (2, 1)
    );
    assert_eq!(chip.registers(), RESET_VALUES);
}

#[test]
fn reserved_and_read_only_bits_keep_their_value() {
    let mut chip = chip(|_| ());
    write(&mut chip, 0, 0, &[0xFF; 10]);
    assert_eq!(
        chip.registers(),
        [0x7E, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0x3D, 0xFF, 0x00, 0x8B]
    );
}

#[test]
fn gpio_outputs_read_back_and_inputs_show_the_pins() {
    let mut chip = chip(|_| ());
    chip.set_gpio_inputs(0x3C);
    write(&mut chip, 0, 7, &[0xF0, 0x55]);
    assert_eq!(chip.registers()[8], 0x35);
}

#[test]
fn cs_high_drops_an_unfinished_command() {
    let mut chip = chip(|_| ());
    chip.transfer(0, &mut [0x61]);
    chip.transfer(0, &mut [0x31]); // not the value of CONFIG1
    assert_eq!(chip.registers()[1], 0x83);
}

#[test]
fn reading_by_command_again_gives_the_same_data_without_new() {
    let mut chip = chip(|_| ());
    write(&mut chip, 0, 4, &[0x08, 0x00]); // AIN3
    chip.set_start(0, true);
    let (status, first) = read(&mut chip, ONE);
    assert_eq!(
        (status, first),
        (0x80 | 0x0B, (0.3_f64 / 4.096 * 7864320.0).round() as i32)
    );
    let twice = transfer(&mut chip, ONE, [0x30, 0, 0, 0, 0, 0x30, 0, 0, 0, 0]);
    for bytes in [&twice[..5], &twice[5..]] {
        let found = (bytes[0], bytes[1], code([bytes[2], bytes[3], bytes[4]]));
        assert_eq!(found, (0xA5, 0x0B, first));
    }
    assert_eq!(chip.counters().read, 1);
}

#[test]
fn read_by_command_has_the_status_byte_whatever_stat_says() {
    let mut chip = chip(|_| ());
    write(&mut chip, 0, 0, &[0x00]);
    chip.set_start(0, true);
    assert_eq!(read(&mut chip, ONE).0, 0x88);
}

#[test]
fn read_by_command_needs_mul() {
    let mut chip = started();
    assert_eq!(transfer(&mut chip, ONE, [0x20, 0, 0, 0, 0]), [0xA5; 5]);
    assert_eq!(chip.counters().odd_commands, 1);
}

#[test]
fn direct_read_has_three_or_four_bytes_then_zeros() {
    // 1.5 V at AIN15, behind its status byte.
    let expected = [0x80 | 0x17, 0x2B, 0xF2, 0x00, 0, 0, 0, 0, 0, 0];
    for (config0, skipped) in [(0x02, 0), (0x00, 1)] {
        for din in [0x00, 0xFF] {
            let mut chip = chip(|_| ());
            write(&mut chip, 0, 0, &[config0]);
            write(&mut chip, 0, 4, &[0x00, 0x80]);
            chip.set_start(0, true);
            assert_eq!(transfer(&mut chip, ONE, [din; 9]), expected[skipped..][..9]);
        }
    }
}

#[test]
fn a_direct_read_behind_a_command_reads_nothing() {
    let mut chip = started();
    let bytes = transfer(&mut chip, ONE, [0x49, 0, 0, 0, 0, 0]);
    assert_eq!(bytes, [0xA5, 0x8B, 0xA5, 0xA5, 0xA5, 0xA5]);
    assert_eq!(read(&mut chip, ONE).0 & 0x80, 0x80, "still new");
}

#[test]
fn a_command_read_survives_a_drdy_edge_and_a_direct_read_does_not() {
    let volts = std::array::from_fn(|n| if n == 1 { -1.0 } else { 1.00001 });
    for direct in [false, true] {
        let options = Options {
            noise: false,
            poison: Some(0),
            ..Options::default()
        };
        let mut chip = Ads1258::new(Box::new(Constant { volts, end_s: 1.0 }), options);
        chip.set_start(0, true);
        let first = chip.next_drdy_fall_ns().unwrap();
        chip.advance_to(first);
        let second = chip.next_drdy_fall_ns().unwrap();
        chip.select(second - 3000);
        let mut bytes = if direct {
            vec![0; 4]
        } else {
            vec![0x30, 0, 0, 0, 0]
        };
        for (k, byte) in bytes.iter_mut().enumerate() {
            let at = second - 3000 + 1000 * k as u64;
            *byte = chip.exchange(at, at + 900, *byte);
        }
        chip.deselect(second + 3000);
        let old = (1.00001_f64 / 4.096 * 7864320.0).round() as i32;
        if direct {
            assert_eq!(bytes[..3], [0x88, 0x1D, 0x4C]);
            assert_ne!(bytes[3], old as u8, "the last byte is the next result's");
        } else {
            assert_eq!(code([bytes[2], bytes[3], bytes[4]]), old);
        }
        assert!(
            !chip.drdy_high(second + 3000),
            "the second result is unread"
        );
        assert_eq!(read(&mut chip, second + 3000).0, 0x89);
    }
}

#[test]
fn the_time_out_resets_the_interface_but_not_the_chip() {
    for (config0, limit_cycles) in [(0x02, 4096), (0x42, 256)] {
        let mut chip = chip(|_| ());
        write(&mut chip, 0, 0, &[config0]);
        let limit_ns = chip.cycles_ns(limit_cycles);
        for (gap_ns, expected) in [(limit_ns - 1, config0), (limit_ns, 0xA5)] {
            chip.select(0);
            let now = chip.exchange(0, 0, 0x40);
            assert_eq!(now, 0xA5);
            // After the time-out the next byte is a command, here the reserved A0h.
            assert_eq!(chip.exchange(gap_ns, gap_ns, 0xA0), expected);
            chip.deselect(gap_ns);
        }
        assert_eq!(chip.registers()[0], config0);
    }
}

#[test]
fn after_the_time_out_the_zeros_of_a_direct_read_end() {
    let mut chip = chip(|_| ());
    chip.select(0);
    for _ in 0..6 {
        chip.exchange(0, 0, 0);
    }
    let late_ns = chip.cycles_ns(4096);
    assert_eq!(chip.exchange(late_ns, late_ns, 0x49), 0xA5);
    assert_eq!(chip.exchange(late_ns, late_ns, 0), 0x8B);
}

#[test]
fn random_poison_is_unlike_what_was_sent_and_repeats_with_the_seed() {
    let dout = |seed| {
        let mut chip = chip(|o| (o.poison, o.seed) = (None, seed));
        transfer(
            &mut chip,
            0,
            [0x70, 0x02, 0x83, 0, 0, 0xFF, 0xFF, 0, 0xFF, 0, 0x8B],
        )
    };
    assert_eq!(dout(1), dout(1));
    assert_ne!(dout(1), dout(2));
    let different: std::collections::BTreeSet<_> = dout(1).into_iter().collect();
    assert!(different.len() > 6);
}

#[test]
fn reset_command_defaults_the_registers_and_lets_the_conversion_finish() {
    let mut chip = chip(|_| ());
    write(&mut chip, 0, 0, &[0x02, 0x30]); // DRATE 0
    write(&mut chip, 0, 4, &[0x10, 0x00]);
    chip.set_start(0, true);
    let edge_ns = chip.next_drdy_fall_ns();
    chip.transfer(1000, &mut [0xC0]);
    assert_eq!(chip.registers(), RESET_VALUES);
    assert_eq!(chip.next_drdy_fall_ns(), edge_ns);
    assert_eq!(next(&mut chip).1, 0x80 | 0x0C, "the old selection's result");
    assert_eq!(next(&mut chip).1, 0x88, "the defaults' first");
}

#[test]
fn reset_pin_ends_everything_and_a_high_start_begins_again() {
    let mut chip = chip(|_| ());
    write(&mut chip, 0, 1, &[0x31]);
    chip.set_start(0, true);
    next(&mut chip);
    let low_ns = chip.next_drdy_fall_ns().unwrap() + 100;
    chip.advance_to(low_ns);
    assert!(!chip.drdy_high(low_ns));
    chip.set_reset(low_ns, false);
    assert!(chip.drdy_high(low_ns));
    assert_eq!(chip.next_drdy_fall_ns(), None);
    assert_eq!(transfer(&mut chip, low_ns, [0x41, 0]), [0xA5; 2]);
    chip.set_reset(low_ns + 1000, true);
    assert_eq!(chip.registers()[1], 0x83);
    assert_eq!(
        chip.next_drdy_fall_ns(),
        Some(low_ns + 1000 + chip.cycles_ns(708))
    );
}

#[test]
fn faults_flip_the_bits_of_their_mask() {
    let mut chip = chip(|_| ());
    chip.begin_fault(Fault::RegisterFlip {
        address: 1,
        mask: 0x01,
    });
    assert_eq!(chip.registers()[1], 0x82);
    chip.begin_fault(Fault::RegisterFlip {
        address: 0x20,
        mask: 0xFF,
    });
    chip.begin_fault(Fault::DoutFlip {
        bytes_ahead: 1,
        mask: 0x80,
    });
    assert_eq!(transfer(&mut chip, 0, [0x49, 0]), [0xA5, 0x0B]);
    assert_eq!(transfer(&mut chip, 0, [0x49, 0]), [0xA5, 0x8B]);
}

#[test]
fn nobody_is_home_during_power_up() {
    let mut chip = chip(|o| o.power_up_cycles = 1 << 18);
    let ready_ns = chip.cycles_ns(1 << 18);
    assert_eq!(transfer(&mut chip, ready_ns - 1, [0x49, 0]), [0xA5; 2]);
    assert_eq!(transfer(&mut chip, ready_ns, [0x49, 0]), [0xA5, 0x8B]);
}
