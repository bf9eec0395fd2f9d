//! A robot's odometry: a file of places or speeds becomes the messages that the robot would send.

use crate::note;
use anyhow::{Context, Result, anyhow, bail, ensure};
use hal_mock::Table;
use ridgetone_proto::odometry::{FRAME_BYTES, Odometry, PLACE_PER_MM, Reading, SPEED_MAX_MM_S};
use ridgetone_proto::telemetry::Packet;
use std::fs::File;
use std::io::{BufRead, BufReader, Read};
use std::path::Path;
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::time::{Duration, Instant};

/// A sender of odometry that hears the board's packets. `now` is the time by the clock that
/// the board runs by ([`Source::clock`](crate::feed::Source::clock)), else by this computer's.
pub trait Robot: Send {
    /// Takes a packet of the board.
    fn hear(&mut self, _packet: &Packet, _now: Duration) {}

    /// The next message that is due, as it travels.
    fn next(&mut self, now: Duration) -> Option<Vec<u8>>;

    /// Whether the last message was sent, and with it everything is over.
    fn has_ended(&self) -> bool {
        false
    }
}

impl Robot for Receiver<Vec<u8>> {
    fn next(&mut self, _now: Duration) -> Option<Vec<u8>> {
        self.try_recv().ok()
    }
}

/// Frames, stuffed and without their zeros, and when each is complete at the board, microseconds of
/// scene time.
pub type Stream = Vec<(u64, Vec<u8>)>;

/// Column of the places along the surface, millimetres.
pub const PLACE_COLUMN: &str = "place_mm";
/// Column of the speeds over the surface, millimetres per second.
pub const SPEED_COLUMN: &str = "speed_mm_s";
/// Column of the times at which messages are complete at the board, seconds.
const ARRIVAL_COLUMN: &str = "arrival_s";
/// Delay of messages without that column, microseconds: a line of 921,600 baud takes 206 for one.
const DELAY_US: f64 = 300.0;
/// Greatest place, millimetres: as far as the numbers on the line reach.
const PLACE_MOST_MM: f64 = 200_000.0;

/// A message of a row: its number, the robot's time in seconds, and a place in millimetres or a
/// speed.
pub fn message(number: usize, t_s: f64, value: f64, is_place: bool) -> Odometry {
    // A place wraps too: an hour at 60 mm/s is as far as its numbers reach.
    let reading = match is_place {
        true => Reading::Place((value * f64::from(PLACE_PER_MM)).round() as i64 as i32),
        false => Reading::Speed(value as f32),
    };
    // Number and stamp wrap, as on a robot.
    Odometry {
        number: number as u16,
        t_us: (t_s * 1e6).round() as i64 as u32,
        reading,
    }
}

/// Which column of a table has the values, and whether they are places.
pub fn column(names: &[String], file: &str) -> Result<(usize, bool)> {
    let at = |name: &str| names.iter().position(|one| one == name);
    match (at(PLACE_COLUMN), at(SPEED_COLUMN)) {
        (Some(place), None) => Ok((place, true)),
        (None, Some(speed)) => Ok((speed, false)),
        (Some(_), Some(_)) => {
            bail!("{file}: both {PLACE_COLUMN} and {SPEED_COLUMN}: leave one of them out")
        }
        (None, None) => {
            bail!(
                "{file}: neither {PLACE_COLUMN} nor {SPEED_COLUMN}; there are: {}",
                names.join(", ")
            )
        }
    }
}

/// Checks a value of a file.
pub fn check(value: f64, is_place: bool, file: &str, t_s: f64) -> Result<()> {
    let (name, most) = if is_place {
        (PLACE_COLUMN, PLACE_MOST_MM)
    } else {
        (SPEED_COLUMN, f64::from(SPEED_MAX_MM_S))
    };
    ensure!(
        value.abs() <= most,
        "{file}: time_s {t_s}: {name} {value}: choose -{most} to {most}"
    );
    Ok(())
}

/// Reads the messages of a file: columns `time_s` (the robot's clock), `place_mm` or `speed_mm_s`,
/// and if messages were not quick `arrival_s` (device time).
pub fn stream(path: &Path) -> Result<Stream> {
    let table = Table::load(path)?;
    let file = table.file();
    let (column, is_place) = column(table.names(), file)?;
    let arrival = table.names().iter().position(|name| name == ARRIVAL_COLUMN);
    let Some(time_s) = table.time_s() else {
        bail!("{file}: no column time_s")
    };
    let mut stream = Vec::with_capacity(time_s.len());
    for (number, (t_s, row)) in time_s.iter().zip(table.rows()).enumerate() {
        // A reading that is missing is a message that is lost.
        if row[column].is_nan() {
            continue;
        }
        check(row[column], is_place, file, *t_s)?;
        let at_us = arrival.map_or(t_s * 1e6 + DELAY_US, |arrival| row[arrival] * 1e6);
        ensure!(
            at_us >= 0.0,
            "{file}: time_s {t_s}: a message arrives before the run begins: add {ARRIVAL_COLUMN}"
        );
        let frame = message(number, *t_s, row[column], is_place).encode();
        stream.push((at_us.round() as u64, frame[..FRAME_BYTES].to_vec()));
    }
    stream.sort_by_key(|(at_us, _)| *at_us);
    Ok(stream)
}

/// Messages of a robot that wait to be sent: a quarter of a second of 250 a second.
const WAITING: usize = 64;

