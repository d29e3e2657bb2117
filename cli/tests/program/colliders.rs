//! Rigid things in a run: every kind is built, drawn and resumed, and what is wrong with one is said where it stands.

use std::fs;

use crate::workshop::{BOX, Workshop, assert_same};

/// A tetrahedron, and the same without one of its faces.
const TETRAHEDRON: &str = "v 0 0 0\nv 0.05 0 0\nv 0 0.05 0\nv 0 0 0.05\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n";
const OPEN: &str = "v 0 0 0\nv 0.05 0 0\nv 0 0.05 0\nv 0 0 0.05\nf 1 3 2\nf 1 2 4\nf 2 3 4\n";

const COLLIDERS: &str = "
[[collider]]
name = 'bullet'
shape = { kind = 'ball', radius = 0.02 }
position = [-0.15, 0.1, 0]
motion = 'free'
density = 8000
velocity = [12, 0, 0]
spin = [0, 0, 50]

[[collider]]
name = 'splinter'
shape = { kind = 'mesh', mesh = 'tetrahedron.obj' }
position = [0.1, 0.01, 0.1]
motion = 'free'
mass = 0.02
velocity = [-2, 0, -2]

[[collider]]
name = 'stone'
shape = { kind = 'hull', mesh = 'tetrahedron.obj', scale = 0.5 }
rotate = { axis = [0, 1, 0], degrees = 20 }
position = [0, 0.001, 0]

[[collider]]
name = 'press'
shape = { kind = 'capsule', radius = 0.03, height = 0.2 }
motion = 'keyframes'
[[collider.keyframe]]
time = 0
position = [0, 0.3, 0]
[[collider.keyframe]]
time = 0.06
position = [0, 0.1, 0]
rotate = { axis = [1, 0, 0], degrees = 90 }
";

#[test]
fn a_run_with_colliders_is_resumed_to_the_same_bytes() {
    let shop = Workshop::new();
    let mesh = shop.put("tetrahedron.obj", TETRAHEDRON);
    shop.put("all.toml", format!("{BOX}{COLLIDERS}"));
    let run = shop.good(&["run", "all.toml", "--out", "whole", "--threads", "2"]);
    for said in ["collider bullet: ball, free, 2.6808e-1 kg", "collider press: capsule, moved along 2 keyframes"] {
        assert!(run.out.contains(said), "{said} in {run}");
    }
    let whole = shop.bytes("whole");
    for (k, until) in ["0.0007", "0.0123", "0.0333"].iter().enumerate() {
        let run = format!("r{k}");
        shop.put("tetrahedron.obj", TETRAHEDRON);
        shop.good(&["run", "all.toml", "--out", &run, "--until", until, "--threads", "1"]);
        // a restart needs no mesh file
        fs::remove_file(&mesh).unwrap();
        shop.good(&["resume", &run]);
        assert_same(&whole, &shop.bytes(&run), &format!("stopped at {until} s"));
        assert_eq!(shop.colliders("whole"), shop.colliders(&run), "colliders after {until} s");
    }
    let frames = shop.colliders("whole");
    assert!(frames.len() == 7 && frames.windows(2).all(|f| f[0] != f[1]), "a frame each, and they move");
    shop.good(&["render", "whole"]);
}

#[test]
fn info_mentions_colliders() {
    let shop = Workshop::new();
    shop.put("all.toml", format!("{BOX}{COLLIDERS}"));
    let answer = shop.good(&["info", "all.toml"]);
    assert!(answer.out.contains("collider bullet: Ball { radius: 0.02 }, free"), "{answer}");
}

#[test]
fn what_is_wrong_with_a_collider_is_said() {
    let shop = Workshop::new();
    shop.put("open.obj", OPEN);
    let refused = |table: &str| {
        shop.put("bad.toml", format!("{BOX}\n[[collider]]\nname = 'it'\n{table}\n"));
        shop.refusal(&["run", "bad.toml", "--out", "bad"])
    };
    let line = BOX.lines().count() + 2;
    let inside = refused("shape = { kind = 'ball', radius = 0.03 }\nposition = [0, 0.09, 0]");
    assert!(inside.contains(&format!("bad.toml:{line}: collider `it` starts 2.")), "{inside}");
    assert!(inside.contains("deep inside body `box`"), "{inside}");
    let late = "shape = { kind = 'ball', radius = 0.03 }\nmotion = 'keyframes'\n[[collider.keyframe]]\ntime = 1\n\
                position = [9, 0, 0]\n[[collider.keyframe]]\ntime = 0.5\nposition = [8, 0, 0]";
    let late = refused(late);
    assert!(
        late.contains("`time` = 0.5") && late.contains("later than the 1 s") && late.contains("bad.toml:"),
        "{late}"
    );
    let open = refused("shape = { kind = 'mesh', mesh = 'open.obj' }\nposition = [9, 0, 0]");
    assert!(open.contains("collider `it`") && open.contains("open.obj"), "{open}");
    let none = refused("shape = { kind = 'mesh', mesh = 'none.obj' }");
    assert!(none.contains("none.obj"), "{none}");
    assert!(refused("shape = { kind = 'ball', radius = 1 }\nmotion = 'free'\nmass = 0").contains("above 0 [kg]"));
}

#[test]
fn bodies_that_start_in_each_other_are_refused() {
    let shop = Workshop::new();
    let (from, to) = (BOX.find("[body.box]").expect("a body"), BOX.find("[ground]").expect("a ground"));
    let other = BOX[from..to].replace("body.box", "body.other").replace("[0, 0.09, 0]", "[0.05, 0.1, 0]");
    shop.put("bad.toml", format!("{BOX}\n{other}"));
    let sentence = shop.refusal(&["run", "bad.toml", "--out", "bad"]);
    for word in ["bad.toml:", "body `other` starts ", " m deep inside body `box`", "move one of them apart"] {
        assert!(sentence.contains(word), "{word} in {sentence}");
    }
}
