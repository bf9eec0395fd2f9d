//! Tests a board that moves from one pseudo-terminal to another.

use super::link::LOOK_EVERY;
use super::list::{Found, Usb, only};
use super::*;
use crate::feed::{Feed, FeedEvent};
use ridgetone_proto::telemetry::{Event, Packet, Release, WIRE_MAX, encode};
use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
use std::fs::File;
use std::io::{self, ErrorKind, Read, Write};
use std::sync::{Arc, Mutex};
use std::time::Duration;

const PATIENCE: Duration = Duration::from_secs(10);

/// The board's end of a line. Dropping it unplugs the board.
struct Plugged {
    end: File,
    name: String,
}

impl Plugged {
    fn new() -> Self {
        let end = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY | OpenptFlags::CLOEXEC).unwrap();
        grantpt(&end).unwrap();
        unlockpt(&end).unwrap();
        let name = ptsname(&end, Vec::new()).unwrap().into_string().unwrap();
        Self {
            end: end.into(),
            name,
        }
    }

    fn send(&mut self, bytes: &[u8]) {
        self.end.write_all(bytes).unwrap();
    }
}

/// Real pseudo-terminals, listed under names and serial numbers that the test chooses.
#[derive(Clone, Default)]
struct Bench(Arc<Mutex<Vec<Found>>>);

impl Bench {
    fn has(&self, ports: &[(&str, Option<&str>)]) {
        let found = ports.iter().map(|(name, number)| {
            let usb = number.map(|number| Usb {
                serial_number: Some(number.to_owned()),
                ..Usb::default()
            });
            Found {
                name: (*name).to_owned(),
                usb,
            }
        });
        *self.0.lock().unwrap() = found.collect();
    }
}

impl Ports for Bench {
    type SerialLine = <System as Ports>::SerialLine;

    fn list(&self) -> io::Result<Vec<Found>> {
        Ok(self.0.lock().unwrap().clone())
    }

    fn open(&self, name: &str) -> io::Result<Self::SerialLine> {
        System.open(name)
    }
}

fn frame(sequence: u16) -> Vec<u8> {
    let packet = Packet {
        sequence,
        event: Event::Release(Release {
            t_us: 1 << 40 | u64::from(sequence),
            reported_after_us: 0,
        }),
    };
    let mut wire = [0; WIRE_MAX];
    let used = encode(&packet, &mut wire).unwrap();
    wire[..used].to_vec()
}

fn connected(link: &mut Feed) -> String {
    match link.next(PATIENCE).unwrap() {
        Some(FeedEvent::Connected(name)) => name,
        other => panic!("{other:?} instead of a board"),
    }
}

fn disconnected(link: &mut Feed) -> String {
    match link.next(PATIENCE).unwrap() {
        Some(FeedEvent::Disconnected(name, _)) => name,
        other => panic!("{other:?} instead of an unplugged board"),
    }
}

fn numbers(link: &mut Feed, count: usize) -> Vec<u16> {
    let number = |event: Option<FeedEvent<Packet>>| match event {
        Some(FeedEvent::Data(packet)) => packet.sequence,
        other => panic!("{other:?} instead of a packet"),
    };
    (0..count)
        .map(|_| number(link.next(PATIENCE).unwrap()))
        .collect()
}

/// Sends frames 0 to 9 and half of 10, unplugs the board, and sends the second half of 20 and 21 to
/// 29 on a different terminal.
fn moves(wanted: impl FnOnce(&str) -> Wanted) {
    let bench = Bench::default();
    let mut first = Plugged::new();
    bench.has(&[
        ("/dev/none", None),
        (&first.name, Some("R-7")),
        ("/dev/other", Some("R-8")),
    ]);
    let mut link = Feed::new(Link::open(bench.clone(), wanted(&first.name)).unwrap());
    assert_eq!(connected(&mut link), first.name);
    (0..10).for_each(|number| first.send(&frame(number)));
    first.send(&frame(10)[..7]);
    assert_eq!(numbers(&mut link, 10), (0..10).collect::<Vec<_>>());
    // Read the half frame too; it produces no event.
    assert!(link.next(Duration::from_millis(300)).unwrap().is_none());

    let old_name = first.name.clone();
    // The system does not reuse the name of a terminal while one end is open.
    drop(first);
    assert_eq!(disconnected(&mut link), old_name);
    let unsent = link.send(b"x").unwrap_err();
    assert_eq!(
        unsent.downcast_ref::<io::Error>().map(io::Error::kind),
        Some(ErrorKind::NotConnected),
        "{unsent:#}"
    );
    // A different board at the old name must not be opened.
    let stranger = Plugged::new();
    bench.has(&[(&stranger.name, Some("R-8"))]);
    assert!(link.next(3 * LOOK_EVERY).unwrap().is_none());

    let mut second = Plugged::new();
    assert_ne!(second.name, stranger.name);
    bench.has(&[(&stranger.name, Some("R-8")), (&second.name, Some("R-7"))]);
    assert_eq!(connected(&mut link), second.name);
    second.send(&frame(20)[9..]);
    (21..30).for_each(|number| second.send(&frame(number)));
    assert_eq!(numbers(&mut link, 9), (21..30).collect::<Vec<_>>());
    // There were two damaged half frames, and 11 missing frames in between.
    assert_eq!((link.counts().damaged, link.counts().missing), (2, 11));

    link.send(b"to the board").unwrap();
    let mut received = [0; 12];
    second.end.read_exact(&mut received).unwrap();
    assert_eq!(&received, b"to the board");
}

