//! `plot`, films and previews; what is known before a run: `check`, `schema`; and for shells: `completions`, `man`.

use std::fs;

use serde_json::Value;

use crate::workshop::{Workshop, names};

/// The cells of `series.csv` in the run folder.
fn series(shop: &Workshop, run: &str) -> Vec<Vec<String>> {
    let text = fs::read_to_string(shop.path(run).join("series.csv")).expect("a run keeps its series");
    text.lines().map(|line| line.split(',').map(str::to_string).collect()).collect()
}

#[test]
fn a_run_keeps_a_series_that_can_be_drawn() {
    let shop = Workshop::new();
    shop.good(&["run", "box.toml", "--out", "r", "--until", "0.041", "--quiet"]);
    let rows = series(&shop, "r");
    assert_eq!(rows.len(), 6, "names and five frames");
    let column = |name: &str| -> Vec<f64> {
        let k = rows[0].iter().position(|n| n == name).unwrap_or_else(|| panic!("no {name}"));
        rows[1..].iter().map(|row| row[k].parse().expect("a number")).collect()
    };
    assert_eq!(column("frame"), [0.0, 1.0, 2.0, 3.0, 4.0]);
    assert!(column("time").iter().zip(0..).all(|(t, k)| (t - 0.01 * f64::from(k)).abs() < 1e-9));
    let (kinetic, broken) = (column("kinetic"), column("broken"));
    // ½mv² of the box, whose tetrahedra leave out some of its edges: measured 1.0e-3
    assert!((kinetic[0] / (0.5 * (4.0f64.powi(2) + 0.2f64.powi(2))) - 1.0).abs() < 2e-3, "{kinetic:?}");
    assert!(broken[0] == 0.0 && broken.is_sorted() && broken[4] > 0.0);
    assert!(column("s_respond")[1..].iter().all(|s| *s > 0.0));

    assert_eq!(shop.good(&["plot", "r"]).out, "r/plot.png\n");
    assert!(fs::read(shop.path("r/plot.png")).unwrap().starts_with(b"\x89PNG"));
    shop.good(&["plot", "r", "--out", "energies.svg"]);
    let svg = fs::read_to_string(shop.path("energies.svg")).unwrap();
    for word in ["<svg", "Broken bonds", "kinetic", "respond", "A box breaks", "</svg>"] {
        assert!(svg.contains(word), "{word}");
    }
    shop.good(&["plot", "r", "--out", "all.csv"]);
    assert_eq!(fs::read(shop.path("all.csv")).unwrap(), fs::read(shop.path("r/series.csv")).unwrap());
    assert!(shop.refusal(&["plot", "r", "--out", "x.jpg"]).contains("none of the endings .png, .svg and .csv"));
    fs::remove_file(shop.path("r/series.csv")).unwrap();
    assert!(shop.refusal(&["plot", "r"]).contains("series.csv cannot be read"));
}

#[test]
fn films_and_previews_show_every_frame() {
    let shop = Workshop::new();
    shop.good(&["run", "box.toml", "--out", "r", "--until", "0.031", "--quiet", "--preview"]);
    let frames = ["frame_0000.png", "frame_0001.png", "frame_0002.png", "frame_0003.png"];
    assert_eq!(names(&shop.path("r/preview")), frames);
    let pictures: Vec<Vec<u8>> = frames.iter().map(|n| fs::read(shop.path("r/preview").join(n)).unwrap()).collect();
    assert!(pictures.windows(2).all(|pair| pair[0] != pair[1]), "it moves");

    shop.good(&["render", "r", "--all", "--every", "2", "--size", "32x24"]);
    assert_eq!(names(&shop.path("r/pictures")), ["frame_0000.png", "frame_0002.png"]);
    let answer = shop.good(&["render", "r", "--gif", "--size", "32x24"]);
    assert_eq!(answer.out, "r/film.gif: 4 pictures\n");
    let gif = fs::read(shop.path("r/film.gif")).unwrap();
    assert!(gif.starts_with(b"GIF89a") && gif[6..10] == [32, 0, 24, 0]);
    shop.good(&["render", "r", "--film", "f.png", "--size", "32x24", "--fps", "10"]);
    let apng = fs::read(shop.path("f.png")).unwrap();
    let at = apng.windows(4).position(|w| w == b"acTL").expect("an animated PNG");
    assert_eq!(apng[at + 4..at + 8], 4u32.to_be_bytes());
    for (arguments, words) in [
        (&["render", "r", "--film", "f.mp4"][..], "let it end in .gif or .png"),
        (&["render", "r", "--gif", "--size", "32"], "give one like 640x360"),
        (&["render", "r", "--gif", "--fps", "-1"], "--fps -1 must be above 0"),
    ] {
        let sentence = shop.refusal(arguments);
        assert!(sentence.contains(words), "{sentence}");
    }
}

