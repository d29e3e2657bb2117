//! A run that was stopped, interrupted or killed, and then resumed, has the same bytes as one that never was.

use std::collections::BTreeMap;
use std::fs;
use std::io::{BufRead, BufReader};
use std::process::{Child, Command};
use std::time::Duration;

use crate::workshop::{Answer, Workshop, assert_same, names};

fn whole(shop: &Workshop, more: &[&str]) -> BTreeMap<String, Vec<u8>> {
    shop.good(&[&["run", "box.toml", "--out", "whole", "--quiet"], more].concat());
    shop.bytes("whole")
}

#[test]
fn stopped_by_until() {
    let shop = Workshop::new();
    let whole = whole(&shop, &[]);
    // before the first step is done, in free fall, on a frame, at the first contact, in the middle of breaking, at the end
    for (k, until) in ["1e-9", "0.0007", "0.01", "0.0123", "0.021", "0.0333", "0.0595"].iter().enumerate() {
        let run = format!("r{k}");
        let stopped = shop.good(&["run", "box.toml", "--out", &run, "--until", until]);
        assert!(stopped.out.contains(&format!("go on with `fissure resume {run}`")), "{stopped}");
        assert!(!shop.path(&run).join("last.png").exists(), "the picture is of the last frame");
        let resumed = shop.good(&["resume", &run]);
        assert!(resumed.out.starts_with("resumed "), "{resumed}");
        assert_same(&whole, &shop.bytes(&run), &format!("stopped at {until} s"));
    }
}

#[test]
fn stopped_many_times_with_other_threads() {
    let shop = Workshop::new();
    let whole = whole(&shop, &["--threads", "2"]);
    shop.good(&["run", "box.toml", "--out", "r", "--until", "0.005", "--threads", "1"]);
    for (until, threads) in [("0.013", "2"), ("0.0222", "1"), ("0.0223", "3"), ("0.04", "1"), ("9", "2")] {
        shop.good(&["resume", "r", "--until", until, "--threads", threads]);
    }
    assert_same(&whole, &shop.bytes("r"), "stopped five times");
    let log = fs::read_to_string(shop.path("r/run.log")).unwrap();
    assert_eq!(log.matches("resumed ").count(), 5, "{log}");
    assert_eq!(log.matches("finished at step").count(), 1, "{log}");
}

#[test]
fn a_finished_run_says_so() {
    let shop = Workshop::new();
    shop.good(&["run", "box.toml", "--out", "r", "--set", "duration=0.01", "--quiet"]);
    let before = shop.bytes("r");
    let answer = shop.good(&["resume", "r"]);
    assert!(answer.out.contains("finished") && answer.out.lines().count() == 1, "{answer}");
    assert_same(&before, &shop.bytes("r"), "nothing is done");
    assert_eq!(shop.good(&["resume", "r", "--quiet"]).out, "");
}

/// The way to let a finished run go on.
#[test]
fn a_changed_scene_is_refused_unless_forced() {
    let shop = Workshop::new();
    let whole = whole(&shop, &[]);
    shop.good(&["run", "box.toml", "--out", "r", "--set", "duration=0.02", "--quiet"]);
    let kept = fs::read_to_string(shop.path("r/scene.toml")).unwrap();
    shop.put("r/scene.toml", format!("# longer\n{}", kept.replace("duration = 0.02", "duration = 0.06")));
    let before = shop.bytes("r");
    let sentence = shop.refusal(&["resume", "r"]);
    assert!(sentence.contains("duration: 0.02 became 0.06; undo that") && sentence.contains("--force"), "{sentence}");
    assert_same(&before, &shop.bytes("r"), "nothing is done");
    let resumed = shop.good(&["resume", "r", "--force"]);
    assert!(resumed.out.starts_with("the scene was changed after the checkpoint"), "{resumed}");
    let longer = shop.bytes("r");
    let frames = |m: &BTreeMap<String, Vec<u8>>| {
        m.iter().filter(|(k, _)| k.starts_with("frames/")).map(|(k, v)| (k.clone(), v.clone())).collect()
    };
    assert_same(&frames(&whole), &frames(&longer), "as if it had been longer from the start");
    let newest = names(&shop.path("r")).into_iter().rfind(|n| n.starts_with("checkpoint_")).unwrap();
    let told = shop.good(&["info", &format!("r/{newest}")]);
    assert!(told.out.contains("scene changed at step ") && told.out.contains("duration: 0.02 became 0.06"), "{told}");
    // what means the same is no change
    shop.put("r/scene.toml", format!("# a comment\n{}", fs::read_to_string(shop.path("r/scene.toml")).unwrap()));
    let again = shop.good(&["resume", "r"]);
    assert!(again.out.contains("is finished") && !again.out.contains("changed"), "{again}");
}

