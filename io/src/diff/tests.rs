use std::path::{Path, PathBuf};

use fissure_engine::buffer::Buffer;
use fissure_engine::column::{Column, Life, Of, Visitor};
use glam::DVec3;

use super::*;
use crate::checkpoint::{About, Columns, FROZEN, checkpoint_name, write};

/// A chain of particles, each bonded to the next, in a given order; and its surface.
#[derive(Clone)]
struct Chain {
    id: Vec<u32>,
    position: Vec<DVec3>,
    offsets: Vec<u32>,
    neighbours: Vec<u32>,
    intact: Vec<u8>,
    memory: Vec<f32>,
    vertex: Vec<f64>,
}

impl Chain {
    /// Particle `k` lies at x = id. Every bond remembers the product of the ids of its ends.
    fn new(id: Vec<u32>) -> Self {
        let n = id.len() as u32;
        let at = |wanted: u32| id.iter().position(|&i| i == wanted).unwrap() as u32;
        let (mut neighbours, mut memory, mut intact) = (Vec::new(), Vec::new(), Vec::new());
        for (k, &i) in id.iter().enumerate() {
            let near: Vec<u32> = [i.wrapping_sub(1), i + 1].into_iter().filter(|&j| j < n).collect();
            for slot in 0..8 {
                let bond = near.get(slot);
                neighbours.push(bond.map_or(k as u32, |&j| at(j)));
                memory.push(bond.map_or(0.0, |&j| (i * j) as f32));
            }
            intact.push((1 << near.len()) - 1);
        }
        Self {
            position: id.iter().map(|&i| DVec3::X * f64::from(i)).collect(),
            offsets: (0..=n).collect(),
            vertex: vec![0.5; 3],
            id,
            neighbours,
            intact,
            memory,
        }
    }

    fn save(&self, dir: &Path, step: u64) -> PathBuf {
        std::fs::create_dir_all(dir).unwrap();
        let about = About { step, scene: String::new(), ..About::default() };
        let frozen = write(dir.join(FROZEN), Life::Frozen, 0, &About::default(), &mut self.clone()).unwrap();
        let path = dir.join(checkpoint_name(step));
        write(&path, Life::Live, frozen.fingerprint, &about, &mut self.clone()).unwrap();
        path
    }
}

impl Columns for Chain {
    fn visit(&mut self, v: &mut Visitor<'_>) {
        let range = vec![0, self.id.len() as u64];
        let mut show =
            |scope: &str, column: Column, buffer: &mut dyn fissure_engine::buffer::AnyBuffer| v(scope, &column, buffer);
        show("particles", Column::frozen("id", "1", Of::Particle), &mut Buffer::from(self.id.clone()));
        show(
            "particles",
            Column::frozen("volume", "m^3", Of::Particle),
            &mut Buffer::from(vec![1.0f64; self.id.len()]),
        );
        show("particles", Column::live("position", "m", Of::Particle), &mut Buffer::from(self.position.clone()));
        show("bodies/a/b", Column::frozen("range", "1", Of::Thing), &mut Buffer::from(range));
        let bonds = "bodies/a/b/bonds";
        show(bonds, Column::frozen("offsets", "1", Of::Row), &mut Buffer::from(self.offsets.clone()));
        show(bonds, Column::frozen("neighbours", "1", Of::Bond), &mut Buffer::from(self.neighbours.clone()));
        show(bonds, Column::live("intact", "1", Of::Chunk), &mut Buffer::from(self.intact.clone()));
        show("bodies/a/b/memory", Column::live("stretch", "m", Of::Bond), &mut Buffer::from(self.memory.clone()));
        show("bodies/a/b/mesh", Column::live("height", "m", Of::Vertex), &mut Buffer::from(self.vertex.clone()));
    }
}

fn compare(a: &Chain, b: &Chain, options: &Options) -> FileDiff {
    let dir = tempfile::tempdir().unwrap();
    let (a, b) = (a.save(&dir.path().join("a"), 7), b.save(&dir.path().join("b"), 7));
    checkpoints(&Side::open(a).unwrap(), &Side::open(b).unwrap(), options).unwrap()
}

fn numbers<'d>(diff: &'d FileDiff, label: &str) -> &'d Numbers {
    match &diff.columns.iter().find(|c| c.label == label).unwrap().verdict {
        Verdict::Numbers(n) => n,
        other => panic!("{label}: {other:?}"),
    }
}

