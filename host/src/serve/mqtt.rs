//! MQTT 5: frames with QoS 0, all other messages with QoS 1; the schemas are retained beside the
//! topics.
//!
//! A session lives as long as its connection. When that breaks, events that the broker has not
//! acknowledged wait again. A broker acknowledges in the order of publication (MQTT 5.0, 4.6):
//! frames before an acknowledged event have arrived, and those after the last one are counted as
//! not confirmed.

use super::queue::{Queue, Queued};
use super::schema;
use super::sink::Sink;
use super::topic::{Names, Topic};
use crate::note;
use crate::usage::UsageError;
use crate::utc::Receipt;
use anyhow::{Result, anyhow};
use rumqttc::v5::mqttbytes::QoS;
use rumqttc::v5::mqttbytes::v5::LastWill;
use rumqttc::v5::{AsyncClient, Event, EventLoop, Incoming, MqttOptions};
use rumqttc::{NetworkOptions, Outgoing};
use std::cell::RefCell;
use std::collections::{HashMap, VecDeque};
use std::time::Duration;
use tokio::sync::Notify;
use tokio::time::{sleep, timeout};

/// The port of MQTT without TLS.
const PORT: u16 = 1883;

/// From one ping to the next; in a silence of twice this the broker is given up.
const PING: Duration = Duration::from_secs(5);

/// Time between two attempts to connect.
const AGAIN: Duration = Duration::from_secs(1);

/// Messages between the queue and the connection.
const CHANNEL: usize = 64;

/// Events that wait for their acknowledgement; a broker may want less.
const UNACKNOWLEDGED_MAX: u16 = 256;

/// What `<board>/status` says, retained; the broker says the second one too if the connection
/// breaks.
const ONLINE: &str = r#"{"state":"online"}"#;
const OFFLINE: &str = r#"{"state":"offline"}"#;

/// Time that the broker has at the end for its last acknowledgements.
const LAST: Duration = Duration::from_secs(2);

pub struct Mqtt {
    host: String,
    port: u16,
    login: Option<(String, String)>,
}

/// Messages given to the connection and not confirmed; nothing in place of a schema.
#[derive(Default)]
struct Flight {
    entries: VecDeque<Option<Queued>>,
    /// Number of the first entry.
    first: u64,
    /// Number of the entry that is written next.
    written: u64,
    /// Entries by their packet identifiers.
    numbers: HashMap<u16, u64>,
}

impl Flight {
    fn write(&mut self, packet: u16) {
        if packet != 0 {
            self.numbers.insert(packet, self.written);
        }
        self.written += 1;
    }

    fn acknowledge(&mut self, packet: u16) {
        let Some(number) = self.numbers.remove(&packet) else {
            return;
        };
        let confirmed = (number + 1).saturating_sub(self.first);
        self.entries.drain(..confirmed as usize);
        self.first += confirmed;
    }
}

impl Sink for Mqtt {
    fn name(&self) -> &'static str {
        "mqtt"
    }

    fn run(self: Box<Self>, queue: &Queue, names: &Names) -> Result<()> {
        let runtime = tokio::runtime::Builder::new_current_thread()
            .enable_all()
            .build()?;
        runtime.block_on(async {
            let mut reported = String::new();
            while let Err(error) = self.session(queue, names).await {
                let why = format!("{error:#}");
                if why != reported {
                    note!("mqtt: {}:{}: {why}; trying again", self.host, self.port);
                    reported = why;
                }
                if queue.is_closed() {
                    break;
                }
                sleep(AGAIN).await;
            }
            Ok(())
        })
    }
}

impl Mqtt {
    pub fn new(url: &str) -> Result<Self> {
        let wrong = |why: &str| {
            UsageError(format!(
                "{url}: {why}; write mqtt://[USER:PASSWORD@]HOST[:PORT]"
            ))
        };
        if url.starts_with("mqtts://") {
            return Err(wrong("this command speaks MQTT without TLS").into());
        }
        let rest = url
            .strip_prefix("mqtt://")
            .ok_or_else(|| wrong("no address of a broker"))?
            .trim_end_matches('/');
        let (login, place) = match rest.rsplit_once('@') {
            None => (None, rest),
            Some((login, place)) => (
                Some(login.split_once(':').ok_or_else(|| wrong("no password"))?),
                place,
            ),
        };
        let (host, port) = match place.rsplit_once(':') {
            Some((host, port)) if !port.ends_with(']') => {
                (host, port.parse().map_err(|_| wrong("no such port"))?)
            }
            _ => (place, PORT),
        };
        if host.is_empty() || host.contains('/') {
            return Err(wrong("no host").into());
        }
        let login = login.map(|(user, password)| (user.to_owned(), password.to_owned()));
        Ok(Self {
            host: host.to_owned(),
            port,
            login,
        })
    }

