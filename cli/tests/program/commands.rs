//! `info`, `mesh`, `materials`, `render`.

use std::fs;

use crate::workshop::{Workshop, names};

/// A cube with a corner at 0 and edges of 1, wound outwards, as OBJ.
pub const CUBE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n\
    f 1 4 3 2\nf 5 6 7 8\nf 1 2 6 5\nf 3 4 8 7\nf 2 3 7 6\nf 1 5 8 4\n";

#[test]
fn verify_reads_every_byte() {
    let shop = Workshop::new();
    shop.good(&["run", "box.toml", "--out", "r", "--set", "duration=0.01", "--quiet"]);
    let answer = shop.good(&["verify", "r"]);
    assert!(answer.out.contains("frozen.fis: step 0, ") && answer.out.contains(", all as written"), "{answer}");
    assert!(answer.out.ends_with("2 frames read\n2 frames of particles read\n"), "{answer}");
    shop.good(&["verify", "r/frozen.fis"]);

    let path = shop.path("r/frozen.fis");
    let mut bytes = std::fs::read(&path).unwrap();
    bytes[5000] ^= 1;
    std::fs::write(&path, bytes).unwrap();
    let frame = shop.path("r/frames/frame_0001.ply");
    let short = std::fs::read(&frame).unwrap();
    std::fs::write(&frame, &short[..short.len() - 7]).unwrap();
    shop.put("r/particles/frame_0000.ply", "ply\nwhatever");
    let answer = shop.call(&["verify", "r"]);
    assert!(
        answer.code == Some(2) && answer.err == "error: r: 3 files damaged; what is wrong stands above\n",
        "{answer}"
    );
    assert!(answer.out.contains("frozen.fis: `r/frozen.fis` is damaged: the checksum of column"), "{answer}");
    assert!(answer.out.contains("frames/frame_0001.ply: "), "{answer}");
    assert!(answer.out.contains("particles/frame_0000.ply: "), "{answer}");
    assert!(shop.refusal(&["verify", "box.toml"]).contains("1 file damaged"), "no checkpoint");
}

#[test]
fn info_of_every_kind_of_file() {
    let shop = Workshop::new();
    shop.good(&["run", "box.toml", "--out", "r", "--until", "0.021", "--quiet"]);
    shop.put("cube.obj", CUBE);
    let before = names(&shop.path("r"));
    let checkpoint = before.iter().rfind(|n| n.starts_with("checkpoint_")).unwrap();
    let expected: &[(&str, &[&str])] = &[
        ("box.toml", &["A box breaks", "body box", "isotropic", "critical_stretch", "0.06 s"]),
        ("r", &["A box breaks", "3 frames", "checkpoint of step", " s of 0.06 s: r/checkpoint_"]),
        ("r/scene.toml", &["A box breaks"]),
        ("r/frozen.fis", &["frozen", "bodies/box", "rest"]),
        (
            &format!("r/{checkpoint}"),
            &[
                "live",
                "position",
                "velocity",
                "damage",
                "energy, kinetic: ",
                "checksums of all columns match",
                "A box breaks; --scene",
            ],
        ),
        ("r/frames/frame_0002.ply", &["frame 2", "t = 0.02", "damage", "triangles", "pieces"]),
        ("r/frames", &["3 frames", "frame_0002.ply"]),
        ("cube.obj", &["8 vertices, 12 triangles", "area 6.0", "volume 1.0", "closed"]),
    ];
    for (file, words) in expected {
        let answer = shop.good(&["info", file]);
        for word in *words {
            assert!(answer.out.contains(word), "{word} in {answer}");
        }
    }
    assert_eq!(names(&shop.path("r")), before, "looking changes nothing");
}

