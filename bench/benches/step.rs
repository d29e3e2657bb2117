//! The peridynamic step on a cubic lattice with 161 neighbours, per directed bond: one thread and all of them.

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use fissure_engine::World;

fn bonds(world: &World) -> u64 {
    world.bond_counts().0
}

fn step(c: &mut Criterion) {
    let mut group = c.benchmark_group("step");
    group.sample_size(10);
    let mut world = fissure_bench::lattice(40, 3.4);
    group.throughput(Throughput::Elements(bonds(&world)));
    for threads in [1, rayon::current_num_threads()] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        group.bench_function(BenchmarkId::new("isotropic", format!("{threads} threads")), |b| {
            pool.install(|| b.iter(|| world.step().expect("stable")));
        });
    }
    group.finish();
}

/// One thread, every law with no fracture; and every criterion beside `isotropic`.
fn laws(c: &mut Criterion) {
    let registry = fissure_materials::registry();
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("threads");
    let mut group = c.benchmark_group("law");
    group.sample_size(10);
    let of_each = registry.entries().iter().map(|e| (e.name, "none"));
    let criteria = registry.entry("isotropic").expect("registered").criteria.iter().map(|c| ("isotropic", c.name));
    for (law, criterion) in of_each.chain(criteria.filter(|(_, c)| *c != "none")) {
        let mut world = fissure_bench::lattice_of(&registry, law, criterion, 24, 3.4);
        group.throughput(Throughput::Elements(bonds(&world)));
        group.bench_function(BenchmarkId::new(law, criterion), |b| {
            pool.install(|| b.iter(|| world.step().expect("stable")));
        });
    }
    group.finish();
}

criterion_group!(benches, step, laws);
criterion_main!(benches);
