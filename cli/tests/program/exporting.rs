//! `fissure export`: columns of a checkpoint for other programs.

use std::fs;

use crate::workshop::{Workshop, names};

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

#[test]
fn what_cannot_be_exported_is_said() {
    let shop = Workshop::new();
    shop.put("x.fis", "no checkpoint");
    for (arguments, part) in [
        (&["export", "x.fis"][..], "is no Fissure checkpoint"),
        (&["export", "."], "give one of its checkpoints"),
        (&["export", "y.fis"], "y.fis"),
        (&["export", "x.fis", "--to", "xls"], "xls"),
    ] {
        let answer = shop.call(arguments);
        assert!(answer.code == Some(2) && answer.err.contains(part), "{part}\n{answer}");
        assert_eq!(answer.err.trim_end().lines().count(), 1, "{answer}");
    }
}
