//! Errors with an exit status of their own: wrong usage (2), and a recording without an estimate
//! (3). All other failures exit with status 1.

/// Error for a command line that requests something impossible; the text says why.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
pub struct UsageError(pub String);

/// Error for a recording without any estimate; the text says why. The process exits with status 3.
#[derive(Debug, thiserror::Error)]
#[error("no estimate: {0}")]
pub struct NoEstimate(pub String);
