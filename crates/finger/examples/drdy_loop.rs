//! A finger in a loop over DRDY: the loop detects, and a second task fits. On a chip the fit is a
//! task of low priority and the ring is behind its lock; here the fit is a thread, and the ADS1258
//! is simulated.
//!
//! `cargo run --example drdy_loop`

use ads1258::Ads1258;
use hal_mock::{Options, SimulatedBoard, Sliding, SlidingScene};
use ridgetone_finger::Diagnostics;
use ridgetone_finger::Ring;
use ridgetone_finger::TimedConversion;
use ridgetone_finger::Window;
use ridgetone_finger::converter::SCAN;
use ridgetone_finger::{Detector, Outputs};
use ridgetone_finger::{Estimator, WindowFit};
use ridgetone_proto::settings::Settings;
use ridgetone_proto::telemetry::Estimate;
use ridgetone_tone::{Fitter, FrameSource, Overwritten, Values};
use std::error::Error;
use std::sync::{Mutex, PoisonError, mpsc};

/// The ring behind its lock, which is held for one read at a time, so the loop waits microseconds.
struct LockedRing<'a>(&'a Mutex<Ring>);

impl FrameSource for LockedRing<'_> {
    fn read(
        &mut self,
        first: u32,
        max: usize,
        show: &mut dyn FnMut(&[Values], &[u16]),
    ) -> Result<(), Overwritten> {
        let ring = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        ring.read(first, max, show).ok_or(Overwritten)
    }
}

/// The second task: fits each window that is due.
fn fit(
    windows: mpsc::Receiver<Window>,
    ring: &Mutex<Ring>,
    diagnostics: &Diagnostics,
) -> Vec<Estimate> {
    let mut estimator = Estimator::new(Settings::DEFAULT);
    let mut fitter = Box::new(Fitter::new());
    let mut estimates = Vec::new();
    for window in windows {
        match estimator.run(&mut fitter, &window, &mut LockedRing(ring)) {
            Ok(WindowFit::Done(mut estimate)) => {
                diagnostics.qualify(&mut estimate, &window);
                println!(
                    "{:?} {:.3} Hz +- {:.3} Hz",
                    estimate.status, estimate.frequency, estimate.sigma
                );
                estimates.push(estimate);
                // Full search on behalf of the next window. If frames are overwritten by now, the
                // next window is searched instead.
                let _ = estimator.search(&mut fitter, &window, &mut LockedRing(ring));
            }
            Ok(WindowFit::Growing) => {}
            Err(Overwritten) => diagnostics.overruns.add(1),
        }
    }
    estimates
}

/// Slides a grating of 3.1 mm over the finger at 30 mm/s.
pub fn run() -> Result<Vec<Estimate>, Box<dyn Error>> {
    let scene = SlidingScene::new(Sliding {
        speed_mm_s: 30.0,
        period_mm: 3.1,
        ..Sliding::default()
    })?;
    let board = SimulatedBoard::new(scene, Options::default());
    let mut adc = Ads1258::new(board.spi());
    adc.configure(&SCAN)?;
    adc.start(&mut board.start_pin())?;

    let (ring, diagnostics) = (Mutex::new(Ring::new()), Diagnostics::new());
    let mut detector = Detector::new(Settings::DEFAULT);
    // Virtual time waits while a window is fitted: the loop hands over the next window only when
    // the fit is done.
    let (due, windows) = mpsc::sync_channel(0);
    std::thread::scope(|scope| {
        let fit = scope.spawn(|| fit(windows, &ring, &diagnostics));
        while let Some(edge_ns) = board.wait_for_drdy() {
            let conversion = TimedConversion::new((edge_ns / 1000) as u32, adc.read()?);
            let mut window = None;
            let mut locked = ring.lock().unwrap_or_else(PoisonError::into_inner);
            detector.push(
                conversion,
                &mut locked,
                &diagnostics,
                &mut Outputs {
                    emit: &mut |_| (),
                    due: &mut |next| window = Some(next),
                },
            );
            drop(locked);
            if let Some(window) = window {
                due.send(window)?;
            }
        }
        drop(due);
        fit.join().map_err(|_| "the fit panicked".into())
    })
}

fn main() -> Result<(), Box<dyn Error>> {
    run().map(|_| ())
}
