//! `fissure export`: columns of a checkpoint for other programs.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use crate::workshop::{Workshop, assert_same, names};

#[test]
fn columns_come_out_as_they_are_in_the_checkpoint() {
    let shop = Workshop::new();
    shop.good(&["run", "box.toml", "--out", "a", "--quiet", "--set", "duration=0.02", "--set", "body.box.tets=300"]);
    let folder = names(&shop.path("a"));
    let last = format!("a/{}", folder.iter().rfind(|n| n.starts_with("checkpoint_")).unwrap());

    shop.good(&["export", &last, "--out", "table.csv"]);
    let mut table = csv::Reader::from_path(shop.path("table.csv")).unwrap();
    let head: Vec<String> = table.headers().unwrap().iter().map(str::to_owned).collect();
    for name in ["body", "id", "position x [m]", "velocity z [m/s]", "mass [kg]", "damage"] {
        assert!(head.iter().any(|h| h == name), "no `{name}` in {head:?}");
    }
    let at = head.iter().position(|h| h == "position y [m]").unwrap();
    let rows: Vec<csv::StringRecord> = table.records().map(Result::unwrap).collect();
    assert!(rows.iter().all(|r| &r[0] == "box"));

    shop.good(&["export", &last, "--to", "npy", "--out", "columns"]);
    let npy = fs::read(shop.path("columns/particles.position.npy")).unwrap();
    let length = 10 + usize::from(u16::from_le_bytes([npy[8], npy[9]]));
    assert_eq!((&npy[..8], length % 64), (&b"\x93NUMPY\x01\x00"[..], 0));
    let header = String::from_utf8(npy[10..length].to_vec()).unwrap();
    assert!(
        header.contains(&format!("'descr': '<f8', 'fortran_order': False, 'shape': ({}, 3)", rows.len())),
        "{header}"
    );
    for (row, numbers) in rows.iter().zip(npy[length..].chunks_exact(24)) {
        let y = f64::from_le_bytes(numbers[8..16].try_into().unwrap());
        assert_eq!(row[at].parse::<f64>().unwrap().to_bits(), y.to_bits());
    }
    let columns = names(&shop.path("columns"));
    assert!(columns.contains(&"bodies.box.bonds.neighbours.npy".into()), "{columns:?}");

    shop.good(&["export", &last, "--to", "vtu"]);
    let vtu = fs::read(shop.path(&last.replace(".fis", ".vtu"))).unwrap();
    let text = String::from_utf8_lossy(&vtu);
    assert!(text.contains(&format!("NumberOfPoints=\"{}\"", rows.len())) && text.contains("Name=\"damage\""));
    let start = vtu.windows(17).position(|w| w == b"encoding=\"raw\">\n_").unwrap() + 17;
    assert_eq!(vtu[start + 8..start + 8 + 24 * rows.len()], npy[length..]);
}

/// All files below `dir`, by their path in it.
fn below(dir: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut all = BTreeMap::new();
    for name in names(dir) {
        let path = dir.join(&name);
        if path.is_dir() {
            all.extend(below(&path).into_iter().map(|(inner, bytes)| (format!("{name}/{inner}"), bytes)));
        } else {
            all.insert(name, fs::read(path).unwrap());
        }
    }
    all
}

const ALL: [&str; 5] = ["usd", "vtu", "ply", "obj", "pov"];

