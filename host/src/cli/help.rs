//! `completions` and `man`: what shells and the manual's reader know of this command.

use crate::output;
use anyhow::{Context, Result};
use clap::{Args, Command};
use clap_complete::Shell;
use std::io::Write;
use std::path::PathBuf;

#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  ridgetone completions bash > ~/.local/share/bash-completion/completions/ridgetone
  ridgetone completions zsh > ~/.zfunc/_ridgetone
  ridgetone completions fish > ~/.config/fish/completions/ridgetone.fish")]
pub struct CompletionsArgs {
    /// Which shell.
    #[arg(value_enum)]
    shell: Shell,
}

impl CompletionsArgs {
    /// `command`: the whole command line.
    pub(super) fn run(self, mut command: Command) -> Result<()> {
        let mut script = Vec::new();
        clap_complete::generate(self.shell, &mut command, "ridgetone", &mut script);
        Ok(std::io::stdout().write_all(&script)?)
    }
}

#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  ridgetone man | man -l -
  ridgetone man -o ~/.local/share/man/man1")]
pub struct ManArgs {
    /// Write a page for each command into this folder.
    #[arg(short, long, value_name = "FOLDER")]
    output: Option<PathBuf>,
}

impl ManArgs {
    /// `command`: the whole command line.
    pub(super) fn run(self, mut command: Command) -> Result<()> {
        command.build();
        let Some(folder) = self.output else {
            let mut page = Vec::new();
            clap_mangen::Man::new(command).render(&mut page)?;
            return Ok(std::io::stdout().write_all(&page)?);
        };
        std::fs::create_dir_all(&folder).with_context(|| folder.display().to_string())?;
        let mut commands = vec![command];
        while let Some(command) = commands.pop() {
            commands.extend(
                command
                    .get_subcommands()
                    .filter(|command| command.get_name() != "help")
                    .cloned(),
            );
            let name = command
                .get_display_name()
                .unwrap_or(command.get_name())
                .to_owned();
            output::new_file(&folder.join(format!("{name}.1")), |file| {
                Ok(clap_mangen::Man::new(command).render(file)?)
            })?;
        }
        Ok(())
    }
}
