//! A board on a serial line that may be unplugged: opened by name or by its USB serial number, and
//! opened again under any name at which it comes back.

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
