//! Says where the page is: its URL, a QR code of it for a phone, and the browser if that is wanted.

use super::guard::Access;
use crate::note;
use crate::output;
use anyhow::{Result, anyhow};
use qrcodegen::{QrCode, QrCodeEcc};
use std::io::IsTerminal;
use std::process::{Command, Stdio};

/// Empty modules around a code (ISO/IEC 18004, 9.1).
const QUIET: i32 = 4;

/// Black on white, whatever the terminal's colours are.
const COLOURS: &str = "\x1b[38;5;16;48;5;231m";
const COLOURS_OFF: &str = "\x1b[0m";

pub fn announce(access: &Access, open: bool) -> Result<()> {
    let url = access.url();
    output::line(&url)?;
    if access.token.is_some() {
        output::line(&code(&url, std::io::stdout().is_terminal())?)?;
        note!(
            "whoever has this address can watch and set the board, and what travels is not encrypted"
        );
    }
    if open && let Err(error) = browse(&access.url_once()?) {
        note!("no browser was opened ({error}): open {url} yourself");
    }
    Ok(())
}

/// A QR code in half blocks: two rows of modules a line.
pub fn code(text: &str, colours: bool) -> Result<String> {
    let code = QrCode::encode_text(text, QrCodeEcc::Low)
        .map_err(|_| anyhow!("this address is too long for a QR code"))?;
    let (begin, end) = if colours {
        (COLOURS, COLOURS_OFF)
    } else {
        ("", "")
    };
    let modules = -QUIET..code.size() + QUIET;
    let line = |y: i32| {
        let half = |x: i32| match (code.get_module(x, y), code.get_module(x, y + 1)) {
            (true, true) => '\u{2588}',
            (true, false) => '\u{2580}',
            (false, true) => '\u{2584}',
            (false, false) => ' ',
        };
        format!(
            "{begin}{}{end}",
            modules.clone().map(half).collect::<String>()
        )
    };
    Ok(modules
        .clone()
        .step_by(2)
        .map(line)
        .collect::<Vec<_>>()
        .join("\n"))
}

fn browse(url: &str) -> std::io::Result<()> {
    let (program, arguments): (&str, &[&str]) = match std::env::consts::OS {
        "windows" => ("rundll32", &["url.dll,FileProtocolHandler"]),
        "macos" => ("open", &[]),
        _ => ("xdg-open", &[]),
    };
    let mut command = Command::new(program);
    command
        .args(arguments)
        .arg(url)
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::null());
    command
        .spawn()
        .map(drop)
        .map_err(|error| std::io::Error::new(error.kind(), format!("{program}: {error}")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_code_has_its_quiet_zone_and_its_three_corners() {
        let text = code(
            "http://192.168.1.7:8321/?token=0123456789abcdef0123456789abcdef",
            false,
        )
        .unwrap();
        let lines: Vec<Vec<char>> = text.lines().map(|line| line.chars().collect()).collect();
        let is_dark = |x: usize, y: usize| match lines[y / 2][x] {
            '\u{2588}' => true,
            '\u{2580}' => y.is_multiple_of(2),
            '\u{2584}' => y % 2 == 1,
            _ => false,
        };
        let size = lines[0].len();
        // Version 4 and its quiet zone (ISO/IEC 18004, table 1): 78 bytes in it at level L.
        assert_eq!(size, 33 + 8);
        assert!((0..size).all(|k| {
            (0..4).all(|q| !is_dark(k, q) && !is_dark(q, k) && !is_dark(size - 1 - q, k))
        }));
        // A finder pattern: dark 7 x 7, light 5 x 5, dark 3 x 3.
        for (left, top) in [(4, 4), (size - 11, 4), (4, size - 11)] {
            for (x, y) in (0..49_usize).map(|at| (at % 7, at / 7)) {
                let ring = x.abs_diff(3).max(y.abs_diff(3));
                assert_eq!(is_dark(left + x, top + y), ring != 2, "{x} {y}");
            }
        }
    }
}
