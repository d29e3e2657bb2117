//! Instructions per directed bond of a step, for every law and criterion, per finest cell of a step of a lattice, and per vertex of
//! its frames: a figure without noise, counted by valgrind.
//!
//!     cargo run --release -p fissure-bench --example instructions             compares with the numbers that are kept
//!     cargo run --release -p fissure-bench --example instructions -- accept   keeps the new ones
//!
//! More than 5 % above what is kept fails. Counts are not times: a pass that waits for memory may take longer with
//! fewer instructions. Another compiler gives other counts, so the file names the one that made it.
//!
//! The isotropic law stands in the list twice: that of `fissure-materials`, and the same source compiled here, in another
//! crate, as a law of somebody else would be.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};

use fissure_bench::{Lattice, cells};
use fissure_engine::{Registry, World};
use fissure_io::scene::Scene;
use fissure_io::simulation::Simulation;
// what the law below calls its own crate's
use fissure_materials::moduli;

#[allow(dead_code)] // a copy of a whole file, of which the law alone is used
#[path = "../../materials/src/isotropic.rs"]
mod elsewhere;

/// Growth that fails.
const LIMIT: f64 = 1.05;
/// A law out of tree may cost this much more than the same one in it.
const OUT_OF_TREE: f64 = 1.03;
const STEPS: u64 = 2;

/// Ends a stretch of counting: valgrind writes its counters whenever this is called.
#[inline(never)]
fn counting_mark() {
    std::hint::black_box(());
}

fn block<'a>(law: &'a str, criterion: &'a str) -> Lattice<'a> {
    Lattice { law, criterion, edge: 12, ..Lattice::default() }
}

/// What is counted.
struct Case {
    name: String,
    what: What,
}

enum What {
    /// Steps of a block of bonds: where the law is registered, law and criterion; per directed bond.
    Bonds(Registry, &'static str, &'static str),
    /// Steps of a ball of cells: method and levels; per finest cell.
    Cells(&'static str, f64),
    /// Frames of a lattice between steps, without the steps; per vertex.
    Frames,
}

impl Case {
    fn new(name: impl Into<String>, what: What) -> Self {
        Self { name: name.into(), what }
    }

    /// What is done again and again, to count it.
    fn work(&self) -> Box<dyn FnMut()> {
        let steps = |mut world: World| -> Box<dyn FnMut()> { Box::new(move || world.step().expect("stable")) };
        match &self.what {
            What::Bonds(registry, law, criterion) => steps(block(law, criterion).world(registry)),
            What::Cells(method, levels) => steps(cells::ball(method, *levels)),
            What::Frames => {
                let mut simulation = blob();
                simulation.step().expect("shape matching always steps");
                Box::new(move || drop(std::hint::black_box(simulation.frame(0))))
            }
        }
    }

    /// Of how many things the work is.
    fn units(&self) -> u64 {
        match &self.what {
            What::Bonds(_, law, criterion) => block(law, criterion).directed(),
            What::Cells(method, levels) => cells::ball(method, *levels).particles.len() as u64,
            What::Frames => blob().frame(0).positions.len() as u64,
        }
    }
}

/// A ball of about 1000 cells whose nodes are of several levels.
fn blob() -> Simulation {
    let text = "\
duration = 1
dt = 0.01
[body.ball]
shape = { kind = 'ball', radius = 0.1 }
density = 1000
cells = 1000
material = { law = 'lattice' }
";
    let scene = Scene::parse(text, Path::new("ball.toml"), &[]).expect("a scene");
    Simulation::build(&scene, &fissure_materials::registry(), &mut |_| ()).expect("a ball")
}

fn cases() -> Vec<Case> {
    let registry = fissure_materials::registry();
    let mut all = Vec::new();
    for entry in registry.bond_laws() {
        all.push(Case::new(entry.name, What::Bonds(registry.clone(), entry.name, "critical_stretch")));
    }
    let others = registry.entry("isotropic").expect("registered").criteria.iter();
    for criterion in others.filter(|c| c.name != "critical_stretch") {
        let name = format!("isotropic with {}", criterion.name);
        all.push(Case::new(name, What::Bonds(registry.clone(), "isotropic", criterion.name)));
    }
    let other = Registry::default().bonds::<elsewhere::Isotropic, _>();
    all.push(Case::new("isotropic from another crate", What::Bonds(other, "isotropic", "critical_stretch")));
    all.push(Case::new("lattice of one level", What::Cells("lsm", 0.0)));
    all.push(Case::new("lattice of three levels", What::Cells("ohta", 2.0)));
    all.push(Case::new("frame of a lattice", What::Frames));
    all
}

/// Runs under valgrind: a stretch of preparation and a stretch of work for each case.
fn steps() {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).use_current_thread().build().expect("a thread");
    pool.install(|| {
        for case in cases() {
            let mut work = case.work();
            work();
            counting_mark();
            (0..STEPS).for_each(|_| work());
            counting_mark();
        }
    });
}

