//! Wrong usage, as opposed to a failure: the process exits with status 2 instead of 1.

/// Error for a command line that requests something impossible; the text says why.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
pub struct UsageError(pub String);

/// Error for a recording without any estimate; the text says why. The process exits with status 3.
#[derive(Debug, thiserror::Error)]
#[error("no estimate: {0}")]
pub struct NoEstimate(pub String);
