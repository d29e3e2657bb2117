//! `fissure plot`: what a run measured, over time.

use std::process::ExitCode;

use fissure_io::atomic::write_atomically;
use fissure_io::scene::Scene;
use fissure_io::series::Series;

use crate::args::PlotArgs;
use crate::info::called;
use crate::say::say;
use crate::{Error, RunFolder};

pub(crate) fn command(options: &PlotArgs) -> Result<ExitCode, Error> {
    let folder = RunFolder::open(&options.dir)?;
    let path = folder.series();
    let series = Series::read(&path).map_err(|e| {
        Error::Usage(format!("{} cannot be read: {e}; a run writes it with its frames", path.display()))
    })?;
    let scene = Scene::load(&folder.scene(), &[])?;
    let figure = || series.figure(called(&scene));
    let out = options.out.clone().unwrap_or_else(|| options.dir.join("plot.png"));
    let bytes = match out.extension().and_then(|e| e.to_str()) {
        Some("png") => figure().draw().to_png()?,
        Some("svg") => figure().svg().into_bytes(),
        Some("csv") => series.to_csv().into_bytes(),
        _ => {
            let message = format!("{} has none of the endings .png, .svg and .csv; give one of them", out.display());
            return Err(Error::Usage(message));
        }
    };
    write_atomically(&out, &bytes).map_err(Error::write(&out))?;
    say!("{}", out.display());
    Ok(ExitCode::SUCCESS)
}
