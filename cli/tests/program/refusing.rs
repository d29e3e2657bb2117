//! Bad input: exit code 2, one sentence that names file, line or element and the cure, and nothing half-written.

use std::fs;

use crate::commands::CUBE;
use crate::workshop::{BOX, Workshop, names, volume};

/// Refuses `scene.toml` with this text; the sentence, with no folder left.
fn refused(shop: &Workshop, text: &str) -> String {
    shop.put("scene.toml", text);
    let before = shop.names();
    let with_out = shop.refusal(&["run", "scene.toml", "--out", "made/for/it"]);
    assert_eq!(shop.names(), before, "{with_out}");
    let without = shop.refusal(&["run", "scene.toml"]);
    assert_eq!(shop.names(), before, "{without}");
    assert_eq!(with_out, without);
    println!("{with_out}");
    with_out
}

/// The scene of the box with one change.
fn changed(from: &str, to: &str) -> String {
    assert!(BOX.contains(from), "{from}");
    BOX.replacen(from, to, 1)
}

/// The number of the line of `text` that has `part`.
fn line_of(text: &str, part: &str) -> usize {
    text.lines().position(|l| l.contains(part)).unwrap_or_else(|| panic!("{part} in {text}")) + 1
}

/// Wants the sentence to begin with file and line of `part`, and to have the words.
pub fn at_line(shop: &Workshop, text: &str, part: &str, words: &[&str]) {
    let sentence = refused(shop, text);
    let place = format!("scene.toml:{}: ", line_of(text, part));
    assert!(sentence.starts_with(&place), "{place} of {sentence}");
    for word in words {
        assert!(sentence.contains(word), "{word} in {sentence}");
    }
    assert_eq!(sentence.matches("scene.toml").count(), 1, "named twice: {sentence}");
}

/// The box from a mesh file.
fn meshed(file: &str) -> String {
    changed("shape = { kind = \"box\", size = [0.1, 0.1, 0.1] }", &format!("mesh = \"{file}\""))
}

#[test]
fn keys_and_values() {
    let shop = Workshop::new();
    let at = |text: &str, part: &str, words: &[&str]| at_line(&shop, text, part, words);
    at(&changed("density", "densty"), "densty", &["unknown key `densty`", "did you mean `density`?"]);
    at(&changed("density = 1000", "density = -3"), "-3", &["`density` = -3", "above 0 [kg/m³]"]);
    at(&changed("duration = 0.06", "duration = 0"), "duration", &["above 0 [s]"]);
    at(&changed("\"isotropic\"", "\"isotropc\""), "law =", &["isotropc", "did you mean `isotropic`?"]);
    at(&changed("\"critical_stretch\"", "\"stretch\""), "criterion =", &["`stretch`", "critical_stretch"]);
    at(&changed("bulk_modulus", "bulk"), "bulk =", &["`bulk`", "bulk_modulus"]);
    at(&changed("bulk_modulus = 5e5", "bulk_modulus = -5e5"), "bulk_modulus", &["above 0"]);
    at(&changed("[ground]", "[ground"), "[ground", &[]);
    at(&changed("width = 64", "width = 9000"), "width = 9000", &["from 16 to 8192"]); // not after a week
    let sentence = shop.refusal(&["run", "box.toml", "--set", "body.box.densty=3"]);
    assert!(sentence.starts_with("--set body.box.densty=3: unknown key"), "{sentence}");
    let sentence = shop.refusal(&["run", "box.toml", "--set", "body.ball.density=3"]);
    assert!(sentence.contains("--set body.ball.density=3"), "{sentence}");
    let sentence = shop.refusal(&["run", "box.toml", "--set", "density"]);
    assert!(sentence.contains("--set density"), "{sentence}");
    assert_eq!(shop.names(), ["box.toml", "scene.toml"]);
}

#[test]
fn scenes_that_are_none() {
    let shop = Workshop::new();
    fs::create_dir(shop.path("folder.toml")).unwrap();
    shop.put("noise.toml", (0..5000_u32).map(|k| ((k * k) >> 3) as u8).collect::<Vec<_>>());
    shop.put("nul.toml", [0; 64]);
    shop.put("empty.toml", "");
    let before = shop.names();
    for (file, words) in [
        ("folder.toml", "cannot be read"),
        ("noise.toml", "cannot be read"),
        ("nul.toml", "nul.toml:1"),
        ("empty.toml", "the scene has no body"),
        ("none.toml", "No such file"),
        (env!("CARGO_BIN_EXE_fissure"), "cannot be read"),
    ] {
        let sentence = shop.refusal(&["run", file]);
        assert!(sentence.starts_with(file) && sentence.contains(words), "{sentence}");
        assert!(sentence.chars().all(|c| !c.is_control()), "{sentence:?}");
        assert_eq!(shop.names(), before, "{file}");
    }
}