    fn options(&self, names: &Names) -> MqttOptions {
        // No two on a broker may have the same.
        let client = format!("ridgetone-{:x}", Receipt::now(0.0).utc_ns);
        let mut options = MqttOptions::new(client, &self.host, self.port);
        options
            .set_keep_alive(PING)
            .set_clean_start(true)
            .set_outgoing_inflight_upper_limit(UNACKNOWLEDGED_MAX);
        // Otherwise a frame waits for the acknowledgement of the one before, up to 40 ms.
        let mut network = NetworkOptions::new();
        network.set_tcp_nodelay(true);
        options.set_network_options(network);
        options.set_last_will(LastWill::new(
            names.status(),
            OFFLINE,
            QoS::AtLeastOnce,
            true,
            None,
        ));
        if let Some((user, password)) = &self.login {
            options.set_credentials(user, password);
        }
        options
    }

    /// Delivers until the queue is closed and empty. Fails if the connection breaks.
    async fn session(&self, queue: &Queue, names: &Names) -> Result<()> {
        let (client, mut events) = AsyncClient::new(self.options(names), CHANNEL);
        let (flight, connected) = (RefCell::new(Flight::default()), Notify::new());
        let ended = tokio::select! {
            why = self.poll(&mut events, &flight, &connected) => Err(why),
            done = async {
                connected.notified().await;
                deliver(&client, queue, names, &flight).await
            } => done,
        };
        if ended.is_ok() {
            // Writes the farewell, and waits until the broker hangs up.
            let _ = timeout(LAST, self.poll(&mut events, &flight, &connected)).await;
        }
        queue.put_back(flight.into_inner().entries.into_iter().flatten());
        ended
    }

    /// Drives the connection until it breaks, and gives why.
    async fn poll(
        &self,
        events: &mut EventLoop,
        flight: &RefCell<Flight>,
        connected: &Notify,
    ) -> anyhow::Error {
        loop {
            match timeout(2 * PING, events.poll()).await {
                Ok(Ok(Event::Incoming(Incoming::ConnAck(_)))) => {
                    note!("mqtt: {}:{}: connected", self.host, self.port);
                    connected.notify_one();
                }
                Ok(Ok(Event::Incoming(Incoming::PubAck(ack)))) => {
                    flight.borrow_mut().acknowledge(ack.pkid)
                }
                Ok(Ok(Event::Outgoing(Outgoing::Publish(packet)))) => {
                    flight.borrow_mut().write(packet)
                }
                Ok(Ok(_)) => {}
                Ok(Err(error)) => return anyhow!(error),
                Err(_) => return anyhow!("the broker does not answer"),
            }
        }
    }
}

/// Says whether this command publishes.
async fn report(
    client: &AsyncClient,
    names: &Names,
    flight: &RefCell<Flight>,
    state: &'static str,
) -> Result<()> {
    flight.borrow_mut().entries.push_back(None);
    Ok(client
        .publish(names.status(), QoS::AtLeastOnce, true, state)
        .await?)
}

/// Publishes what waits, and at the end waits for the acknowledgements.
async fn deliver(
    client: &AsyncClient,
    queue: &Queue,
    names: &Names,
    flight: &RefCell<Flight>,
) -> Result<()> {
    report(client, names, flight, ONLINE).await?;
    for finger in 0..names.fingers.len() {
        for topic in Topic::ALL {
            flight.borrow_mut().entries.push_back(None);
            let path = format!("{}/schema", names.path(finger, topic));
            client
                .publish(
                    path,
                    QoS::AtLeastOnce,
                    true,
                    schema::json(topic).to_string(),
                )
                .await?;
        }
    }
    while let Some(queued) = queue.next().await {
        let (topic, path) = (
            queued.message.topic,
            names.path(queued.message.finger, queued.message.topic),
        );
        let quality = if topic == Topic::Frames {
            QoS::AtMostOnce
        } else {
            QoS::AtLeastOnce
        };
        let json = queued.message.json.clone();
        flight.borrow_mut().entries.push_back(Some(queued));
        // A subscriber gets the latest state at once.
        client
            .publish(path, quality, topic == Topic::Health, json)
            .await?;
    }
    // Its acknowledgement confirms all frames before it.
    report(client, names, flight, OFFLINE).await?;
    let all_confirmed = async {
        while !flight.borrow().entries.is_empty() {
            sleep(Duration::from_millis(10)).await;
        }
    };
    // What is not confirmed by then is counted.
    let _ = timeout(LAST, all_confirmed).await;
    // The connection's end is what this ends with.
    Ok(client.disconnect().await?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn addresses_of_brokers_are_read() {
        let read = |url: &str| Mqtt::new(url).map(|mqtt| (mqtt.host, mqtt.port, mqtt.login));
        assert_eq!(
            read("mqtt://robot.local").unwrap(),
            ("robot.local".into(), 1883, None)
        );
        let login = Some(("me".to_owned(), "a@b".to_owned()));
        assert_eq!(
            read("mqtt://me:a@b@10.0.0.2:2883/").unwrap(),
            ("10.0.0.2".into(), 2883, login)
        );
        assert_eq!(read("mqtt://[::1]").unwrap().0, "[::1]");
        for wrong in [
            "http://x",
            "mqtts://x",
            "mqtt://",
            "mqtt://x:port",
            "mqtt://me@x",
            "mqtt://x/y",
        ] {
            let error = read(wrong).unwrap_err();
            assert!(
                error.is::<UsageError>() && error.to_string().starts_with(wrong),
                "{error}"
            );
        }
    }
}