#[test]
fn info_for_programs() {
    let shop = Workshop::new();
    shop.good(&["run", "box.toml", "--out", "r", "--until", "0.021", "--quiet"]);
    shop.put("cube.obj", CUBE);
    let value = |file: &str| -> serde_json::Value {
        let answer = shop.good(&["info", file, "--json"]);
        assert_eq!(answer.out.lines().count(), 1, "{answer}");
        serde_json::from_str(&answer.out).unwrap()
    };
    let run = value("r");
    assert_eq!(
        (&run["kind"], &run["frames"], &run["title"]),
        (&"run".into(), &3.into(), &"A box breaks".into()),
        "{run}"
    );
    let newest = run["checkpoints"].as_array().unwrap().last().unwrap();
    let (file, step) = (newest["file"].as_str().unwrap(), &newest["step"]);
    assert!((0.02..0.022).contains(&newest["time"].as_f64().unwrap()), "{newest}");

    let checkpoint = value(file);
    assert_eq!(
        (&checkpoint["step"], &checkpoint["time"], &checkpoint["intact"]),
        (step, &newest["time"], &true.into())
    );
    assert_eq!(checkpoint["belongs_to"], value("r/frozen.fis")["fingerprint"]);
    assert!(checkpoint["notes"]["energy, kinetic"].as_str().unwrap().ends_with(" J"), "{}", checkpoint["notes"]);
    assert!(checkpoint["program"].as_str().unwrap().starts_with("fissure "), "{}", checkpoint["program"]);
    let columns = checkpoint["columns"].as_array().unwrap();
    let velocity = columns.iter().find(|c| c["column"] == "particles/velocity").unwrap();
    for (key, wanted) in [("unit", "m/s"), ("type", "f64")] {
        assert_eq!(velocity[key], wanted, "{velocity}");
    }
    assert!(
        velocity["width"] == 3 && velocity["count"].as_u64() > Some(100) && velocity["intact"] == true,
        "{velocity}"
    );
    assert!(velocity["min"].as_f64() < Some(-0.1) && velocity["max"].as_f64() > Some(0.1), "{velocity}");

    let scene = shop.good(&["info", file, "--scene"]).out;
    assert_eq!(scene.trim_end(), checkpoint["scene"].as_str().unwrap().trim_end());
    shop.put("again.toml", scene);
    assert_eq!(shop.call(&["diff", "again.toml", "r/scene.toml"]).code, Some(0), "the scene that made it");
    assert!(
        shop.refusal(&["info", "box.toml", "--scene"]).contains("--scene prints the scene that a checkpoint keeps")
    );

    assert_eq!(value("box.toml")["bodies"][0]["law"], "isotropic");
    assert_eq!((&value("r/frames/frame_0002.ply")["frame"], &value("r/frames")["frames"]), (&2.into(), &3.into()));
    let cube = value("cube.obj");
    assert!(
        cube["triangles"] == 12 && cube["findings"] == serde_json::json!([]) && cube["bounds"][1][2] == 1.0,
        "{cube}"
    );
}

#[test]
fn info_of_what_it_does_not_know() {
    let shop = Workshop::new();
    shop.put("picture.png", b"\x89PNG\r\n\x1a\n");
    shop.put("words", "");
    shop.put("odd.fis", [7; 300]);
    fs::create_dir(shop.path("folder")).unwrap();
    for (file, word) in [
        ("nothing.toml", "nothing.toml: the scene cannot be read"),
        ("nothing.ply", "nothing.ply: cannot be read"),
        ("nothing.fis", "nothing.fis"),
        ("nothing", "nothing: "),
        ("picture.png", "picture.png: "),
        ("words", "words: "),
        ("odd.fis", "no Fissure checkpoint"),
        ("folder", "folder is no run folder"),
    ] {
        let sentence = shop.refusal(&["info", file]);
        assert!(sentence.contains(word), "{sentence}");
    }
}

#[test]
fn a_damaged_checkpoint_is_told() {
    let shop = Workshop::new();
    shop.good(&["run", "box.toml", "--out", "r", "--until", "0.001", "--quiet"]);
    let path = shop.path("r/frozen.fis");
    let mut bytes = fs::read(&path).unwrap();
    let middle = bytes.len() / 2;
    bytes[middle] ^= 1;
    fs::write(&path, bytes).unwrap();
    let answer = shop.call(&["info", "r/frozen.fis"]);
    assert_eq!(answer.code, Some(2), "{answer}");
    assert!(answer.err.starts_with("error: r/frozen.fis is damaged"), "{answer}");
    let sentence = shop.refusal(&["resume", "r"]);
    assert!(sentence.contains("r/frozen.fis") && sentence.contains("damaged"), "{sentence}");
}

