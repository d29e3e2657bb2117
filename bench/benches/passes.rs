//! The step and its passes on a cubic lattice, and the step on tetrahedra, per directed bond. One thread, but for the steps.

use std::cell::{Cell, OnceCell};
use std::time::Duration;

use criterion::Criterion;
use fissure_bench::{Blind, Cloud, Lattice, SPACING, bytes_per_bond, on_threads, phase_of_a_step};
use fissure_engine::buffer::AnyBuffer;
use fissure_engine::column::Life;
use fissure_engine::{Families, Phase, Registry, World};
use fissure_materials as laws;
use fissure_meshing::family::families;
use fissure_meshing::order::morton_order;
use fissure_meshing::shapes;
use fissure_meshing::tetrahedralise::{Options, size_for, tetrahedralise};
use glam::DVec3;

use crate::{Per, Sample, counted, group, measure, timed};

/// Small enough to be built in a moment, large enough that its bonds (56 MB) don't lie in a cache of one core.
const SOME: Lattice<'static> =
    Lattice { law: "isotropic", criterion: "critical_stretch", edge: 37, horizon: 3.4, critical_stretch: 0.5 };

fn bonds(lattice: &Lattice<'_>) -> Per {
    Per { unit: "directed bond", count: lattice.directed() }
}

/// A world that is built when it is first asked for, so a benchmark that is filtered out costs nothing.
struct Lazy<'a> {
    lattice: Lattice<'a>,
    registry: Registry,
    world: OnceCell<(World, f64)>,
}

impl<'a> Lazy<'a> {
    fn new(lattice: Lattice<'a>, registry: &Registry) -> Self {
        Self { lattice, registry: registry.clone(), world: OnceCell::new() }
    }

    /// The world, and its bytes per bond.
    fn get(&mut self) -> (&mut World, f64) {
        self.world.get_or_init(|| {
            let mut world = self.lattice.world(&self.registry);
            let bytes = bytes_per_bond(&mut world).1;
            (world, bytes)
        });
        let (world, bytes) = self.world.get_mut().expect("just made");
        (world, *bytes)
    }

    fn phase(&mut self, phase: Phase) -> Sample {
        let (world, bytes) = self.get();
        (on_threads(1, || phase_of_a_step(world, phase)), Some(bytes))
    }
}

/// The whole step, default law: one thread and all. Bytes are those of all columns.
pub fn step(c: &mut Criterion) {
    let mut group = group(c, "step");
    let mut lazy = Lazy::new(SOME, &laws::registry());
    for threads in [1, rayon::current_num_threads()] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        measure(&mut group, &format!("isotropic, {threads} threads"), bonds(&SOME), || {
            let (world, bytes) = lazy.get();
            (pool.install(|| timed(|| world.step().expect("stable")).0), Some(bytes))
        });
    }
}

/// The whole step on the tetrahedra of a ball, no two families alike.
pub fn irregular(c: &mut Criterion) {
    let mut group = group(c, "irregular");
    let (mut made, count) = (None, Cell::new(0));
    for threads in [1, rayon::current_num_threads()] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        counted(&mut group, &format!("isotropic, tetrahedra, {threads} threads"), "directed bond", &count, || {
            let (world, bytes) = made.get_or_insert_with(|| {
                let (cloud, families) = ball();
                let mut world = SOME.world_of(&laws::registry(), &cloud, families);
                count.set(world.bond_counts().0);
                let bytes = bytes_per_bond(&mut world).1;
                (world, bytes)
            });
            (pool.install(|| timed(|| world.step().expect("stable")).0), Some(*bytes))
        });
    }
}

/// About 3·10⁵ tetrahedra in a ball as large as the lattice of [`SOME`], and families of about 120.
fn ball() -> (Cloud, Families) {
    let surface = shapes::ball(0.5 * f64::from(SOME.edge) * SPACING, 5).expect("a ball");
    let (mesh, _) = tetrahedralise(&surface, &Options::new(size_for(&surface, 300_000))).expect("a closed surface");
    let centres: Vec<DVec3> = (0..mesh.tets.len()).map(|t| mesh.barycentre(t)).collect();
    let order = morton_order(&centres);
    let points: Vec<DVec3> = order.iter().map(|&t| centres[t as usize]).collect();
    let volumes: Vec<f64> = order.iter().map(|&t| mesh.volume(t as usize)).collect();
    let cloud = Cloud { spacing: (volumes.iter().sum::<f64>() / points.len() as f64).cbrt(), points, volumes };
    let families = families(&cloud.points, SOME.horizon * cloud.spacing, None).expect("families");
    (cloud, families)
}

