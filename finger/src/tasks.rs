//! What the tasks of the firmware do, and what they share.

pub mod commands;
pub mod liveness;
pub mod load;
pub mod outbox;
pub mod queues;
pub mod stack_depth;