#[test]
fn mesh_fills_converts_and_reports() {
    let shop = Workshop::new();
    shop.put("cube.obj", CUBE);
    let filled = shop.good(&["mesh", "cube.obj", "cube.vtu", "--tets", "2000"]);
    for word in ["tetrahedra", "volume", "against the surface", "element sizes", "dihedral angles", "170-180°"] {
        assert!(filled.out.contains(word), "{word} in {filled}");
    }
    let tets: f64 = filled.out.lines().find_map(|l| l.split_once(" tetrahedra,")).unwrap().0.parse().unwrap();
    assert!((1500.0..2500.0).contains(&tets), "{tets} for 2000");
    let smallest: f64 =
        filled.out.split("dihedral angles ").nth(1).unwrap().split('°').next().unwrap().parse().unwrap();
    assert!(smallest >= 10.0, "{smallest}");
    let counts: f64 = filled
        .out
        .lines()
        .filter_map(|l| l.trim().split_once("° "))
        .filter(|(bin, _)| bin.contains('-'))
        .map(|(_, rest)| rest.split_whitespace().next().unwrap().parse::<f64>().unwrap())
        .sum();
    assert_eq!(counts, 6.0 * tets, "six angles in each, all in the histogram");

    let mut said = Vec::new();
    let names = ["cube.vtu", "a.msh", "b.v22.msh", "c.node", "d.vtu"];
    for pair in names.windows(2) {
        shop.good(&["mesh", pair[0], pair[1]]);
    }
    for name in names {
        said.push(shop.good(&["info", name]).out);
    }
    assert!(said.iter().all(|s| *s == said[0]), "the same mesh in every format: {said:?}");
    let volume: f64 = said[0].split("volume ").nth(1).unwrap().split(' ').next().unwrap().parse().unwrap();
    assert!((volume - 1.0).abs() < 2e-3, "{volume}"); // measured: 3e-4 missing at the edges
    assert!(shop.path("c.ele").exists());

    shop.good(&["mesh", "cube.obj", "cube.ply"]);
    shop.good(&["mesh", "cube.ply", "cube.stl"]);
    assert_eq!(shop.good(&["info", "cube.stl"]).out, shop.good(&["info", "cube.obj"]).out);
    let sized = shop.good(&["mesh", "cube.obj", "sized.msh", "--size", "0.2"]);
    let edge: f64 = sized.out.split("mean edge ").nth(1).unwrap().split(' ').next().unwrap().parse().unwrap();
    assert!((edge / 0.2 - 1.0).abs() < 0.15, "{edge} for 0.2");
    let shell = shop.good(&["mesh", "cube.obj", "shell.msh", "--shell", "0.1", "--tets", "5000"]);
    assert!(shell.out.contains("tetrahedra"), "{shell}");
}

#[test]
fn mesh_refuses() {
    let shop = Workshop::new();
    shop.put("cube.obj", CUBE);
    shop.good(&["mesh", "cube.obj", "cube.vtu", "--tets", "300"]);
    let before = shop.names();
    for (arguments, word) in [
        (&["mesh", "cube.obj", "x.vtk"][..], "x.vtk: the extension 'vtk' is not a mesh format to write"),
        (&["mesh", "cube.obj", "x"], "x: the name has no extension"),
        (&["mesh", "cube.vtu", "x.ply"], "x.ply: "),
        (&["mesh", "cube.obj", "no/where/x.vtu"], "no/where/x.vtu: cannot be written"),
        (&["mesh", "cube.obj", "x.vtu", "--size", "-1"], "--size"),
        (&["mesh", "cube.obj", "x.vtu", "--size", "nan"], "--size"),
        (&["mesh", "cube.obj", "x.vtu", "--size", "1e-5"], "cube.obj: "),
        (&["mesh", "cube.obj", "x.vtu", "--size", "50"], "cube.obj: "),
        (&["mesh", "cube.obj", "x.vtu", "--tets", "0"], "--tets"),
        (&["mesh", "cube.obj", "x.vtu", "--shell", "0"], "--shell"),
        (&["mesh", "cube.vtu", "x.msh", "--shell", "0.1"], "--shell"),
        (&["mesh", "cube.obj", "x.ply", "--tets", "100"], "--tets"),
        (&["mesh", "none.obj", "x.vtu"], "none.obj: cannot be read"),
    ] {
        let sentence = shop.refusal(arguments);
        assert!(sentence.contains(word), "{arguments:?}: {sentence}");
        assert_eq!(shop.names(), before, "{arguments:?}");
    }
}

