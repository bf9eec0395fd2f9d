//! MQTT 5: frames with QoS 0, all other messages with QoS 1. A broker retains the latest states of
//! the fingers, a status with totals, and the schemas next to the topics. Each connection publishes
//! these messages again, because the broker may have restarted and lost them.
//!
//! A session ends with its connection; events that the broker has not acknowledged are then queued
//! again. A broker acknowledges in the order of publication (MQTT 5.0, 4.6): frames before an
//! acknowledged event have arrived, and frames after the last such event are counted as not
//! confirmed.

mod flight;
mod totals;

use super::message::{Latest, Message};
use super::queue::{Queue, Queued, Sink};
use super::schema;
use super::topic::{Names, Topic};
use crate::note;
use crate::usage::UsageError;
use crate::utc::Receipt;
use anyhow::{Error, Result};
use flight::Flight;
use rumqttc::v5::mqttbytes::QoS;
use rumqttc::v5::mqttbytes::v5::LastWill;
use rumqttc::v5::{AsyncClient, Event, EventLoop, Incoming, MqttOptions};
use rumqttc::{NetworkOptions, Outgoing};
use std::cell::RefCell;
use std::sync::Arc;
use std::time::Duration;
use tokio::sync::Notify;
use tokio::time::{Instant, sleep, timeout, timeout_at};
use totals::{Publishes, Totals};

/// The port of MQTT without TLS.
const PORT: u16 = 1883;

/// Interval between pings. The connection is dropped if the broker is silent for twice this time.
const PING: Duration = Duration::from_secs(5);

/// Time between two attempts to connect.
const AGAIN: Duration = Duration::from_secs(1);

/// Maximum number of messages between the queue and the connection.
const CHANNEL: usize = 64;

/// Maximum number of unacknowledged events; a broker may allow fewer.
const UNACKNOWLEDGED_MAX: u16 = 256;

/// Delay before messages that waited for a broker are published. Subscribers need this time to
/// reconnect; otherwise they would silently miss these messages.
const PAUSE: Duration = Duration::from_secs(2);

/// Interval between two statuses.
const STATUS_EVERY: Duration = Duration::from_secs(1);

/// Status that the broker publishes if the connection breaks.
const OFFLINE: &str = r#"{"state":"offline"}"#;

/// Time to wait at the end for the broker's last acknowledgements.
const LAST: Duration = Duration::from_secs(2);

pub struct Mqtt {
    host: String,
    port: u16,
    login: Option<(String, String)>,
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
            let mut publishing = Publishing {
                queue,
                names,
                latest: Latest::default(),
                totals: Totals::new(names.fingers.len()),
                has_waited: false,
            };
            let mut reported = String::new();
            while let Err(error) = self.session(&mut publishing).await {
                publishing.has_waited = true;
                let why = error.to_string();
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
        // The client identifier must be unique on a broker.
        let client = format!("ridgetone-{:x}", Receipt::now(0.0).utc_ns);
        let mut options = MqttOptions::new(client, &self.host, self.port);
        options
            .set_keep_alive(PING)
            .set_clean_start(true)
            .set_outgoing_inflight_upper_limit(UNACKNOWLEDGED_MAX);
        // With Nagle's algorithm a frame would wait up to 40 ms for the last acknowledgement.
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
    async fn session(&self, publishing: &mut Publishing<'_>) -> Result<()> {
        let (client, mut events) = AsyncClient::new(self.options(publishing.names), CHANNEL);
        let (flight, connected) = (RefCell::new(Flight::default()), Notify::new());
        let connection = Connection {
            client: &client,
            flight: &flight,
        };
        let ended = tokio::select! {
            why = self.poll(&mut events, &flight, &connected) => Err(why),
            done = async {
                connected.notified().await;
                publishing.deliver(&connection).await
            } => done,
        };
        if ended.is_ok() {
            // Sends the disconnect packet and waits until the broker closes the connection.
            let _ = timeout(LAST, self.poll(&mut events, &flight, &connected)).await;
        }
        publishing.put_back(flight.into_inner());
        ended
    }

    /// Drives the connection until it breaks, and returns the reason.
    async fn poll(
        &self,
        events: &mut EventLoop,
        flight: &RefCell<Flight>,
        connected: &Notify,
    ) -> Error {
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
                // Pass on only the text, which already includes the sources of the error.
                Ok(Err(error)) => return Error::msg(error.to_string()),
                Err(_) => return Error::msg("the broker does not answer"),
            }
        }
    }
}

