//! `fissure diff`: what it says, and exit codes as diff(1) has them.

use std::fs;

use crate::workshop::Workshop;

const SHORT: &[&str] = &["--quiet", "--set", "duration=0.02", "--set", "body.box.tets=600"];

#[test]
fn runs_that_are_the_same_and_not() {
    let shop = Workshop::new();
    shop.good(&[&["run", "box.toml", "--out", "a", "--threads", "1"], SHORT].concat());
    shop.good(&[&["run", "box.toml", "--out", "b", "--threads", "2"], SHORT].concat());
    let same = shop.good(&["diff", "a", "b"]);
    assert!(same.out.contains("the same at step") && same.out.contains("3 frames are the same"), "{same}");

    shop.good(&[&["run", "box.toml", "--out", "c", "--set", "body.box.velocity=[0.2, -4.0001, 0]"], SHORT].concat());
    let answer = shop.call(&["diff", "a", "c", "--png", "where.png"]);
    assert_eq!((answer.code, answer.err.as_str()), (Some(1), ""), "{answer}");
    for part in [
        "scene: body.box.velocity: [0.2, -4, 0] became [0.2, -4.0001, 0]",
        "first differing step: ",
        "particles/position: ",
        "of box at (",
        "3 of 3 frames differ, the first is frame 0",
        "where.png: where particles/velocity differs, deep red is 1.000e-4",
    ] {
        assert!(answer.out.contains(part), "{part}\n{answer}");
    }
    assert!(fs::read(shop.path("where.png")).unwrap().starts_with(b"\x89PNG"));

    let json = shop.call(&["diff", "a", "c", "--columns", "velocity", "--json"]);
    let json: serde_json::Value = serde_json::from_str(&json.out).unwrap();
    assert_eq!(json["same"], false);
    let column = &json["checkpoints"][0]["columns"][0];
    assert_eq!((&column["column"], &column["unit"]), (&"particles/velocity".into(), &"m/s".into()));
    let (rms, largest) = (column["rms"].as_f64().unwrap(), column["largest"].as_f64().unwrap());
    assert!(1e-5 < rms && rms < largest && column["at"]["body"] == "box", "{column}");

    let last = |run: &str| {
        let names = crate::workshop::names(&shop.path(run));
        format!("{run}/{}", names.iter().rfind(|n| n.starts_with("checkpoint_")).unwrap())
    };
    let files = [&*last("a"), &*last("c")];
    assert_eq!(shop.call(&["diff", files[0], files[1]]).code, Some(1));
    assert_eq!(shop.call(&["diff", files[0], files[1], "--columns", "position", "--tolerance", "1"]).code, Some(0));
    assert_eq!(shop.call(&["diff", "box.toml", "a/scene.toml"]).code, Some(1)); // the overrides
    assert_eq!(shop.call(&["diff", "box.toml", "box.toml"]).code, Some(0));
}

#[test]
fn what_cannot_be_compared_is_trouble() {
    let shop = Workshop::new();
    shop.put("x.fis", "no checkpoint");
    for (arguments, part) in [
        (["diff", "box.toml", "x.fis"], "are not of one kind"),
        (["diff", "x.fis", "x.fis"], "is no Fissure checkpoint"),
        (["diff", "x.fis", "y.fis"], "x.fis"),
        (["diff", ".", "."], "is no run folder"),
        (["diff", "z.toml", "box.toml"], "z.toml cannot be read"),
    ] {
        let answer = shop.call(&arguments);
        assert_eq!(answer.code, Some(2), "{answer}");
        assert!(answer.err.contains(part) && answer.err.lines().count() == 1, "{answer}");
    }
    let answer = shop.call(&["diff", "box.toml", "box.toml", "--tolerance", "-1"]);
    assert!(answer.code == Some(2) && answer.err.contains("--tolerance is -1"), "{answer}");
}
