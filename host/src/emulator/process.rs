//! The emulator as a child process in a directory of its own, and the pipes to it.

use anyhow::{Context, Result, bail};
use rustix::fs::{Mode, OFlags, fcntl_getfl, fcntl_setfl};
use std::fs::File;
use std::io::{ErrorKind, Write};
use std::os::fd::OwnedFd;
use std::path::Path;
use std::process::{Child, ChildStdin, Command, ExitStatus, Stdio};
use tempfile::TempDir;

pub const QEMU: &str = "qemu-system-arm";

/// Records from the board.
pub const REQUESTS: usize = 0;
/// The board's third serial port.
pub const SERIAL: usize = 1;
/// The emulator's standard error.
pub const MESSAGES: usize = 2;

/// A running emulator. Dropped, it is killed and its directory removed.
pub struct Emulator {
    child: Child,
    directory: Option<TempDir>,
    /// Pipes from the emulator, by [`REQUESTS`], [`SERIAL`], [`MESSAGES`] and the rest, the board's
    /// log.
    pub pipes: [File; 4],
    reply: File,
    /// To the board's third serial port.
    line: ChildStdin,
    /// Bytes that the line did not accept yet.
    unsent: Vec<u8>,
}

/// Starts QEMU on an image, whose path must be absolute, in a directory with the image's files. Its
/// standard input and output are `stdio`, its standard error is a pipe.
pub fn qemu(
    image: &Path,
    directory: &Path,
    icount: &str,
    ports: &[&str],
    stdio: fn() -> Stdio,
) -> Result<Child> {
    let spawned = Command::new(QEMU)
        .args(["-machine", "netduinoplus2", "-icount", icount])
        .args(["-display", "none", "-monitor", "none"])
        .args(["-semihosting-config", "enable=on,target=native"])
        .args(ports.iter().flat_map(|port| ["-serial", port]))
        .arg("-kernel")
        .arg(image)
        .current_dir(directory)
        .stdin(stdio())
        .stdout(stdio())
        .stderr(Stdio::piped())
        .spawn();
    match spawned {
        Err(error) if error.kind() == ErrorKind::NotFound => {
            bail!(
                "{QEMU} is not installed: `cargo xtask setup` installs it (Debian: apt-get install qemu-system-arm)"
            )
        }
        spawned => spawned.context(QEMU),
    }
}

impl Emulator {
    /// Starts the emulator on an image, whose path must be absolute. An instruction takes
    /// 2^`icount_shift` ns.
    pub fn start(image: &Path, icount_shift: u8) -> Result<Self> {
        let directory = tempfile::Builder::new()
            .prefix("ridgetone-")
            .tempdir()
            .context("a temporary directory")?;
        let request = fifo(&directory.path().join("spi.request"))?;
        let reply = fifo(&directory.path().join("spi.reply"))?;
        let log = fifo(&directory.path().join("defmt.log"))?;
        let icount = format!("shift={icount_shift},sleep=off");
        let mut child = qemu(
            image,
            directory.path(),
            &icount,
            &["null", "null", "stdio"],
            Stdio::piped,
        )?;
        let (Some(line), Some(serial), Some(messages)) =
            (child.stdin.take(), child.stdout.take(), child.stderr.take())
        else {
            bail!("{QEMU}: no pipes");
        };
        // A board that does not read must not block the loop that serves it.
        let flags = fcntl_getfl(&line).context("the line to the emulated board")?;
        fcntl_setfl(&line, flags | OFlags::NONBLOCK).context("the line to the emulated board")?;
        let pipes = [
            request,
            OwnedFd::from(serial).into(),
            OwnedFd::from(messages).into(),
            log,
        ];
        Ok(Self {
            child,
            directory: Some(directory),
            pipes,
            reply,
            line,
            unsent: Vec::new(),
        })
    }

    /// Removes the directory once both ends of the bridge are open: nothing is left behind even if
    /// this program is killed.
    pub fn connected(&mut self) {
        self.directory = None;
    }

    pub fn reply(&mut self, bytes: &[u8]) -> Result<()> {
        self.reply
            .write_all(bytes)
            .context("the bridge to the emulated board")
    }

    /// Sends bytes to the board's serial port; bytes that it does not accept now go with the next
    /// call.
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

/// Makes a FIFO and opens it for both directions, which never blocks, whatever happens at the other
/// end.
fn fifo(path: &Path) -> Result<File> {
    let named = || path.display().to_string();
    make_fifo(path).with_context(named)?;
    let flags = OFlags::RDWR | OFlags::NONBLOCK | OFlags::CLOEXEC;
    Ok(File::from(
        rustix::fs::open(path, flags, Mode::empty()).with_context(named)?,
    ))
}

#[cfg(target_os = "linux")]
fn make_fifo(path: &Path) -> Result<()> {
    Ok(rustix::fs::mkfifoat(
        rustix::fs::CWD,
        path,
        Mode::RUSR | Mode::WUSR,
    )?)
}

/// By the program: rustix has no call for macOS.
#[cfg(not(target_os = "linux"))]
fn make_fifo(path: &Path) -> Result<()> {
    let made = Command::new("mkfifo")
        .args(["-m", "600"])
        .arg(path)
        .status()
        .context("mkfifo")?;
    anyhow::ensure!(made.success(), "mkfifo failed");
    Ok(())
}