#[test]
fn check_says_what_the_run_will_be() {
    let shop = Workshop::new();
    let told: Value = serde_json::from_str(&shop.good(&["check", "box.toml", "--json"]).out).expect("JSON");
    assert_eq!(shop.names(), ["box.toml"], "it leaves nothing behind");
    let ran = shop.good(&["run", "box.toml", "--out", "r"]).out;
    let (particles, bonds) = (&told["bodies"][0]["particles"], &told["bodies"][0]["directed_bonds"]);
    assert!(ran.contains(&format!("body box: {particles} particles, {bonds} directed bonds")), "{told}\n{ran}");
    let steps = told["steps"].as_u64().unwrap();
    assert!(ran.contains(&format!("{steps} steps of {:.3e} s", told["dt"].as_f64().unwrap())), "{told}\n{ran}");
    assert_eq!(told["frames"].as_u64().unwrap() as usize, names(&shop.path("r/frames")).len());
    let size = |name: &str| fs::metadata(shop.path("r").join(name)).unwrap().len() as f64;
    let frozen = told["frozen_bytes"].as_f64().unwrap();
    assert!((frozen / size("frozen.fis") - 1.0).abs() < 0.2, "{frozen} of {}", size("frozen.fis"));
    let text = shop.good(&["check", "box.toml"]).out;
    assert!(text.starts_with("A box breaks: 1 body with nothing wrong in it\n"), "{text}");
    assert!(text.contains(", 79 % of the stable"), "{text}"); // 80 %, less what lets frames fall on steps
    assert!(shop.refusal(&["check", "box.toml", "--set", "body.box.density=-1"]).contains("density"));
}

#[test]
fn the_schema_knows_every_key_of_every_scene_here() {
    let shop = Workshop::new();
    let schema: Value = serde_json::from_str(&shop.good(&["schema"]).out).expect("JSON");
    let scenes = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes");
    let mut seen = 0;
    for folder in [scenes.clone(), scenes.join("lattice")] {
        for name in names(&folder).iter().filter(|n| n.ends_with(".toml")) {
            let text = fs::read_to_string(folder.join(name)).unwrap();
            let scene: toml_edit::DocumentMut = text.parse().unwrap();
            known(&schema, scene.as_item(), name);
            seen += 1;
        }
    }
    assert!(seen > 15);
    let material = &schema["properties"]["body"]["additionalProperties"]["properties"]["material"];
    let plastic =
        material["allOf"].as_array().unwrap().iter().find(|c| c["if"]["properties"]["law"]["const"] == "plastic");
    let cap = &plastic.unwrap()["then"]["properties"]["bulk_modulus"];
    assert_eq!(cap["exclusiveMinimum"], 0.0, "{cap}");
}

/// Walks `item` along the schema.
fn known(schema: &Value, item: &toml_edit::Item, path: &str) {
    if let Some(tables) = item.as_array_of_tables() {
        for table in tables {
            known(&schema["items"], &toml_edit::Item::Table(table.clone()), path);
        }
    } else if let Some(table) = item.as_table_like() {
        assert_eq!(schema["type"], "object", "{path}");
        for (key, value) in table.iter() {
            let named = schema["properties"].get(key).or(schema.get("additionalProperties").filter(|s| s.is_object()));
            let place = format!("{path}.{key}");
            known(named.unwrap_or_else(|| panic!("{place} is not in the schema")), value, &place);
        }
    } else if let (Some(words), Some(word)) = (schema["enum"].as_array(), item.as_str()) {
        assert!(words.iter().any(|w| w == word), "{path} = {word}");
    }
}

#[test]
fn shells_and_manuals_know_every_command() {
    let shop = Workshop::new();
    for shell in ["bash", "zsh", "fish", "powershell"] {
        let text = shop.good(&["completions", shell]).out;
        for word in ["render", "resume", "schema"] {
            assert!(text.contains(word), "{shell}: {word}");
        }
    }
    shop.good(&["man", "pages"]);
    let pages = names(&shop.path("pages"));
    for page in ["fissure.1", "fissure-run.1", "fissure-plot.1"] {
        assert!(pages.iter().any(|p| p == page), "{page} in {pages:?}");
    }
    assert!(fs::read_to_string(shop.path("pages/fissure-run.1")).unwrap().contains("preview"));
}
