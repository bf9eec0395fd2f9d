//! Runs the example, which must count the damaged packet and the missing one.

#[path = "../examples/decode.rs"]
#[allow(dead_code, reason = "its main is for cargo run --example")]
mod decode;

use ridgetone_proto::telemetry::{Contact, Event, Packet, WIRE_MAX, encode};

#[test]
fn packets_come_out_and_a_lost_and_a_damaged_one_are_counted() {
    let packets: Vec<Packet> = (0..8)
        .map(|sequence| {
            let contact = Contact {
                t_us: 1_000_000 * u64::from(sequence),
                taxel: 3,
                height_v: 0.012,
                onset_us: 0,
                reported_after_us: 0,
            };
            Packet {
                sequence,
                event: Event::Contact(contact),
            }
        })
        .collect();
    let mut bytes = Vec::new();
    for packet in packets.iter().filter(|packet| packet.sequence != 2) {
        let mut wire = [0; WIRE_MAX];
        let used = encode(packet, &mut wire).expect("it fits");
        if packet.sequence == 5 {
            // Flip a bit of the content without creating a zero, which would end the frame.
            wire[used / 2] ^= if wire[used / 2] == 0x40 { 0x20 } else { 0x40 };
        }
        bytes.extend_from_slice(&wire[..used]);
    }
    let (decoded, decoder) = decode::decode(bytes);
    let expected: Vec<Packet> = packets
        .into_iter()
        .filter(|packet| ![2, 5].contains(&packet.sequence))
        .collect();
    assert_eq!(decoded, expected);
    // The damaged packet also counts as missing, because its number is unknown.
    assert_eq!((decoder.damaged, decoder.missing), (1, 2));
}
