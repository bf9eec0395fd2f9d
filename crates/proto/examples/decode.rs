//! Decodes the bytes of a finger's serial line into packets.
//!
//! `cargo run -p ridgetone-proto --example decode < FILE`, where the file has the bytes from the
//! serial port.

use ridgetone_proto::telemetry::{Decoder, Event, Packet};
use std::io::Read;

/// Decodes bytes. Returns the packets, and the decoder with its counts of damaged and missing ones.
pub fn decode(bytes: impl IntoIterator<Item = u8>) -> (Vec<Packet>, Decoder) {
    let mut decoder = Decoder::new();
    let packets = bytes
        .into_iter()
        .filter_map(|byte| decoder.push(byte))
        .collect();
    (packets, decoder)
}

fn main() -> std::io::Result<()> {
    let mut bytes = Vec::new();
    std::io::stdin().read_to_end(&mut bytes)?;
    let (packets, decoder) = decode(bytes);
    for packet in &packets {
        match &packet.event {
            Event::Contact(contact) => {
                println!("{} us: taxel {} was touched", contact.t_us, contact.taxel)
            }
            Event::Release(release) => println!("{} us: released", release.t_us),
            Event::Estimate(estimate) => {
                println!("{:?}: {:.2} Hz", estimate.status, estimate.frequency)
            }
            _ => {}
        }
    }
    println!(
        "{} packets, {} damaged, {} missing",
        packets.len(),
        decoder.damaged,
        decoder.missing
    );
    Ok(())
}
