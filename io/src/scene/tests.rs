//! Tests of scenes: what is read, what is refused and with which sentence, overrides, fingerprints, noise.

use std::path::Path;

use fissure_engine::Relax;
use fissure_engine::params::Value;
use glam::DVec3;

use super::*;
use crate::export::Format;

/// The least that a scene can say.
const MINIMAL: &str = "\
duration = 0.5

[body.vase]
mesh = \"vase.ply\"
density = 2400

[body.vase.material]
law = \"isotropic\"
bulk_modulus = 1e6
shear_modulus = 6e5
";

/// Every table at least once.
const FULL: &str = r#"# a full scene
title = "everything"
duration = 2
gravity = [0, 0, -9.81]
dt = 1e-4
safety = 0.5
integrator = "relax"
residual = 1e-4
iterations = 2e4
seed = 7

[body.second]   # first in the file
shape = { kind = "revolution", profile = [[0, 0], [1, 0], [1, 2], [0, 2]], segments = 12 }
size = 0.05
shell = 0.02
scale = 2
rotate = { axis = [0, 0, 2], degrees = 90 }
translate = [1, 2, 3]
density = 1000.0
velocity = [1, 0, 0]
spin = [0, 1, 0]
horizon = 0.1
surface = "as_written"

[body.second.material]
law = "isotropic"
bulk_modulus = 1e6
shear_modulus = 6e5
axes = [[1, 0, 0], [0, 1, 0], [0, 0, 1]]
formulation = "as_written"

[body.second.fracture]
critical_stretch = 0.02

[[body.second.cut]]
triangle = [[0, 0, 0], [1, 0, 0], [0, 1, 0]]

[[body.second.cut]]
rectangle = { corner = [0, 0, 0], u = [1, 0, 0], v = [0, 1, 0] }

[body.a]
mesh = "a.ply"
density = 1
tets = 3e5
horizon_factor = 1.5
[body.a.material]
law = "plastic"

[[anchor]]
body = "a"
box = [[-1, -1, -1], [1, 1, 1]]

[[anchor]]
name = "grip"
body = "second"
ball = { centre = [0, 1, 0], radius = 0.5 }
velocity = [0, 1, 0]
spin = [1, 0, 0]
centre = [0, 0, 1]
from = 0.25
until = 1

[[anchor]]
body = "second"
all = true

[ground]
height = -1
normal = [0, 0, 3]
restitution = 0
friction = 0.3

[output]
frame_every = 0.1
checkpoint_every = 0.5
checkpoint_minutes = 15
on_write_error = "go_on"
keep = 0
particles = "off"
export = ["usd", "glb"]

[output.picture]
width = 640
height = 480
camera = [1, 2, 3]
target = [0, 0, 0]
color = "damage"
outside = [1, 1, 1]
inside = [0.5, 0, 0]
"#;

fn parse(text: &str) -> Result<Scene, SceneError> {
    Scene::parse(text, Path::new("scenes/x.toml"), &[])
}

fn with(text: &str, sets: &[&str]) -> Result<Scene, SceneError> {
    let sets: Vec<String> = sets.iter().map(|s| s.to_string()).collect();
    Scene::parse(text, Path::new("scenes/x.toml"), &sets)
}

/// The line of the full scene that first begins with `start`.
fn line_of(start: &str) -> usize {
    1 + FULL.lines().position(|line| line.starts_with(start)).unwrap()
}

mod errors;
mod noise;
mod overriding;

#[test]
fn a_minimal_scene_has_the_documented_defaults() {
    let s = parse(MINIMAL).unwrap();
    assert_eq!((s.title.as_str(), s.duration, s.dt, s.safety, s.seed), ("", 0.5, None, 0.8, 1));
    assert_eq!(s.integrator, Integrator::SymplecticEuler);
    assert_eq!(s.gravity, DVec3::new(0.0, -9.81, 0.0));
    assert!(s.ground.is_none() && s.anchors.is_empty() && s.bodies.len() == 1);
    let b = &s.bodies[0];
    assert_eq!(b.source, Source::Mesh { path: "scenes/vase.ply".into(), written: "vase.ply".into() });
    assert_eq!((b.resolution, b.horizon), (Resolution::Tets(20_000), Horizon::Factor(1.4)));
    assert_eq!((b.shell, b.surface, b.velocity, b.spin), (None, SurfaceMode::Smooth, DVec3::ZERO, DVec3::ZERO));
    assert_eq!(b.placement.place(DVec3::new(1.0, 2.0, 3.0)), DVec3::new(1.0, 2.0, 3.0));
    assert_eq!((b.criterion.name.as_str(), b.criterion.given.len(), b.cuts.len()), ("none", 0, 0));
    assert_eq!(s.output.frame_every, 1.0 / 60.0);
    assert_eq!((s.output.checkpoint_every, s.output.keep), (0.05, 5));
    let picture = Picture {
        width: 1280,
        height: 720,
        camera: None,
        target: None,
        colouring: Colouring::Material,
        outside: None,
        inside: None,
    };
    assert_eq!(s.output.picture, picture);
}

