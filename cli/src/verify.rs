//! `fissure verify`: every byte of checkpoints and frames against what they say of themselves.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use fissure_io::checkpoint::{CheckpointError, FROZEN, Opened, Store};
use fissure_io::frames::{self, FrameError, FrameFolder, ParticleFrame};

use crate::say::{counted, say};
use crate::{Error, RunFolder};

pub(crate) fn command(path: &Path) -> Result<ExitCode, Error> {
    let mut wrong = 0;
    if path.is_dir() {
        let folder = RunFolder::open(path)?;
        let frozen = Opened::open(path.join(FROZEN)).and_then(|f| f.verify().map(|()| f));
        tell(&path.join(FROZEN), frozen.as_ref().map(columns), &mut wrong);
        for (_, file) in Store::listing(path)? {
            let checked = whole(&file).and_then(|live| match &frozen {
                Ok(frozen) => live.belongs_to(frozen).map(|()| live),
                Err(_) => Ok(live),
            });
            tell(&file, checked.as_ref().map(columns), &mut wrong);
        }
        let surface = |path: &Path| frames::read(path).and_then(|frame| frame.check());
        let particles = |path: &Path| ParticleFrame::read(path).and_then(|frame| frame.check());
        each(&folder.frames(), "", surface, &mut wrong)?;
        each(&folder.particles(), " of particles", particles, &mut wrong)?;
        each(&folder.colliders(), " of colliders", surface, &mut wrong)?;
    } else {
        tell(path, whole(path).as_ref().map(columns), &mut wrong);
    }
    if wrong > 0 {
        return Err(Error::Usage(format!(
            "{}: {} damaged; what is wrong stands above",
            path.display(),
            counted(wrong, "file")
        )));
    }
    Ok(ExitCode::SUCCESS)
}

/// Reads every frame of a folder, which may be none.
fn each(
    list: &FrameFolder,
    what: &str,
    read: impl Fn(&Path) -> Result<(), FrameError>,
    wrong: &mut usize,
) -> Result<(), Error> {
    let numbers = list.numbers()?;
    if numbers.is_empty() {
        return Ok(());
    }
    for path in numbers.iter().map(|&n| list.path(n)) {
        if let Err(error) = read(&path) {
            tell(&path, Err(&error), wrong);
        }
    }
    say!("{}{what} read", counted(numbers.len(), "frame"));
    Ok(())
}

fn whole(path: &Path) -> Result<Opened, CheckpointError> {
    let file = Opened::open(path)?;
    file.verify()?;
    Ok(file)
}

fn columns(file: &Opened) -> String {
    let step = file.about().step;
    format!("step {step}, {}, {} bytes, all as written", counted(file.sections().len(), "column"), file.file_length())
}

fn tell<E: std::fmt::Display>(path: &Path, checked: Result<String, &E>, wrong: &mut usize) {
    // frames of all kinds are called the same, so the folder is named too
    let parent = path.parent().and_then(Path::file_name).filter(|_| path.extension().is_some_and(|e| e == "ply"));
    let name = parent.map_or_else(PathBuf::new, PathBuf::from).join(path.file_name().unwrap_or(path.as_os_str()));
    match checked {
        Ok(sentence) => say!("{}: {sentence}", name.display()),
        Err(error) => {
            say!("{}: {error}", name.display());
            *wrong += 1;
        }
    }
}
