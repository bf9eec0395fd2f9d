//! `help-files`: the manual's pages, and completions for shells, for packagers.

use crate::output;
use anyhow::{Context, Result};
use clap::{Args, Command};
use clap_complete::Shell;
use std::io::Write;
use std::path::{Path, PathBuf};

#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  ridgetone help-files --completions bash > ~/.local/share/bash-completion/completions/ridgetone
  ridgetone help-files --completions fish > ~/.config/fish/completions/ridgetone.fish
  ridgetone help-files --man ~/.local/share/man/man1")]
#[group(required = true)]
pub struct HelpFilesArgs {
    /// Write a manual page for each command into this folder.
    #[arg(long, value_name = "FOLDER")]
    man: Option<PathBuf>,
    /// Print the completion script for this shell.
    #[arg(long, value_enum)]
    completions: Option<Shell>,
}

impl HelpFilesArgs {
    /// Writes the files; `command` is the whole command line.
    pub(super) fn run(self, mut command: Command) -> Result<()> {
        if let Some(shell) = self.completions {
            let mut script = Vec::new();
            clap_complete::generate(shell, &mut command.clone(), "ridgetone", &mut script);
            std::io::stdout().write_all(&script)?;
        }
        match &self.man {
            Some(folder) => {
                command.build();
                write_pages(command, folder)
            }
            None => Ok(()),
        }
    }
}

fn write_pages(command: Command, folder: &Path) -> Result<()> {
    std::fs::create_dir_all(folder).with_context(|| folder.display().to_string())?;
    let mut commands = vec![command];
    while let Some(command) = commands.pop() {
        let is_shown = |command: &&Command| command.get_name() != "help" && !command.is_hide_set();
        commands.extend(command.get_subcommands().filter(is_shown).cloned());
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