#[test]
fn a_full_scene_is_read_to_the_last_key() {
    let s = parse(FULL).unwrap();
    assert_eq!((s.title.as_str(), s.duration, s.dt, s.safety, s.seed), ("everything", 2.0, Some(1e-4), 0.5, 7));
    assert_eq!(s.integrator, Integrator::Relax(Relax { residual: 1e-4, iterations: 20_000 }));
    let plain = FULL.replace("\"relax\"\nresidual = 1e-4\niterations = 2e4", "\"relax\"");
    assert_eq!(parse(&plain).unwrap().integrator, Integrator::Relax(Relax::default()), "the documented defaults");
    let names: Vec<&str> = s.bodies.iter().map(|b| b.name.as_str()).collect();
    assert_eq!(names, ["second", "a"], "the order of the file");
    let b = &s.bodies[0];
    let profile = vec![[0.0, 0.0], [1.0, 0.0], [1.0, 2.0], [0.0, 2.0]];
    assert_eq!(b.source, Source::Shape(Shape::Revolution { profile, segments: 12 }));
    assert_eq!((b.resolution, b.horizon, b.shell), (Resolution::Size(0.05), Horizon::Length(0.1), Some(0.02)));
    assert_eq!((b.velocity, b.spin, b.surface), (DVec3::X, DVec3::Y, SurfaceMode::AsWritten));
    // scaled to (2, 0, 0), turned about z to (0, 2, 0), shifted; measured error 4e-16
    assert!(b.placement.place(DVec3::X).distance(DVec3::new(1.0, 4.0, 3.0)) < 1e-14);
    let given: Vec<(&str, &Value)> = b.law.given.iter().map(|g| (g.key.as_str(), &g.value)).collect();
    let axes = Value::List(vec![1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]);
    let word = Value::Word("as_written".into());
    let wanted = [
        ("bulk_modulus", &Value::Number(1e6)),
        ("shear_modulus", &Value::Number(6e5)),
        ("axes", &axes),
        ("formulation", &word),
    ];
    assert_eq!(given, wanted);
    assert_eq!(b.law.given[0].place.line(), Some(line_of("bulk_modulus")));
    assert_eq!(b.criterion.name, "critical_stretch");
    assert_eq!(b.cuts[0], Cut::Triangle([DVec3::ZERO, DVec3::X, DVec3::Y]));
    assert_eq!(b.cuts[1], Cut::Rectangle { corner: DVec3::ZERO, u: DVec3::X, v: DVec3::Y });
    assert_eq!(b.cuts[1].triangles().len(), 2);
    assert_eq!((s.bodies[1].resolution, s.bodies[1].horizon), (Resolution::Tets(300_000), Horizon::Factor(1.5)));
    let [first, grip, all] = &s.anchors[..] else { panic!("{} anchors", s.anchors.len()) };
    assert_eq!((first.name.as_str(), first.body, first.until), ("anchor 1", 1, f64::INFINITY));
    assert_eq!(first.region, Region::Box { min: DVec3::NEG_ONE, max: DVec3::ONE });
    assert!(first.region.contains(DVec3::ONE) && !first.region.contains(DVec3::new(0.0, 1.1, 0.0)));
    assert_eq!((grip.name.as_str(), grip.body, grip.from, grip.until), ("grip", 0, 0.25, 1.0));
    assert_eq!(grip.region, Region::Ball { centre: DVec3::Y, radius: 0.5 });
    assert_eq!((grip.velocity, grip.spin, grip.centre), (DVec3::Y, DVec3::X, DVec3::Z));
    assert_eq!((all.name.as_str(), all.region), ("anchor 3", Region::All));
    let ground = Ground { normal: DVec3::Z, height: -1.0, restitution: 0.0, friction: 0.3 };
    assert_eq!(s.ground, Some(ground));
    let picture = Picture {
        width: 640,
        height: 480,
        camera: Some(DVec3::new(1.0, 2.0, 3.0)),
        target: Some(DVec3::ZERO),
        colouring: Colouring::Damage,
        outside: Some([1.0; 3]),
        inside: Some([0.5, 0.0, 0.0]),
    };
    let output = Output {
        frame_every: 0.1,
        checkpoint_every: 0.5,
        checkpoint_steps: None,
        checkpoint_minutes: Some(15.0),
        keep: 0,
        on_write_error: OnFailure::GoOn,
        export: vec![Format::Usd, Format::Glb],
        particles: false,
        picture,
    };
    assert_eq!(s.output, output);
}

