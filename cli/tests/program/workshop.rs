//! A folder to work in, and the program called in it.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};

use fissure_io::frames::{self, Frame};

/// A soft box that falls flat on the ground at 4 m/s and breaks: about 1500 tetrahedra, some 300 steps, 7 frames.
pub const BOX: &str = r#"
title = "A box breaks"
duration = 0.06

[body.box]
shape = { kind = "box", size = [0.1, 0.1, 0.1] }
tets = 1500
rotate = { axis = [1, 0, 1], degrees = 30 }
translate = [0, 0.09, 0]
density = 1000
velocity = [0.2, -4, 0]

[body.box.material]
law = "isotropic"
bulk_modulus = 5e5
shear_modulus = 3e5

[body.box.fracture]
criterion = "critical_stretch"
critical_stretch = 0.05

[ground]

[output]
frame_every = 0.01
checkpoint_every = 0.008

[output.picture]
width = 64
height = 48
"#;

/// A temporary folder with the scene `box.toml` in it.
pub struct Workshop {
    folder: tempfile::TempDir,
}

impl Workshop {
    pub fn new() -> Self {
        let workshop = Self { folder: tempfile::tempdir().expect("a temporary folder") };
        workshop.put("box.toml", BOX);
        workshop
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    pub fn put(&self, name: &str, content: impl AsRef<[u8]>) -> PathBuf {
        let path = self.path(name);
        fs::write(&path, content).expect("a file in a temporary folder");
        path
    }

    /// Names in the folder, sorted.
    pub fn names(&self) -> Vec<String> {
        names(self.folder.path())
    }

    pub fn command(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_fissure"));
        command.args(arguments).current_dir(self.folder.path());
        command
    }

    pub fn call(&self, arguments: &[&str]) -> Answer {
        Answer::of(arguments, self.command(arguments).output().expect("the program starts"))
    }

    /// Calls and wants exit code 0 and silence on standard error.
    pub fn good(&self, arguments: &[&str]) -> Answer {
        let answer = self.call(arguments);
        assert_eq!(answer.code, Some(0), "{answer}");
        assert_eq!(answer.err, "", "{answer}");
        answer
    }

    /// Calls and wants exit code 2 and one sentence; gives it without `error: `.
    pub fn refusal(&self, arguments: &[&str]) -> String {
        let answer = self.call(arguments);
        assert_eq!(answer.code, Some(2), "{answer}");
        let sentence = answer.err.strip_prefix("error: ").and_then(|s| s.strip_suffix('\n'));
        let sentence = sentence.unwrap_or_else(|| panic!("no `error: …` line: {answer}"));
        assert!(!sentence.contains('\n'), "more than one line: {answer}");
        assert!(!sentence.contains("panicked"), "{answer}");
        sentence.to_owned()
    }

    /// Starts the program with its output in pipes.
    pub fn start(&self, arguments: &[&str]) -> Child {
        let mut command = self.command(arguments);
        command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("the program starts")
    }

    /// All that is comparable of a run: frames, frozen columns, the newest checkpoint and the series but for its times, by name.
    pub fn bytes(&self, run: &str) -> BTreeMap<String, Vec<u8>> {
        let dir = self.path(run);
        let mut files: Vec<String> = names(&dir.join("frames")).iter().map(|n| format!("frames/{n}")).collect();
        files.extend(names(&dir.join("particles")).iter().map(|n| format!("particles/{n}")));
        files.extend(names(&dir).into_iter().rfind(|n| n.starts_with("checkpoint_")));
        files.extend(["frozen.fis".into(), "last.png".into()]);
        let mut bytes: BTreeMap<String, Vec<u8>> =
            files.into_iter().filter_map(|n| Some((n.clone(), fs::read(dir.join(&n)).ok()?))).collect();
        if let Ok(text) = fs::read_to_string(dir.join("series.csv")) {
            let names: Vec<&str> = text.lines().next().unwrap_or_default().split(',').collect();
            let told = |line: &str| -> Vec<String> {
                let cells = line.split(',').zip(&names).filter(|(_, name)| !name.starts_with("s_"));
                cells.map(|(cell, _)| cell.to_string()).collect()
            };
            let rows: Vec<String> = text.lines().map(|line| told(line).join(",")).collect();
            bytes.insert("series.csv".into(), rows.join("\n").into_bytes());
        }
        bytes
    }

    /// The frames of the colliders of a run, in order.
    pub fn colliders(&self, run: &str) -> Vec<Vec<u8>> {
        let dir = self.path(run).join("colliders");
        names(&dir).iter().map(|n| fs::read(dir.join(n)).expect("a frame")).collect()
    }

    pub fn frame(&self, run: &str, number: u32) -> Frame {
        let path = self.path(run).join(format!("frames/frame_{number:04}.ply"));
        frames::read(&path).expect("a frame")
    }
}

/// What a call answered.
pub struct Answer {
    pub code: Option<i32>,
    pub out: String,
    pub err: String,
    line: String,
}

impl Answer {
    pub fn of(arguments: &[&str], output: Output) -> Self {
        Self {
            code: output.status.code(),
            out: String::from_utf8_lossy(&output.stdout).into_owned(),
            err: String::from_utf8_lossy(&output.stderr).into_owned(),
            line: arguments.join(" "),
        }
    }
}

impl std::fmt::Display for Answer {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "fissure {}\nexit code {:?}\n{}\n{}", self.line, self.code, self.out, self.err)
    }
}

