//! The emulator as a child process in a directory of its own, and the pipes to it.

use anyhow::{Context, Result, bail};
use rustix::fs::{CWD, Mode, OFlags, fcntl_getfl, fcntl_setfl};
use std::fs::File;
use std::io::{ErrorKind, Write};
use std::path::Path;
use std::process::{Child, ChildStderr, ChildStdin, ChildStdout, Command, ExitStatus, Stdio};
use tempfile::TempDir;

/// The emulator's program.
pub const QEMU: &str = "qemu-system-arm";

/// A running emulator. Dropped, it is killed and its directory removed.
pub struct Emulator {
    child: Child,
    directory: Option<TempDir>,
    /// Records from the board.
    pub request: File,
    reply: File,
    /// The board's log.
    pub log: File,
    /// To the board's third serial port.
    line: ChildStdin,
    /// Bytes that the line did not accept yet.
    unsent: Vec<u8>,
    /// From the board's third serial port.
    pub serial: ChildStdout,
    /// The emulator's standard error.
    pub messages: ChildStderr,
}

impl Emulator {
    /// Starts the emulator on an image, whose path must be absolute. An instruction takes 2^`icount_shift` ns.
    pub fn start(image: &Path, icount_shift: u8) -> Result<Self> {
        let directory = tempfile::Builder::new().prefix("ridgetone-").tempdir().context("a temporary directory")?;
        let request = fifo(&directory.path().join("spi.request"))?;
        let reply = fifo(&directory.path().join("spi.reply"))?;
        let log = fifo(&directory.path().join("defmt.log"))?;
        let spawned = Command::new(QEMU)
            .args(["-machine", "netduinoplus2", "-icount", &format!("shift={icount_shift},sleep=off")])
            .args(["-display", "none", "-monitor", "none"])
            .args(["-semihosting-config", "enable=on,target=native"])
            .args(["-serial", "null", "-serial", "null", "-serial", "stdio", "-kernel"])
            .arg(image)
            .current_dir(directory.path())
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn();
        let mut child = match spawned {
            Ok(child) => child,
            Err(error) if error.kind() == ErrorKind::NotFound => {
                bail!(
                    "{QEMU} is not installed: `cargo xtask setup` installs it (Debian: apt-get install qemu-system-arm)"
                )
            }
            Err(error) => return Err(error).context(QEMU),
        };
        let (Some(line), Some(serial), Some(messages)) = (child.stdin.take(), child.stdout.take(), child.stderr.take())
        else {
            bail!("{QEMU}: no pipes");
        };
        // A board that does not read must not block the loop that serves it.
        let flags = fcntl_getfl(&line).context("the line to the emulated board")?;
        fcntl_setfl(&line, flags | OFlags::NONBLOCK).context("the line to the emulated board")?;
        let directory = Some(directory);
        Ok(Self { child, directory, request, reply, log, line, unsent: Vec::new(), serial, messages })
    }

    /// Removes the directory once both ends of the bridge are open: nothing is left behind even if this program is killed.
    pub fn connected(&mut self) {
        self.directory = None;
    }

    /// Sends a reply.
    pub fn reply(&mut self, bytes: &[u8]) -> Result<()> {
        self.reply.write_all(bytes).context("the bridge to the emulated board")
    }

    /// Sends bytes to the board's serial port; bytes that it does not accept now go with the next call.
    pub fn send(&mut self, bytes: &[u8]) -> Result<()> {
        self.unsent.extend_from_slice(bytes);
        while !self.unsent.is_empty() {
            match self.line.write(&self.unsent) {
                Ok(sent) => drop(self.unsent.drain(..sent)),
                Err(error) if error.kind() == ErrorKind::WouldBlock => break,
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                Err(error) if error.kind() == ErrorKind::BrokenPipe => self.unsent.clear(),
                Err(error) => return Err(error).context("the line to the emulated board"),
            }
        }
        Ok(())
    }

    /// The emulator's exit status, if it has ended.
    pub fn exit_status(&mut self) -> Result<Option<ExitStatus>> {
        self.child.try_wait().context(QEMU)
    }
}

impl Drop for Emulator {
    fn drop(&mut self) {
        // Both fail only after its end.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// Makes a FIFO and opens it for both directions, which never blocks, whatever happens at the other end.
fn fifo(path: &Path) -> Result<File> {
    let named = || path.display().to_string();
    rustix::fs::mkfifoat(CWD, path, Mode::RUSR | Mode::WUSR).with_context(named)?;
    let flags = OFlags::RDWR | OFlags::NONBLOCK | OFlags::CLOEXEC;
    Ok(File::from(rustix::fs::open(path, flags, Mode::empty()).with_context(named)?))
}
