//! What a run leaves and what it says.

use std::fs;

use serde_json::Value;

use crate::workshop::{Workshop, assert_same, names, open_edges};

#[test]
fn a_run_leaves_its_folder() {
    let shop = Workshop::new();
    let answer = shop.good(&["run", "box.toml", "--out", "r"]);
    let run = shop.path("r");
    let expected =
        ["checkpoint_", "frames", "frozen.fis", "last.png", "particles", "run.log", "scene.toml", "series.csv"];
    for name in names(&run) {
        assert!(expected.iter().any(|e| name.starts_with(e)), "{name} is left");
    }
    for name in &expected[1..] {
        assert!(run.join(name).exists(), "{name} is missing");
    }
    let frames: Vec<String> = (0..=6).map(|n| format!("frame_{n:04}.ply")).collect();
    assert_eq!(names(&run.join("frames")), frames);
    assert_eq!(names(&run.join("particles")), frames);
    assert_eq!(fs::read_to_string(run.join("scene.toml")).unwrap(), crate::workshop::BOX);
    assert!(fs::read(run.join("last.png")).unwrap().starts_with(b"\x89PNG\r\n"));

    let (first, last) = (shop.frame("r", 0), shop.frame("r", 6));
    assert_eq!(first.piece.iter().max(), Some(&0), "whole at first");
    assert!(first.damage.iter().all(|&d| d == 0.0));
    assert!(first.velocity.iter().all(|v| (v[1] + 4.0).abs() < 1e-4), "the velocity of the scene");
    assert!(last.piece.iter().max() > Some(&3), "broken at last");
    assert!(last.inside.contains(&1) && last.inside.contains(&0));
    assert!(last.damage.iter().all(|d| (0.0..=1.0).contains(d)) && last.damage.iter().any(|&d| d > 0.5));
    assert!((last.time - 0.06).abs() < 1e-9, "{}", last.time);
    for number in 0..=6 {
        let frame = shop.frame("r", number);
        assert_eq!(open_edges(&frame), 0, "frame {number} is closed");
        assert!(frame.positions.iter().flatten().all(|x| x.is_finite()));
        assert!(frame.positions.iter().all(|x| x[1] > -0.02), "frame {number} is above the ground");
    }

    let log = fs::read_to_string(run.join("run.log")).unwrap();
    for word in
        ["A box breaks", "body box:", "isotropic", "critical_stretch", "frame 6:", "finished at step", "fragments"]
    {
        assert!(log.contains(word), "{word} in the log:\n{log}");
    }
    for word in ["finished at step", "bonds broken", "fragments", "time: ", "ns per directed bond"] {
        assert!(answer.out.contains(word), "{word} in\n{answer}");
    }
    assert!(!answer.out.contains("NaN") && !answer.out.contains("inf "), "{answer}");
}

#[test]
fn frames_have_their_vertex_properties() {
    let shop = Workshop::new();
    shop.good(&["run", "box.toml", "--out", "r", "--until", "0.001"]);
    let bytes = fs::read(shop.path("r/frames/frame_0000.ply")).unwrap();
    let end = bytes.windows(10).position(|w| w == b"end_header").expect("a PLY header");
    let header = String::from_utf8(bytes[..end].to_vec()).unwrap();
    assert!(header.starts_with("ply\nformat binary_little_endian 1.0\n"), "{header}");
    let vertex = header.split("element vertex").nth(1).unwrap().split("element face").next().unwrap();
    for property in [
        "float x",
        "float y",
        "float z",
        "float velocity_x",
        "float velocity_y",
        "float velocity_z",
        "float damage",
        "uint id",
        "uchar inside",
    ] {
        assert!(vertex.contains(&format!("property {property}\n")), "{property} in\n{header}");
    }
}