#[test]
fn every_kind_of_shape_is_read() {
    let shape = |text: &str| {
        let scene = MINIMAL.replace("mesh = \"vase.ply\"", &format!("shape = {{ {text} }}"));
        match parse(&scene).unwrap().bodies[0].source.clone() {
            Source::Shape(shape) => shape,
            Source::Mesh { .. } => panic!("{text} became a mesh"),
        }
    };
    assert_eq!(shape("kind='box', size=[1, 2, 3]"), Shape::Box { size: DVec3::new(1.0, 2.0, 3.0) });
    assert_eq!(shape("kind='beam', length=2, width=1"), Shape::Beam { length: 2.0, width: 1.0 });
    let (width, height, thickness) = (3.0, 2.0, 1.0);
    assert_eq!(shape("kind='wall', width=3, height=2, thickness=1"), Shape::Wall { width, height, thickness });
    assert_eq!(shape("kind='sheet', width=3, height=2, thickness=1"), Shape::Sheet { width, height, thickness });
    assert_eq!(shape("kind='ball', radius=0.5"), Shape::Ball { radius: 0.5 });
    assert_eq!(shape("kind='cylinder', radius=0.5, height=1"), Shape::Cylinder { radius: 0.5, height: 1.0 });
    let profile = vec![[0.0, -1.0], [1.0, 0.0]];
    assert_eq!(shape("kind='revolution', profile=[[0, -1], [1, 0]]"), Shape::Revolution { profile, segments: 64 });
    assert_eq!(shape("kind='vase', height=0.3, wall=0.006"), Shape::Vase { height: 0.3, wall: 0.006 });
    let kinds: Vec<&str> = SHAPES.iter().map(|(kind, _)| *kind).collect();
    assert_eq!(keys::key("body.NAME.shape", "kind").unwrap().kind, KeyKind::Word(kinds.leak()));
}

#[test]
fn the_scenes_of_the_project_are_read_and_their_materials_known() {
    let registry = fissure_materials::registry();
    for name in ["bunny", "vase"] {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("../scenes/{name}.toml"));
        let scene = Scene::load(&path, &[]).unwrap();
        assert_eq!(scene.bodies[0].name, name);
        assert!(scene.ground.is_some() && scene.dt.is_none(), "{name}");
        scene.check(&registry).unwrap();
    }
    for name in ["fig09_stretch", "fig10_bend", "fig11_swing", "fig12_twist", "fig13_vibration", "fig13_stand_in"] {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("../scenes/{name}.toml"));
        let scene = Scene::load(&path, &[]).unwrap();
        assert!(scene.compares.len() >= 2 && !scene.anchors.is_empty(), "{name}");
        scene.check(&registry).unwrap();
    }
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes/inclusion.toml");
    let scene = Scene::load(&path, &[]).unwrap();
    assert_eq!((scene.bodies[0].parts[0].name.as_str(), scene.bodies[0].interface.strength), ("disc", 0.3));
    scene.check(&registry).unwrap();
}

