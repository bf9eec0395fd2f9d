//! A simulated board as a source, in step with its reader: virtual time passes only while the
//! reader waits.

use crate::check::{Inputs, Observations, Plan, gather};
use crate::feed::{Feed, FeedEvent, Source};
use crate::input::Opened;
use crate::output::Progress;
use crate::ram_flash::RamFlash;
use crate::simulated::{self, Start, Surroundings};
use anyhow::{Context, Result};
use hal_mock::{Ads1258, SimulatedBoard};
use ridgetone_finger::tasks::Received;
use ridgetone_proto::boot::{Boot, BrownOut, Oscillator, ResetCause, SettingsSource};
use ridgetone_proto::settings::Settings;
use ridgetone_proto::store::{FlashStore, Store};
use ridgetone_proto::telemetry::{Decoder, Event, Packet, WIRE_MAX, encode};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::thread::JoinHandle;
use std::time::Duration;

/// Changes the bytes of one packet, numbered from 0.
type OnLine = Box<dyn FnMut(u64, &mut Vec<u8>) + Send>;

/// A healthy board, except for the faults that these fields inject.
pub struct Bench {
    pub input: Opened,
    pub boot: Boot,
    /// Settings in the flash at the start.
    pub stored: Option<Settings>,
    /// True if the flash refuses to be written.
    pub is_worn: bool,
    /// Settings that were sent since the start.
    pub in_force: Option<Settings>,
    /// Injects faults into the chip after its set-up.
    pub on_start: fn(&mut Ads1258),
    /// Changes each packet before it is sent.
    pub altered: Box<dyn FnMut(&mut Packet) + Send>,
    pub on_line: OnLine,
    /// Maps each byte, numbered from 0, to what the board's USART receives.
    pub received: fn(u64, u8) -> Received,
    pub plan: Plan,
}

impl Default for Bench {
    fn default() -> Self {
        let boot = Boot {
            cause: ResetCause::Power,
            oscillator: Oscillator::External,
            brown_out: BrownOut::Level3,
            record: None,
        };
        Self {
            input: Opened::untouched(),
            boot,
            stored: None,
            is_worn: false,
            in_force: None,
            on_start: |_| {},
            altered: Box::new(|_| {}),
            on_line: Box::new(|_, _| {}),
            received: |_, byte| Received::Byte(byte),
            plan: Plan {
                length_s: 5.0,
                stores: false,
                inputs: Inputs::Shorted,
            },
        }
    }
}

impl Bench {
    pub fn with(change: impl FnOnce(&mut Self)) -> Self {
        let mut bench = Self::default();
        change(&mut bench);
        bench
    }

    pub fn feed(mut self) -> Feed {
        let mut flash = RamFlash::default();
        if let Some(settings) = &self.stored {
            let mut store = FlashStore::new(flash);
            assert!(store.save(Some(settings), true).is_ok());
            flash = store.release();
        }
        flash.is_worn = self.is_worn;
        let mut start = Start::new(flash, self.boot.clone());
        if let Some(settings) = self.in_force {
            (start.settings, start.source) = (settings, SettingsSource::Sent);
        }
        let input = std::mem::replace(&mut self.input, Opened::untouched());
        let (to_feed, telemetry) = channel();
        let (requests, to_board) = channel();
        let mut line = BoardEnd {
            bench: self,
            to_feed,
            to_board,
            decoder: Decoder::new(),
            packets: 0,
            bytes: 0,
        };
        let board = move || simulated::run(input, start, &mut line).map(|_| ());
        Feed::new(Running {
            telemetry,
            requests: Some(requests),
            unsent: Vec::new(),
            is_waited_for: false,
            thread: Some(std::thread::spawn(board)),
        })
    }

    pub fn observations(self) -> Observations {
        let plan = self.plan;
        gather(&mut self.feed(), plan, &mut Progress::default())
    }
}

/// The board's end of the line.
struct BoardEnd {
    bench: Bench,
    to_feed: Sender<Vec<u8>>,
    to_board: Receiver<Vec<u8>>,
    decoder: Decoder,
    packets: u64,
    bytes: u64,
}

impl Surroundings for BoardEnd {
    fn started(&mut self, board: &SimulatedBoard, _: bool) -> Result<()> {
        board.with_chip(self.bench.on_start);
        Ok(())
    }

    fn exchange(&mut self, _: &SimulatedBoard, sent: &[u8]) -> Result<Vec<Received>> {
        if sent.is_empty() {
            return Ok(Vec::new());
        }
        let mut bytes = Vec::new();
        for mut packet in sent.iter().filter_map(|byte| self.decoder.push(*byte)) {
            if let Event::Health(health) = &mut packet.event {
                // A simulated board does not measure load and stack, so set plausible values.
                (health.load, health.stack_used_bytes, health.stack_bytes) = (0.1, 7000, 32_768);
            }
            (self.bench.altered)(&mut packet);
            let mut wire = [0; WIRE_MAX];
            let length = encode(&packet, &mut wire)?;
            let mut packet = wire[..length].to_vec();
            (self.bench.on_line)(self.packets, &mut packet);
            self.packets += 1;
            bytes.extend(packet);
        }
        self.to_feed.send(bytes).context("the reader is gone")?;
        let arrived = self.to_board.recv().context("the reader is gone")?;
        let numbered = (self.bytes..).zip(&arrived);
        self.bytes += arrived.len() as u64;
        Ok(numbered
            .map(|(number, byte)| (self.bench.received)(number, *byte))
            .collect())
    }
}

struct Running {
    telemetry: Receiver<Vec<u8>>,
    requests: Option<Sender<Vec<u8>>>,
    unsent: Vec<u8>,
    /// True if the board is waiting for bytes from the reader.
    is_waited_for: bool,
    thread: Option<JoinHandle<Result<()>>>,
}

impl Source for Running {
    fn name(&self) -> String {
        "simulated board".into()
    }

    fn next(&mut self, _: Duration) -> Result<Option<FeedEvent<Vec<u8>>>> {
        if std::mem::replace(&mut self.is_waited_for, true)
            && let Some(requests) = &self.requests
        {
            // If the board is gone, the next line fails too.
            let _ = requests.send(std::mem::take(&mut self.unsent));
        }
        Ok(Some(
            self.telemetry
                .recv()
                .map_or(FeedEvent::Over, FeedEvent::Data),
        ))
    }

    fn send(&mut self, bytes: &[u8]) -> Result<()> {
        self.unsent.extend_from_slice(bytes);
        Ok(())
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        self.requests = None;
        // The thread ends with an error, because nobody reads its bytes any more.
        let _ = self.thread.take().map(JoinHandle::join);
    }
}
