//! The program `fissure` as a library: [`main_with`] gives a crate of your own the whole program with your laws in it.
//!
//! Errors are one sentence on standard error and exit code 2; an interrupted run exits with 130.

mod args;
mod bench;
mod check;
mod compare;
mod diff;
mod error;
mod export;
mod folder;
mod info;
mod keys;
mod log;
mod materials;
mod mesh;
mod plot;
mod progress;
mod render;
mod run;
mod say;
mod schema;
mod shell;
mod verify;
mod view;

use std::process::ExitCode;

use clap::Parser;
use clap::error::ErrorKind;
use fissure_engine::Registry;

use crate::args::{Args, Command};
pub use crate::error::Error;
pub use crate::folder::RunFolder;
pub use crate::run::{Outcome, RunOptions, resume, run};
use crate::say::complain;

/// The program: reads the command line, does what it says, answers with the exit code.
///
/// ```no_run
/// fn main() -> std::process::ExitCode {
///     fissure_cli::main_with(fissure_materials::registry()) // .bonds::<Mine, _>()
/// }
/// ```
pub fn main_with(registry: Registry) -> ExitCode {
    if let Some(lack) = missing_instructions() {
        complain!("error: {lack}");
        return ExitCode::from(2);
    }
    let args = match Args::try_parse() {
        Ok(args) => args,
        Err(error) if error.use_stderr() && error.kind() != ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand => {
            complain!("{}", one_line(&error.to_string()));
            return ExitCode::from(2);
        }
        Err(help) => help.exit(),
    };
    match dispatch(args.command, &registry) {
        Ok(code) => code,
        Err(error) => {
            complain!("error: {error}");
            ExitCode::from(2)
        }
    }
}

fn dispatch(command: Command, registry: &Registry) -> Result<ExitCode, Error> {
    match command {
        Command::Run { scene, out, run } => run::command(&scene, out, &run, registry),
        Command::Resume { dir, force, run } => run::resume_command(&dir, force, &run, registry),
        Command::Info(options) => info::command(&options, registry),
        Command::Mesh(options) => mesh::command(&options),
        Command::Materials { name } => materials::command(name.as_deref(), registry),
        Command::Keys { part } => keys::command(part.as_deref()),
        Command::Render(options) => render::command(&options),
        Command::Plot(options) => plot::command(&options),
        Command::Check(options) => check::command(&options, registry),
        Command::Schema => schema::command(registry),
        Command::Completions { shell } => Ok(shell::completions(shell)),
        Command::Man { out } => shell::manual(&out),
        Command::Export(options) => export::command(&options),
        Command::Verify { path } => verify::command(&path),
        Command::View(options) => view::command(&options),
        Command::Bench(options) => bench::command(&options, registry),
        Command::Diff(options) => diff::command(&options),
    }
}

/// What clap says in several paragraphs, as one sentence without the summary of usage.
fn one_line(message: &str) -> String {
    let lines =
        message.lines().map(str::trim).take_while(|line| !line.starts_with("Usage:") && !line.starts_with("For more"));
    let mut sentence = String::new();
    for line in lines.filter(|line| !line.is_empty()) {
        let (join, line) = match line.strip_prefix("tip: ") {
            Some(tip) => ("; ", tip),
            None => (" ", line),
        };
        sentence += if sentence.is_empty() { "" } else { join };
        sentence += line;
    }
    sentence + "; see `fissure help`"
}

/// What this processor lacks of what the program was built for.
fn missing_instructions() -> Option<&'static str> {
    #[cfg(all(target_arch = "x86_64", target_feature = "avx2"))]
    if !std::arch::is_x86_feature_detected!("avx2") {
        return Some(
            "this program was built for processors with AVX2, which this one lacks; build it with RUSTFLAGS=\"-C target-cpu=x86-64\"",
        );
    }
    None
}
