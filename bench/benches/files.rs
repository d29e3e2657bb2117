//! Checkpoints and frames. Times end when the system has the bytes on its disk.

use criterion::Criterion;
use fissure_bench::Lattice;
use fissure_engine::{Visitor, World};
use fissure_io::checkpoint::{About, Columns, Store};
use fissure_io::frames::FrameFolder;
use tempfile::{TempDir, tempdir};

use crate::meshes::Torn;
use crate::{Per, group, measure, timed};

const BLOCK: Lattice<'static> =
    Lattice { law: "plastic", criterion: "critical_stretch", edge: 30, horizon: 3.4, critical_stretch: 0.5 };

struct Block(World);

impl Columns for Block {
    fn visit(&mut self, v: &mut Visitor<'_>) {
        self.0.visit(v);
    }
}

/// A run folder with the frozen columns of a block in it.
fn run() -> (TempDir, Block, Store, About) {
    let dir = tempdir().expect("a folder");
    let mut block = Block(BLOCK.world(&fissure_materials::registry()));
    let mut store = Store::create(dir.path()).expect("a store");
    let about = About { step: 0, time: 0.0, scene: String::new(), program: String::new(), notes: Vec::new() };
    store.write_frozen(&mut block, &about).expect("room");
    (dir, block, store, about)
}

/// A checkpoint of a plastic block is written; the newest is found, opened and mapped.
pub fn checkpoint(c: &mut Criterion) {
    let mut group = group(c, "checkpoint");
    let per = || Per { unit: "directed bond", count: BLOCK.directed() };
    let mut made = None;
    measure(&mut group, "checkpoint write", per(), || {
        let (_, block, store, about) = made.get_or_insert_with(run);
        let (time, written) = timed(|| store.write_live(block, about).expect("room"));
        (time, Some(written.bytes as f64 / BLOCK.directed() as f64))
    });
    let mut made = None;
    measure(&mut group, "checkpoint open", per(), || {
        let (_, block, store, about) = made.get_or_insert_with(run);
        let written = store.write_live(block, about).expect("room");
        let (time, ()) = timed(|| {
            let latest = store.latest_trusted().expect("a checkpoint");
            latest.live.restore(block, &latest.frozen).expect("the same columns");
        });
        (time, Some(written.bytes as f64 / BLOCK.directed() as f64))
    });
}

/// The surface of a torn box is written as a frame.
pub fn frame(c: &mut Criterion) {
    let mut group = group(c, "frame");
    let mut made = None;
    measure(&mut group, "frame write", Torn::TETS, || {
        let (frame, dir) = made.get_or_insert_with(|| (Torn::new().frame(), tempdir().expect("a folder")));
        let (time, path) = timed(|| FrameFolder::new(dir.path()).write(frame).expect("room"));
        let length = path.metadata().map_or(0, |m| m.len());
        (time, Some(length as f64 / Torn::TETS.count as f64))
    });
}
