//! Debian's broker and subscriber, and a relay whose connections can be cut.

use rustix::process::{Pid, Signal, kill_process};
use serde_json::Value;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::{Shutdown, TcpListener, TcpStream};
use std::process::{Child, Command, Stdio};
use std::sync::{Arc, Mutex};
use std::thread::sleep;
use std::time::{Duration, Instant};

pub fn free_port() -> u16 {
    TcpListener::bind("127.0.0.1:0")
        .and_then(|free| free.local_addr())
        .expect("a port")
        .port()
}

/// Returns the path of a program from Debian's mosquitto.
pub fn program(name: &str) -> String {
    let folders = [
        "/usr/sbin",
        "/usr/bin",
        "/usr/local/sbin",
        "/opt/homebrew/sbin",
    ];
    let mut paths = folders.iter().map(|folder| format!("{folder}/{name}"));
    paths
        .find(|path| std::path::Path::new(path).exists())
        .unwrap_or_else(|| panic!("{name} is not there: `cargo xtask setup` installs it"))
}

pub struct Broker {
    pub port: u16,
    child: Child,
    _folder: tempfile::TempDir,
}

impl Broker {
    pub fn start() -> Self {
        Self::start_at(free_port())
    }

    pub fn start_at(port: u16) -> Self {
        let folder = crate::common::directory();
        let config = crate::common::file(
            folder.path(),
            "broker.conf",
            &format!(
                "listener {port} 127.0.0.1\nallow_anonymous true\nset_tcp_nodelay true\nsys_interval 1\n"
            ),
        );
        let mut broker = Command::new(program("mosquitto"));
        let child = broker
            .arg("-c")
            .arg(config)
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .expect("a broker");
        let begun = Instant::now();
        while TcpStream::connect(("127.0.0.1", port)).is_err() {
            assert!(
                begun.elapsed() < Duration::from_secs(20),
                "the broker does not listen"
            );
            sleep(Duration::from_millis(20));
        }
        Self {
            port,
            child,
            _folder: folder,
        }
    }

    pub fn hang(&self) {
        self.signal(Signal::STOP);
    }

    pub fn go_on(&self) {
        self.signal(Signal::CONT);
    }

    fn signal(&self, signal: Signal) {
        kill_process(
            Pid::from_raw(self.child.id() as i32).expect("a process"),
            signal,
        )
        .expect("a signal");
    }
}

impl Drop for Broker {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// A message as a subscriber received it.
pub struct Received {
    pub is_retained: bool,
    pub topic: String,
    pub message: Value,
}

/// Longest pause between messages before the last one.
const SILENCE: Duration = Duration::from_secs(10);

pub struct Subscriber {
    child: Child,
    got: Arc<Mutex<Vec<Received>>>,
}

impl Subscriber {
    /// Subscribes to everything, and waits for the subscription.
    pub fn start(port: u16) -> Self {
        // `stdbuf` sends every line to the pipe at once.
        let mut subscriber = Command::new("stdbuf");
        subscriber.args(["-oL", &program("mosquitto_sub")]);
        // "-d" also prints the acknowledgement of the subscription, on lines without JSON.
        subscriber.args(["-V", "mqttv5", "-q", "1", "-d", "-F", "%r %t %p"]);
        subscriber.args(["-t", "ridgetone/#", "-p", &port.to_string()]);
        let mut child = subscriber
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .expect("a subscriber");
        let mut lines = BufReader::new(child.stdout.take().expect("a pipe"))
            .lines()
            .map(|line| line.expect("UTF-8"));
        assert!(
            lines.any(|line| line.starts_with("Subscribed")),
            "a subscription"
        );
        let got = Arc::new(Mutex::new(Vec::new()));
        let shared = Arc::clone(&got);
        std::thread::spawn(move || {
            for one in lines.filter_map(|line| Received::read(&line)) {
                shared.lock().expect("messages").push(one);
            }
        });
        Self { child, got }
    }

    pub fn count(&self) -> usize {
        self.got.lock().expect("messages").len()
    }

    /// Waits for the status that `serve` sends when it ends, and returns all messages.
    pub fn finish(self) -> Vec<Received> {
        let (mut count, mut since) = (self.count(), Instant::now());
        let is_over = || {
            let got = self.got.lock().expect("messages");
            got.last()
                .is_some_and(|one| one.message["state"] == "offline")
        };
        while !is_over() {
            if self.count() != count {
                (count, since) = (self.count(), Instant::now());
            }
            assert!(
                since.elapsed() < SILENCE,
                "no last message after {count}: is the broker there?"
            );
            sleep(Duration::from_millis(20));
        }
        self.leave()
    }

    /// Returns the messages received so far.
    pub fn leave(self) -> Vec<Received> {
        std::mem::take(&mut self.got.lock().expect("messages"))
    }
}

impl Drop for Subscriber {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

impl Received {
    fn read(line: &str) -> Option<Self> {
        let mut parts = line.splitn(3, ' ');
        let is_retained = parts.next()?;
        let topic = parts.next()?.to_owned();
        let json = parts.next().filter(|json| json.starts_with('{'))?;
        let message = serde_json::from_str(json).unwrap_or_else(|error| panic!("{error}: {line}"));
        Some(Self {
            is_retained: is_retained == "1",
            topic,
            message,
        })
    }
}

pub struct Relay {
    pub port: u16,
    /// Both ends of every connection; `None` if the relay is cut.
    ends: Arc<Mutex<Option<Vec<TcpStream>>>>,
}

impl Relay {
    pub fn start(to: u16) -> Self {
        let listener = TcpListener::bind("127.0.0.1:0").expect("a port");
        let port = listener.local_addr().expect("an address").port();
        let ends = Arc::new(Mutex::new(Some(Vec::new())));
        let shared = Arc::clone(&ends);
        std::thread::spawn(move || {
            for near in listener.incoming() {
                let mut ends = shared.lock().expect("ends");
                // If the relay is cut, close the connection at once.
                let (Some(ends), Ok(near)) = (ends.as_mut(), near) else {
                    continue;
                };
                let far = TcpStream::connect(("127.0.0.1", to)).expect("the broker");
                for (from, into) in [(&near, &far), (&far, &near)] {
                    let (mut from, mut into) = (
                        from.try_clone().expect("an end"),
                        into.try_clone().expect("an end"),
                    );
                    std::thread::spawn(move || pass(&mut from, &mut into));
                }
                ends.extend([near, far]);
            }
        });
        Self { port, ends }
    }

    /// Breaks all connections; data in transit is lost.
    pub fn cut(&self) {
        for end in self.ends.lock().expect("ends").take().into_iter().flatten() {
            let _ = end.shutdown(Shutdown::Both);
        }
    }

    pub fn is_used(&self) -> bool {
        self.ends
            .lock()
            .expect("ends")
            .as_ref()
            .is_some_and(|ends| !ends.is_empty())
    }

    pub fn mend(&self) {
        *self.ends.lock().expect("ends") = Some(Vec::new());
    }
}

fn pass(from: &mut TcpStream, into: &mut TcpStream) {
    let mut bytes = [0; 16 * 1024];
    while let Ok(count @ 1..) = from.read(&mut bytes) {
        if into.write_all(&bytes[..count]).is_err() {
            break;
        }
    }
    let _ = into.shutdown(Shutdown::Both);
}
