//! The latest states of the fingers, for a receiver that comes later.

use super::message::Message;
use super::topic::Topic;
use std::collections::BTreeMap;
use std::sync::Arc;

#[derive(Debug, Default)]
pub struct Latest(BTreeMap<(usize, Topic), Arc<Message>>);

impl Latest {
    /// Keeps the message if it is a state. Each topic has one type of state.
    pub fn take(&mut self, message: &Arc<Message>) {
        if message.is_state {
            let key = (message.finger, message.topic);
            self.0.insert(key, Arc::clone(message));
        }
    }

    pub fn all(&self) -> impl Iterator<Item = &Arc<Message>> {
        self.0.values()
    }
}
