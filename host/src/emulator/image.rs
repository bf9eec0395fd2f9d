//! Finds the firmware image to emulate, and the board that it is for.

use anyhow::{Context, Result, bail, ensure};
use ridgetone_emulator::{Board, Image};
use std::path::{Path, PathBuf};
use std::sync::Arc;

// Images that existed when this command was built: names of boards, and ELF files.
include!(concat!(env!("OUT_DIR"), "/images.rs"));

/// Path of the default image within cargo's target directory, as `cargo xtask firmware` writes it.
const IMAGE: &str = "firmware/feather-f405/ridgetone-firmware.elf";

/// Board that is emulated by default.
const BOARD: Board = Board::FeatherF405;

/// An image of a finger's firmware, and the board that it runs on.
#[derive(Clone, Debug)]
pub struct Firmware {
    pub board: Board,
    pub image: Arc<Image>,
}

/// Finds the default image: embedded in this command, else in `CARGO_TARGET_DIR`, else in `target`
/// of the workspace around the current directory, else of the workspace that this program was built
/// in.
pub fn find() -> Result<Firmware> {
    if let Some(firmware) = embedded(BOARD.name().as_ref()) {
        return firmware;
    }
    let here = std::env::current_dir().unwrap_or_default();
    let root = Path::new(env!("CARGO_MANIFEST_DIR"))
        .parent()
        .unwrap_or(Path::new("."));
    let chosen = std::env::var_os("CARGO_TARGET_DIR").map(|target| root.join(target));
    let usual = here
        .ancestors()
        .chain([root])
        .map(|root| root.join("target"));
    let found = chosen
        .into_iter()
        .chain(usual)
        .map(|target: PathBuf| target.join(IMAGE))
        .find(|image| image.is_file());
    let found = found.with_context(|| {
        format!("firmware image target/{IMAGE} not found: build it with `cargo xtask firmware` in a clone of the repository, and run this in there or name the file with --elf FILE")
    })?;
    read(&found)
}

/// Returns the embedded image for the board of this name, if there is one.
fn embedded(name: &Path) -> Option<Result<Firmware>> {
    let (_, bytes) = EMBEDDED
        .iter()
        .find(|(board, _)| name == Path::new(board))?;
    Some(of_bytes(bytes, name))
}

/// Reads a file, or takes the embedded image of the board of that name. Refuses a device, which may
/// never end.
pub fn read(path: &Path) -> Result<Firmware> {
    if !path.exists()
        && let Some(firmware) = embedded(path)
    {
        return firmware;
    }
    let shown = path.display();
    let found = std::fs::metadata(path).with_context(|| {
        let boards: Vec<_> = EMBEDDED.iter().map(|(name, _)| *name).collect();
        match boards[..] {
            [] => format!(
                "{shown}: there is no such firmware image; `cargo xtask firmware` builds one"
            ),
            _ => format!(
                "{shown}: no such file; this command holds the images {}",
                boards.join(", ")
            ),
        }
    })?;
    ensure!(found.is_file(), "{shown}: not a file");
    of_bytes(
        &std::fs::read(path).with_context(|| shown.to_string())?,
        path,
    )
}

fn of_bytes(bytes: &[u8], name: &Path) -> Result<Firmware> {
    let image = Image::parse(bytes, name)?;
    let Some(board) = board(&image) else {
        bail!(
            "{}: not Ridgetone's firmware (or stripped): it has no symbol _board_...",
            name.display()
        );
    };
    let image = Arc::new(image);
    Ok(Firmware { board, image })
}

/// Returns the board, whose name build.rs puts into the name of a symbol.
fn board(image: &Image) -> Option<Board> {
    let name = image.name_after("_board_")?;
    Board::named(&name.replace('_', "-"))
}
