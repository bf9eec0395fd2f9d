//! Writes files either completely or not at all.

use crate::recording;
use anyhow::{Context, Result, bail};
use std::fs::{File, FileType};
use std::io::{BufWriter, ErrorKind, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};

/// True if existing files may be replaced (`--force`).
static IS_FORCED: AtomicBool = AtomicBool::new(false);

/// Allows existing files to be replaced from now on.
pub fn force() {
    IS_FORCED.store(true, Ordering::Relaxed);
}

/// Target of a path, after following symbolic links.
enum Target {
    /// `-`.
    StandardOutput,
    /// Path at which there is no file yet.
    New,
    /// Regular file, with links resolved, so that replacing the file keeps a link to it.
    Regular(PathBuf),
    /// Device or pipe, which is written to directly.
    Stream,
}

impl Target {
    fn of(path: &Path) -> Result<Self> {
        let named = || path.display().to_string();
        if path == Path::new("-") {
            return Ok(Self::StandardOutput);
        }
        let kind = match path.metadata() {
            Ok(metadata) => metadata.file_type(),
            Err(error) if error.kind() == ErrorKind::NotFound => {
                let folder = folder(path);
                if !folder.is_dir() {
                    bail!("{}: there is no folder {}", named(), folder.display());
                }
                return Ok(Self::New);
            }
            Err(error) => return Err(error).with_context(named),
        };
        if kind.is_file() {
            Ok(Self::Regular(path.canonicalize().with_context(named)?))
        } else if kind.is_dir() {
            bail!("{}: that is a folder: name a file in it", named())
        } else if is_socket(kind) {
            bail!(
                "{}: that is a socket, which is not written to: choose another name",
                named()
            )
        } else {
            Ok(Self::Stream)
        }
    }
}

#[cfg(unix)]
fn is_socket(kind: FileType) -> bool {
    std::os::unix::fs::FileTypeExt::is_socket(&kind)
}

#[cfg(not(unix))]
fn is_socket(_: FileType) -> bool {
    false
}

fn folder(path: &Path) -> &Path {
    match path.parent() {
        Some(parent) if parent != Path::new("") => parent,
        _ => Path::new("."),
    }
}

/// Fails if the path cannot be written: a folder, a socket, or an existing file unless [`force`]
/// was called. Call this before a long computation whose result goes to the file.
pub fn check_new(path: &Path) -> Result<()> {
    let Target::Regular(file) = Target::of(path)? else {
        return Ok(());
    };
    let is_forced = IS_FORCED.load(Ordering::Relaxed);
    if is_forced && !recording::is_telemetry(&file).unwrap_or(false) {
        return Ok(());
    }
    let way_out = if is_forced { "" } else { ", or add --force" };
    bail!(
        "{}: this file exists already and is not overwritten: choose another name{way_out}",
        path.display()
    )
}

/// Writes a complete file; replaces an existing one only if [`force`] was called. Devices and pipes
/// are written to directly, and `-` is standard output. All errors, also those of `write`, name
/// the file.
pub fn new_file(path: &Path, write: impl FnOnce(&mut dyn Write) -> Result<()>) -> Result<()> {
    check_new(path)?;
    whole_file(path, write)
}

pub fn new_text(path: &Path, text: &str) -> Result<()> {
    new_file(path, |file| Ok(file.write_all(text.as_bytes())?))
}

/// Like [`new_file`], but replaces an existing file. A recording of telemetry is never replaced,
/// because it cannot be made again.
pub fn whole_file(path: &Path, write: impl FnOnce(&mut dyn Write) -> Result<()>) -> Result<()> {
    let named = || path.display().to_string();
    match Target::of(path)? {
        Target::StandardOutput => {
            stream(std::io::stdout().lock(), write).context("standard output")
        }
        Target::Stream => File::options()
            .write(true)
            .open(path)
            .map_err(Into::into)
            .and_then(|file| stream(file, write))
            .with_context(named),
        Target::New => replace(path, write).with_context(named),
        Target::Regular(file) if recording::is_telemetry(&file).unwrap_or(false) => bail!(
            "{}: that is a recording of telemetry, which is not overwritten: choose another name",
            named()
        ),
        Target::Regular(file) => replace(&file, write).with_context(named),
    }
}

