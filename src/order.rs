//! Carries out what a PC orders: checked first, then in force from the next window on.

use crate::boot::SettingsSource;
use crate::command::{Command, Order, Outcome, Part, Reply};
use crate::detector::Detector;
use crate::pipeline::Estimator;
use crate::profile::{After, KNOTS_MAX, Knot, Profile};
use crate::settings::{Settings, SettingsError};
use crate::store::Store;
use crate::telemetry::News;
use heapless::{String, Vec};

/// What an order is to change, once no window is due any more that came before it.
#[derive(Clone, Debug, PartialEq)]
#[allow(clippy::large_enum_variant)]
pub enum Effect {
    /// Nothing.
    None,
    /// The greeting is to be said.
    Greet,
    /// These settings are in force.
    Use(Settings, SettingsSource),
    /// All begins anew.
    Start,
    /// Nothing is told but `health`.
    Stop,
    /// So many frames are told raw.
    Raw(u32),
    /// The profile that has come is in force.
    Follow(After),
    /// No profile is in force.
    Unfollow,
    /// The board is to be reset when all that is to be told has left.
    Restart,
}

/// Settles orders one after the other. What it keeps is bounded: a profile, one in the making, and the latest reply.
#[derive(Debug, Default)]
pub struct Executor {
    profile: Option<Profile>,
    knots: Vec<Knot, KNOTS_MAX>,
    latest: Option<Reply>,
    restarting: bool,
}

impl Executor {
    /// One that has seen no order.
    pub const fn new() -> Self {
        Self { profile: None, knots: Vec::new(), latest: None, restarting: false }
    }

    /// The speed profile in force.
    pub const fn profile(&self) -> Option<&Profile> {
        self.profile.as_ref()
    }

    /// Whether the board is to be reset as soon as the line is silent.
    pub const fn is_restarting(&self) -> bool {
        self.restarting
    }

    /// Settles an order: stores what is to be kept, and gives what is to be changed with [`Self::carry_out`] and
    /// answered. `touched`: the finger is on something, so the flash must not be erased now, which takes a second or two
    /// and stops the processor.
    #[inline(never)]
    pub fn settle(&mut self, order: &Order, touched: bool, store: &mut dyn Store) -> (Effect, Reply) {
        let again = self.latest.as_ref().filter(|reply| reply.number == order.number);
        if let Some(reply) = again {
            return (Effect::None, reply.clone());
        }
        let (effect, outcome) = if self.restarting {
            (Effect::None, Outcome::Busy)
        } else {
            match &order.command {
                Command::Greet => (Effect::Greet, Outcome::Done),
                Command::Set { settings, keep } => match settings.validate() {
                    Err(error) => (Effect::None, refused(&error)),
                    Ok(()) => {
                        let stored = if *keep { store.save(Some(settings), !touched) } else { Ok(()) };
                        let outcome = if stored.is_ok() { Outcome::Done } else { Outcome::NotStored };
                        (Effect::Use(*settings, SettingsSource::Sent), outcome)
                    }
                },
                Command::Forget => {
                    let stored = store.save(None, !touched);
                    let outcome = if stored.is_ok() { Outcome::Done } else { Outcome::NotStored };
                    (Effect::Use(Settings::DEFAULT, SettingsSource::Default), outcome)
                }
                Command::Start => (Effect::Start, Outcome::Done),
                Command::Stop => (Effect::Stop, Outcome::Done),
                Command::Follow(part) => self.collect(part),
                Command::Unfollow => (Effect::Unfollow, Outcome::Done),
                Command::Raw { frames } => (Effect::Raw(*frames), Outcome::Done),
                Command::Restart => (Effect::Restart, Outcome::Done),
            }
        };
        let reply = Reply { number: order.number, outcome };
        // Who is told to ask again is not to get the same answer then.
        if reply.outcome != Outcome::Busy {
            self.latest = Some(reply.clone());
        }
        (effect, reply)
    }

    /// Takes a part of a profile. Anything wrong drops all parts; the profile in force stays.
    fn collect(&mut self, part: &Part) -> (Effect, Outcome) {
        if part.first == 0 {
            self.knots.clear();
        }
        let follows = usize::from(part.first) == self.knots.len() && !part.knots.is_empty();
        let fits = follows && self.knots.extend_from_slice(&part.knots).is_ok();
        let good = fits && part.last.is_none_or(|after| Profile::new(&self.knots, after).is_ok());
        if !good {
            self.knots.clear();
            return (Effect::None, Outcome::Profile);
        }
        (part.last.map_or(Effect::None, Effect::Follow), Outcome::Done)
    }

    /// Changes what an order changes. All windows that were due before it must have been fitted.
    #[inline(never)]
    pub fn carry_out(
        &mut self,
        effect: &Effect,
        detector: &mut Detector,
        estimator: &mut Estimator,
        emit: &mut dyn FnMut(News),
    ) {
        match effect {
            Effect::None => {}
            Effect::Greet => emit(detector.hello()),
            Effect::Use(settings, source) => {
                detector.change(settings, *source);
                estimator.change(settings);
                emit(detector.hello());
            }
            Effect::Start => detector.restart(true),
            Effect::Stop => detector.restart(false),
            Effect::Raw(frames) => detector.tell_raw(*frames),
            Effect::Follow(after) => {
                // Made a second time, rather than kept meanwhile: half a kilobyte.
                self.profile = Profile::new(&self.knots, *after).ok();
                self.knots.clear();
            }
            Effect::Unfollow => self.profile = None,
            Effect::Restart => self.restarting = true,
        }
    }
}

/// The answer to settings outside their bounds.
fn refused(error: &SettingsError) -> Outcome {
    let SettingsError { field, value, least, greatest } = *error;
    // Every name fits: a test says so.
    Outcome::Setting { field: String::try_from(field).unwrap_or_default(), value, least, greatest }
}
