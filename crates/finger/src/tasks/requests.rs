//! Carries out requests between windows: the windows that were due before a request are fitted
//! first.

use super::commands::{At, CommandExecutor};
use super::line::RequestInbox;
use super::outbox::{Mail, Outbox};
use super::shared::{Platform, Shared, Task};
use crate::detector::Detector;
use crate::estimator::Estimator;
use core::ops::DerefMut;
use core::sync::atomic::Ordering::Relaxed;
use ridgetone_proto::command::{Command, Reply, Request};
use ridgetone_proto::store::Store;
use ridgetone_proto::telemetry::Event;
use rtic_core::Mutex;

/// Objects that a request may change.
pub struct Targets<'a, D> {
    /// Takes the new settings of the fit.
    pub estimator: &'a mut Estimator,
    /// Takes the new settings of frames and touch.
    pub detector: &'a mut D,
}

/// Takes requests from the inbox, one after the other.
#[derive(Debug)]
pub struct Requests<S> {
    executor: CommandExecutor,
    store: S,
    /// Command and reply that are decided, but not carried out yet.
    decided: Option<(Option<Command>, Reply)>,
}

impl<S: Store> Requests<S> {
    /// Starts without a request. `store` keeps the settings.
    pub const fn new(store: S) -> Self {
        Self {
            executor: CommandExecutor::new(),
            store,
            decided: None,
        }
    }

    /// Storage of the settings.
    pub fn into_store(self) -> S {
        self.store
    }

    /// Carries out a request, if there is one and `is_window_due` returns false. Returns false if
    /// there is no request. If a window is due, fit it and call this again.
    // Not inlined: its stack frame of 3700 bytes would add to that of a fit, the deepest use of the
    // stack.
    #[inline(never)]
    pub fn step<P: Platform>(
        &mut self,
        is_window_due: impl Fn() -> bool,
        targets: Targets<'_, impl Mutex<T: DerefMut<Target = Detector>>>,
        mail: Mail<'_, impl Mutex<T = RequestInbox>, impl Mutex<T = Outbox>>,
        shared: &Shared<P>,
    ) -> bool {
        let Targets {
            estimator,
            detector,
        } = targets;
        let Mail { inbox, outbox } = mail;
        let Self {
            executor,
            store,
            decided,
        } = self;
        if decided.is_none() {
            *decided = take(inbox, shared).map(|request| {
                let at = detector.lock(|detector| At {
                    is_touched: detector.is_touched(),
                    converter: detector.converter(),
                });
                executor.decide(request, at, store)
            });
        }
        let Some((command, reply)) = decided else {
            return false;
        };
        let mut emit = |event: Event| outbox.lock(|outbox| outbox.send(event, shared));
        let is_carried_out = detector.lock(|detector| {
            // A window may have fallen due while the request was decided.
            let may = !is_window_due();
            if let Some(command) = command.as_ref().filter(|_| may) {
                executor.carry_out(command, detector, estimator, &mut emit);
            }
            may
        });
        if is_carried_out {
            let plan = detector.lock(|detector| detector.settings().plan);
            if plan != shared.plan.plan() {
                shared.request_plan(&plan);
            }
            let reply = Event::Reply(reply.clone());
            outbox.lock(|outbox| outbox.send(reply, shared));
            shared.restarting.store(executor.restarting, Relaxed);
            *decided = None;
        }
        true
    }
}

/// Takes the request from the inbox, if undamaged, and lets `report` receive the next one.
fn take<P: Platform>(
    inbox: &mut impl Mutex<T = RequestInbox>,
    shared: &Shared<P>,
) -> Option<Request> {
    let mut frame = inbox.lock(|inbox| inbox.take())?;
    P::pend(shared, Task::Report);
    let request = Request::decode(&mut frame);
    if request.is_none() {
        shared.diagnostics.requests_damaged.add(1);
    }
    request
}