/// By steps, by the clock, or by simulated time: the same bits.
#[test]
fn checkpoints_change_nothing() {
    let shop = Workshop::new();
    let whole = whole(&shop, &["--set", "duration=0.03"]);
    for (run, key) in [("s", "output.checkpoint_steps=7"), ("m", "output.checkpoint_minutes=1e-9")] {
        let scene = fs::read_to_string(shop.path("box.toml")).unwrap().replace("checkpoint_every = 0.008\n", "");
        shop.put("other.toml", scene);
        shop.good(&[
            "run",
            "other.toml",
            "--out",
            run,
            "--set",
            "duration=0.03",
            "--set",
            key,
            "--until",
            "0.02",
            "--quiet",
        ]);
        let steps: Vec<u64> = names(&shop.path(run))
            .iter()
            .filter_map(|n| n.strip_prefix("checkpoint_")?.strip_suffix(".fis")?.parse().ok())
            .collect();
        assert_eq!(steps.len(), 5, "{steps:?}");
        let apart = if run == "s" { 7 } else { 1 };
        assert!(steps[..4].windows(2).all(|s| s[1] == s[0] + apart), "{steps:?}");
        shop.good(&["resume", run, "--quiet"]);
        let mut ours = shop.bytes(run);
        let theirs = whole.iter().filter(|(k, _)| !k.ends_with(".fis")).map(|(k, v)| (k.clone(), v.clone())).collect();
        ours.retain(|k, _| !k.ends_with(".fis")); // they hold the scene, which differs
        assert_same(&theirs, &ours, key);
        let answer = shop.call(&["diff", "whole", run]);
        assert!(!answer.out.contains("first differing step"), "{answer}");
    }
}

#[test]
fn until_a_time_that_is_past() {
    let shop = Workshop::new();
    shop.good(&["run", "box.toml", "--out", "r", "--until", "0.02", "--quiet"]);
    let before = shop.bytes("r");
    let sentence = shop.refusal(&["resume", "r", "--until", "0.01"]);
    assert!(sentence.contains("--until 0.01") && sentence.contains("0.02"), "{sentence}");
    assert_same(&before, &shop.bytes("r"), "nothing is done");
}

/// Long enough to be met in the middle: some thousand steps.
const LONG: [&str; 6] =
    ["--set", "safety=0.1", "--set", "output.checkpoint_every=0.003", "--set", "output.frame_every=0.005"];

/// Starts a run and waits for its frame `number`.
fn until_frame(shop: &Workshop, arguments: &[&str], number: u64) -> (Child, BufReader<std::process::ChildStdout>) {
    let mut child = shop.start(&[arguments, &["--json"]].concat());
    let mut out = BufReader::new(child.stdout.take().unwrap());
    let mut line = String::new();
    let wanted = format!("\"frame\":{number},");
    while !line.contains(&wanted) {
        line.clear();
        assert!(out.read_line(&mut line).unwrap() > 0, "no frame {number}");
    }
    (child, out)
}

#[cfg(unix)]
fn signal(child: &Child, name: &str) {
    let status = Command::new("sh").args(["-c", &format!("kill -{name} {}", child.id())]).status().unwrap();
    assert!(status.success());
}

#[cfg(unix)]
#[test]
fn interrupted() {
    let shop = Workshop::new();
    let whole = whole(&shop, &LONG);
    for frame in [0, 3, 6] {
        let run = format!("r{frame}");
        let arguments = [&["run", "box.toml", "--out", &run], &LONG[..]].concat();
        let (child, mut out) = until_frame(&shop, &arguments, frame);
        signal(&child, "INT");
        let mut rest = String::new();
        while out.read_line(&mut rest).unwrap() > 0 {}
        let answer = Answer::of(&arguments, child.wait_with_output().unwrap());
        assert_eq!((answer.code, &answer.err[..]), (Some(130), ""), "{answer}");
        assert!(rest.contains("\"outcome\":\"stopped\""), "{rest}");
        let log = fs::read_to_string(shop.path(&run).join("run.log")).unwrap();
        let step: u64 = log.split("stopped at step ").nth(1).unwrap().split(',').next().unwrap().parse().unwrap();
        assert!(shop.path(&run).join(format!("checkpoint_{step:08}.fis")).exists(), "a checkpoint of step {step}");
        shop.good(&["resume", &run, "--quiet"]);
        assert_same(&whole, &shop.bytes(&run), &format!("interrupted after frame {frame}"));
    }
}

#[test]
fn killed() {
    let shop = Workshop::new();
    let whole = whole(&shop, &LONG);
    let mut noise = 7_u64;
    for frame in [0, 2, 5, 9] {
        let run = format!("r{frame}");
        let arguments = [&["run", "box.toml", "--out", &run], &LONG[..]].concat();
        let (mut child, _out) = until_frame(&shop, &arguments, frame);
        noise = noise.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        std::thread::sleep(Duration::from_micros(noise >> 48)); // up to 65 ms
        child.kill().unwrap();
        child.wait().unwrap();
        if frame == 0 && names(&shop.path(&run)).iter().all(|n| !n.starts_with("checkpoint_")) {
            let sentence = shop.refusal(&["resume", &run]);
            assert!(sentence.contains("no complete checkpoint"), "{sentence}");
            continue;
        }
        shop.good(&["resume", &run, "--quiet"]);
        assert_same(&whole, &shop.bytes(&run), &format!("killed after frame {frame}"));
        let left: Vec<String> = [names(&shop.path(&run)), names(&shop.path(&run).join("frames"))].concat();
        assert!(left.iter().all(|n| !n.starts_with('.')), "temporary files are left: {left:?}");
    }
}

