//! Lists the programs that use a serial port, if the system shows them.

use super::list::Found;
use serde::Serialize;
use std::fmt;
use std::path::Path;

/// A port with its users.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Listed {
    #[serde(flatten)]
    pub port: Found,
    /// Programs that have it open, such as `minicom (process 4711)`.
    pub used_by: Vec<String>,
}

impl From<Found> for Listed {
    fn from(port: Found) -> Self {
        let used_by = users(&port.name);
        Self { port, used_by }
    }
}

impl fmt::Display for Listed {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.port)?;
        match self.used_by.as_slice() {
            [] => Ok(()),
            users => write!(f, ", in use by {}", users.join(", ")),
        }
    }
}

/// Returns the programs that have a file open. Linux lists only the user's own programs, except for
/// root; on other systems the list is empty.
pub fn users(name: &str) -> Vec<String> {
    let Ok(path) = std::fs::canonicalize(name) else {
        return Vec::new();
    };
    let entries = |path: &Path| std::fs::read_dir(path).into_iter().flatten().flatten();
    let mut found = Vec::new();
    for process in entries(Path::new("/proc")) {
        let Some(number) = process
            .file_name()
            .to_str()
            .and_then(|n| n.parse::<u32>().ok())
        else {
            continue;
        };
        let is_it =
            |file: std::fs::DirEntry| std::fs::read_link(file.path()).is_ok_and(|to| to == path);
        if entries(&process.path().join("fd")).any(is_it) {
            let program = std::fs::read_to_string(process.path().join("comm")).unwrap_or_default();
            found.push(format!("{} (process {number})", program.trim()));
        }
    }
    found
}

/// Turns a failure to open a port into an error that says what to do.
pub fn in_words(name: &str, error: serialport::Error) -> std::io::Error {
    let error = std::io::Error::from(error);
    let text = error.to_string();
    let words = match text.as_str() {
        text if text.contains("exclusive lock") || text.contains("busy") => match users(name)[..] {
            [] => "in use by another program: close it there first".to_owned(),
            ref users => format!("in use by {}: close it there first", users.join(", ")),
        },
        text if text.contains("typewriter") => {
            "no serial port; `ridgetone ports` lists those of this computer".to_owned()
        }
        _ => return error,
    };
    std::io::Error::new(error.kind(), words)
}
