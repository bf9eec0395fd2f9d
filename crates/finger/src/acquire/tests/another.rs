//! A converter of another family behind the same acquisition: no register of an ADS1258, a bus that
//! says by a checksum that a read failed.

use super::*;
use crate::assembler::Assembler;
use crate::converter::REGISTERS;

/// Its fastest conversion, microseconds.
const LEAST_PERIOD_US: u32 = 10;

#[derive(Default)]
struct Another {
    ids: Vec<u8>,
    at: usize,
    latest: Option<Sample>,
    is_running: bool,
    is_changed: bool,
    is_absent: bool,
    /// Reads that fail from now on.
    bad_reads: u32,
    reads: u32,
}

impl Another {
    /// Ends a conversion. Its code is ten times the channel's id.
    fn convert(&mut self) {
        assert!(self.is_running);
        let id = self.ids[self.at];
        self.at = (self.at + 1) % self.ids.len();
        self.latest = Some(Sample {
            tag: Tag(Tag::NEW | id),
            code: 10 * i32::from(id),
        });
    }
}

impl Converter for Rc<RefCell<Another>> {
    fn stop(&mut self) -> bool {
        self.borrow_mut().is_running = false;
        true
    }

    fn set_up(&mut self, plan: &Plan, scanned: Scanned, _: &mut impl DelayNs) -> bool {
        let mut another = self.borrow_mut();
        another.ids = match scanned {
            Scanned::Inputs => (0..16)
                .filter(|k| plan.inputs >> k & 1 == 1)
                .map(|k| 8 + k)
                .collect(),
            Scanned::Health => std::vec![24, 26, 27, 28, 29],
        };
        (another.at, another.latest, another.is_changed) = (0, None, false);
        !another.is_absent
    }

    fn start(&mut self) -> bool {
        self.borrow_mut().is_running = true;
        true
    }

    fn read(&mut self) -> Option<Sample> {
        let mut another = self.borrow_mut();
        another.reads += 1;
        if another.bad_reads > 0 {
            another.bad_reads -= 1;
            return None;
        }
        let latest = another.latest?;
        let read = Sample {
            tag: Tag(latest.tag.0 & !Tag::NEW),
            ..latest
        };
        another.latest.replace(read)
    }

    fn is_as_set_up(&mut self) -> bool {
        !self.borrow().is_changed
    }

    fn registers(&mut self) -> Option<[u8; REGISTERS]> {
        (!self.borrow().is_absent).then_some([7; REGISTERS])
    }

    fn least_period_us(&mut self) -> u32 {
        LEAST_PERIOD_US
    }
}

struct Behind {
    chip: Rc<RefCell<Another>>,
    acquisition: Acquisition<Rc<RefCell<Another>>>,
    queue: Queue<TimedConversion, 64>,
    diagnostics: Diagnostics,
    t_us: u32,
}

impl Behind {
    /// Eight inputs at 1 kHz, set up, behind the health readings.
    fn new() -> Self {
        let plan = Plan::of_frames(1000.0, 8).unwrap();
        let chip = Rc::<RefCell<Another>>::default();
        let mut acquisition = Acquisition::new(chip.clone(), plan);
        let diagnostics = Diagnostics::new();
        assert!(acquisition.set_up(&diagnostics, &mut NoWait));
        let mut behind = Self {
            chip,
            acquisition,
            queue: Queue::new(),
            diagnostics,
            t_us: 0,
        };
        let health: Vec<Drdy> = (0..5).map(|_| behind.next()).collect();
        assert_eq!(health[..4], [Drdy::Midway; 4]);
        assert_eq!(health[4], Drdy::HealthRead);
        behind
            .acquisition
            .read_inputs(&behind.diagnostics, &mut NoWait);
        behind
    }

    fn next(&mut self) -> Drdy {
        self.chip.borrow_mut().convert();
        self.t_us += 125;
        let t_us = self.t_us;
        self.acquisition
            .edge(|| t_us, &mut self.queue.split().0, &self.diagnostics)
    }

    fn watch(&mut self) -> bool {
        self.acquisition
            .watch(self.t_us, &self.diagnostics, &mut NoWait)
    }

    fn taken(&mut self) -> Vec<TimedConversion> {
        let mut out = self.queue.split().1;
        core::iter::from_fn(|| out.dequeue()).collect()
    }
}

struct NoWait;

impl DelayNs for NoWait {
    fn delay_ns(&mut self, _: u32) {}
}

#[test]
fn its_samples_become_frames() {
    let mut behind = Behind::new();
    let plan = behind.acquisition.plan();
    for n in 1..=24 {
        let expected = if n % 8 == 0 {
            Drdy::Listen
        } else {
            Drdy::Midway
        };
        assert_eq!(behind.next(), expected);
    }
    assert_eq!(
        behind.chip.borrow().reads,
        2 * (5 + 24),
        "each is read twice"
    );
    assert_eq!(behind.diagnostics.adc_registers(), [7; REGISTERS]);
    let (mut assembler, mut frames) = (Assembler::new(2.5, &plan), Vec::new());
    for timed in behind.taken() {
        assembler.push(&timed, |frame| frames.push(*frame));
    }
    assembler.finish(&mut |frame| frames.push(*frame));
    assert_eq!(frames.len(), 3);
    for frame in frames {
        assert_eq!((frame.present, frame.good), (0xff, 0xff));
        assert_eq!(frame.codes[..8], [80, 90, 100, 110, 120, 130, 140, 150]);
    }
    assert_eq!((assembler.lost, assembler.doubtful), (0, 0));
    assert_eq!(assembler.own, [240, 260, 270, 280, 290].map(Some));
}

#[test]
fn its_failures_are_reported_and_mended() {
    let mut behind = Behind::new();
    // One failed read: the two after it agree. Three: the conversion is dropped and counted.
    behind.chip.borrow_mut().bad_reads = 1;
    assert_eq!(behind.next(), Drdy::Watch);
    behind.chip.borrow_mut().bad_reads = 3;
    let _ = behind.next();
    assert_eq!(behind.diagnostics.faults.count(Bus), 2);
    assert_eq!(behind.diagnostics.overruns.get(), 1);
    // Other registers: as many conversions as it can have made at its fastest are lost.
    behind.chip.borrow_mut().is_changed = true;
    behind.t_us += 900;
    assert!(behind.watch());
    assert_eq!(behind.diagnostics.faults.count(Registers), 1);
    assert!(behind.diagnostics.unseen.get() >= 900 / LEAST_PERIOD_US);
    assert_eq!(behind.next(), Drdy::Midway);
    // Absent: tried again, and found when it is back.
    behind.chip.borrow_mut().is_absent = true;
    behind.t_us += 500_000;
    assert!(behind.watch());
    assert_eq!(behind.diagnostics.faults.count(NoAnswer), 1);
    behind.chip.borrow_mut().is_absent = false;
    behind.t_us += 500_000;
    assert!(behind.watch());
    behind.taken();
    let _ = behind.next();
    assert_eq!(behind.taken()[0].tag(), Tag::of_input(0));
}