/// The whole step of every law of bonds with no fracture, and of `isotropic` with every criterion.
pub fn law(c: &mut Criterion) {
    let registry = laws::registry();
    let mut group = group(c, "law");
    let criteria = &registry.entry("isotropic").expect("registered").criteria;
    let each = registry.bond_laws().map(|e| (e.name, "none"));
    for (law, criterion) in each.chain(criteria.iter().filter(|c| c.name != "none").map(|c| ("isotropic", c.name))) {
        let lattice = Lattice { law, criterion, edge: 24, ..SOME };
        let mut lazy = Lazy::new(lattice, &registry);
        measure(&mut group, &format!("{law}, fracture {criterion}"), bonds(&lattice), || {
            let (world, bytes) = lazy.get();
            (on_threads(1, || timed(|| world.step().expect("stable")).0), Some(bytes))
        });
    }
}

/// The laws without their θ pass.
fn blind() -> Registry {
    Registry::default()
        .bonds::<Blind<laws::Isotropic>, _>()
        .bonds::<Blind<laws::Plastic>, _>()
        .bonds::<Blind<laws::Anisotropic<laws::Isotropic>>, _>()
        .bonds::<Blind<laws::Viscoelastic>, _>()
        .bonds::<Blind<laws::Lps>, _>()
        .bonds::<laws::Pmb, _>()
}

/// The pass over dilatations: what *respond* takes longer with it than without, the least of either so far.
pub fn theta(c: &mut Criterion) {
    let mut group = group(c, "theta");
    let (mut with, mut without) = (Lazy::new(SOME, &laws::registry()), Lazy::new(SOME, &blind()));
    let mut least = [Duration::MAX; 2];
    measure(&mut group, "theta pass", bonds(&SOME), || {
        let ((all, bytes), (force, _)) = (with.phase(Phase::Respond), without.phase(Phase::Respond));
        least = [least[0].min(all), least[1].min(force)];
        (least[0].saturating_sub(least[1]), bytes)
    });
}

/// The pass over forces with bits of fracture, and the gathering of records before it.
pub fn force(c: &mut Criterion) {
    let (registry, mut group) = (blind(), group(c, "force"));
    for entry in registry.entries() {
        let mut lazy = Lazy::new(Lattice { law: entry.name, ..SOME }, &registry);
        measure(&mut group, &format!("force, {}", entry.name), bonds(&SOME), || lazy.phase(Phase::Respond));
    }
}

/// Memory flows.
pub fn flow(c: &mut Criterion) {
    let (registry, mut group) = (laws::registry(), group(c, "flow"));
    for law in ["plastic", "viscoelastic"] {
        let mut lazy = Lazy::new(Lattice { law, ..SOME }, &registry);
        measure(&mut group, &format!("flow, {law}"), bonds(&SOME), || lazy.phase(Phase::Flow));
    }
}

/// Some bonds break: the same step again and again, from a copy of the state before it.
pub fn fracture(c: &mut Criterion) {
    let mut group = group(c, "fracture");
    // between what the motion stretches bonds by in the first step, 0.8e-5, and in two
    let lattice = Lattice { critical_stretch: 1.2e-5, ..SOME };
    let mut lazy = Lazy::new(lattice, &laws::registry());
    let mut kept: Option<Vec<Vec<u8>>> = None;
    let mut broken = 0.0;
    measure(&mut group, "fracture", bonds(&lattice), || {
        let (world, bytes) = lazy.get();
        let kept = kept.get_or_insert_with(|| {
            on_threads(1, || (0..2).for_each(|_| world.step().expect("stable")));
            let mut live = Vec::new();
            each_live(world, |column| live.push(column.bytes().to_vec()));
            live
        });
        let mut columns = kept.iter();
        each_live(world, |column| assert!(column.set_bytes(columns.next().expect("as many as before"))));
        let before = world.bond_counts().1;
        let time = on_threads(1, || phase_of_a_step(world, Phase::Fracture));
        broken = (world.bond_counts().1 - before) as f64 / lattice.directed() as f64;
        assert!(broken > 0.0, "nothing broke");
        (time, Some(bytes))
    });
    if broken > 0.0 {
        println!("{:.2} % of the bonds break in that step", 100.0 * broken);
    }
}

fn each_live(world: &mut World, mut see: impl FnMut(&mut dyn AnyBuffer)) {
    world.visit(&mut |_, column, buffer| {
        if column.life == Life::Live {
            see(buffer);
        }
    });
}

/// Positions follow velocities, per particle.
pub fn integrate(c: &mut Criterion) {
    let mut group = group(c, "integrate");
    let mut lazy = Lazy::new(SOME, &laws::registry());
    measure(&mut group, "integrate", Per { unit: "particle", count: SOME.particles() }, || {
        (lazy.phase(Phase::Integrate).0, None)
    });
}