#[test]
fn the_same_is_the_same_and_a_number_is_found_where_it_is() {
    let chain = Chain::new(vec![0, 1, 2, 3, 4, 5]);
    assert!(!compare(&chain, &chain, &Options::default()).differs());

    let mut other = chain.clone();
    other.position[4].y = 1e-3;
    other.position[2].z = -2e-3;
    other.memory[3 * 8 + 1] = f32::NAN;
    other.intact[5] = 0;
    let diff = compare(&chain, &other, &Options::default());
    let n = numbers(&diff, "particles/position");
    assert_eq!((n.of, n.differing, n.largest), (18, 2, 2e-3));
    assert!((n.rms - (5e-6f64 / 18.0).sqrt()).abs() < 1e-15);
    assert_eq!(
        (n.place.particle, n.place.body.as_deref(), n.place.position),
        (Some(2), Some("a/b"), Some(DVec3::X * 2.0))
    );
    let n = numbers(&diff, "bodies/a/b/memory/stretch");
    assert_eq!((n.differing, n.largest, n.place.particle), (1, f64::INFINITY, Some(3)));
    let n = numbers(&diff, "bodies/a/b/bonds/intact");
    assert_eq!((n.differing, n.largest, n.place.particle), (1, 1.0, Some(5)));

    let loose = Options { tolerance: 1e-3, columns: "position".into() };
    let diff = compare(&chain, &other, &loose);
    assert_eq!((diff.columns.len(), numbers(&diff, "particles/position").differing), (1, 1));
    assert!(!compare(&chain, &other, &Options { tolerance: 2e-3, ..loose }).differs());
}

#[test]
fn bits_count_even_where_numbers_are_equal() {
    let chain = Chain::new(vec![0, 1, 2]);
    let mut other = chain.clone();
    other.position[1].z = -0.0;
    let diff = compare(&chain, &other, &Options::default());
    assert_eq!(
        (numbers(&diff, "particles/position").differing, numbers(&diff, "particles/position").largest),
        (1, 0.0)
    );
    assert!(!compare(&chain, &other, &Options { tolerance: 1e-300, ..Options::default() }).differs());
}

#[test]
fn another_order_is_matched_by_id() {
    let (chain, mut other) = (Chain::new(vec![0, 1, 2, 3, 4, 5]), Chain::new(vec![3, 0, 5, 1, 4, 2]));
    let diff = compare(&chain, &other, &Options::default());
    assert!(diff.matched && !diff.differs(), "{diff}");
    // what cannot be matched is said
    let skipped: Vec<&str> =
        diff.columns.iter().filter(|c| matches!(c.verdict, Verdict::Order)).map(|c| c.label.as_str()).collect();
    assert_eq!(skipped, ["bodies/a/b/mesh/height"]);

    // id 5 is third; its only bond is the one to 4
    other.position[2].x += 0.25;
    other.memory[2 * 8] += 1.0;
    other.intact[2] = 0;
    let diff = compare(&chain, &other, &Options::default());
    for (label, largest) in
        [("particles/position", 0.25), ("bodies/a/b/memory/stretch", 1.0), ("bodies/a/b/bonds/intact", 1.0)]
    {
        let n = numbers(&diff, label);
        assert_eq!((n.differing, n.largest, n.place.particle), (1, largest, Some(5)), "{label}");
    }
}

#[test]
fn columns_that_one_has_not_or_that_are_longer_are_named() {
    let (short, long) = (Chain::new(vec![0, 1, 2]), Chain::new(vec![0, 1, 2, 3]));
    let diff = compare(&short, &long, &Options { columns: "position".into(), ..Options::default() });
    let Verdict::Shape(shapes) = &diff.columns[0].verdict else { panic!("{diff}") };
    assert_eq!(shapes[0], "3 f64 × 3 [m]");
    assert_eq!(shapes[1], "4 f64 × 3 [m]");

    let dir = tempfile::tempdir().unwrap();
    let live = Side::open(short.save(dir.path(), 1)).unwrap();
    let frozen = Side::open(dir.path().join(FROZEN)).unwrap();
    let error = checkpoints(&live, &frozen, &Options::default()).unwrap_err().to_string();
    assert!(error.contains("holds frozen columns where live ones are needed"), "{error}");
    let options = Options { columns: "temperature".into(), ..Options::default() };
    let error = checkpoints(&live, &live, &options).unwrap_err().to_string();
    assert!(error.contains("\"temperature\"; there are particles/position"), "{error}");
}

