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

criterion_group!(benches, step);
criterion_main!(benches);