#[test]
fn a_board_known_by_its_serial_number_is_followed_to_another_name() {
    moves(|_| Wanted::UsbSerial("R-7".into()));
}

#[test]
fn a_board_opened_by_name_is_followed_by_its_serial_number() {
    moves(|name| Wanted::Name(name.into()));
}

#[test]
fn without_a_serial_number_it_is_the_name_that_counts() {
    let (folder, bench) = (tempfile::tempdir().unwrap(), Bench::default());
    let link_name = folder.path().join("finger");
    let name = link_name.to_str().unwrap();
    let plug = |board: &Plugged| std::os::unix::fs::symlink(&board.name, &link_name).unwrap();
    let mut first = Plugged::new();
    plug(&first);
    // Cheap adapters may share one serial number, which then identifies neither.
    bench.has(&[(&first.name, Some("0001")), ("/dev/other", Some("0001"))]);
    let mut link = Feed::new(Link::open(bench.clone(), Wanted::Name(name.into())).unwrap());
    assert_eq!(connected(&mut link), name);
    first.send(&frame(65_535));
    assert_eq!(numbers(&mut link, 1), [65_535]);
    std::fs::remove_file(&link_name).unwrap();
    drop(first);
    assert_eq!(disconnected(&mut link), name);
    assert!(link.next(3 * LOOK_EVERY).unwrap().is_none());
    let mut second = Plugged::new();
    plug(&second);
    assert_eq!(connected(&mut link), name);
    second.send(&frame(2));
    assert_eq!(
        (
            numbers(&mut link, 1),
            link.counts().missing,
            link.counts().damaged
        ),
        (vec![2], 2, 0)
    );
}

#[test]
fn a_missing_board_is_an_error_that_lists_the_ports() {
    let bench = Bench::default();
    let open = |wanted| {
        Link::open(bench.clone(), wanted)
            .map(|_| ())
            .unwrap_err()
            .to_string()
    };
    let number = || Wanted::UsbSerial("R-9".into());
    assert_eq!(
        open(number()),
        "no serial port has the USB serial number R-9: there is no serial port"
    );
    bench.has(&[("/dev/none-a", Some("R-8")), ("/dev/none-b", None)]);
    let error = open(number());
    assert!(
        error.ends_with("there are /dev/none-a (USB, serial number R-8), /dev/none-b"),
        "{error}"
    );
    assert!(open(Wanted::Name("/dev/none-a".into())).starts_with("/dev/none-a: "));
    bench.has(&[("/dev/none-a", Some("R-9")), ("/dev/none-b", Some("R-9"))]);
    assert!(
        open(number())
            .starts_with("more than one port has the USB serial number R-9, choose with --port")
    );
}

#[test]
fn the_only_port_is_found_and_of_several_none_is_guessed() {
    let only = |ports: &[(&str, Option<&str>)]| {
        let bench = Bench::default();
        bench.has(ports);
        let found = bench.list().unwrap();
        only(&found)
            .map(|port| port.name.clone())
            .map_err(|error| error.to_string())
    };
    assert!(only(&[]).unwrap_err().contains("--emulated"));
    // A mainboard's own port is listed even if nothing is plugged in, so it is never chosen.
    assert!(only(&[("/dev/a", None)]).unwrap_err().contains("--port"));
    assert_eq!(
        only(&[("/dev/a", None), ("/dev/b", Some("R-7"))]),
        Ok("/dev/b".into())
    );
    let error = only(&[
        ("/dev/a", None),
        ("/dev/b", Some("R-7")),
        ("/dev/c", Some("R-8")),
    ])
    .unwrap_err();
    assert!(
        error.contains("--usb-serial")
            && error.contains("R-7")
            && error.contains("R-8")
            && !error.contains("/dev/a")
    );
}

#[test]
fn the_ports_of_this_computer_are_listed_or_an_error_names_the_directory() {
    match System.list() {
        Ok(found) => assert!(
            found.iter().all(|port| port.name.starts_with("/dev/")),
            "{found:?}"
        ),
        Err(error) => assert!(error.to_string().contains(system::TERMINALS), "{error}"),
    }
}

/// Asserts that the error names the program that uses a port, and does not call a file a port.
#[test]
fn a_port_that_cannot_be_opened_is_refused_in_plain_words() {
    let board = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY).expect("a terminal");
    grantpt(&board)
        .and_then(|()| unlockpt(&board))
        .expect("it may be opened");
    let name = ptsname(&board, Vec::new())
        .expect("a name")
        .into_string()
        .expect("UTF-8");
    let _first = System.open(&name).expect("it is free");
    let why = System.open(&name).expect_err("it is in use").to_string();
    let own = format!("(process {})", std::process::id());
    assert!(why.starts_with("in use by ") && why.contains(&own), "{why}");
    let file = tempfile::NamedTempFile::new().expect("a file");
    let why = System
        .open(file.path().to_str().expect("UTF-8"))
        .expect_err("no port")
        .to_string();
    assert!(
        why.contains("no serial port") && why.contains("ridgetone ports"),
        "{why}"
    );
}