/// For each documented key a line that gives it another value than its default, and lines that it needs beside it.
fn another(key: &Key) -> Vec<String> {
    let path = key.path.replace("NAME", "vase").replace(".N", ".1");
    let set = |value: &str| vec![format!("{path}={value}")];
    match (key.path, key.kind) {
        ("body.NAME.shape.kind", _) => vec!["body.vase.shape={kind='ball', radius=2}".into()],
        (shape, _) if shape.starts_with("body.NAME.shape.") => {
            let (kind, keys) = SHAPES.iter().find(|(_, keys)| keys.contains(&key.name())).unwrap();
            let value = |name: &str| match name {
                "size" => "[1, 2, 3]",
                "profile" => "[[0, 0], [1, 1]]",
                "segments" => "12",
                _ => "0.25",
            };
            let body: Vec<String> = keys.iter().map(|name| format!("{name} = {}", value(name))).collect();
            vec![format!("body.vase.shape={{ kind = '{kind}', {} }}", body.join(", "))]
        }
        ("body.NAME.rotate.axis" | "body.NAME.rotate.degrees", _) => {
            vec!["body.vase.rotate={axis = [1, 0, 0], degrees = 30}".into()]
        }
        ("anchor.N.ball.centre" | "anchor.N.ball.radius", _) => {
            vec!["anchor.1.ball={centre = [0, 0, 0], radius = 1}".into()]
        }
        (cut, _) if cut.starts_with("body.NAME.cut.N.rectangle.") => {
            vec!["body.vase.cut.1.rectangle={corner = [0, 0, 9], u = [1, 0, 0], v = [0, 2, 0]}".into()]
        }
        ("anchor.N.body" | "compare.N.body", _) => set("other"),
        ("compare.N.point", _) => vec!["compare.1.track=t.csv".into(), "compare.1.point=[1, 2, 3]".into()],
        ("compare.N.track", _) => vec!["compare.1.track=t.csv".into(), "compare.1.point=[0, 0, 0]".into()],
        ("compare.N.displacement", _) => {
            ["displacement=1", "point=[0, 0, 0]", "along=[1, 0, 0]"].map(|s| format!("compare.1.{s}")).into()
        }
        ("compare.N.force" | "compare.N.torque" | "compare.N.anchor" | "compare.N.along", _) => {
            let kind = if key.name() == "torque" { "torque=1" } else { "force=1" };
            [kind, "anchor=anchor 1", "along=[0, 1, 0]"].map(|s| format!("compare.1.{s}")).into()
        }
        ("body.NAME.region.N.ball.centre" | "body.NAME.region.N.ball.radius", _) => {
            vec!["body.vase.region.1.ball={centre = [0, 0, 0], radius = 1}".into()]
        }
        ("body.NAME.region.N.nearest" | "body.NAME.region.N.than", _) => {
            vec!["body.vase.region.1.nearest=a.ply".into(), "body.vase.region.1.than=b.ply".into()]
        }
        ("body.NAME.region.N.name", _) => {
            vec!["body.vase.region.1.name=rim".into(), "body.vase.interface.pair.1.of=rim".into()]
        }
        ("body.NAME.interface.pair.N.of" | "body.NAME.interface.pair.N.and", _) => {
            vec!["body.vase.interface.pair.1.of=vase".into(), "body.vase.interface.pair.1.and=lip".into()]
        }
        (shape, _) if shape.starts_with("collider.N.shape.") => {
            let (kind, keys) = COLLIDERS.iter().rfind(|(_, keys)| keys.contains(&key.name())).unwrap_or(&COLLIDERS[2]);
            let value = |name: &str| match name {
                "size" | "normal" => "[1, 2, 3]",
                "mesh" => "'other.ply'",
                "height" => "2",
                _ => "0.25",
            };
            let all: Vec<String> = keys.iter().map(|name| format!("{name} = {}", value(name))).collect();
            let at = if *kind == "plane" { 2 } else { 1 };
            vec![format!("collider.{at}.shape={{ kind = '{kind}', {} }}", all.join(", "))]
        }
        (turn, _) if turn.starts_with("collider.N.rotate.") => {
            vec!["collider.1.rotate={axis = [1, 0, 0], degrees = 30}".into()]
        }
        (turn, _) if turn.starts_with("collider.N.keyframe.N.rotate.") => {
            vec!["collider.2.keyframe.1.rotate={axis = [1, 0, 0], degrees = 30}".into()]
        }
        ("collider.N.keyframe.N.time" | "collider.N.keyframe.N.position", _) => {
            let value = if key.name() == "time" { "0.125" } else { "[1, 2, 3]" };
            vec![format!("collider.2.keyframe.1.{}={value}", key.name())]
        }
        ("collider.N.mass", _) => vec!["collider.3.motion='free'".into(), "collider.3.mass=1".into()],
        ("collider.N.motion", _) => vec!["collider.3.motion='free'".into(), "collider.3.mass=1".into()],
        (_, KeyKind::Text) => set("different"),
        (_, KeyKind::Word(words)) => set(words[1]),
        (_, KeyKind::Words(words)) => set(&format!("['{}']", words[1])),
        (_, KeyKind::Number(_) | KeyKind::NumberOr(..)) => set("0.125"),
        (_, KeyKind::Whole(..)) => set("77"),
        (_, KeyKind::Yes) => set("true"),
        (_, KeyKind::Three(_) | KeyKind::Direction) => set("[0.25, 0.5, 0.75]"),
        (_, KeyKind::Points(2)) => set("[[0, 0, 0], [1, 1, 2]]"),
        (_, KeyKind::Points(_)) => set("[[0, 0, 0], [1, 0, 0], [0, 0, 1]]"),
        (_, KeyKind::Profile) => set("[[0, 0], [1, 1]]"),
        (_, KeyKind::Table | KeyKind::Tables) => Vec::new(),
    }
}