/// Name and instructions per thing and step, or a sentence that says why there are none.
fn count() -> Result<Vec<(String, f64)>, String> {
    let folder = std::env::temp_dir().join(format!("fissure-instructions-{}", std::process::id()));
    std::fs::create_dir_all(&folder).map_err(|e| format!("{} cannot be made: {e}", folder.display()))?;
    let counted = count_in(&folder);
    let _ = std::fs::remove_dir_all(&folder);
    counted
}

fn count_in(folder: &Path) -> Result<Vec<(String, f64)>, String> {
    let own = std::env::current_exe().map_err(|e| format!("this program does not find itself: {e}"))?;
    let out = folder.join("counts");
    let done = Command::new("valgrind")
        .args(["--tool=callgrind", "--dump-before=*counting_mark*"])
        .arg(format!("--callgrind-out-file={}", out.display()))
        .arg(own)
        .arg("steps")
        .output()
        .map_err(|e| format!("valgrind does not start: {e}"))?;
    if !done.status.success() {
        return Err(format!("valgrind failed: {}", String::from_utf8_lossy(&done.stderr)));
    }
    let mut counts = Vec::new();
    for (k, case) in cases().into_iter().enumerate() {
        // the dump before every second mark holds the steps
        let path = folder.join(format!("counts.{}", 2 * k + 2));
        let text = std::fs::read_to_string(&path).map_err(|e| format!("{}: {e}", path.display()))?;
        let total = text.lines().find_map(|line| line.strip_prefix("summary: ")?.trim().parse::<u64>().ok());
        let total = total.ok_or_else(|| format!("{} has no summary", path.display()))?;
        let each = total as f64 / (STEPS * case.units()) as f64;
        counts.push((case.name, each));
    }
    Ok(counts)
}

fn kept_path() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("instructions.csv")
}

/// The numbers of a file, and the compiler that made them.
fn parse(text: &str) -> (Vec<(String, f64)>, String) {
    let row = |line: &str| line.rsplit_once(',').and_then(|(name, n)| Some((name.to_string(), n.parse().ok()?)));
    let compiler = text.lines().find_map(|line| line.strip_prefix("# ")).unwrap_or("an unknown compiler");
    (text.lines().filter_map(row).collect(), compiler.to_string())
}

fn compiler() -> String {
    let said = Command::new("rustc").arg("--version").output().ok();
    said.map_or("an unknown compiler".into(), |out| String::from_utf8_lossy(&out.stdout).trim().to_string())
}