#[test]
fn materials_are_listed_and_explained() {
    let shop = Workshop::new();
    let all = shop.good(&["materials"]).out;
    assert!(all.contains("isotropic") && all.contains("Chen") && all.contains("tension_shear"), "{all}");
    let criterion = shop.good(&["materials", "tension_shear"]).out;
    assert!(criterion.contains("shear_release_rate") && criterion.contains("For isotropic, "), "{criterion}");
    let both = shop.good(&["materials", "critical_stretch"]).out;
    assert!(both.contains("Eq. 19") && both.contains("For lattice."), "of bonds, and of lattices: {both}");
    let one = shop.good(&["materials", "isotropic"]).out;
    for word in [
        "bulk_modulus",
        "shear_modulus",
        "[Pa]",
        "formulation",
        "as_written",
        "critical_stretch",
        "law = \"isotropic\"",
    ] {
        assert!(one.contains(word), "{word} in {one}");
    }
    let sentence = shop.refusal(&["materials", "isotopic"]);
    assert!(sentence.contains("isotopic") && sentence.contains("did you mean `isotropic`"), "{sentence}");
}

#[test]
fn render_draws_frames() {
    let shop = Workshop::new();
    shop.good(&["run", "box.toml", "--out", "r", "--until", "0.021", "--quiet"]);
    assert_eq!(shop.good(&["render", "r"]).out, "r/frame_0002.png\n");
    let png = fs::read(shop.path("r/frame_0002.png")).unwrap();
    assert_eq!(&png[16..24], &[0, 0, 0, 64, 0, 0, 0, 48], "the size that the scene gives");
    let mut pictures = Vec::new();
    for color in ["material", "damage", "speed", "piece"] {
        let name = format!("{color}.png");
        shop.good(&["render", "r", "--frame", "2", "--color", color, "--out", &name]);
        pictures.push(fs::read(shop.path(&name)).unwrap());
    }
    assert_eq!(pictures[0], png, "material is the scene's colouring");
    assert!(pictures[1] != png && pictures[2] != png);
    for (arguments, word) in [
        (&["render", "r", "--frame", "99"][..], "frame_0099.ply"),
        (&["render", "r", "--out", "no/where.png"], "no/where.png"),
        (&["render", "nowhere"], "nowhere is no run folder"),
    ] {
        let sentence = shop.refusal(arguments);
        assert!(sentence.contains(word), "{sentence}");
    }
}

#[test]
fn bench_prints_the_machine_and_its_floor() {
    let shop = Workshop::new();
    let text = shop.good(&["bench", "--edge", "10"]).out;
    for word in ["machine", "threads", "1000 particles", "read GB/s", "of the floor"] {
        assert!(text.contains(word), "{word} in {text}");
    }
    let json: serde_json::Value = serde_json::from_str(&shop.good(&["bench", "--edge", "10", "--json"]).out).unwrap();
    assert_eq!(json["particles"], 1000);
    for row in json["measured"].as_array().unwrap() {
        let of = |key: &str| row[key].as_f64().unwrap();
        let rate = json["directed_bonds"].as_f64().unwrap() / of("seconds_per_step");
        assert!((of("directed_bonds_per_second") / rate - 1.0).abs() < 1e-9 && of("triad") > 0.0, "{row}");
        assert!((of("share_of_floor") * of("read") / 16.0 / rate - 1.0).abs() < 1e-9, "{row}");
    }
    let sentence = shop.refusal(&["bench", "--edge", "3"]);
    assert!(sentence.contains("--edge") && sentence.contains("8..=120"), "{sentence}");
}
