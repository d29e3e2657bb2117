//! Sizes and speeds on files of 1 GB. Run with `cargo test -p fissure-io speed -- --ignored --nocapture`.

use std::io::Write;
use std::time::{Duration, Instant};

use super::*;

/// The best of a few runs: other work on the machine only ever adds to a time.
fn best<T>(runs: usize, mut work: impl FnMut() -> T) -> Duration {
    let time = || {
        let start = Instant::now();
        std::hint::black_box(work());
        start.elapsed()
    };
    std::iter::repeat_with(time).take(runs).min().unwrap()
}

/// Resident memory of this process [bytes]; 0 where the system has no way to ask.
fn resident() -> usize {
    let status = std::fs::read_to_string("/proc/self/statm").unwrap_or_default();
    status.split(' ').nth(1).and_then(|pages| pages.parse::<usize>().ok()).unwrap_or(0) * 4096
}

#[test]
#[ignore = "writes 3 GB"]
fn opening_takes_no_longer_for_large_files() {
    let dir = tempfile::tempdir().unwrap();
    let (small_frozen, small_live) = {
        std::fs::create_dir(dir.path().join("small")).unwrap();
        pair(&dir.path().join("small"), &mut thing(10))
    };
    let n = 8_000_000;
    let mut large = thing(n);
    let copy = best(2, || large.position.to_vec());
    eprintln!("memory copy {:.2} GB/s", 24.0 * n as f64 / 1e9 / copy.as_secs_f64());
    let mut plain = Vec::new();
    large.visit(&mut |_, _, buffer| plain.push(buffer.bytes().to_vec()));
    let (mut write_time, mut plain_time, mut written) = (Duration::MAX, Duration::MAX, None);
    for _ in 0..3 {
        write_time = write_time.min(best(1, || written = Some(pair(dir.path(), &mut large))));
        plain_time = plain_time.min(best(1, || {
            let mut file = std::fs::File::create(dir.path().join("plain")).unwrap();
            plain.iter().for_each(|bytes| file.write_all(bytes).unwrap());
            file.sync_all().unwrap();
        }));
        std::fs::remove_file(dir.path().join("plain")).unwrap();
    }
    let (frozen_path, live_path) = written.unwrap();
    let bytes = [&frozen_path, &live_path].map(|p| p.metadata().unwrap().len()).iter().sum::<u64>() as f64;
    let rate = |time: Duration| bytes / 1e9 / time.as_secs_f64();
    eprintln!("{:.2} GB: written {:.2} GB/s, plain {:.2} GB/s", bytes / 1e9, rate(write_time), rate(plain_time));
    let all = bits(&mut large);
    drop((plain, large));

    let small_open = best(20, || (Opened::open(&small_frozen).unwrap(), Opened::open(&small_live).unwrap()));
    let open = best(20, || (Opened::open(&frozen_path).unwrap(), Opened::open(&live_path).unwrap()));
    eprintln!("open both files: small {small_open:?}, large {open:?}");
    assert!(open < Duration::from_millis(5), "{open:?}"); // measured 0.02 ms

    let before = resident();
    let (frozen, live) = (Opened::open(&frozen_path).unwrap(), Opened::open(&live_path).unwrap());
    let verify = best(2, || (frozen.verify().unwrap(), live.verify().unwrap()));
    let read = best(1, || live.column::<DVec3>("vase", "position").unwrap()[n / 2]);
    let mut restored = Thing::default();
    let restore = best(1, || live.restore(&mut restored, &frozen).unwrap());
    let grown = resident().saturating_sub(before);
    eprintln!("verify {:.2} GB/s, read {read:?}, restore {restore:?}, resident +{} kB", rate(verify), grown / 1000);
    assert!((grown as f64) < bytes / 100.0, "{grown} bytes resident"); // measured 1.8 MB of 1 GB, 1 MB of it the buffer
    assert!(bits(&mut restored) == all);
}
