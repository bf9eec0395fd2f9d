//! The scan configuration used by most tests.

use ads1258::{Config, DataRate, Delay, IdleMode, Mux, Sysred};

/// All inputs and all internal readings, 241.14 times a second.
pub const SCAN: Config = Config {
    mux: Mux::AutoScan {
        differential: 0,
        single: 0xFFFF,
        internal: Sysred::ALL,
    },
    data_rate: DataRate::Drate1,
    delay: Delay::Dly3,
    idle_mode: IdleMode::Standby,
    ..Config::RESET
};
