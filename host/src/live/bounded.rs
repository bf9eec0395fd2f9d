//! A list that keeps the latest items.

use serde::Serialize;
use std::collections::VecDeque;
use std::ops::Deref;

/// The latest `MOST` items, oldest first.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(transparent)]
pub struct Bounded<T, const MOST: usize>(VecDeque<T>);

impl<T, const MOST: usize> Default for Bounded<T, MOST> {
    fn default() -> Self {
        Self(VecDeque::new())
    }
}

impl<T, const MOST: usize> Bounded<T, MOST> {
    pub fn push(&mut self, item: T) {
        if self.0.len() == MOST {
            self.0.pop_front();
        }
        self.0.push_back(item);
    }
}

impl<T, const MOST: usize> Deref for Bounded<T, MOST> {
    type Target = VecDeque<T>;

    fn deref(&self) -> &VecDeque<T> {
        &self.0
    }
}
