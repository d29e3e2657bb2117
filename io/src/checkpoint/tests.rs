//! What the checkpoint tests share: a small thing with a column of every type, and a folder of its own.

mod format;
mod hostile;
mod restoring;
mod run_folder;
mod speed;

use std::path::{Path, PathBuf};

use fissure_engine::buffer::{AnyBuffer, Buffer};
use fissure_engine::column::{Column, Life, Of, Visitor};
use glam::{DVec3, Vec3};

use super::{About, Columns, FROZEN, Opened, write};

/// Columns of every type, width and owner, one of them empty and one without a scope.
#[derive(Default)]
pub struct Thing {
    pub rest: Buffer<DVec3>,
    pub offsets: Buffer<u64>,
    pub neighbours: Buffer<u32>,
    pub tets: Buffer<[u32; 4]>,
    pub triangles: Buffer<[u32; 3]>,
    pub position: Buffer<DVec3>,
    pub damage: Buffer<f32>,
    pub energy: Buffer<f64>,
    pub frame: Buffer<[f32; 4]>,
    pub normal: Buffer<Vec3>,
    pub broken: Buffer<u8>,
    pub pieces: Buffer<u32>,
    pub seed: Buffer<u64>,
}

impl Columns for Thing {
    fn visit(&mut self, v: &mut Visitor<'_>) {
        v("vase", &Column::frozen("rest_position", "m", Of::Particle), &mut self.rest);
        v("vase", &Column::live("position", "m", Of::Particle), &mut self.position);
        v("vase", &Column::live("damage", "1", Of::Particle), &mut self.damage);
        v("vase/bonds", &Column::frozen("offsets", "1", Of::Row), &mut self.offsets);
        v("vase/bonds", &Column::frozen("neighbours", "1", Of::Bond), &mut self.neighbours);
        v("vase/bonds", &Column::live("broken", "1", Of::Chunk), &mut self.broken);
        v("vase/mesh", &Column::frozen("tets", "1", Of::Tet), &mut self.tets);
        v("vase/mesh", &Column::frozen("triangles", "1", Of::Thing), &mut self.triangles);
        v("vase/mesh", &Column::live("a_rather_long_name_of_frames", "1", Of::Tet), &mut self.frame);
        v("vase/mesh", &Column::live("normal", "1", Of::Vertex), &mut self.normal);
        v("vase/mesh", &Column::live("pieces", "1", Of::Thing), &mut self.pieces);
        v("", &Column::live("energy", "J", Of::Thing), &mut self.energy);
        v("", &Column::live("seed", "1", Of::Thing), &mut self.seed);
    }
}

/// Shows what `inner` shows, after `change` had its way with each declaration; `None` hides the column.
pub struct Changed<'c> {
    pub inner: Thing,
    pub change: &'c dyn Fn(&str, Column) -> Option<Column>,
}

impl Columns for Changed<'_> {
    fn visit(&mut self, v: &mut Visitor<'_>) {
        let change = self.change;
        self.inner.visit(&mut |scope, column: &Column, buffer: &mut dyn AnyBuffer| {
            if let Some(column) = change(scope, *column) {
                v(scope, &column, buffer);
            }
        });
    }
}

/// A thing of `n` particles with numbers that differ everywhere, NaN and both zeros among them.
pub fn thing(n: usize) -> Thing {
    let f = |i: usize| (i * 37 % 101) as f64 / 64.0 - 0.75; // exact, so that stored bytes are the same everywhere
    Thing {
        rest: (0..n).map(|i| DVec3::new(f(i), f(i + 1), i as f64)).collect::<Vec<_>>().into(),
        offsets: (0..=n as u64).map(|i| i * 3).collect::<Vec<_>>().into(),
        neighbours: (0..3 * n as u32).map(|i| i.wrapping_mul(2_654_435_761)).collect::<Vec<_>>().into(),
        tets: (0..n as u32).map(|i| [i, i + 1, i + 2, i + 3]).collect::<Vec<_>>().into(),
        triangles: (0..n as u32).map(|i| [i, i + 1, i + 2]).collect::<Vec<_>>().into(),
        position: (0..n).map(|i| DVec3::new(f(i + 5), -0.0, 1e-300 * i as f64)).collect::<Vec<_>>().into(),
        damage: (0..n).map(|i| if i == 1 { f32::NAN } else { i as f32 / n as f32 }).collect::<Vec<_>>().into(),
        energy: vec![-1.5, 2.5].into(),
        frame: (0..n).map(|i| [f(i) as f32, 1.0, -2.0, f32::INFINITY]).collect::<Vec<_>>().into(),
        normal: (0..n).map(|i| Vec3::splat(f(i) as f32)).collect::<Vec<_>>().into(),
        broken: (0..n).map(|i| (i * 7) as u8).collect::<Vec<_>>().into(),
        pieces: Buffer::default(),
        seed: vec![u64::MAX - 1].into(),
    }
}

/// All columns with their bytes: equal if and only if the things are, bit for bit.
pub fn bits(thing: &mut dyn Columns) -> Vec<(String, Vec<u8>)> {
    let mut all = Vec::new();
    thing.visit(&mut |scope, column, buffer| all.push((format!("{scope}/{}", column.name), buffer.bytes().to_vec())));
    all
}

pub fn about(step: u64) -> About {
    About {
        step,
        time: step as f64 * 0.5e-3,
        scene: "[body.vase]\nmesh = \"vase.ply\"\nlaw = \"isotropic\"\nbulk_modulus = 2.5e5\ndensity = 1000\n".into(),
        program: "fissure 0.1.0-a1".into(), // 16 bytes: the longest string that lies in place
        notes: vec![("forced".into(), "gravity: -9.81 was -9.8".into())],
    }
}

/// Writes `thing` as a frozen and a live file.
pub fn pair(dir: &Path, thing: &mut dyn Columns) -> (PathBuf, PathBuf) {
    let frozen = write(dir.join(FROZEN), Life::Frozen, 0, &about(0), thing).unwrap();
    let live = write(dir.join("live.fis"), Life::Live, frozen.fingerprint, &about(7), thing).unwrap();
    (frozen.path, live.path)
}

/// Opens and reads everything: the way in for any hostile file.
pub fn open_all(path: &Path) -> Result<Opened, super::CheckpointError> {
    let file = Opened::open(path)?;
    file.verify()?;
    Ok(file)
}

/// Splitmix64: random numbers that are the same everywhere.
pub struct Random(pub u64);

impl Random {
    pub fn below(&mut self, n: usize) -> usize {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) % n as u64) as usize
    }
}
