//! Overrides: what they change, what of the text stays, what is refused.

use super::*;

const COMMENTED: &str = r#"# what it is
duration = 0.5 # [s]

[body.vase] # the vase
mesh = "vase.ply" # ours
tets = 60_000     # many
density = 2400
[body.vase.material]
law = 'isotropic' # the law
"#;

fn refused(sets: &[&str]) -> String {
    with(FULL, sets).expect_err(&sets.join(" ")).to_string()
}

#[test]
fn values_change_and_comments_stay() {
    let text = COMMENTED;
    let scene =
        with(text, &["body.vase.tets=3e5", "duration = 0.25", "body.vase.mesh=/a b/c.ply", "title=one"]).unwrap();
    assert_eq!((scene.duration, scene.title.as_str()), (0.25, "one"));
    assert_eq!(scene.bodies[0].resolution, Resolution::Tets(300_000));
    assert_eq!(scene.bodies[0].source, Source::Mesh { path: "/a b/c.ply".into(), written: "/a b/c.ply".into() });
    let wanted = text
        .replace("60_000 ", "3e5 ")
        .replace("0.5 # [s]\n", "0.25 # [s]\ntitle = \"one\"\n")
        .replace("vase.ply\"", "/a b/c.ply\"");
    assert_eq!(scene.text(), wanted);
    assert_eq!(parse(scene.text()).unwrap().fingerprint(), scene.fingerprint());
    assert_eq!(with(text, &[]).unwrap().text(), text);
}

#[test]
fn tables_lists_and_free_keys_can_be_set() {
    let sets = [
        "ground.friction=0.9",
        "output.picture.color=speed",
        "body.vase.fracture.critical_stretch=0.5",
        "body.vase.material.bulk_modulus=7",
        "body.vase.rotate.axis=[1,0,0]",
        "body.vase.rotate.degrees=10",
        "title=12",
        "dt=auto",
    ];
    let scene = with(COMMENTED, &sets).unwrap();
    assert_eq!(scene.ground.unwrap().friction, 0.9);
    assert_eq!(scene.output.picture.colouring, Colouring::Speed);
    assert_eq!(scene.bodies[0].criterion.values(), [("critical_stretch".to_string(), Value::Number(0.5))]);
    assert_eq!(scene.bodies[0].law.values(), [("bulk_modulus".to_string(), Value::Number(7.0))]);
    assert_eq!(scene.bodies[0].placement.degrees, 10.0);
    assert_eq!(scene.title, "12", "a key that takes text takes the word as text");
    assert_eq!(parse(scene.text()).unwrap().fingerprint(), scene.fingerprint());
    let sets = ["anchor.2.until=0.75", "body.second.cut.1.triangle=[[0,0,0],[2,0,0],[0,2,0]]", "anchor.1.all=true"];
    let scene = with(FULL, &sets).unwrap();
    assert_eq!((scene.anchors[1].until, scene.anchors[0].region), (0.75, Region::All));
    assert_eq!(scene.bodies[0].cuts[0], Cut::Triangle([DVec3::ZERO, 2.0 * DVec3::X, 2.0 * DVec3::Y]));
    let inline = COMMENTED
        .replace("# the law\n", "\n[output]\n")
        .replace("duration", "anchor = [{ body = 'vase', all = true }]\nduration");
    assert_eq!(with(&inline, &["anchor.1.from=0.125"]).unwrap().anchors[0].from, 0.125);
}

#[test]
fn a_key_replaces_the_one_that_it_excludes() {
    let scene = with(FULL, &["body.second.tets=500", "body.second.mesh=m.ply", "output.frames_per_second=10"]).unwrap();
    assert_eq!(scene.bodies[0].resolution, Resolution::Tets(500));
    assert!(matches!(scene.bodies[0].source, Source::Mesh { .. }));
    assert_eq!(scene.output.frame_every, 0.1);
    assert!(!scene.text().contains("size = 0.05") && scene.text().contains("shell = 0.02"));
    assert_eq!(
        refused(&["body.a.size=0.1", "body.a.tets=5"]),
        "--set body.a.tets=5: both `size` and `tets` are given in [body.a]; keep one of them"
    );
}

