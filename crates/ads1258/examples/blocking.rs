//! Four inputs in volts and the chip's temperature, with blocking SPI on a simulated chip.

use ads1258::{Ads1258, Channel, Config, DataRate, Error, IdleMode, Mux, Sysred, reading};
use embedded_hal::digital::{InputPin, OutputPin};
use embedded_hal::spi::SpiDevice;
use hal_mock::{Constant, Options, SimulatedBoard};

/// Reference voltage, V.
const VREF_V: f32 = 4.096;

const CONFIG: Config = Config {
    mux: Mux::AutoScan {
        differential: 0,
        single: 0b1111,
        internal: Sysred {
            temp: true,
            ..Sysred::NONE
        },
    },
    data_rate: DataRate::Drate1,
    idle_mode: IdleMode::Standby,
    ..Config::RESET
};

/// Reads one scan. A real board would use an interrupt for DRDY instead of a loop.
fn run<SPI: SpiDevice>(
    adc: &mut Ads1258<SPI>,
    start: &mut impl OutputPin,
    drdy: &mut impl InputPin,
) -> Result<[f32; 4], Error<SPI::Error>> {
    let _ = adc.stop(start);
    adc.reset()?;
    adc.configure(&CONFIG)?;
    let _ = adc.start(start);
    let mut inputs_v = [0.0; 4];
    for _ in 0..CONFIG.slots() {
        while matches!(drdy.is_high(), Ok(true)) {}
        let conversion = adc.read()?;
        match conversion.status.channel() {
            Some(Channel::Single(input)) => {
                inputs_v[usize::from(input)] = reading::volts(conversion.code, VREF_V)
            }
            Some(Channel::Temp) => {
                println!("{:.1} C", reading::temperature_c(conversion.code, VREF_V))
            }
            _ => {}
        }
    }
    adc.verify()?;
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
    board.set_poll_ns(1_000); // each poll of DRDY takes 1 us of virtual time
    let mut adc = Ads1258::new(board.spi());
    let inputs_v = run(&mut adc, &mut board.start_pin(), &mut board.drdy_pin())
        .expect("the simulated chip answers");
    println!("{inputs_v:.3?} V, {:.1} scans/s", CONFIG.frame_rate_hz());
    assert!((inputs_v[3] - 0.3).abs() < 1e-6);
    let _spi = adc.destroy();
}
