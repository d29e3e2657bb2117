//! `fissure completions` and `fissure man`: what shells and readers of manuals want, from the command line's own declaration.

use std::io::Write;
use std::path::Path;
use std::process::ExitCode;

use clap::CommandFactory;
use clap_complete::Shell;

use crate::Error;
use crate::args::Args;
use crate::say::{counted, say};

pub(crate) fn completions(shell: Shell) -> ExitCode {
    let mut text = Vec::new();
    clap_complete::generate(shell, &mut Args::command(), "fissure", &mut text);
    // who closes the pipe early has read enough
    let _ = std::io::stdout().write_all(&text);
    ExitCode::SUCCESS
}

/// Writes a page for the program and one for each of its commands.
pub(crate) fn manual(out: &Path) -> Result<ExitCode, Error> {
    std::fs::create_dir_all(out).map_err(Error::write(out))?;
    clap_mangen::generate_to(Args::command(), out).map_err(Error::write(out))?;
    let pages = std::fs::read_dir(out).map_err(Error::write(out))?.count();
    say!("{}: {}; read them with `man -l {}`", out.display(), counted(pages, "page"), out.join("fissure.1").display());
    Ok(ExitCode::SUCCESS)
}
