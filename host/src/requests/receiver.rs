//! The board's receiver on this PC: turns bytes into replies with the code of the firmware's tasks
//! `line` and `fit`.

use embedded_storage::nor_flash::NorFlash;
use ridgetone_finger::Detector;
use ridgetone_finger::Estimator;
use ridgetone_finger::tasks::{Mail, Outbox};
use ridgetone_finger::tasks::{Platform, Shared, Task};
use ridgetone_finger::tasks::{Received, RequestInbox, receive};
use ridgetone_finger::tasks::{Requests, Targets};
use ridgetone_proto::boot::{Boot, SettingsSource};
use ridgetone_proto::command::Reply;
use ridgetone_proto::settings::Settings;
use ridgetone_proto::store::{FlashStore, Store};
use ridgetone_proto::telemetry::Event;
use rtic_core::Exclusive;
use std::cell::Cell;

/// Flag that is set when the task `fit` must run.
#[derive(Debug, Default)]
struct FitPended(Cell<bool>);

impl Platform for FitPended {
    fn pend(shared: &Shared<Self>, task: Task) {
        if task == Task::Fit {
            shared.platform.0.set(true);
        }
    }

    fn now_us(&self) -> u32 {
        0
    }
}

/// The part of a board that handles requests.
#[derive(Debug)]
pub struct Receiver<F: NorFlash> {
    inbox: RequestInbox,
    requests: Requests<FlashStore<F>>,
    detector: Box<Detector>,
    estimator: Estimator,
    outbox: Outbox,
    shared: Shared<FitPended>,
    pub answered: u64,
}

impl<F: NorFlash> Receiver<F> {
    pub fn new(flash: F) -> Self {
        let mut store = FlashStore::new(flash);
        let (settings, source) = store.load();
        let mut detector = Box::new(Detector::new(settings));
        detector.boot(settings, source, Boot::UNKNOWN);
        Self {
            inbox: RequestInbox::new(),
            requests: Requests::new(store),
            detector,
            estimator: Estimator::new(settings),
            outbox: Outbox::new(),
            shared: Shared::new(FitPended::default(), settings.plan),
            answered: 0,
        }
    }

    /// Takes a byte as the line's interrupt does. Returns true if a request is complete.
    pub fn push(&mut self, byte: u8) -> bool {
        receive(&mut self.inbox, Received::Byte(byte), &self.shared);
        self.shared.platform.0.take()
    }

    /// Runs the part of the task `fit` that handles requests.
    pub fn obey(&mut self) -> Option<Reply> {
        let Self {
            inbox,
            requests,
            detector,
            estimator,
            outbox,
            shared,
            ..
        } = self;
        let (detector, inbox, outbox) = (
            &mut Exclusive(detector),
            &mut Exclusive(inbox),
            &mut Exclusive(outbox),
        );
        loop {
            let targets = Targets {
                estimator,
                detector,
            };
            if !requests.step(|| false, targets, Mail { inbox, outbox }, shared) {
                break;
            }
        }
        let replies =
            std::iter::from_fn(|| outbox.take()).filter_map(|packet| match packet.event {
                Event::Reply(reply) => Some(reply),
                _ => None,
            });
        let reply = replies.last();
        self.answered += u64::from(reply.is_some());
        reply
    }

    /// Takes bytes, carries out all complete requests and returns the replies.
    pub fn hear(&mut self, bytes: &[u8]) -> Vec<Reply> {
        bytes
            .iter()
            .filter_map(|byte| if self.push(*byte) { self.obey() } else { None })
            .collect()
    }

    /// Returns the number of damaged requests, as reported in `health`.
    pub fn damaged(&self) -> u64 {
        self.shared.diagnostics.requests_damaged.get().into()
    }

    pub fn in_force(&self) -> (Settings, SettingsSource) {
        match self.detector.hello() {
            Event::Hello(hello) => (hello.settings, hello.source),
            _ => (Settings::DEFAULT, SettingsSource::Damaged),
        }
    }

    /// True if the board resets as soon as the line is silent.
    pub fn is_restarting(&self) -> bool {
        self.shared.is_restarting()
    }

    /// Returns the flash as a loss of power would leave it.
    pub fn into_pages(self) -> F {
        self.requests.into_store().release()
    }
}
