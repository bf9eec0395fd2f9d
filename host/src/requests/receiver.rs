//! The board's receiver on this PC: bytes in, replies out, by the same rooms as the firmware's tasks `line` and `fit`.

use embedded_storage::nor_flash::NorFlash;
use ridgetone::pipeline::{Detector, Estimator};
use ridgetone::tasks::commands::CommandExecutor;
use ridgetone_proto::boot::{Boot, SettingsSource};
use ridgetone_proto::command::{REQUEST_WIRE_MAX, Reply, Request};
use ridgetone_proto::framing as wire;
use ridgetone_proto::framing::{Inbox, Pushed};
use ridgetone_proto::settings::Settings;
use ridgetone_proto::store::{FlashStore, Store};
use ridgetone_proto::telemetry::Event;

/// What of a board has to do with orders.
#[derive(Debug)]
pub struct Receiver<F: NorFlash> {
    inbox: Inbox<REQUEST_WIRE_MAX>,
    executor: CommandExecutor,
    /// Frames, contact and windows.
    pub detector: Box<Detector>,
    /// The fit.
    pub estimator: Box<Estimator>,
    store: FlashStore<F>,
    /// Orders that came damaged, as `health` has them.
    pub damaged: u64,
    /// Orders that were answered.
    pub answered: u64,
}

impl<F: NorFlash> Receiver<F> {
    /// A board that starts with these pages of flash.
    pub fn new(flash: F) -> Self {
        let mut store = FlashStore::new(flash);
        let (settings, source) = store.load();
        Self {
            inbox: Inbox::new(),
            executor: CommandExecutor::new(),
            detector: Box::new(Detector::booted(settings, source, Boot::UNKNOWN)),
            estimator: Box::new(Estimator::new(settings)),
            store,
            damaged: 0,
            answered: 0,
        }
    }

    /// What the line's interrupt does with a byte. True if an order is to be taken.
    pub fn push(&mut self, byte: u8) -> bool {
        match self.inbox.push(byte) {
            Pushed::More => false,
            Pushed::Whole => true,
            Pushed::Damaged => {
                self.damaged += 1;
                false
            }
        }
    }

    /// What the task `fit` does when no window is due.
    pub fn obey(&mut self) -> Option<Reply> {
        let mut frame = self.inbox.take()?;
        let Some(request) = wire::decode::<Request>(&mut frame) else {
            self.damaged += 1;
            return None;
        };
        let (effect, reply) = self.executor.settle(&request, self.detector.is_touched(), &mut self.store);
        self.executor.carry_out(&effect, &mut self.detector, &mut self.estimator, &mut |_| {});
        self.answered += 1;
        Some(reply)
    }

    /// Both at once.
    pub fn hear(&mut self, bytes: &[u8]) -> Vec<Reply> {
        let mut replies = Vec::new();
        for byte in bytes {
            if self.push(*byte) {
                replies.extend(self.obey());
            }
        }
        replies
    }

    /// Settings in force, and where they come from.
    pub fn in_force(&self) -> (Settings, SettingsSource) {
        match self.detector.hello() {
            Event::Hello(hello) => (hello.settings, hello.source),
            _ => (Settings::DEFAULT, SettingsSource::Damaged),
        }
    }

    /// What the orders have made of speed profiles and of a restart.
    pub const fn executor(&self) -> &CommandExecutor {
        &self.executor
    }

    /// The flash, as a loss of power leaves it.
    pub fn into_pages(self) -> F {
        self.store.release()
    }
}