pub fn whole_text(path: &Path, text: &str) -> Result<()> {
    whole_file(path, |file| Ok(file.write_all(text.as_bytes())?))
}

fn stream(out: impl Write, write: impl FnOnce(&mut dyn Write) -> Result<()>) -> Result<()> {
    let mut writer = BufWriter::new(out);
    write(&mut writer)?;
    Ok(writer.flush()?)
}

/// Writes a temporary file in the same folder and renames it, so that the file is never incomplete.
fn replace(path: &Path, write: impl FnOnce(&mut dyn Write) -> Result<()>) -> Result<()> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(".ridgetone-");
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        // Same permissions as any new file, subject to the process's umask.
        builder.permissions(std::fs::Permissions::from_mode(0o666));
    }
    // Keep only the kind of the error: its text would name the temporary file.
    let mut file = builder
        .tempfile_in(folder(path))
        .map_err(|error| std::io::Error::from(error.kind()))?;
    stream(file.as_file_mut(), write)?;
    file.persist(path).map_err(|error| error.error)?;
    Ok(())
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;
    use std::os::unix::fs::{FileTypeExt, symlink};
    use std::os::unix::net::UnixListener;
    use std::process::Command;

    const TEXT: &str = "one\ntwo\n";

    fn kind(path: &Path) -> FileType {
        path.symlink_metadata().expect("there").file_type()
    }

    #[test]
    fn a_pipe_is_written_to_and_stays_a_pipe() {
        let folder = tempfile::tempdir().expect("a folder");
        let pipe = folder.path().join("pipe");
        let made = Command::new("mkfifo").arg(&pipe).status().expect("mkfifo");
        assert!(made.success());
        let reader = std::thread::spawn({
            let pipe = pipe.clone();
            move || std::fs::read_to_string(pipe).expect("text")
        });
        new_text(&pipe, TEXT).expect("written");
        assert_eq!(reader.join().expect("read"), TEXT);
        assert!(kind(&pipe).is_fifo());
    }

    #[test]
    fn a_device_is_written_to_and_stays_a_device() {
        // Write through a link, so that a bug would replace the link and not `/dev/null` itself.
        let folder = tempfile::tempdir().expect("a folder");
        let null = folder.path().join("null");
        symlink("/dev/null", &null).expect("a link");
        new_text(&null, TEXT).expect("written");
        assert!(kind(&null).is_symlink());
        let kind = null.metadata().expect("a device").file_type();
        assert!(kind.is_char_device());
    }

    #[test]
    fn a_socket_and_a_folder_are_refused_by_name() {
        let folder = tempfile::tempdir().expect("a folder");
        let socket = folder.path().join("socket");
        let _listener = UnixListener::bind(&socket).expect("a socket");
        for (path, word) in [(socket.as_path(), "socket"), (folder.path(), "folder")] {
            for refused in [check_new(path), whole_text(path, TEXT)] {
                let message = format!("{:#}", refused.expect_err("refused"));
                assert!(message.contains(word), "{message}");
            }
        }
        assert!(kind(&socket).is_socket());
    }

    #[test]
    fn what_a_link_leads_to_is_replaced_and_not_the_link() {
        let folder = tempfile::tempdir().expect("a folder");
        let (file, link) = (folder.path().join("file"), folder.path().join("link"));
        std::fs::write(&file, "before").expect("written");
        symlink(&file, &link).expect("a link");
        whole_text(&link, TEXT).expect("written");
        assert!(kind(&link).is_symlink());
        assert_eq!(std::fs::read_to_string(&file).expect("text"), TEXT);
    }

    #[test]
    fn no_message_has_a_temporary_name() {
        let path = Path::new("/nonexistent/x.csv");
        let message = format!("{:#}", whole_text(path, TEXT).expect_err("no folder"));
        assert_eq!(
            message,
            "/nonexistent/x.csv: there is no folder /nonexistent"
        );
    }
}