/// A session's connection, and the messages that it has not confirmed.
struct Connection<'a> {
    client: &'a AsyncClient,
    flight: &'a RefCell<Flight>,
}

impl Connection<'_> {
    /// Publishes a retained message; the next session publishes it again.
    async fn retain(&self, topic: String, text: String) -> Result<()> {
        self.flight.borrow_mut().entries.push_back(None);
        let quality = QoS::AtLeastOnce;
        Ok(self.client.publish(topic, quality, true, text).await?)
    }
}

/// State of publishing that outlasts a session.
struct Publishing<'a> {
    queue: &'a Queue,
    names: &'a Names,
    latest: Latest,
    totals: Totals,
    /// True if messages have waited for a broker.
    has_waited: bool,
}

impl Publishing<'_> {
    /// Publishes messages until there are no more, then waits for their acknowledgements.
    async fn deliver(&mut self, connection: &Connection<'_>) -> Result<()> {
        self.retain_again(connection).await?;
        self.pause().await;
        let (mut stated, mut due) = (String::new(), Instant::now() + STATUS_EVERY);
        loop {
            match timeout_at(due, self.queue.next()).await {
                Ok(Some(queued)) => self.publish(connection, queued).await?,
                Ok(None) => break,
                Err(_) => {}
            }
            let status = (Instant::now() >= due).then(|| self.status(Publishes::Online));
            if let Some(status) = status {
                due = Instant::now() + STATUS_EVERY;
                if status != stated {
                    stated.clone_from(&status);
                    connection.retain(self.names.status(), status).await?;
                }
            }
        }
        // The acknowledgement of this status confirms all earlier frames.
        let status = self.status(Publishes::Offline);
        connection.retain(self.names.status(), status).await?;
        let all_confirmed = async {
            while !connection.flight.borrow().entries.is_empty() {
                sleep(Duration::from_millis(10)).await;
            }
        };
        // Frames not confirmed within this time are counted.
        let _ = timeout(LAST, all_confirmed).await;
        // The future ends when the connection does.
        Ok(connection.client.disconnect().await?)
    }

    async fn retain_again(&self, connection: &Connection<'_>) -> Result<()> {
        let status = self.status(Publishes::Online);
        connection.retain(self.names.status(), status).await?;
        for finger in 0..self.names.fingers.len() {
            for topic in Topic::ALL {
                let path = format!("{}/schema", self.names.path(finger, topic));
                let schema = schema::json(topic).to_string();
                connection.retain(path, schema).await?;
            }
        }
        for message in self.latest.all() {
            let path = self.path(message);
            connection.retain(path, message.json.clone()).await?;
        }
        Ok(())
    }

    /// Gives subscribers time to reconnect, if messages have waited for the broker.
    async fn pause(&self) {
        let until = Instant::now() + PAUSE;
        while self.has_waited && !self.queue.is_closed() && Instant::now() < until {
            sleep(Duration::from_millis(20)).await;
        }
    }

    async fn publish(&mut self, connection: &Connection<'_>, queued: Queued) -> Result<()> {
        let message = Arc::clone(&queued.message);
        self.latest.take(&message);
        self.totals.publish(&message);
        let quality = match message.topic {
            Topic::Frames => QoS::AtMostOnce,
            _ => QoS::AtLeastOnce,
        };
        connection
            .flight
            .borrow_mut()
            .entries
            .push_back(Some(queued));
        let (path, json) = (self.path(&message), message.json.clone());
        let client = connection.client;
        // States are retained, so that a new subscriber gets them at once.
        Ok(client
            .publish(path, quality, message.is_state, json)
            .await?)
    }

    /// Puts unconfirmed messages back into the queue, or counts them as lost.
    fn put_back(&mut self, flight: Flight) {
        let unconfirmed = flight.entries.into_iter().flatten();
        self.queue.put_back(unconfirmed.inspect(|queued| {
            if queued.message.topic != Topic::Frames {
                self.totals.take_back(&queued.message);
            }
        }));
    }

    fn status(&self, state: Publishes) -> String {
        let lost = self.queue.losses();
        self.totals.status(state, self.names, &lost)
    }

    fn path(&self, message: &Message) -> String {
        self.names.path(message.finger, message.topic)
    }
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