#[test]
fn the_newest_checkpoint_is_damaged() {
    let shop = Workshop::new();
    let whole = whole(&shop, &[]);
    shop.good(&["run", "box.toml", "--out", "r", "--until", "0.045", "--quiet"]);
    let newest = names(&shop.path("r")).into_iter().rfind(|n| n.starts_with("checkpoint_")).unwrap();
    let path = shop.path("r").join(&newest);
    let mut bytes = fs::read(&path).unwrap();
    let middle = bytes.len() / 2;
    bytes[middle] ^= 4;
    fs::write(&path, &bytes).unwrap();
    let resumed = shop.good(&["resume", "r"]);
    assert!(resumed.out.contains("passed over") && resumed.out.contains(&newest), "{resumed}");
    assert_same(&whole, &shop.bytes("r"), "one checkpoint earlier");
}

#[test]
fn nothing_to_resume() {
    let shop = Workshop::new();
    let sentence = shop.refusal(&["resume", "nowhere"]);
    assert!(sentence.starts_with("nowhere is no run folder"), "{sentence}");
    assert!(!shop.path("nowhere").exists());
    let sentence = shop.refusal(&["resume", "box.toml"]);
    assert!(sentence.starts_with("box.toml is no run folder"), "{sentence}");
    fs::create_dir(shop.path("begun")).unwrap();
    shop.put("begun/scene.toml", crate::workshop::BOX);
    let sentence = shop.refusal(&["resume", "begun"]);
    assert!(sentence.contains("begun") && sentence.contains("no complete checkpoint"), "{sentence}");
}

/// Two programs in one folder would overwrite each other's frames and checkpoints.
#[test]
fn a_running_run_is_not_resumed() {
    let shop = Workshop::new();
    let arguments = [&["run", "box.toml", "--out", "r"], &LONG[..]].concat();
    let (mut child, _out) = until_frame(&shop, &arguments, 1);
    let sentence = shop.refusal(&["resume", "r"]);
    assert!(sentence.starts_with("r is being run"), "{sentence}");
    child.kill().unwrap();
    child.wait().unwrap();
    shop.good(&["resume", "r", "--until", "0.03", "--quiet"]);
}

/// A box that is pulled by both ends until it tears, every frame an equilibrium.
const PULLED: &str = r#"
duration = 0.06
gravity = [0, 0, 0]
integrator = "relax"
residual = 1e-4

[body.box]
shape = { kind = "box", size = [0.1, 0.1, 0.1] }
tets = 1000
density = 1000
material = { law = "plastic", bulk_modulus = 5e5, shear_modulus = 3e5, yield_stretch = 0.02 }
fracture = { critical_stretch = 0.05 }

[[anchor]]
body = "box"
name = "bottom"
box = [[-1, -1, -1], [1, -0.03, 1]]

[[anchor]]
body = "box"
name = "top"
box = [[-1, 0.03, -1], [1, 1, 1]]
velocity = [0, 0.1, 0]

[output]
frame_every = 0.01
checkpoint_every = 0.02
picture = { width = 64, height = 48 }
"#;

#[test]
fn by_other_integrators() {
    let shop = Workshop::new();
    shop.put("box.toml", PULLED);
    let whole = whole(&shop, &[]);
    shop.good(&["run", "box.toml", "--out", "r", "--until", "0.03"]);
    let answer = shop.good(&["resume", "r"]);
    assert_same(&whole, &shop.bytes("r"), "stopped between equilibria");
    let log = fs::read_to_string(shop.path("r/run.log")).unwrap();
    assert!(log.contains("6 steps of 1.000e-2 s (one a frame), relax"), "{log}");
    assert_eq!(log.matches(", equilibrium in ").count(), 6, "{log}");
    assert!(answer.out.contains("anchor top: holding takes a force of ("), "{answer}");

    shop.put("box.toml", PULLED.replace("\"relax\"\nresidual = 1e-4", "\"velocity_verlet\""));
    let json = shop.good(&["run", "box.toml", "--out", "v", "--json"]);
    let end = json.out.lines().last().map(|line| serde_json::from_str::<serde_json::Value>(line).unwrap()).unwrap();
    let pull = |k: usize| end["reactions"][k]["force"][1].as_f64().unwrap();
    assert!(pull(0) < 0.0 && pull(1) > 0.0 && end["reactions"][1]["anchor"] == "top", "{end}");
    shop.good(&["run", "box.toml", "--out", "w", "--until", "0.0123"]);
    shop.good(&["resume", "w"]);
    assert_same(&shop.bytes("v"), &shop.bytes("w"), "stopped on the way");
}
