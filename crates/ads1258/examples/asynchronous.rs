//! Four inputs in volts, with async SPI and an async wait for DRDY on a simulated chip.

use ads1258::{Ads1258, Channel, Config, DataRate, Error, IdleMode, Mux, Sysred, reading};
use embedded_hal::digital::OutputPin;
use embedded_hal_async::{digital::Wait, spi::SpiDevice};
use hal_mock::{Constant, Options, SimulatedBoard};

/// Reference voltage, V.
const VREF_V: f32 = 4.096;

const CONFIG: Config = Config {
    mux: Mux::AutoScan {
        differential: 0,
        single: 0b1111,
        internal: Sysred::NONE,
    },
    data_rate: DataRate::Drate1,
    idle_mode: IdleMode::Standby,
    ..Config::RESET
};

/// Reads one scan, as a task of an async executor would do for ever.
async fn run<SPI: SpiDevice>(
    adc: &mut Ads1258<SPI>,
    start: &mut impl OutputPin,
    drdy: &mut impl Wait,
) -> Result<[f32; 4], Error<SPI::Error>> {
    let _ = adc.stop(start);
    adc.reset_async().await?;
    adc.configure_async(&CONFIG).await?;
    let _ = adc.start(start);
    let mut inputs_v = [0.0; 4];
    for _ in 0..CONFIG.slots() {
        let _ = drdy.wait_for_low().await;
        let conversion = adc.read_async().await?;
        if let Some(Channel::Single(input)) = conversion.status.channel() {
            inputs_v[usize::from(input)] = reading::volts(conversion.code, VREF_V);
        }
    }
    adc.verify_async().await?;
    Ok(inputs_v)
}

/// Public, so that a test can run the example.
pub fn main() {
    let scene = Constant {
        volts: core::array::from_fn(|input| 0.1 * input as f64),
        ..Constant::default()
    };
    let board = SimulatedBoard::new(
        scene,
        Options {
            noise: false,
            ..Options::default()
        },
    );
    let mut adc = Ads1258::new(board.spi());
    let (mut start, mut drdy) = (board.start_pin(), board.drdy_pin());
    let inputs_v = embassy_futures::block_on(run(&mut adc, &mut start, &mut drdy))
        .expect("the simulated chip answers");
    println!("{inputs_v:.3?} V, {:.1} scans/s", CONFIG.frame_rate_hz());
    assert!((inputs_v[3] - 0.3).abs() < 1e-6);
}