/// Follows a robot that writes lines as [`stream`] reads them, a header first, into a pipe, a port
/// or, as `-`, standard input: gives each message as it travels. A file is read at the pace of its
/// stamps. A wrong line ends it, with a message on standard error.
pub fn follow(path: &Path) -> Result<Receiver<Vec<u8>>> {
    let shown = path.display().to_string();
    let is_file = path.metadata().is_ok_and(|about| about.is_file());
    let source: Box<dyn Read + Send> = match path.as_os_str() == "-" {
        true => Box::new(std::io::stdin()),
        false => Box::new(File::open(path).with_context(|| shown.clone())?),
    };
    // A robot's pipe waits for a board that is slower.
    let (found, messages) = sync_channel(WAITING);
    std::thread::spawn(move || {
        if let Err(error) = send_lines(BufReader::new(source), &shown, is_file, &found) {
            note!("{error:#}; estimates come by time from now on");
        }
    });
    Ok(messages)
}

/// Bytes of the longest line; a row of numbers has some tens.
const LINE_MOST: u64 = 1 << 16;

/// The lines of a source, which need not have any.
fn lines(mut source: impl BufRead) -> impl Iterator<Item = Result<String>> {
    std::iter::from_fn(move || {
        let mut line = String::new();
        let read = source.by_ref().take(LINE_MOST).read_line(&mut line);
        match read {
            Ok(0) => None,
            Ok(length) if length as u64 == LINE_MOST => {
                Some(Err(anyhow!("a line of 64 KiB and more: these are no rows")))
            }
            Ok(_) => Some(Ok(line.trim_end_matches(['\n', '\r']).to_owned())),
            Err(error) => Some(Err(error.into())),
        }
    })
}

fn send_lines(
    source: impl BufRead,
    file: &str,
    is_paced: bool,
    found: &SyncSender<Vec<u8>>,
) -> Result<()> {
    let mut lines = lines(source);
    let Some(header) = lines.next().transpose().with_context(|| file.to_owned())? else {
        bail!("{file}: no line")
    };
    let names: Vec<String> = header
        .split(',')
        .map(|name| name.trim().to_owned())
        .collect();
    let Some(time) = names.iter().position(|name| name == "time_s") else {
        bail!("{file}: no column time_s")
    };
    let (column, is_place) = column(&names, file)?;
    let (begun, mut first_s) = (Instant::now(), None);
    for (number, line) in lines.enumerate() {
        let line = line.with_context(|| file.to_owned())?;
        let values: Vec<f64> = line
            .split(',')
            .map(|value| value.trim().parse().unwrap_or(f64::NAN))
            .collect();
        let (Some(t_s), Some(value)) = (values.get(time), values.get(column)) else {
            bail!("{file}: line {}: {line}: too few columns", number + 2)
        };
        ensure!(
            t_s.is_finite(),
            "{file}: line {}: {line}: no time",
            number + 2
        );
        if value.is_nan() {
            continue;
        }
        check(*value, is_place, file, *t_s)?;
        if is_paced {
            let due =
                Duration::try_from_secs_f64(t_s - *first_s.get_or_insert(*t_s)).unwrap_or_default();
            std::thread::sleep(due.saturating_sub(begun.elapsed()));
        }
        if found
            .send(message(number, *t_s, *value, is_place).encode().to_vec())
            .is_err()
        {
            // The receiver is gone.
            break;
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(text: &str) -> Result<Stream> {
        let file = tempfile::NamedTempFile::with_suffix(".csv")?;
        std::fs::write(file.path(), text)?;
        stream(file.path())
    }

    #[test]
    fn rows_become_messages_with_the_robots_stamps() {
        let stream = of(
            "time_s,place_mm,arrival_s\n5000,1.5,0.001\n5000.004,,0.005\n5000.008,-0.00005,0.009\n",
        )
        .unwrap();
        let decoded: Vec<_> = (stream.iter().cloned())
            .map(|(at_us, mut frame)| (at_us, Odometry::decode(&mut frame).unwrap()))
            .collect();
        let expected = |number, t_us, place| Odometry {
            number,
            t_us,
            reading: Reading::Place(place),
        };
        // 5000 s are 705,032,704 us behind the first wrap of 2^32.
        assert_eq!(
            decoded,
            [
                (1000, expected(0, 705_032_704, 15_000)),
                (9000, expected(2, 705_040_704, -1))
            ]
        );
    }

    #[test]
    fn lines_become_messages_as_they_come() {
        let (found, messages) = sync_channel(WAITING);
        let lines = "time_s, speed_mm_s\n1.0,5\n1.004,\n1.008,-7.5\n1.012\n1.016,2\n";
        let error = send_lines(lines.as_bytes(), "a pipe", false, &found).unwrap_err();
        assert!(
            format!("{error}").contains("a pipe: line 5: 1.012: too few columns"),
            "{error}"
        );
        let sent: Vec<_> = messages
            .try_iter()
            .map(|mut wire| {
                assert_eq!(wire.pop(), Some(0));
                Odometry::decode(&mut wire).unwrap()
            })
            .collect();
        let expected = |number, t_us, mm_s| Odometry {
            number,
            t_us,
            reading: Reading::Speed(mm_s),
        };
        assert_eq!(
            sent,
            [expected(0, 1_000_000, 5.0), expected(2, 1_008_000, -7.5)]
        );
    }

    #[test]
    fn what_is_wrong_is_named() {
        for (text, why) in [
            ("time_s,x\n0,1\n", "neither place_mm nor speed_mm_s"),
            ("time_s,place_mm,speed_mm_s\n0,1,1\n", "both"),
            ("time_s,speed_mm_s\n0,2001\n", "choose -2000 to 2000"),
            ("time_s,place_mm\n-1,0\n", "add arrival_s"),
        ] {
            let error = format!("{:#}", of(text).unwrap_err());
            assert!(error.contains(why), "{error}");
        }
    }
}
