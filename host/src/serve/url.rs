//! The messages that `ridgetone view` serves, of this computer or of another one.

use crate::usage::UsageError;
use anyhow::{Context, Result, bail, ensure};
use std::io::{BufRead, BufReader, ErrorKind, Write};
use std::net::{TcpStream, ToSocketAddrs};
use std::time::Duration;

/// Longest wait for a connection.
const CONNECT: Duration = Duration::from_secs(5);

/// Longest wait for a part of a line.
const LOOK: Duration = Duration::from_millis(50);

/// Where a page serves its messages.
const PATH: &str = "/packets";

/// Lines of JSON.
pub struct Lines {
    reader: BufReader<TcpStream>,
    partial: Vec<u8>,
}

/// The host and the port of `http://HOST:PORT`.
pub fn host(url: &str) -> Result<&str> {
    let host = url
        .strip_prefix("http://")
        .map(|rest| rest.trim_end_matches('/'));
    match host.filter(|host| {
        !host.contains('/')
            && host
                .rsplit_once(':')
                .is_some_and(|(_, port)| port.parse::<u16>().is_ok())
    }) {
        Some(host) => Ok(host),
        None => Err(UsageError(format!(
            "{url}: write http://HOST:PORT, the address of `ridgetone view`"
        ))
        .into()),
    }
}

impl Lines {
    pub fn open(url: &str) -> Result<Self> {
        let host = host(url)?;
        let named = || format!("{url}: is `ridgetone view` running there?");
        let address = host
            .to_socket_addrs()
            .with_context(named)?
            .next()
            .with_context(named)?;
        let mut stream = TcpStream::connect_timeout(&address, CONNECT).with_context(named)?;
        stream.set_read_timeout(Some(CONNECT))?;
        // A server sends the answer to version 1.0 as it is, without chunks.
        stream.write_all(format!("GET {PATH} HTTP/1.0\r\nHost: {host}\r\n\r\n").as_bytes())?;
        let mut reader = BufReader::new(stream);
        let (mut status, mut header) = (String::new(), String::new());
        reader.read_line(&mut status).with_context(named)?;
        ensure!(
            status.split(' ').nth(1) == Some("200"),
            "{url}: answers {:?} to {PATH}",
            status.trim()
        );
        while reader.read_line(&mut header).with_context(named)? > 2 {
            header.clear();
        }
        reader.get_ref().set_read_timeout(Some(LOOK))?;
        Ok(Self {
            reader,
            partial: Vec::new(),
        })
    }

    /// Waits a moment for the next line.
    /// Fails if the connection ends.
    pub fn next(&mut self) -> Result<Option<String>> {
        match self.reader.read_until(b'\n', &mut self.partial) {
            Ok(_) if self.partial.ends_with(b"\n") => Ok(Some(
                String::from_utf8(std::mem::take(&mut self.partial)).context("a line")?,
            )),
            Ok(_) => bail!("the page has closed the connection"),
            Err(error)
                if matches!(
                    error.kind(),
                    ErrorKind::WouldBlock | ErrorKind::TimedOut | ErrorKind::Interrupted
                ) =>
            {
                Ok(None)
            }
            Err(error) => Err(error).context("the page"),
        }
    }
}