#[test]
fn every_documented_key_is_read_and_changes_the_fingerprint() {
    // all tables in it, so that each key has a place
    let base = "integrator = 'relax'\n".to_owned()
        + MINIMAL
        + "[body.vase.fracture]\ncriterion = 'none'\n[body.vase.crack_faces]\n[[body.vase.cut]]\ntriangle = [[0,0,0],[1,0,0],[0,1,0]]\n\
           [[body.vase.region]]\nname = 'lip'\nbox = [[0,0,0],[1,1,1]]\nmaterial = { law = 'isotropic' }\n\
           fracture = { criterion = 'none' }\n[[body.vase.interface.pair]]\nof = 'lip'\nand = 'vase'\nstrength = 1\n\
           [body.other]\nmesh = 'o.ply'\ndensity = 1\nmaterial = { law = 'isotropic' }\n\
           [[anchor]]\nbody = 'vase'\nbox = [[0,0,0],[1,1,1]]\n[[compare]]\nfield = 'f.csv'\n[ground]\n[output.picture]\n[contact]\n\
           [[collider]]\nshape = { kind = 'ball', radius = 1 }\nmotion = 'free'\ndensity = 1\n\
           [[collider]]\nshape = { kind = 'ball', radius = 1 }\nmotion = 'keyframes'\n\
           [[collider.keyframe]]\ntime = 0\nposition = [0, 0, 0]\n\
           [[collider]]\nshape = { kind = 'ball', radius = 1 }\n";
    let before = parse(&base).unwrap().fingerprint();
    let mut count = 0;
    for key in keys() {
        let sets = another(key);
        if sets.is_empty() {
            continue;
        }
        let scene = Scene::parse(&base, Path::new("x.toml"), &sets).unwrap_or_else(|e| panic!("{}: {e}", key.path));
        assert_ne!(scene.fingerprint(), before, "{} has no effect", key.path);
        count += 1;
    }
    assert_eq!(count, 130, "keys that take a value");
}

#[test]
fn the_documentation_is_whole() {
    for (k, key) in keys().iter().enumerate() {
        assert!(!key.about.is_empty() && keys()[..k].iter().all(|other| other.path != key.path), "{}", key.path);
        let table = key.table();
        let outer = table.strip_suffix(".N").unwrap_or(table).strip_suffix(".NAME").unwrap_or(table);
        let outer = outer.strip_suffix(".N").unwrap_or(outer);
        assert!(outer.is_empty() || keys().iter().any(|other| other.path == outer), "{} has no table", key.path);
        if let Fallback::Toml(text) = key.default {
            text.parse::<toml_edit::Value>().unwrap_or_else(|e| panic!("{}: {e}", key.path));
        }
    }
    for (table, group) in RIVALS {
        group.iter().for_each(|name| assert!(keys::key(table, name).is_some(), "{table}.{name}"));
    }
}

#[test]
fn the_fingerprint_is_of_the_meaning() {
    let print = |text: &str| parse(text).unwrap().fingerprint();
    let base = print(MINIMAL);
    assert_eq!(base, 2_655_110_859_513_251_419, "pinned: a run folder must know its scene after an update");
    let same = [
        format!("# a comment\n\n{MINIMAL}# another\n"),
        MINIMAL.replace("duration = 0.5", "duration=5e-1   # s"),
        MINIMAL.replace("density = 2400", "density = 2400.0\ntets = 20000\nvelocity = [0, -0.0, 0]"),
        MINIMAL.replace("bulk_modulus = 1e6\nshear_modulus = 6e5", "shear_modulus = 600000\nbulk_modulus = 1000000"),
        MINIMAL.replace("duration = 0.5", "gravity = [0, -9.81, 0]\ndt = \"auto\"\nduration = 0.5\nseed = 1"),
        format!(
            "{MINIMAL}[output]\nframes_per_second = 60\ncheckpoint_every = 0.05\n[output.picture]\ncolor = 'material'\n"
        ),
        MINIMAL.replace('\n', "\r\n"),
    ];
    for text in &same {
        assert_eq!(print(text), base, "{text}");
    }
    let other = [
        MINIMAL.replace("0.5", "0.51"),
        MINIMAL.replace("1e6", "1.0000001e6"),
        MINIMAL.replace("bulk_modulus", "bulk_modulos"),
        format!("{MINIMAL}[ground]\n"),
    ];
    for text in &other {
        assert_ne!(print(text), base, "{text}");
    }
}