#[test]
fn a_flipped_bit_is_damage_and_no_difference() {
    let dir = tempfile::tempdir().unwrap();
    let chain = Chain::new((0..40).collect());
    let (a, b) = (chain.save(&dir.path().join("a"), 1), chain.save(&dir.path().join("b"), 1));
    let mut bytes = std::fs::read(&b).unwrap();
    bytes[100] ^= 4;
    std::fs::write(&b, bytes).unwrap();
    let error = checkpoints(&Side::open(a).unwrap(), &Side::open(b).unwrap(), &Options::default()).unwrap_err();
    assert!(error.to_string().contains("checksum of column `particles/position` does not match"), "{error}");
}

#[test]
fn runs_know_the_first_step_that_differs() {
    let dir = tempfile::tempdir().unwrap();
    let (a, b) = (dir.path().join("a"), dir.path().join("b"));
    let chain = Chain::new(vec![0, 1, 2, 3]);
    let mut other = chain.clone();
    for step in [10, 20, 30] {
        chain.save(&a, step);
        other.save(&b, step + 10);
        other.position[0].x += 1e-9; // from step 30 on
    }
    for (folder, seconds) in [(&a, "1"), (&b, "1.0")] {
        std::fs::write(folder.join("scene.toml"), format!("duration = {seconds}\n")).unwrap();
        std::fs::create_dir(folder.join("frames")).unwrap();
    }
    let diff = runs(&a, &b, &Options::default()).unwrap();
    assert_eq!(diff.steps.iter().map(|d| d.step[0]).collect::<Vec<_>>(), [20, 30]);
    assert_eq!((diff.first_step(), diff.only.clone()), (Some(30), [vec![10], vec![40]]));
    assert!(diff.scene.is_empty() && diff.differs());
    assert!(diff.to_string().contains("first differing step: 30; step 20 is the same"), "{diff}");
    let diff = runs(&a, &b, &Options { tolerance: 1e-8, ..Options::default() }).unwrap();
    assert!(diff.first_step().is_none() && diff.differs(), "the second went further");
}

#[test]
fn the_picture_is_red_where_it_differs() {
    let dir = tempfile::tempdir().unwrap();
    let chain = Chain::new(vec![0, 1, 2, 3]);
    let mut other = chain.clone();
    other.position[1].y = 0.5;
    other.position[3].y = 1.0;
    let (a, b) = (chain.save(&dir.path().join("a"), 1), other.save(&dir.path().join("b"), 1));
    let (a, b) = (Side::open(a).unwrap(), Side::open(b).unwrap());
    let diff = checkpoints(&a, &b, &Options::default()).unwrap();
    let (drawn, label, largest) = frame(&a, &b, &diff).unwrap().unwrap();
    assert_eq!((label.as_str(), largest), ("particles/position", 1.0));
    let of_particle: Vec<f32> = drawn.damage.chunks(6).map(|d| d[0]).collect();
    assert_eq!(of_particle, [0.0, 0.5, 0.0, 1.0]);
    drawn.check().unwrap();
    assert!(frame(&a, &a, &checkpoints(&a, &a, &Options::default()).unwrap()).unwrap().is_none());
}

#[test]
fn scenes_are_compared_by_key() {
    let a = "duration = 1\ngravity = [0, -10, 0]\n[body.a]\ntets = 5\n[[anchor]]\nbox = [[0, 0, 0], [1, 1, 1]]\n";
    let b = "gravity = [0.0, -10.0, 0.0]\nduration = 2 # longer\n[body.a]\ntets = 5.0\n[[anchor]]\nbox = [[0, 0, 0], [1, 1, 2]]\nbody = 'a'\n";
    let keys = scenes([a, b], [Path::new("a.toml"), Path::new("b.toml")]).unwrap();
    let said: Vec<String> = keys.iter().map(KeyDiff::to_string).collect();
    assert_eq!(
        said,
        [
            "duration: 1 became 2",
            "anchor.1.box: [[0, 0, 0], [1, 1, 1]] became [[0, 0, 0], [1, 1, 2]]",
            "anchor.1.body = \"a\": only in the second",
        ]
    );
    let error = scenes(["= 1", ""], [Path::new("a.toml"), Path::new("b.toml")]).unwrap_err().to_string();
    assert!(error.contains("a.toml:1") && error.contains("not TOML"), "{error}");
}
