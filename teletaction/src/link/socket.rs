//! Connection to the other end on a different computer: one message per UDP datagram.

use anyhow::{Context, Result};
use std::io::ErrorKind;
use std::net::{SocketAddr, ToSocketAddrs, UdpSocket};

/// Errors that count as loss: nobody listens at the peer, which Windows reports as a reset, or
/// nothing has arrived.
const NOTHING: [ErrorKind; 4] = [
    ErrorKind::WouldBlock,
    ErrorKind::ConnectionRefused,
    ErrorKind::ConnectionReset,
    ErrorKind::Interrupted,
];

/// Maximum length of a datagram, bytes. On Windows, a datagram longer than the buffer is an error,
/// and anybody may send one.
const LONGEST: usize = 65_536;

pub struct Socket {
    socket: UdpSocket,
    /// Destination of messages; the stylus' end becomes known with its first message.
    peer: Option<SocketAddr>,
}

impl Socket {
    /// Connects to the finger's end at HOST:PORT.
    pub fn to(address: &str) -> Result<Self> {
        let named = || format!("{address}: write HOST:PORT, such as robot.local:7450");
        let peer = address
            .to_socket_addrs()
            .with_context(named)?
            .next()
            .with_context(named)?;
        let here = if peer.is_ipv4() {
            "0.0.0.0:0"
        } else {
            "[::]:0"
        };
        Self::bound(UdpSocket::bind(here).with_context(named)?, Some(peer))
    }

    /// Listens for a stylus at a local address.
    pub fn at(address: &str) -> Result<Self> {
        let named =
            || format!("{address}: write ADDRESS:PORT of this computer, such as 0.0.0.0:7450");
        Self::bound(UdpSocket::bind(address).with_context(named)?, None)
    }

    fn bound(socket: UdpSocket, peer: Option<SocketAddr>) -> Result<Self> {
        socket.set_nonblocking(true)?;
        Ok(Self { socket, peer })
    }

    pub fn address(&self) -> Result<SocketAddr> {
        Ok(self.socket.local_addr()?)
    }

    /// Sends to the peer, if known. Data that the system cannot send count as lost.
    pub fn send(&self, bytes: &[u8]) {
        if let Some(peer) = self.peer {
            let _ = self.socket.send_to(bytes, peer);
        }
    }

    /// Returns the next datagram and its origin.
    pub fn receive(&self) -> Result<Option<(Vec<u8>, SocketAddr)>> {
        let mut bytes = vec![0; LONGEST];
        match self.socket.recv_from(&mut bytes) {
            Ok((length, from)) => Ok(Some((bytes[..length].to_vec(), from))),
            Err(error) if NOTHING.contains(&error.kind()) => Ok(None),
            Err(error) => Err(error).context("the network"),
        }
    }

    /// Sends future messages to `from`, which has sent a valid message.
    pub fn answer(&mut self, from: SocketAddr) {
        self.peer = Some(from);
    }
}
