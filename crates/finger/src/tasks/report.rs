//! `report`: encodes packets while the line has room for them.

use super::outbox::Outbox;
use super::shared::{LOW_WATER, Platform, Shared, Task};
use core::sync::atomic::Ordering::Relaxed;
use heapless::spsc::Producer;
use ridgetone_proto::telemetry::{Events, WIRE_MAX};
use rtic_core::Mutex;

/// State that only this task uses.
pub struct Report<'a> {
    bytes: Producer<'a, u8>,
    wire: [u8; WIRE_MAX],
}

impl<'a> Report<'a> {
    /// `bytes`: to `line`. A zero goes first. It ends a packet that a reset may have cut; without
    /// it the greeting would be taken for the rest of that packet.
    pub fn new(mut bytes: Producer<'a, u8>) -> Self {
        let _ = bytes.enqueue(0);
        Self {
            bytes,
            wire: [0; WIRE_MAX],
        }
    }

    /// Runs when an event was posted, and when the queue of bytes is nearly empty.
    pub fn run<P: Platform, E: Events>(
        &mut self,
        outbox: &mut impl Mutex<T = Outbox<E>>,
        shared: &Shared<P>,
    ) {
        while self.bytes.len() <= LOW_WATER {
            let wire = &mut self.wire;
            let (headline, length) =
                outbox.lock(|outbox| (outbox.headline(), outbox.encode_next(wire)));
            let Some(length) = length else {
                break;
            };
            // Without the lock, which `detect` may wait for.
            if let Some(headline) = headline {
                shared.platform.log(headline);
            }
            let Some(encoded) = length.ok().and_then(|length| wire.get(..length)) else {
                shared.diagnostics.messages_dropped.add(1);
                continue;
            };
            for byte in encoded {
                // Never full: see `LOW_WATER`.
                let _ = self.bytes.enqueue(*byte);
            }
            // After the bytes: `line` clears it when it finds none.
            shared.sending.store(true, Relaxed);
            P::pend(shared, Task::SerialLine);
        }
    }
}
