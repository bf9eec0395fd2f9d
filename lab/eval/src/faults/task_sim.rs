//! Runs the firmware's tasks on this PC with the simulated chip and its faults, and observes them.

use super::scan_order::ScanOrder;
use ads1258::{Channel, Register};
use anyhow::{Result, ensure};
use hal_mock::{Counters, CutFlash, Injected, SimulatedBoard};
use ridgetone_finger::TimedConversion;
use ridgetone_finger::converter::Ads1258Plan;
use ridgetone_finger::tasks::Received;
use ridgetone_host::input::Opened;
use ridgetone_host::simulated::{self, Start, Surroundings};
use ridgetone_proto::boot::Boot;
use ridgetone_proto::settings::Settings;
use ridgetone_proto::telemetry::{Decoder, Packet};

/// Registers that keep their written values. GPIOD reads back the pins, and ID is read-only.
fn writable(registers: &[u8]) -> &[u8] {
    &registers[..Register::Gpiod as usize]
}

#[derive(Clone, Debug, Default)]
pub struct Ran {
    pub packets: Vec<Packet>,
    /// Numbers of lost and damaged packets.
    pub line: (u32, u32),
    pub chip: Counters,
    /// Times when each injection took effect, nanoseconds of the simulated board.
    pub injected: Vec<Injected>,
    /// Conversions taken from the queue with NEW set.
    pub delivered: u64,
    /// Conversions that differ from the chip's results.
    pub altered: u64,
    /// Arrival times of conversions with an altered code but the right status, which cannot be
    /// detected, nanoseconds of the simulated board.
    pub unseen_ns: Vec<u64>,
    /// Arrival times of the chip's supply and reference readings, nanoseconds of the simulated
    /// board.
    pub readings_ns: Vec<(Channel, u64)>,
    /// Times when a scan was completed with correct registers, nanoseconds of the simulated board.
    pub whole_ns: Vec<u64>,
    /// Simulated time at device time zero, nanoseconds.
    pub zero_ns: u64,
    pub end_ns: u64,
    pub registers_right: bool,
}

pub fn run(input: Opened, settings: Settings, boot: Boot) -> Result<Ran> {
    let own = Ads1258Plan::of(&settings.plan);
    let mut observer = Observer {
        decoder: Decoder::new(),
        ran: Ran::default(),
        registers: [own.config().registers()?, own.health_config().registers()?],
        order: ScanOrder::new(&own.config()),
        begun: false,
    };
    let start = Start {
        settings,
        ..Start::new(CutFlash::<1024>::new(1), boot)
    };
    let board = simulated::run(input, start, &mut observer)?;
    Ok(observer.into_ran(&board))
}

struct Observer {
    decoder: Decoder,
    ran: Ran,
    /// Registers during the scan, and during the health readings between touches.
    registers: [[u8; Register::WRITABLE]; 2],
    order: ScanOrder,
    begun: bool,
}

impl Surroundings for Observer {
    fn started(&mut self, _: &SimulatedBoard, is_set_up: bool) -> Result<()> {
        ensure!(is_set_up, "the simulated chip cannot be set up");
        Ok(())
    }

    fn read(&mut self, timed: &TimedConversion, board: &SimulatedBoard) {
        let status = timed.status();
        if !status.is_new() {
            return;
        }
        let (truth, registers, edge_ns) = board.with_chip(|chip| {
            (
                chip.latest_results(),
                chip.registers(),
                chip.latest_drdy_fall_ns().unwrap_or(0),
            )
        });
        let ran = &mut self.ran;
        if !std::mem::replace(&mut self.begun, true) {
            ran.zero_ns = edge_ns;
        }
        ran.delivered += 1;
        let is_altered = !truth.contains(&(status.0 & 0x7F, timed.code()));
        ran.altered += u64::from(is_altered);
        if is_altered
            && truth
                .iter()
                .any(|(flags_and_id, _)| *flags_and_id == status.0 & 0x7F)
        {
            ran.unseen_ns.push(board.now_ns());
        }
        if let Some(reading @ (Channel::Vcc | Channel::Ref)) = Channel::from_id(status.chid()) {
            ran.readings_ns.push((reading, board.now_ns()));
        }
        let is_whole = self.order.take(&timed.conversion());
        if is_whole && writable(&registers) == writable(&self.registers[0]) {
            ran.whole_ns.push(board.now_ns());
        }
    }

    fn exchange(&mut self, _: &SimulatedBoard, sent: &[u8]) -> Result<Vec<Received>> {
        self.ran
            .packets
            .extend(sent.iter().filter_map(|byte| self.decoder.push(*byte)));
        Ok(Vec::new())
    }
}

impl Observer {
    fn into_ran(self, board: &SimulatedBoard) -> Ran {
        let (line, end_ns) = ((self.decoder.missing, self.decoder.damaged), board.now_ns());
        let registers = board.with_chip(|chip| chip.registers());
        let registers_right = self
            .registers
            .iter()
            .any(|right| writable(right) == writable(&registers));
        board.with_chip(|chip| Ran {
            line,
            chip: chip.counters(),
            injected: chip.injected().to_vec(),
            end_ns,
            registers_right,
            ..self.ran
        })
    }
}
