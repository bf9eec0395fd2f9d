//! `replay`: runs the library on this PC behind the simulated chip, conversion for conversion as on
//! the board.

use crate::input::Opened;
use crate::live::Counts;
use crate::settings_form::explained;
use crate::stop;
use ads1258::Ads1258;
use anyhow::{Context, Result, bail, ensure};
use embedded_hal::delay::DelayNs;
use hal_mock::SimulatedBoard;
use ridgetone_finger::Pipeline;
use ridgetone_finger::TimedConversion;
use ridgetone_finger::converter::Ads1258Plan;
use ridgetone_proto::plan::{HealthReadings, Plan};
use ridgetone_proto::settings::{Settings, SettingsError};
use ridgetone_proto::telemetry::{Decoder, Event, Packet, WIRE_MAX, encode};

/// Board time in microseconds at which START rises, about the same as in the firmware.
///
/// With any whole microsecond the results equal those of the emulated board, whose START also rises
/// at a whole microsecond: the DRDY edges then fall at the same times after START, and device time
/// begins with the first edge.
pub const START_US: u32 = 20_100;

/// Conversions between two reports of progress.
const PROGRESS_EVERY: u64 = 2048;

#[derive(Clone, Debug, Default)]
pub struct Outcome {
    /// Bytes that a board would have sent.
    pub serial: Vec<u8>,
    /// Packets at the PC's end of the wire.
    pub counts: Counts,
    pub conversions: u64,
}

/// Runs `input` through the library. Packets go to `sink` after encoding and decoding; `progress`
/// takes the seconds done and the total. `settings` must have passed [`Settings::validate`]. Ends
/// early if the process is asked to stop.
pub fn run(
    input: Opened,
    settings: Settings,
    sink: &mut dyn FnMut(&Packet) -> Result<()>,
    progress: &mut dyn FnMut(f64, f64),
) -> Result<Outcome> {
    let observers = Observers {
        sink,
        progress,
        watch: &mut |_| {},
    };
    run_watched(input, settings, observers)
}

pub struct Observers<'a> {
    /// Takes packets after encoding and decoding.
    pub sink: &'a mut dyn FnMut(&Packet) -> Result<()>,
    /// Takes the seconds done and the total.
    pub progress: &'a mut dyn FnMut(f64, f64),
    /// Takes every conversion, with the board time of its DRDY edge.
    pub watch: &'a mut dyn FnMut(TimedConversion),
}

/// Like [`run`], with all observers.
pub fn run_watched(input: Opened, settings: Settings, observers: Observers<'_>) -> Result<Outcome> {
    let Observers {
        sink,
        progress,
        watch,
    } = observers;
    let end_s = input.end_s;
    let decoder = Decoder::default();
    let mut wire = Wire {
        sequence: 0,
        serial: Vec::new(),
        decoder,
        received: 0,
        sink,
        failure: None,
    };
    let mut pipeline = Box::new(Pipeline::new(settings));
    wire.send(pipeline.hello());
    let mut count = 0;
    let plan = settings.plan;
    let whole = conversions_of(input, &plan, &mut |timed| {
        ensure!(!stop::is_requested(), "interrupted");
        watch(timed);
        pipeline.push(timed, &mut |event| wire.send(event));
        wire.result()?;
        count += 1;
        if count % PROGRESS_EVERY == 0 {
            progress(
                (count * u64::from(plan.conversion_ns())) as f64 * 1e-9,
                end_s,
            );
        }
        Ok(())
    });
    if !stop::is_requested() {
        whole?;
    }
    pipeline.finish(&mut |event| wire.send(event));
    wire.result()?;
    Ok(Outcome {
        counts: Counts::of(&wire.decoder, wire.received),
        serial: wire.serial,
        conversions: count,
    })
}

/// Like [`conversions_of`], with the default plan.
pub fn conversions(
    input: Opened,
    take: &mut dyn FnMut(TimedConversion) -> Result<()>,
) -> Result<()> {
    conversions_of(input, &Plan::PAPER, take)
}

/// Sets up the simulated chip like the firmware and passes every conversion of `input` to `take`.
/// If the plan's scan has no health readings, they are converted once, before the scan.
pub fn conversions_of(
    input: Opened,
    plan: &Plan,
    take: &mut dyn FnMut(TimedConversion) -> Result<()>,
) -> Result<()> {
    let own = Ads1258Plan::of(plan);
    if let Err(refused) = Ads1258Plan::check(plan) {
        let why = explained(&SettingsError::from(refused));
        bail!("the simulated converter is an ADS1258: {why}");
    }
    let board = SimulatedBoard::new(input.scene, input.options);
    board.set_sclk_hz(0); // as over the bridge: a transfer takes no time

    let mut chip = Ads1258::new(board.spi());
    let (mut start, mut reset) = (board.start_pin(), board.reset_pin());
    board.delay().delay_us(START_US - ads1258::RESET_LOW_US);
    chip.stop(&mut start)?;
    chip.reset_by_pin(&mut reset, &mut board.delay())?;
    let mut readings = 0;
    if plan.health == HealthReadings::BetweenTouches {
        let config = own.health_config();
        readings = config.slots();
        chip.configure(&config).context("the simulated chip")?;
    } else {
        chip.configure(&own.config())
            .context("the simulated chip")?;
    }
    chip.start(&mut start)?;
    while let Some(edge_ns) = board.wait_for_drdy() {
        let conversion = chip.read().context("the simulated chip")?;
        // Truncates like the board's counter, which wraps after 71 minutes, as the library expects.
        take(TimedConversion::new((edge_ns / 1000) as u32, conversion))?;
        if readings > 0 {
            readings -= 1;
            if readings == 0 {
                chip.stop(&mut start)?;
                chip.reset_by_pin(&mut reset, &mut board.delay())?;
                chip.configure(&own.config())
                    .context("the simulated chip")?;
                chip.start(&mut start)?;
            }
        }
    }
    Ok(())
}

/// Both ends of the wire: numbers, encodes and decodes events, and passes them on.
struct Wire<'a> {
    sequence: u16,
    serial: Vec<u8>,
    decoder: Decoder,
    received: u64,
    sink: &'a mut dyn FnMut(&Packet) -> Result<()>,
    /// First failure; after it, no packets go to the sink.
    failure: Option<anyhow::Error>,
}

impl Wire<'_> {
    fn send(&mut self, event: Event) {
        if self.failure.is_some() {
            return;
        }
        let packet = Packet {
            sequence: self.sequence,
            event,
        };
        self.sequence = self.sequence.wrapping_add(1);
        let mut bytes = [0; WIRE_MAX];
        let Ok(length) = encode(&packet, &mut bytes) else {
            self.failure = Some(anyhow::anyhow!(
                "a packet is longer than {WIRE_MAX} bytes on the wire"
            ));
            return;
        };
        for byte in &bytes[..length] {
            self.serial.push(*byte);
            if let Some(packet) = self.decoder.push(*byte) {
                self.received += 1;
                if let Err(error) = (self.sink)(&packet) {
                    self.failure = Some(error);
                    return;
                }
            }
        }
    }

    fn result(&mut self) -> Result<()> {
        self.failure.take().map_or(Ok(()), Err)
    }
}
