//! The machine: what it is, how fast it reads memory, and what this process takes of it.

use std::time::Instant;

use rayon::prelude::*;

/// What identifies the machine that a number was taken on.
#[derive(Clone, Debug)]
pub struct Machine {
    /// The processor, as the system calls it.
    pub processor: String,
    /// Threads that run at once.
    pub threads: usize,
    /// Vector instructions that this build uses.
    pub features: Vec<&'static str>,
    /// Processes that were running or waiting over the last minute, if the system tells. Above 1 before a benchmark,
    /// times are those of a busy machine.
    pub load: Option<f64>,
}

impl Machine {
    /// This machine.
    pub fn here() -> Self {
        let cpus = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
        let named = |line: &&str| line.starts_with("model name") || line.starts_with("Model");
        let name = cpus.lines().find(named).and_then(|line| line.split_once(':')).map(|(_, name)| name.trim());
        let load = std::fs::read_to_string("/proc/loadavg").ok();
        let known = [
            ("avx512f", cfg!(target_feature = "avx512f")),
            ("avx2", cfg!(target_feature = "avx2")),
            ("fma", cfg!(target_feature = "fma")),
            ("neon", cfg!(target_feature = "neon")),
        ];
        Self {
            processor: format!("{} ({})", name.unwrap_or("unknown processor"), std::env::consts::ARCH),
            threads: std::thread::available_parallelism().map_or(1, usize::from),
            features: known.into_iter().filter(|k| k.1).map(|k| k.0).collect(),
            load: load.and_then(|l| l.split(' ').next()?.parse().ok()),
        }
    }

    /// In one line.
    pub fn sentence(&self) -> String {
        let features = if self.features.is_empty() { "no wide vectors".into() } else { self.features.join(", ") };
        let load = self.load.map_or(String::new(), |l| format!(", load {l:.1}"));
        format!("{}, {} threads, built for {features}{load}", self.processor, self.threads)
    }
}

/// Processor time of all threads of this process so far [s], as Linux counts it; 0 elsewhere.
pub fn processor_time() -> f64 {
    let tasks = std::fs::read_dir("/proc/self/task").into_iter().flatten().flatten();
    let spent = |task: std::fs::DirEntry| {
        let text = std::fs::read_to_string(task.path().join("schedstat")).ok()?;
        text.split(' ').next()?.parse::<f64>().ok()
    };
    tasks.filter_map(spent).sum::<f64>() * 1e-9
}

/// Memory of this process [B], now and at most so far, as Linux counts it; 0 elsewhere.
pub fn resident() -> (u64, u64) {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let of = |key: &str| -> Option<u64> {
        let line = status.lines().find_map(|line| line.strip_prefix(key))?;
        Some(line.trim().trim_end_matches(" kB").parse::<u64>().ok()? * 1024)
    };
    (of("VmRSS:").unwrap_or(0), of("VmHWM:").unwrap_or(0))
}

/// Bandwidth of memory [B/s] with the threads of the present pool.
#[derive(Clone, Copy, Debug)]
pub struct Bandwidth {
    /// Adding up an array.
    pub read: f64,
    /// a = b + s c, counted as three arrays as STREAM does.
    pub triad: f64,
}

/// Bytes of each array at most: more than caches hold, also large ones that are shared with other virtual machines.
const MOST: usize = 256 << 20;
/// Elements that one task works through.
const PIECE: usize = 1 << 16;

impl Bandwidth {
    /// The best of `runs`, over arrays of `bytes`, but 256 MiB at most.
    pub fn measure(runs: usize, bytes: usize) -> Self {
        let n = bytes.clamp(PIECE, MOST) / size_of::<f64>();
        let filled = |x: f64| -> Vec<f64> { (0..n).into_par_iter().map(|_| x).collect() };
        let (mut a, b, c) = (filled(0.0), filled(1.0), filled(2.0));
        let least = |work: &mut dyn FnMut()| {
            let time = |_| {
                let start = Instant::now();
                work();
                start.elapsed().as_secs_f64()
            };
            (0..runs.max(1)).map(time).fold(f64::INFINITY, f64::min)
        };
        // as bits, for those may be added in any order: eight lanes wide
        let sum = |piece: &[f64]| piece.iter().fold(0u64, |s, x| s.wrapping_add(x.to_bits()));
        let read = least(&mut || {
            std::hint::black_box(b.par_chunks(PIECE).map(sum).reduce(|| 0, u64::wrapping_add));
        });
        let triad = least(&mut || {
            let pieces = a.par_chunks_mut(PIECE).zip(b.par_chunks(PIECE)).zip(c.par_chunks(PIECE));
            pieces.for_each(|((a, b), c)| a.iter_mut().zip(b).zip(c).for_each(|((a, b), c)| *a = b + 3.0 * c));
            std::hint::black_box(&a);
        });
        Self { read: (n * 8) as f64 / read, triad: (n * 24) as f64 / triad }
    }

    /// Directed bonds per second that reading eight bytes of each twice would allow: neighbour and weight, in the pass over
    /// dilatations and in that over forces.
    pub fn floor(&self) -> f64 {
        self.read / 16.0
    }
}
