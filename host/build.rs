//! Embeds the firmware images of two boards, for a command distributed without the repository.
//! `cargo xtask firmware` makes the folder of images, target/firmware; RIDGETONE_IMAGES names it.

use std::path::{Path, PathBuf};
use std::{env, fs};

/// Boards whose images are embedded. The first is emulated by default.
const BOARDS: [&str; 2] = ["feather-f405", "nucleo-f446re"];

fn main() {
    println!("cargo::rerun-if-env-changed=RIDGETONE_IMAGES");
    let mut list = String::new();
    if let Some(folder) = env::var_os("RIDGETONE_IMAGES") {
        for name in BOARDS {
            let elf = Path::new(&folder).join(name).join("ridgetone-firmware.elf");
            println!("cargo::rerun-if-changed={}", elf.display());
            match elf.canonicalize() {
                Ok(elf) => list += &format!("({name:?}, include_bytes!({elf:?})),"),
                Err(error) => println!("cargo::error=RIDGETONE_IMAGES: {}: {error}", elf.display()),
            }
        }
    }
    let out = PathBuf::from(env::var_os("OUT_DIR").unwrap_or_default());
    let text = format!("const EMBEDDED: &[(&str, &[u8])] = &[{list}];\n");
    if let Err(error) = fs::write(out.join("images.rs"), text) {
        println!("cargo::error=images.rs: {error}");
    }
}