#[test]
fn any_number_of_threads_gives_the_same_bytes() {
    let shop = Workshop::new();
    for threads in ["1", "2", "3"] {
        shop.good(&["run", "box.toml", "--out", threads, "--threads", threads, "--quiet"]);
    }
    let one = shop.bytes("1");
    assert_eq!(
        one.len(),
        2 * 7 + 1 + 3,
        "7 frames and their particles, a checkpoint, frozen columns, a picture, the series"
    );
    for threads in ["2", "3"] {
        assert_same(&one, &shop.bytes(threads), &format!("1 and {threads} threads"));
    }
}

#[test]
fn quiet_says_nothing_and_json_only_objects() {
    let shop = Workshop::new();
    let quiet = shop.good(&["run", "box.toml", "--out", "q", "--quiet"]);
    assert_eq!(quiet.out, "");
    let json = shop.good(&["run", "box.toml", "--out", "j", "--json"]);
    let events: Vec<Value> = json.out.lines().map(|l| serde_json::from_str(l).expect(l)).collect();
    let of = |kind: &str| events.iter().filter(|e| e["event"] == kind).collect::<Vec<_>>();
    assert_eq!(of("frame").len(), 7);
    for (number, event) in of("frame").iter().enumerate() {
        assert_eq!(event["frame"], number);
        for key in ["time", "kinetic", "elastic", "gravity"] {
            assert!(event[key].as_f64().is_some_and(f64::is_finite), "{key} of {event}");
        }
    }
    let [end] = of("end")[..] else { panic!("one end") };
    assert_eq!(end["outcome"], "finished");
    assert!(end["fragments"].as_u64() > Some(3) && end["broken"].as_u64() > Some(0), "{end}");
    assert_eq!(events.last(), Some(end));
    let both = shop.call(&["run", "box.toml", "--out", "b", "--json", "--quiet"]);
    assert_eq!(both.code, Some(2), "{both}");
}

#[test]
fn set_changes_the_scene_and_the_run_keeps_it() {
    let shop = Workshop::new();
    let set = [
        "--set",
        "duration=0.01",
        "--set",
        "body.box.fracture.critical_stretch=9",
        "--set",
        "output.frame_every=0.005",
    ];
    shop.good(&[&["run", "box.toml", "--out", "r"][..], &set].concat());
    assert_eq!(names(&shop.path("r/frames")).len(), 3);
    let kept = fs::read_to_string(shop.path("r/scene.toml")).unwrap();
    assert!(kept.contains("duration = 0.01") && kept.contains("critical_stretch = 9"), "{kept}");
    assert_eq!(shop.frame("r", 2).inside.iter().max(), Some(&0), "unbreakable at a stretch of 9");
    shop.good(&["run", "r/scene.toml", "--out", "again"]);
    assert_same(&shop.bytes("r"), &shop.bytes("again"), "the kept scene is the scene");
    let refused = shop.refusal(&["resume", "r", "--set", "duration=1"]);
    assert!(refused.contains("--set cannot change a run"), "{refused}");
}

#[test]
fn the_folder_without_out_is_numbered() {
    let shop = Workshop::new();
    for _ in 0..3 {
        shop.good(&["run", "box.toml", "--until", "0.001", "--quiet"]);
    }
    assert_eq!(names(&shop.path("runs")), ["box", "box-2", "box-3"]);
}

/// `fissure … | head -1`, and a full disk behind standard output.
#[test]
fn nobody_listening_is_no_reason_to_stop() {
    let shop = Workshop::new();
    let mut child = shop.start(&["run", "box.toml", "--out", "r", "--json"]);
    drop(child.stdout.take());
    let output = child.wait_with_output().unwrap();
    assert_eq!(String::from_utf8_lossy(&output.stderr), "");
    assert_eq!(output.status.code(), Some(0));
    assert!(shop.path("r/last.png").exists());
    for arguments in [&["materials"][..], &["materials", "isotropic"], &["info", "r"], &["info", "r/frozen.fis"]] {
        let mut child = shop.start(arguments);
        drop(child.stdout.take());
        let output = child.wait_with_output().unwrap();
        assert!(!String::from_utf8_lossy(&output.stderr).contains("panicked"), "{arguments:?}");
    }
}