#[test]
fn meshes_that_are_none() {
    let shop = Workshop::new();
    let at = |file: &str, words: &[&str]| {
        at_line(&shop, &meshed(file), "mesh = ", &[&[file, "body `box`"], words].concat());
        let sentence = refused(&shop, &meshed(file));
        assert_eq!(sentence.matches(file).count(), 1, "named twice: {sentence}");
    };
    at("none.ply", &["cannot be read", "check the path"]);
    shop.put("nan.obj", CUBE.replace("v 1 1 1", "v 1 nan 1"));
    at("nan.obj", &["line 7", "nan"]);
    shop.put("open.obj", CUBE.replace("f 1 4 3 2\n", ""));
    at("open.obj", &["open along 4 edges", "shell = "]);
    shop.put("points.obj", CUBE.lines().take(8).map(|l| l.to_owned() + "\n").collect::<String>());
    at("points.obj", &["no "]);
    shop.put("mesh.doc", "words");
    at("mesh.doc", &["extension 'doc'", ".obj"]);
    shop.put("flat.node", "4 3 0 0\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 1 1 0\n");
    shop.put("flat.ele", "1 4 0\n1 1 2 3 4\n");
    let text = meshed("flat.node");
    at_line(&shop, &text, "mesh = ", &["flat.ele", "line 2", "tetrahedron 1", "no volume", "remove it"]);
    shop.put("lone.node", "4 3 0 0\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n");
    at_line(&shop, &meshed("lone.node"), "mesh = ", &["lone.ele", "cannot be read"]);
    shop.put("one.node", "4 3 0 0\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n");
    shop.put("one.ele", "1 4 0\n1 1 2 3 4\n");
    at_line(&shop, &meshed("one.node"), "mesh = ", &["one.node", "single tetrahedron", "finer"]);
    let shell = meshed("one.node").replace("tets = 1500", "shell = 0.1");
    at_line(&shop, &shell, "shell = ", &["`shell`", "tetrahedra already"]);
}

#[test]
fn an_inside_out_surface_is_turned_and_told() {
    let shop = Workshop::new();
    let inside_out: String = CUBE
        .lines()
        .map(|l| match l.strip_prefix("f ") {
            Some(face) => {
                let c: Vec<&str> = face.split(' ').collect();
                format!("f {} {} {} {}\n", c[0], c[3], c[2], c[1])
            }
            None => format!("{l}\n"),
        })
        .collect();
    shop.put("in.obj", inside_out);
    shop.put("out.obj", CUBE);
    for name in ["in", "out"] {
        let small = meshed(&format!("{name}.obj")).replace("tets = 1500", "tets = 300\nscale = 0.1");
        shop.put(&format!("{name}.toml"), small);
        let answer = shop.good(&["run", &format!("{name}.toml"), "--out", name, "--until", "0.001"]);
        let told = answer.out.contains("turned");
        assert_eq!(told, name == "in", "{answer}");
    }
    let info = shop.good(&["info", "in.obj"]).out;
    assert!(info.contains("to be repaired"), "{info}");
    for name in ["in", "out"] {
        let volume = volume(&shop.frame(name, 0));
        assert!((volume / 1e-3 - 1.0).abs() < 0.01, "{name}: {volume} m³"); // measured: 0.4 % missing at the edges
    }
}

#[test]
fn geometry_that_does_not_work_out() {
    let shop = Workshop::new();
    let with = |line: &str| changed("tets = 1500", &format!("tets = 1500\n{line}"));
    at_line(
        &shop,
        &with("horizon = 0.003"),
        "horizon =",
        &["body `box`", "no neighbour", "3.0000e-3 m", "horizon well above"],
    );
    at_line(&shop, &with("horizon_factor = 0.2"), "horizon_factor", &["body `box`", "no neighbour"]);
    let size = |value: &str| changed("tets = 1500", &format!("size = {value}"));
    at_line(&shop, &size("3"), "size = 3", &["body `box`", "too large"]);
    at_line(&shop, &size("1e-6"), "size = 1e-6", &["body `box`", "more than fit in memory"]);
    let vase = changed("kind = \"box\", size = [0.1, 0.1, 0.1]", "kind = \"vase\", height = 0.1, wall = 0.09");
    at_line(&shop, &vase, "shape =", &["body `box`", "wall of 0.09 m"]);
    let sentence = refused(&shop, &format!("dt = 7\n{BOX}"));
    assert!(sentence.starts_with("scene.toml: `dt` = 7 s is longer than the duration of 0.06 s"), "{sentence}");
    for endless in [format!("dt = 1e-30\n{BOX}"), changed("density = 1000", "density = 1e-300")] {
        let sentence = refused(&shop, &endless);
        assert!(sentence.starts_with("scene.toml: 0.06 s in steps of") && sentence.contains("stable is"), "{sentence}");
    }
    let anchor = format!("{BOX}\n[[anchor]]\nname = \"hook\"\nbody = \"box\"\nbox = [[5, 5, 5], [6, 6, 6]]\n");
    at_line(&shop, &anchor, "[[anchor]]", &["anchor `hook`", "no particle of body `box`"]);
}

