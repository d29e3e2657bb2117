//! Lattices through the whole program: what is said of them, frames, going on, differences, pictures.

use std::fs;

use crate::workshop::{Workshop, assert_same, open_edges};

const SCENE: &str = r#"
title = "A lattice tears"
duration = 0.3
dt = 0.005
[body.block]
shape = { kind = "box", size = [0.2, 0.1, 0.1] }
cells = 300
density = 1000
translate = [0, 0.052, 0]
velocity = [0, -3, 0]
spin = [0, 0, 12]
[body.block.material]
law = "lattice"
stiffness = 0.3
[body.block.fracture]
critical_stretch = 0.3
[ground]
[output]
frame_every = 0.05
checkpoint_steps = 15
keep = 0
"#;

#[test]
fn a_lattice_runs_resumes_and_is_told_apart() {
    let shop = Workshop::new();
    shop.put("block.toml", SCENE);
    let info = shop.good(&["info", "block.toml"]);
    assert!(info.out.contains("about 300 cells, lattice with critical_stretch"), "{info}");
    let run = shop.good(&["run", "block.toml", "--out", "a", "--threads", "1"]);
    for part in ["body block: cells in ", "nodes (", "the finest first)", "fragment"] {
        assert!(run.out.contains(part), "{part}\n{run}");
    }
    assert!(!run.out.contains("bonds broken") && !run.out.contains("per directed bond"), "{run}");
    let torn = shop.frame("a", 6);
    assert!(torn.inside.contains(&1), "it tears");
    assert_eq!(open_edges(&torn), 0);

    shop.good(&["run", "block.toml", "--out", "b", "--threads", "2", "--until", "0.15", "--quiet"]);
    shop.good(&["resume", "b", "--threads", "2", "--quiet"]);
    assert_same(&shop.bytes("a"), &shop.bytes("b"), "stopped in the middle");
    assert!(shop.good(&["diff", "a", "b"]).out.contains("the same at step"));
    shop.good(&["run", "block.toml", "--out", "c", "--quiet", "--set", "body.block.material.stiffness=0.31"]);
    assert_eq!(shop.call(&["diff", "a", "c"]).code, Some(1));

    shop.good(&["render", "a", "--color", "piece", "--out", "piece.png"]);
    assert!(fs::read(shop.path("piece.png")).unwrap().starts_with(b"\x89PNG"));
    assert!(shop.good(&["materials", "lattice"]).out.contains("fissure keys crack_faces"));
    assert!(shop.good(&["keys", "crack_faces"]).out.contains("body.NAME.crack_faces.noise"));
}
