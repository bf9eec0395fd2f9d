//! How fields look in text formats such as JSON. In postcard they keep their plain form.

use serde::{Serialize, Serializer};

/// Microseconds, in text as seconds.
pub fn seconds<S: Serializer>(t_us: &u64, serializer: S) -> Result<S::Ok, S::Error> {
    if serializer.is_human_readable() { (*t_us as f64 / 1e6).serialize(serializer) } else { t_us.serialize(serializer) }
}

/// The same for a time that may be missing.
pub fn optional_seconds<S: Serializer>(t_us: &Option<u64>, serializer: S) -> Result<S::Ok, S::Error> {
    if serializer.is_human_readable() {
        t_us.map(|t_us| t_us as f64 / 1e6).serialize(serializer)
    } else {
        t_us.serialize(serializer)
    }
}