#[test]
fn folders_that_will_not_do() {
    let shop = Workshop::new();
    for out in ["box.toml/r", "/proc/fissure/r", "box.toml"] {
        let sentence = shop.refusal(&["run", "box.toml", "--out", out]);
        assert!(sentence.starts_with(&format!("{out} cannot be written")), "{sentence}");
        assert_eq!(shop.names(), ["box.toml"]);
    }
    shop.good(&["run", "box.toml", "--out", "r", "--until", "0.001", "--quiet"]);
    let before = shop.bytes("r");
    let sentence = shop.refusal(&["run", "box.toml", "--out", "r"]);
    for word in ["r holds another run", "--out", "fissure resume r"] {
        assert!(sentence.contains(word), "{sentence}");
    }
    assert_eq!(shop.bytes("r"), before, "untouched");
    // a folder with something else in it is used, and not removed when the run does not come about
    fs::create_dir(shop.path("mine")).unwrap();
    shop.put("mine/notes.txt", "keep");
    shop.refusal(&["run", "box.toml", "--out", "mine", "--set", "body.box.horizon=0.001"]);
    assert_eq!(names(&shop.path("mine")), ["notes.txt"]);
    fs::create_dir(shop.path("empty")).unwrap();
    shop.refusal(&["run", "box.toml", "--out", "empty", "--set", "body.box.horizon=0.001"]);
    assert!(shop.path("empty").exists(), "made by the user, not by us");
}

#[test]
fn options_that_will_not_do() {
    let shop = Workshop::new();
    for (option, value, words) in [
        ("--threads", "0", "--threads must be 1 or more"),
        ("--until", "-1", "--until -1"),
        ("--until", "0", "--until 0 must be above 0 [s]"),
        ("--until", "nan", "--until NaN"),
        ("--until", "soon", "soon"),
        ("--threads", "-2", "-2"),
        ("--threads", "100000000", "--threads"),
        ("--colour", "red", "--colour"),
    ] {
        let answer = shop.call(&["run", "box.toml", "--out", "r", option, value]);
        assert_eq!(answer.code, Some(2), "{answer}");
        assert!(answer.err.starts_with("error: ") && answer.err.contains(words), "{answer}");
        assert!(!answer.err.contains("panicked") && answer.out.is_empty(), "{answer}");
        assert_eq!(shop.names(), ["box.toml"]);
    }
}

#[test]
fn a_step_far_too_long_stops_with_the_last_good_state() {
    let shop = Workshop::new();
    let answer = shop.call(&[
        "run",
        "box.toml",
        "--out",
        "r",
        "--set",
        "dt=0.003",
        "--set",
        "body.box.fracture.critical_stretch=1e9",
    ]);
    assert_eq!(answer.code, Some(2), "{answer}");
    let sentence = answer.err.strip_prefix("error: ").expect("an error").trim_end().to_owned();
    for word in ["body `box`", "particle ", "step ", "time ", "0.003 s", "\"auto\"", "last good state", "checkpoint_"] {
        assert!(sentence.contains(word), "{word} in {sentence}");
    }
    assert_eq!(sentence.lines().count(), 1, "{sentence}");
    let step: u64 = sentence.split("at step ").nth(1).unwrap().split(',').next().unwrap().parse().unwrap();
    let checkpoint = shop.path("r").join(format!("checkpoint_{step:08}.fis"));
    assert!(sentence.contains(&*checkpoint.file_name().unwrap().to_string_lossy()), "{sentence}");
    let info = shop.good(&["info", &checkpoint.to_string_lossy()]).out;
    assert!(!info.contains("NaN") && !info.contains("inf"), "{info}");
    let log = fs::read_to_string(shop.path("r/run.log")).unwrap();
    assert!(log.contains(sentence.split(';').next().unwrap()), "{log}");
    assert!(log.contains("times the longest stable step"), "{log}");
    let again = shop.refusal(&["resume", "r"]);
    assert!(again.contains(&format!("at step {step},")), "{again}");
}
