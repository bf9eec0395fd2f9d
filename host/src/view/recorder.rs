//! Recordings made from a page, in the format of `record`: packets between start and stop, or of
//! the latest minute.

use crate::digits::time_s;
use crate::recording::{self, Keep, Recording};
use crate::utc::Receipt;
use anyhow::{Context, Result, ensure};
use ridgetone_proto::telemetry::{Event, Hello, Packet, Starts, WIRE_MAX, encode};
use std::collections::VecDeque;
use std::path::PathBuf;
use std::time::{Duration, Instant};

/// Maximum size of a recording in bytes: over three hours of raw frames. Use `record` for longer
/// ones.
const BYTES_MAX: usize = 256 << 20;

/// Length and maximum number of the latest packets, which are always kept; the number is slightly
/// more than a board sends in this time.
const LATEST: Duration = Duration::from_secs(60);
const LATEST_MAX: usize = 16_000;

#[derive(Default)]
pub struct Latest {
    packets: VecDeque<(Instant, Packet, Option<Receipt>)>,
    starts: Starts,
}

impl Latest {
    pub fn push(&mut self, packet: &Packet, receipt: Option<Receipt>) {
        if self.starts.take(&packet.event) {
            // The board has restarted, and a recording has only one time axis.
            self.packets.clear();
        }
        while self.packets.len() >= LATEST_MAX
            || self
                .packets
                .front()
                .is_some_and(|(then, ..)| then.elapsed() > LATEST)
        {
            self.packets.pop_front();
        }
        self.packets
            .push_back((Instant::now(), packet.clone(), receipt));
    }

    pub fn recorder(&self, path: PathBuf, source: &str, hello: Option<&Hello>) -> Result<Recorder> {
        let mut recorder = Recorder::new(path, source);
        for (_, packet, receipt) in &self.packets {
            recorder.keep(packet, *receipt, hello)?;
        }
        Ok(recorder)
    }
}

pub struct Recorder {
    pub path: PathBuf,
    source: String,
    begun: Instant,
    file: Option<Recording>,
    bytes: usize,
    /// First and last device time, seconds.
    times_s: Option<(f64, f64)>,
}

impl Recorder {
    pub fn new(path: PathBuf, source: &str) -> Self {
        Self {
            path,
            source: source.to_owned(),
            begun: Instant::now(),
            file: None,
            bytes: 0,
            times_s: None,
        }
    }

    pub fn length_s(&self) -> f64 {
        self.begun.elapsed().as_secs_f64()
    }

    pub fn name(&self) -> String {
        let source = self
            .source
            .rsplit(['/', '\\'])
            .next()
            .unwrap_or_default()
            .replace(' ', "-");
        let (from_s, until_s) = self.times_s.unwrap_or_default();
        format!("{source}-{from_s:.1}s-{until_s:.1}s.rec")
    }

    pub fn is_empty(&self) -> bool {
        self.file.is_none()
    }

    /// Records a packet. The latest greeting is recorded before the first packet, because it has
    /// the reference voltage.
    pub fn keep(
        &mut self,
        packet: &Packet,
        receipt: Option<Receipt>,
        hello: Option<&Hello>,
    ) -> Result<()> {
        ensure!(
            self.bytes < BYTES_MAX,
            "the recording is full; `ridgetone record` makes longer ones"
        );
        if self.file.is_none() {
            let byte_s = receipt.map_or(0.0, |receipt| receipt.byte_s);
            self.file = Some(recording::create(&self.path, &self.source, byte_s)?);
            if let (Some(hello), false) = (hello, matches!(packet.event, Event::Hello(_))) {
                let sequence = packet.sequence.wrapping_sub(1);
                self.write(
                    &Packet {
                        sequence,
                        event: Event::Hello(hello.clone()),
                    },
                    receipt,
                )?;
            }
        }
        if let Some(t_s) = time_s(&packet.event) {
            let (from_s, until_s) = self.times_s.unwrap_or((t_s, t_s));
            self.times_s = Some((from_s.min(t_s), until_s.max(t_s)));
        }
        self.write(packet, receipt)
    }

    fn write(&mut self, packet: &Packet, receipt: Option<Receipt>) -> Result<()> {
        let mut wire = [0; WIRE_MAX];
        let used = encode(packet, &mut wire).context("a packet")?;
        self.bytes += used;
        let file = self.file.as_mut().context("the recording")?;
        Ok(file.keep(&wire[..used], receipt)?)
    }
}
