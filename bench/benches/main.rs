//! Where the time goes, piece by piece. `cargo bench -p fissure-bench -- step` runs one group; those that are not run build
//! nothing. Beside what criterion says, every benchmark prints a line of a table: the least time per directed bond or
//! particle, and the bytes behind it.

mod contact;
mod files;
mod meshes;
mod passes;

use std::cell::Cell;
use std::time::{Duration, Instant};

use criterion::measurement::WallTime;
use criterion::{BenchmarkGroup, Criterion, Throughput, criterion_group, criterion_main};

/// A group of few samples, for things that take long.
fn group<'a>(c: &'a mut Criterion, name: &str) -> BenchmarkGroup<'a, WallTime> {
    let mut group = c.benchmark_group(name);
    group.sample_size(10).warm_up_time(Duration::from_millis(500)).measurement_time(Duration::from_secs(3));
    group
}

/// What one measurement is of: so many things called `unit`, and bytes for each where that says something.
struct Per {
    unit: &'static str,
    count: u64,
}

/// A time, and the bytes per thing that were held or moved, if they are of interest.
type Sample = (Duration, Option<f64>);

/// Benchmarks `work`, which times itself.
fn measure(group: &mut BenchmarkGroup<'_, WallTime>, name: &str, per: Per, work: impl FnMut() -> Sample) {
    group.throughput(Throughput::Elements(per.count));
    counted(group, name, per.unit, &Cell::new(per.count), work);
}

/// The same where only `work` finds out how many there are.
fn counted(
    group: &mut BenchmarkGroup<'_, WallTime>,
    name: &str,
    unit: &str,
    count: &Cell<u64>,
    mut work: impl FnMut() -> Sample,
) {
    let (mut least, mut held) = (Duration::MAX, None);
    group.bench_function(name, |b| {
        b.iter_custom(|times| {
            let one = |_| {
                let (time, bytes) = work();
                least = least.min(time);
                held = bytes;
                time
            };
            (0..times).map(one).sum()
        });
    });
    if least < Duration::MAX {
        let ns = least.as_secs_f64() * 1e9 / count.get() as f64;
        let bytes = held.map_or(String::new(), |b| format!(", {b:.2} bytes"));
        println!("{name:<36} {ns:>9.3} ns per {unit}{bytes}\n");
    }
}

/// How long `work` takes.
fn timed<T>(work: impl FnOnce() -> T) -> (Duration, T) {
    let start = Instant::now();
    let out = work();
    (start.elapsed(), out)
}

criterion_group!(
    benches,
    passes::step,
    passes::irregular,
    passes::law,
    passes::theta,
    passes::force,
    passes::flow,
    passes::fracture,
    passes::integrate,
    contact::contact,
    meshes::families,
    meshes::surface,
    files::checkpoint,
    files::frame,
);
criterion_main!(benches);
