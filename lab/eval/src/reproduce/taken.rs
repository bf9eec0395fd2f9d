//! A run: a scene through the whole path, here or in the emulator, and its data.

use anyhow::{Context, Result};
use hal_mock::{Sliding, Truth};
use ridgetone_host::demo::later;
use ridgetone_host::digits::seconds;
use ridgetone_host::emulator::{self, Options};
use ridgetone_host::input::{Input, frame_rate_hz};
use ridgetone_host::picture::Recording;
use ridgetone_host::replay::{self, START_US};
use ridgetone_proto::settings::{Settings, TAXELS};
use ridgetone_proto::telemetry::{Event, Packet};
use std::ops::Range;

/// Where the firmware's code runs.
#[derive(Clone, Copy, Debug)]
pub enum Place<'a> {
    /// On this PC: the library, conversion for conversion as on the chip.
    Pc,
    Emulator(&'a Options<'a>),
}

/// The data of a run. Times are device times in seconds.
#[derive(Clone, Debug)]
pub struct Taken {
    pub truth: Truth,
    /// All channels, and the events in them.
    pub recording: Recording,
    pub packets: Vec<Packet>,
    /// ADC codes of each frame, whole numbers.
    pub codes: Vec<[f32; TAXELS]>,
    pub rate_hz: f64,
}

impl Taken {
    pub fn new(scene: Sliding, place: Place<'_>) -> Result<Self> {
        let seed = scene.seed;
        let input = Input { scene, seed }.open()?;
        let truth = input.truth.context("the scene has no truth")?;
        let (mut packets, mut conversions) = (Vec::new(), Vec::new());
        let mut sink = |packet: &Packet| {
            packets.push(packet.clone());
            Ok(())
        };
        let start_us = match place {
            Place::Pc => {
                let watch = &mut |timed| conversions.push(timed);
                replay::run_watched(
                    input,
                    Settings::DEFAULT,
                    replay::Observers {
                        sink: &mut sink,
                        progress: &mut |_, _| {},
                        watch,
                    },
                )?;
                u64::from(START_US)
            }
            Place::Emulator(options) => {
                let options = Options {
                    keep_conversions: true,
                    ..*options
                };
                let outcome = emulator::run(input, options, &mut sink, &mut |_, _| {})?;
                conversions = outcome.conversions;
                // In the time of the firmware's own counter.
                let zero_us = outcome.first_edge_us - outcome.start_us;
                let first_us = conversions.first().map_or(0, |first| first.t_us);
                u64::from(first_us).saturating_sub(zero_us)
            }
        };
        let first_us = conversions
            .first()
            .context("the board has read nothing")?
            .t_us;
        let recording = Recording::new(&conversions, &packets);
        let volts_per_code = f64::from(ads1258::reading::volts(1, Settings::DEFAULT.vref_v));
        let frames = recording.channels.iter().map(Vec::len).min().unwrap_or(0);
        let codes = (0..frames).map(|frame| {
            std::array::from_fn(|taxel| {
                let volts = recording.channels[taxel][frame].1 + recording.idle_v[taxel];
                (volts / volts_per_code).round() as f32
            })
        });
        let codes = codes.collect();
        let truth = later(truth, (start_us as f64 - f64::from(first_us)) * 1e-6);
        Ok(Self {
            truth,
            recording,
            packets,
            codes,
            rate_hz: frame_rate_hz(),
        })
    }

    /// The channel of a taxel, volts above its idle level, frame by frame.
    pub fn volts(&self, taxel: usize) -> &[(f64, f64)] {
        self.recording.channels.get(taxel).map_or(&[], |channel| {
            &channel[..channel.len().min(self.codes.len())]
        })
    }

    /// Some frames of it; empty if they are not all there.
    pub fn part(&self, taxel: usize, frames: &Range<usize>) -> &[(f64, f64)] {
        self.volts(taxel).get(frames.clone()).unwrap_or_default()
    }

    pub fn samples(&self, taxel: usize, frames: &Range<usize>) -> Vec<f64> {
        self.part(taxel, frames)
            .iter()
            .map(|(_, volts)| *volts)
            .collect()
    }

    /// The first frame of a taxel that is not before a time.
    pub fn frame_at(&self, taxel: usize, t_s: f64) -> usize {
        self.volts(taxel).partition_point(|(at_s, _)| *at_s < t_s)
    }

    /// The longest slide that the firmware found, from its start to its end.
    pub fn longest_slide_s(&self) -> Option<(f64, f64)> {
        let slides = self.events(|event| match event {
            Event::Slide(slide) => Some((seconds(slide.start_us), seconds(slide.end_us?))),
            _ => None,
        });
        slides.max_by(|a, b| (a.1 - a.0).total_cmp(&(b.1 - b.0)))
    }

    pub fn events<'a, T: 'a>(
        &'a self,
        kind: impl Fn(&'a Event) -> Option<T> + 'a,
    ) -> impl Iterator<Item = T> + 'a {
        self.packets
            .iter()
            .filter_map(move |packet| kind(&packet.event))
    }
}
