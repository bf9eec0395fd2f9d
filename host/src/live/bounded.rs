//! A list that keeps the latest items.

use serde::Serialize;
use std::collections::VecDeque;
use std::ops::Deref;

/// The latest `MOST` items, oldest first.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(transparent)]
pub struct Bounded<T, const MAX: usize>(VecDeque<T>);

impl<T, const MAX: usize> Default for Bounded<T, MAX> {
    fn default() -> Self {
        Self(VecDeque::new())
    }
}

impl<T, const MAX: usize> Bounded<T, MAX> {
    pub fn push(&mut self, item: T) {
        if self.0.len() == MAX {
            self.0.pop_front();
        }
        self.0.push_back(item);
    }
}

impl<T, const MAX: usize> Deref for Bounded<T, MAX> {
    type Target = VecDeque<T>;

    fn deref(&self) -> &VecDeque<T> {
        &self.0
    }
}
