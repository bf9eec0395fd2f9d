//! The command line: one file per command, and one for shared options.

mod actuator;
mod link;
mod pins;
mod touch;

use anyhow::Result;
use clap::{Parser, Subcommand};

/// Lets a person feel at a distance what a robot's finger touches.
///
/// `ridgetone` runs it: `ridgetone touch` is `ridgetone-teletaction touch`. Results go to standard
/// output, everything else to standard error. Exit status: 0 done, 1 an error (one line says
/// which), 2 usage error.
#[derive(Debug, Parser)]
#[command(name = "ridgetone-teletaction", version, max_term_width = 100)]
pub struct Cli {
    /// Replace files that exist already.
    #[arg(long, global = true)]
    force: bool,
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Feel a texture under the mouse, a finger or a pen: a page that plays its vibration.
    Touch(touch::TouchArgs),
    /// Turn the strain under the finger into the forces of a display of pins.
    Pins(Box<pins::PinsArgs>),
    /// Connect a finger with a stylus over a network: textures one way, the position of the hand
    /// the other.
    Link(link::LinkArgs),
}

impl Cli {
    pub fn run(self) -> Result<()> {
        if self.force {
            ridgetone_host::output::force();
        }
        match self.command {
            Command::Touch(args) => args.run(),
            Command::Pins(args) => args.run(),
            Command::Link(args) => args.run(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Cli;
    use clap::CommandFactory;

    #[test]
    fn the_command_line_is_sound() {
        Cli::command().debug_assert();
    }
}