/// One line per case, and what is wrong.
fn compare(counts: &[(String, f64)], kept: &[(String, f64)]) -> (String, Vec<String>) {
    let (mut table, mut faults) = (String::new(), Vec::new());
    for (name, now) in counts {
        let Some((_, before)) = kept.iter().find(|k| k.0 == *name) else {
            let _ = writeln!(table, "{name:<36} {now:>8.2}      new");
            faults.push(format!("{name} is not in bench/instructions.csv"));
            continue;
        };
        let change = 100.0 * (now / before - 1.0);
        let _ = writeln!(table, "{name:<36} {now:>8.2} {change:>+7.1} %");
        if now / before > LIMIT {
            faults.push(format!("{name} takes {now:.2} instructions each, {change:+.1} % on {before:.2}"));
        }
    }
    let of = |name: &str| counts.iter().find(|c| c.0 == name).map(|c| c.1);
    if let (Some(ours), Some(theirs)) = (of("isotropic"), of("isotropic from another crate"))
        && theirs > OUT_OF_TREE * ours
    {
        faults.push(format!("a law in another crate takes {theirs:.2} instructions, the same one in ours {ours:.2}"));
    }
    (table, faults)
}

fn main() -> ExitCode {
    let word = std::env::args().nth(1);
    if word.as_deref() == Some("steps") {
        steps();
        return ExitCode::SUCCESS;
    }
    if !cfg!(all(target_arch = "x86_64", target_feature = "avx2")) {
        println!("instructions are not counted: those that are kept are of AVX2, which this build does not use");
        return ExitCode::SUCCESS;
    }
    if Command::new("valgrind").arg("--version").output().is_err() {
        println!("instructions are not counted: valgrind is not installed (Debian: apt-get install valgrind)");
        return ExitCode::SUCCESS;
    }
    let counts = match count() {
        Ok(counts) => counts,
        Err(sentence) => {
            eprintln!("error: {sentence}");
            return ExitCode::from(2);
        }
    };
    if word.as_deref() == Some("accept") {
        let rows: String = counts.iter().map(|(name, n)| format!("{name},{n:.3}\n")).collect();
        let text = format!("# {}\ncase,instructions per directed bond, cell or vertex\n{rows}", compiler());
        if let Err(e) = std::fs::write(kept_path(), text) {
            eprintln!("error: {} cannot be written: {e}", kept_path().display());
            return ExitCode::from(2);
        }
        println!("kept in {}", kept_path().display());
        return ExitCode::SUCCESS;
    }
    let (kept, made_by) = parse(&std::fs::read_to_string(kept_path()).unwrap_or_default());
    let (table, faults) = compare(&counts, &kept);
    println!("instructions per directed bond, cell or vertex, against those that are kept:\n{table}");
    if faults.is_empty() {
        if counts.iter().any(|(name, now)| kept.iter().any(|(k, before)| k == name && now * LIMIT < *before)) {
            println!(
                "Some take fewer: keep that with `cargo run --release -p fissure-bench --example instructions -- accept`."
            );
        }
        return ExitCode::SUCCESS;
    }
    faults.iter().for_each(|fault| eprintln!("error: {fault}"));
    let now = compiler();
    if now != made_by {
        eprintln!("The numbers that are kept were made by {made_by}, this is {now}.");
    }
    eprintln!("Make it cheaper, or accept it: cargo run --release -p fissure-bench --example instructions -- accept");
    ExitCode::FAILURE
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn six_per_cent_more_fails_and_four_or_fewer_do_not() {
        let (kept, compiler) = parse("# rustc 1.2.3\nlaw,instructions\na,100.0\nb,50\n");
        assert_eq!((kept.len(), compiler.as_str()), (2, "rustc 1.2.3"));
        let now = |a: f64, b: f64| compare(&[("a".into(), a), ("b".into(), b)], &kept).1;
        assert!(now(104.0, 20.0).is_empty());
        let faults = now(106.0, 50.0);
        assert!(
            faults.len() == 1 && faults[0].contains("a takes 106.00") && faults[0].contains("+6.0 %"),
            "{faults:?}"
        );
        assert_eq!(compare(&[("c".into(), 1.0)], &kept).1, ["c is not in bench/instructions.csv"]);
    }

    #[test]
    fn a_law_in_another_crate_may_cost_three_per_cent() {
        let with = |n: f64| {
            let counts = [("isotropic".to_string(), 100.0), ("isotropic from another crate".to_string(), n)];
            compare(&counts, &counts).1.len()
        };
        assert_eq!((with(102.9), with(103.1)), (0, 1));
    }
}
