//! How fields look in text formats such as JSON. In postcard they keep their plain form.

use serde::{Serialize, Serializer};

/// A time or an optional time in microseconds, in text as seconds.
pub fn seconds<T, S>(t_us: &T, serializer: S) -> Result<S::Ok, S::Error>
where
    T: Serialize + Copy + Into<Option<u64>>,
    S: Serializer,
{
    if !serializer.is_human_readable() {
        return t_us.serialize(serializer);
    }
    (*t_us)
        .into()
        .map(|t_us| t_us as f64 / 1e6)
        .serialize(serializer)
}
