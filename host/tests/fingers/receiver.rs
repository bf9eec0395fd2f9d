//! Receivers of many fingers that keep little of each frame: when it came, and what it says of its
//! time.

use crate::mosquitto::program;
use crate::process::processor_s;
use rustix::process::{Pid, Signal, kill_process};
use std::collections::HashMap;
use std::io::{BufRead, BufReader};
use std::process::{Child, Command, Stdio};
use std::sync::mpsc::channel;
use std::sync::{Arc, Mutex};
use std::thread::JoinHandle;
use std::time::{SystemTime, UNIX_EPOCH};
use zenoh::{Config, Session, Wait};

/// Frames by finger's topic.
#[derive(Default)]
pub struct Arrivals(HashMap<String, Vec<Arrival>>);

#[derive(Clone, Copy)]
struct Arrival {
    utc_s: f64,
    /// Board time.
    t_s: f64,
    /// When `serve` read it.
    read_utc_s: f64,
}

/// The number behind a name in a message.
fn number(json: &str, name: &str) -> Option<f64> {
    let rest = json.split_once(name)?.1;
    let end = rest.find([',', '}'])?;
    rest[..end].parse().ok()
}

impl Arrivals {
    fn take(&mut self, utc_s: f64, topic: &str, json: &str) {
        if !topic.ends_with("/frames") {
            return;
        }
        let [t_s, read_utc_s] = [r#""t_s":"#, r#""received_utc_s":"#]
            .map(|name| number(json, name).unwrap_or_else(|| panic!("no {name} in {json}")));
        let arrival = Arrival {
            utc_s,
            t_s,
            read_utc_s,
        };
        match self.0.get_mut(topic) {
            Some(all) => all.push(arrival),
            None => drop(self.0.insert(topic.to_owned(), vec![arrival])),
        }
    }

    pub fn frames(&self) -> u64 {
        self.0.values().map(|all| all.len() as u64).sum()
    }

    /// From the moment at which a frame was due to its receipt, in order, milliseconds. A finger's
    /// clock is that of its frame that was read soonest, so that a command that reads behind time
    /// counts as late.
    pub fn late_ms(&self) -> Vec<f64> {
        let mut late_ms = Vec::new();
        for all in self.0.values() {
            let offset_s = all
                .iter()
                .map(|one| one.read_utc_s - one.t_s)
                .fold(f64::MAX, f64::min);
            late_ms.extend(all.iter().map(|one| 1e3 * (one.utc_s - one.t_s - offset_s)));
        }
        late_ms.sort_by(f64::total_cmp);
        late_ms
    }
}

/// Debian's subscriber.
pub struct MqttReceiver {
    child: Child,
    reader: Option<JoinHandle<Arrivals>>,
}

impl MqttReceiver {
    /// Subscribes to everything, and is subscribed: a message that the broker retains comes first.
    pub fn start(port: u16) -> Self {
        let port = port.to_string();
        let told = Command::new(program("mosquitto_pub"))
            .args(["-r", "-t", "ridgetone/first", "-m", "1", "-p", &port])
            .status();
        assert!(told.expect("a publisher").success());
        // A pipe gets every line at once.
        let mut subscriber = Command::new("stdbuf");
        subscriber.args(["-oL", &program("mosquitto_sub")]);
        subscriber.args(["-V", "mqttv5", "-F", "%U %t %p", "-t", "ridgetone/#"]);
        let mut child = subscriber
            .args(["-p", &port])
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .expect("a subscriber");
        let out = BufReader::new(child.stdout.take().expect("a pipe"));
        let (to_start, is_subscribed) = channel();
        let reader = std::thread::spawn(move || {
            let mut arrivals = Arrivals::default();
            for line in out.lines().map(|line| line.expect("UTF-8")) {
                let mut parts = line.splitn(3, ' ');
                let mut next = || parts.next().expect("three parts");
                let utc_s = next().parse().expect("a time");
                let topic = next();
                if topic == "ridgetone/first" {
                    let _ = to_start.send(());
                }
                arrivals.take(utc_s, topic, next());
            }
            arrivals
        });
        is_subscribed.recv().expect("a subscription");
        Self {
            child,
            reader: Some(reader),
        }
    }

    pub fn processor_s(&self) -> f64 {
        processor_s(self.child.id())
    }

    /// Ends it: it prints what it has.
    pub fn finish(mut self) -> Arrivals {
        let id = Pid::from_raw(self.child.id() as i32).expect("a process");
        kill_process(id, Signal::TERM).expect("a signal");
        let reader = self.reader.take().expect("once");
        reader.join().expect("messages")
    }
}

impl Drop for MqttReceiver {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// Messages that a broker has dropped, by its own count.
pub fn dropped(port: u16) -> u64 {
    let topic = "$SYS/broker/publish/messages/dropped";
    let told = Command::new(program("mosquitto_sub"))
        .args(["-C", "1", "-W", "5", "-t", topic, "-p", &port.to_string()])
        .output()
        .expect("a subscriber");
    let text = String::from_utf8(told.stdout).expect("UTF-8");
    text.trim().parse().expect("a count")
}

/// A router of Zenoh, and a client of it that subscribes to everything.
pub struct Router {
    router: Session,
    client: Session,
    got: Arc<Mutex<Arrivals>>,
}

impl Router {
    pub fn start(port: u16) -> Self {
        let address = format!("[\"tcp/127.0.0.1:{port}\"]");
        let router = session("router", "listen/endpoints", &address);
        let client = session("client", "connect/endpoints", &address);
        let got = Arc::new(Mutex::new(Arrivals::default()));
        let to = Arc::clone(&got);
        client
            .declare_subscriber("ridgetone/**")
            .callback(move |sample| {
                let now = SystemTime::now().duration_since(UNIX_EPOCH);
                let utc_s = now.expect("a clock").as_secs_f64();
                let payload = sample.payload().to_bytes();
                let json = std::str::from_utf8(&payload).expect("UTF-8");
                let mut got = to.lock().expect("messages");
                got.take(utc_s, sample.key_expr().as_str(), json);
            })
            .background()
            .wait()
            .expect("a subscription");
        Self {
            router,
            client,
            got,
        }
    }

    pub fn finish(self) -> Arrivals {
        self.client.close().wait().expect("closed");
        self.router.close().wait().expect("closed");
        std::mem::take(&mut self.got.lock().expect("messages"))
    }
}

fn session(mode: &str, name: &str, address: &str) -> Session {
    let mut config = Config::default();
    for (name, value) in [
        ("mode", format!("\"{mode}\"").as_str()),
        (name, address),
        ("scouting/multicast/enabled", "false"),
    ] {
        config.insert_json5(name, value).expect("a setting");
    }
    zenoh::open(config).wait().expect("a session")
}