/// Volume inside the triangles [m³], positive if they are wound outwards.
pub fn volume(frame: &Frame) -> f64 {
    let corner = |v: u32| glam::Vec3::from(frame.positions[v as usize]).as_dvec3();
    let cone = |t: &[u32; 3]| corner(t[0]).dot(corner(t[1]).cross(corner(t[2]))) / 6.0;
    frame.triangles.iter().map(cone).sum()
}

/// Says which files differ, rather than printing them.
pub fn assert_same(a: &BTreeMap<String, Vec<u8>>, b: &BTreeMap<String, Vec<u8>>, what: &str) {
    let keys = |m: &BTreeMap<String, Vec<u8>>| m.keys().cloned().collect::<Vec<_>>();
    assert_eq!(keys(a), keys(b), "{what}");
    let differ: Vec<&String> = a.keys().filter(|k| a[*k] != b[*k]).collect();
    assert!(differ.is_empty(), "{what}: {differ:?} differ");
}

/// The names in a folder, sorted; none if there is no folder.
pub fn names(dir: &Path) -> Vec<String> {
    let entries = fs::read_dir(dir).into_iter().flatten();
    let mut names: Vec<String> =
        entries.map(|e| e.expect("an entry").file_name().into_string().expect("UTF-8")).collect();
    names.sort();
    names
}

/// Edges of a frame that are not walked as often one way as the other, in each piece: 0 for a closed surface. Crack
/// faces have vertices of their own, so edges are told apart by where their ends are.
pub fn open_edges(frame: &Frame) -> usize {
    let mut walks = BTreeMap::new();
    for corners in &frame.triangles {
        for k in 0..3 {
            let (a, b) = (corners[k] as usize, corners[(k + 1) % 3] as usize);
            assert_eq!(frame.piece[a], frame.piece[b], "a triangle of two pieces");
            let end = |v: usize| frame.positions[v].map(f32::to_bits);
            if end(a) == end(b) {
                continue; // shorter than f32 can tell: one point, with nothing open
            }
            let (key, walk) = if end(a) < end(b) { ((end(a), end(b)), 1) } else { ((end(b), end(a)), -1) };
            *walks.entry((frame.piece[a], key)).or_insert(0) += walk;
        }
    }
    walks.values().filter(|&&sum| sum != 0).count()
}
