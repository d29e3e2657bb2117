//! `fissure view`: a page that shows one run or two, served to this machine only; `export --to html` puts all of it
//! into one file.
//!
//! `request` reads what a browser asks, `server` answers on 127.0.0.1, `route` knows the few addresses there are, `shown`
//! reads the run folder, `pack` makes bytes of frames, `assets` holds the page, `html` the page as one file. The page
//! itself is in `cli/assets/view`.

mod assets;
pub(crate) mod html;
mod pack;
mod request;
mod route;
mod server;
mod shown;

use std::process::{Command, ExitCode, Stdio};

use self::server::Server;
use self::shown::Shown;
use crate::Error;
use crate::args::ViewArgs;
use crate::say::say;

pub(crate) fn command(options: &ViewArgs) -> Result<ExitCode, Error> {
    let mut runs = vec![Shown::open(&options.dir)?];
    if let Some(other) = &options.other {
        runs.push(Shown::open(other)?);
    }
    let server = Server::start(options.port, runs)?;
    say!("{}\nCtrl-C ends", server.url());
    if options.open {
        open(server.url());
    }
    server.serve();
    Ok(ExitCode::SUCCESS)
}

/// Opens the address in the browser that the system prefers; where none starts, the printed address is there.
fn open(url: &str) {
    let mut command = if cfg!(target_os = "macos") {
        Command::new("open")
    } else if cfg!(windows) {
        let mut command = Command::new("rundll32");
        command.arg("url.dll,FileProtocolHandler");
        command
    } else {
        Command::new("xdg-open")
    };
    let started = command.arg(url).stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null()).spawn();
    if started.is_err() {
        say!("no browser could be started; open the address above");
    }
}
