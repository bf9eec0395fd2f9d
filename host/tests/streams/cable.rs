//! A cable between a board and the name of its port: it can be pulled, and damages a byte on demand.

use crate::serial_board::raw_end;
use rustix::fs::{OFlags, fcntl_setfl};
use std::fs::File;
use std::io::{Read, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};
use std::thread::sleep;
use std::time::Duration;

#[derive(Default)]
struct Shared {
    is_pulled: AtomicBool,
    damages: AtomicBool,
    ends: AtomicBool,
}

pub struct Cable {
    /// Name of the port.
    pub path: PathBuf,
    shared: Arc<Shared>,
}

impl Cable {
    /// From a board's line to a port of this name.
    pub fn new(board: &str, path: PathBuf) -> Self {
        let mut line = File::options();
        let board = line.read(true).write(true).open(board).expect("a line");
        fcntl_setfl(&board, OFlags::NONBLOCK).expect("a line that never waits");
        let shared = Arc::new(Shared::default());
        let (at, with) = (path.clone(), Arc::clone(&shared));
        let plugged = plug(&at);
        std::thread::spawn(move || pass(board, plugged, &at, &with));
        Self { path, shared }
    }

    /// Pulls it, so that the port is gone, or plugs it in again; the board goes on.
    pub fn pull(&self, is_pulled: bool) {
        self.shared.is_pulled.store(is_pulled, Relaxed);
    }

    /// Damages the next byte.
    pub fn damage(&self) {
        self.shared.damages.store(true, Relaxed);
    }
}

impl Drop for Cable {
    fn drop(&mut self) {
        self.shared.ends.store(true, Relaxed);
    }
}

/// A new port under a name.
fn plug(path: &Path) -> File {
    let (end, name) = raw_end();
    fcntl_setfl(&end, OFlags::NONBLOCK).expect("a line that never waits");
    let _ = std::fs::remove_file(path);
    std::os::unix::fs::symlink(name, path).expect("a name");
    end
}

fn pass(mut board: File, plugged: File, path: &Path, shared: &Shared) {
    let (mut port, mut bytes) = (Some(plugged), [0; 4096]);
    while !shared.ends.load(Relaxed) {
        match (shared.is_pulled.load(Relaxed), &port) {
            (true, Some(_)) => {
                // Before the terminal is closed: the next one that anybody opens may have its number.
                let _ = std::fs::remove_file(path);
                port = None;
            }
            (false, None) => port = Some(plug(path)),
            _ => {}
        }
        let sent = board.read(&mut bytes).unwrap_or(0);
        if let (1.., Some(port)) = (sent, &mut port) {
            if shared.damages.swap(false, Relaxed) {
                bytes[sent / 2] ^= 0x55;
            }
            // What does not fit, since nobody reads, is lost as on a real line.
            let _ = port.write_all(&bytes[..sent]);
        }
        let asked = port
            .as_mut()
            .map_or(0, |port| port.read(&mut bytes).unwrap_or(0));
        let _ = board.write_all(&bytes[..asked]);
        if sent + asked == 0 {
            sleep(Duration::from_millis(1));
        }
    }
}