#[test]
fn listed_tables_answer_to_their_names() {
    let text = format!(
        "{FULL}\n[[collider]]\nname = 'bullet'\nshape = {{ kind = 'ball', radius = 0.1 }}\nmotion = 'free'\ndensity = 8000\n\
         [[collider]]\nname = '1'\nshape = {{ kind = 'ball', radius = 0.1 }}\n"
    );
    let before = with(&text, &[]).unwrap().colliders.len();
    let scene = with(&text, &["collider.bullet.mass=2", "collider.bullet.shape.radius=0.25"]).unwrap();
    let numbered =
        with(&text, &[&format!("collider.{}.mass=2", before - 1), "collider.bullet.shape.radius=0.25"]).unwrap();
    assert_eq!(scene.text(), numbered.text());
    assert!(scene.text().contains("radius = 0.25") && !scene.text().contains("8000"), "a mass replaces the density");
    let one = with(&text, &["collider.1.friction=0.75"]).unwrap();
    let friction: Vec<f64> = one.colliders.iter().map(|collider| collider.friction).collect();
    assert_eq!(friction[before - 2..], [0.75, 0.5], "a number goes before a name");
}

#[test]
fn bad_overrides_are_refused_as_in_the_file() {
    assert_eq!(
        refused(&["body.second.densty=3"]),
        "--set body.second.densty=3: unknown key `densty` in [body.second]; did you mean `density`?"
    );
    assert_eq!(
        refused(&["durations=3"]),
        "--set durations=3: unknown key `durations` in the top of the scene; did you mean `duration`?"
    );
    assert_eq!(
        refused(&["body.secnd.density=3"]),
        "--set body.secnd.density=3: no body is called `secnd`; did you mean `second`?"
    );
    assert_eq!(
        refused(&["body.second.density=-3"]),
        "--set body.second.density=-3: `density` = -3 in [body.second] must be a finite number above 0 [kg/m³]"
    );
    assert_eq!(
        refused(&["anchor.4.from=1"]),
        "--set anchor.4.from=1: `4` is neither a name nor a number of one of the 3 tables [[anchor]], counted from 1"
    );
    assert_eq!(
        refused(&["body.a.cut.1.triangle=1"]),
        "--set body.a.cut.1.triangle=1: `1` is neither a name nor a number of one of the 0 tables [[body.a.cut]], counted from 1"
    );
    assert_eq!(refused(&["anchor.1=5"]), "--set anchor.1=5: `anchor.1` is a whole table; set one of its keys");
    assert_eq!(refused(&["density"]), "--set density: an override is key.path=value, for instance duration=0.5");
    assert_eq!(refused(&["a..b=1"]), "--set a..b=1: `a..b` is no path of keys, such as body.vase.tets");
    assert_eq!(refused(&["title.x=1"]), "--set title.x=1: unknown key `x` in [title]; none is known here");
    assert_eq!(
        refused(&["body.second.material.x.y=1"]),
        "--set body.second.material.x.y=1: unknown key `x` in [body.second.material]; known are law"
    );
    assert_eq!(
        refused(&["gravity=[0,1"]),
        "--set gravity=[0,1: `gravity` = \"[0,1\" in the top of the scene must be a list of 3 finite numbers [m/s²]"
    );
    // a line after an inserted one keeps its number in the file
    let text = FULL.replace("friction = 0.3", "friction = -1");
    assert_eq!(
        with(&text, &["output.picture.color=speed", "body.a.shell=0.5"]).unwrap_err().to_string(),
        format!("scenes/x.toml:{}: `friction` = -1 in [ground] must be a finite number 0 or more", line_of("friction"))
    );
}