/// What is streamed does not depend on where a run was stopped, and is what is made afterwards.
#[test]
fn every_format_streams_through_a_restart() {
    let shop = Workshop::new();
    let set = "output.export=['usd', 'vtu', 'ply', 'obj', 'glb', 'pov']";
    shop.good(&["run", "box.toml", "--out", "whole", "--quiet", "--set", set]);
    shop.good(&["run", "box.toml", "--out", "r", "--quiet", "--set", set, "--until", "0.033"]);
    let stage = fs::read_to_string(shop.path("r/usd/stage.usda")).unwrap();
    assert!(stage.contains("endTimeCode = 3\n") && !shop.path("r/run.glb").exists(), "{stage}");
    shop.good(&["resume", "r"]);
    let whole = shop.path("whole");
    for format in ALL {
        assert_same(&below(&whole.join(format)), &below(&shop.path("r").join(format)), format);
    }
    assert!(fs::read(whole.join("run.glb")).unwrap() == fs::read(shop.path("r/run.glb")).unwrap(), "glb");
    assert_eq!(names(&whole.join("vtu")), ["particles", "particles.pvd", "surface", "surface.pvd", "tets", "tets.pvd"]);

    let answer = shop.good(&["export", "whole", "--to", "vtu", "--out", "later"]);
    assert!(answer.out.contains("7 frames") && answer.out.contains("output.export"), "{answer}");
    for part in ["surface", "particles"] {
        assert_same(&below(&whole.join("vtu").join(part)), &below(&shop.path("later").join(part)), part);
    }
    for format in ["usd", "ply", "obj"] {
        shop.good(&["export", "whole", "--to", format, "--out", format]);
        assert_same(&below(&whole.join(format)), &below(&shop.path(format)), format);
    }
    shop.good(&["export", "whole", "--to", "glb", "--out", "again.glb"]);
    assert!(fs::read(whole.join("run.glb")).unwrap() == fs::read(shop.path("again.glb")).unwrap(), "glb");
}

#[test]
fn fragments_carry_all_momentum() {
    let shop = Workshop::new();
    shop.good(&["run", "box.toml", "--out", "r", "--quiet"]);
    let answer = shop.good(&["export", "r", "--fragments"]);
    assert!(answer.out.contains("r/fragments.csv: 7 frames, "), "{answer}");
    let mut table = csv::Reader::from_path(shop.path("r/fragments.csv")).unwrap();
    let head = table.headers().unwrap().clone();
    assert_eq!(head.iter().take(4).collect::<Vec<_>>(), ["frame", "time", "id", "parent"]);
    let rows: Vec<csv::StringRecord> = table.records().map(Result::unwrap).collect();
    let last: Vec<&csv::StringRecord> = rows.iter().filter(|r| &r[0] == "6").collect();
    assert!(last.len() > 3 && rows.iter().filter(|r| &r[0] == "0").count() == 1, "{} at last", last.len());
    let at = |name: &str| head.iter().position(|h| h == name).unwrap();
    let number = |row: &csv::StringRecord, name: &str| row[at(name)].parse::<f64>().unwrap();
    let particles = fissure_io::frames::ParticleFrame::read(&shop.path("r/particles/frame_0006.ply")).unwrap();
    for (axis, name) in ["velocity_x", "velocity_y", "velocity_z"].iter().enumerate() {
        let got: f64 = last.iter().map(|r| number(r, "mass") * number(r, name)).sum();
        let each = particles.mass.iter().zip(&particles.velocity);
        let want: f64 = each.map(|(&m, v)| f64::from(m) * f64::from(v[axis])).sum();
        assert!((got - want).abs() < 1e-12, "{name}: {got} {want} kg m/s"); // measured: round-off of 1 kg at 4 m/s
    }
    let mass: f64 = last.iter().map(|r| number(r, "mass")).sum();
    assert!((mass - 1.0).abs() < 1e-3, "{mass} kg of a litre of water"); // measured: the mesh fills the box
    assert!(last.iter().all(|r| r[3].is_empty() == (&r[2] == "0")), "every piece but the first broke off another");
}

#[test]
fn what_cannot_be_exported_is_said() {
    let shop = Workshop::new();
    shop.put("x.fis", "no checkpoint");
    for (arguments, part) in [
        (&["export", "x.fis"][..], "is no Fissure checkpoint"),
        (&["export", "."], "give one of its checkpoints"),
        (&["export", "y.fis"], "y.fis"),
        (&["export", "x.fis", "--to", "xls"], "xls"),
        (&["export", "x.fis", "--to", "usd"], "made of a whole run"),
        (&["export", "x.fis", "--fragments"], "give its folder"),
        (&["export", ".", "--to", "usd"], "is no run folder"),
    ] {
        let answer = shop.call(arguments);
        assert!(answer.code == Some(2) && answer.err.contains(part), "{part}\n{answer}");
        assert_eq!(answer.err.trim_end().lines().count(), 1, "{answer}");
    }
}
