//! Wrong usage, as opposed to a failure: the process exits with status 2 instead of 1.

/// The command line requests something impossible; the text says why.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
pub struct UsageError(pub String);
