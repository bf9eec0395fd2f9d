//! A board on a serial line that may be unplugged. It is opened by port name or USB serial number,
//! and reopened when it is plugged in again, even under a different name.

mod link;
mod list;
mod system;
#[cfg(all(test, target_os = "linux"))]
mod tests;
mod users;

pub use link::Link;
pub use list::{Ports, Wanted, list_error};
pub use system::{BYTE_S, System};
pub use users::Listed;
