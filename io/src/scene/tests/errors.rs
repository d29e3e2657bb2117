//! Each thing that can be wrong, once, with the exact sentence.

use super::*;

/// The sentence for `text` after its place, which must be line `line` of the file.
fn refused(text: &str, line: usize) -> String {
    let sentence = parse(text).expect_err(text).to_string();
    let place = format!("scenes/x.toml:{line}: ");
    sentence.strip_prefix(&place).unwrap_or_else(|| panic!("not at line {line}: {sentence}")).to_owned()
}

/// The minimal scene with one change.
fn minimal(from: &str, to: &str) -> String {
    assert!(MINIMAL.contains(from), "{from}");
    MINIMAL.replacen(from, to, 1)
}

#[test]
fn unknown_keys() {
    let sentence = parse(&minimal("density", "densty")).unwrap_err().to_string();
    assert_eq!(sentence, "scenes/x.toml:5: unknown key `densty` in [body.vase]; did you mean `density`?");
    let top = minimal("duration", "durations");
    assert_eq!(refused(&top, 1), "unknown key `durations` in the top of the scene; did you mean `duration`?");
    let keep = minimal("duration", "keep = 5\nduration");
    assert_eq!(refused(&keep, 1), "unknown key `keep` in the top of the scene; it belongs in [output]");
    let ground = format!("{MINIMAL}[ground]\nzzz = 1\n");
    let known = "known are height, normal, restitution, friction";
    assert_eq!(refused(&ground, 12), format!("unknown key `zzz` in [ground]; {known}"));
    let rotate = minimal("density", "rotate = { axes = [0, 1, 0], degrees = 3 }\ndensity");
    assert_eq!(refused(&rotate, 5), "unknown key `axes` in [body.vase.rotate]; did you mean `axis`?");
    let cut = format!("{MINIMAL}\n[[body.vase.cut]]\ntriangel = 1\n");
    assert_eq!(refused(&cut, 13), "unknown key `triangel` in [[body.vase.cut]] 1; did you mean `triangle`?");
    let anchor = format!("{MINIMAL}\n[[anchor]]\nbody = 'vase'\nall = true\n[[anchor]]\nbdy = 'vase'");
    assert_eq!(refused(&anchor, 16), "unknown key `bdy` in [[anchor]] 2; did you mean `body`?");
}

#[test]
fn wrong_kinds_and_ranges() {
    let density = |value: &str| refused(&minimal("2400", value), 5);
    let end = "in [body.vase] must be a finite number above 0 [kg/m³]";
    assert_eq!(density("-3"), format!("`density` = -3 {end}"));
    assert_eq!(density("0"), format!("`density` = 0 {end}"));
    assert_eq!(density("nan"), format!("`density` = NaN {end}"));
    assert_eq!(density("inf"), format!("`density` = inf {end}"));
    assert_eq!(density("'heavy'"), format!("`density` = \"heavy\" {end}"));
    assert_eq!(density("[1]"), format!("`density` = [1] {end}"));
    assert_eq!(density("1979-05-27"), format!("`density` = 1979-05-27 {end}"));
    let vase = |line: &str| refused(&minimal("density", &format!("{line}\ndensity")), 5);
    let three = "must be a list of 3 finite numbers [m/s]";
    assert_eq!(vase("velocity = [1, 2]"), format!("`velocity` = [1, 2] in [body.vase] {three}"));
    assert_eq!(vase("velocity = [1, nan, 2]"), format!("`velocity` = [1, NaN, 2] in [body.vase] {three}"));
    assert_eq!(vase("velocity = [1, 2, 3, 4, 5]"), format!("`velocity` = [1, 2, 3, 4, ..] in [body.vase] {three}"));
    let count = "must be a whole number from 1 to 1000000000";
    assert_eq!(vase("tets = 1.5"), format!("`tets` = 1.5 in [body.vase] {count}"));
    assert_eq!(vase("tets = -1"), format!("`tets` = -1 in [body.vase] {count}"));
    let word = "must be one of \"smooth\", \"as_written\"; did you mean `smooth`?";
    assert_eq!(vase("surface = 'smoth'"), format!("`surface` = \"smoth\" in [body.vase] {word}"));
    assert_eq!(vase("rotate = 5"), "[body.vase.rotate] must be a table, not 5");
    assert_eq!(vase("cut = 5"), "`cut` = 5 in [body.vase] must be a list of tables");
    assert_eq!(
        vase("rotate = { axis = [0, 0, 0], degrees = 1 }"),
        "`axis` = [0, 0, 0] in [body.vase.rotate] must be a list of 3 finite numbers that are not all 0"
    );
    let top = |line: &str| refused(&format!("{line}\n{MINIMAL}"), 1);
    let place = "in the top of the scene must be";
    assert_eq!(top("dt = 'slow'"), format!("`dt` = \"slow\" {place} \"auto\" or a finite number above 0 [s]"));
    assert_eq!(top("safety = 1.5"), format!("`safety` = 1.5 {place} a finite number in (0, 1]"));
    assert_eq!(
        refused(&format!("integrator = 'velocity_verlet'\nresidual = 1e-4\n{MINIMAL}"), 2),
        "`residual` belongs to integrator = \"relax\", but this is \"velocity_verlet\"; remove one of them"
    );
    assert_eq!(top("title = 5"), format!("`title` = 5 {place} a text in quotes"));
    let tail = |lines: &str, line| refused(&format!("{MINIMAL}{lines}\n"), line);
    assert_eq!(
        tail("[output.picture]\noutside = [1, 2, 0]", 12),
        "`outside` = [1, 2, 0] in [output.picture] must be a list of 3 numbers in [0, 1]"
    );
    let anchor = "[[anchor]]\nbody = 'vase'\n";
    assert_eq!(tail(&format!("{anchor}all = false"), 13), "`all` = false in [[anchor]] 1 must be true (or left out)");
    assert_eq!(
        tail(&format!("{anchor}box = [[0, 0, 0]]"), 13),
        "`box` = [[0, 0, 0]] in [[anchor]] 1 must be a list of 2 points of 3 finite numbers each [m]"
    );
    assert_eq!(
        tail("poisson = true", 11),
        "`poisson` = true in [body.vase.material] must be a finite number, a word, or a list of numbers"
    );
    assert_eq!(
        tail("poisson = [1, [inf]]", 11),
        "`poisson` = [1, [inf]] in [body.vase.material] must be a finite number, a word, or a list of numbers"
    );
}

#[test]
fn missing_keys() {
    assert_eq!(
        refused(&minimal("density = 2400\n", ""), 3),
        "`density` [kg/m³] is missing in [body.vase]: mass per volume"
    );
    assert_eq!(
        refused(&minimal("duration = 0.5\n", ""), 1),
        "`duration` [s] is missing in the top of the scene: simulated time"
    );
    assert_eq!(
        refused(&minimal("law = \"isotropic\"\n", ""), 7),
        "`law` is missing in [body.vase.material]: name of a law; `fissure materials` lists them"
    );
    assert_eq!(
        refused("duration = 1\n[body.b]\nmesh = 'x'\ndensity = 1\n", 2),
        "`material` is missing in [body.b]: the constitutive law; its own keys stand beside `law`"
    );
    assert_eq!(refused(&minimal("mesh = \"vase.ply\"", ""), 3), "[body.vase] needs exactly one of `mesh`, `shape`");
    assert_eq!(
        refused(&format!("{MINIMAL}\n[[anchor]]\nbody = 'vase'\n"), 12),
        "[[anchor]] 1 needs exactly one of `box`, `ball`, `all`"
    );
    assert_eq!(
        refused(&minimal("mesh = \"vase.ply\"", "shape = { kind = 'beam', length = 1 }"), 4),
        "`width` [m] is missing in [body.vase.shape]: width of a wall or sheet; both edges of a beam's cross-section"
    );
    let cure = "write at least one table [body.NAME] with `mesh` or `shape`, `density` and [body.NAME.material]";
    assert_eq!(refused("duration = 1\n", 1), format!("the scene has no body; {cure}"));
    assert_eq!(refused("duration = 1\n[body]\n", 2), format!("the scene has no body; {cure}"));
    assert_eq!(refused("duration = 1\nbody = 3\n", 2), format!("`body` must be a table of bodies; {cure}"));
    assert_eq!(
        refused("duration = 1\n[body]\nmesh = 'x'\n", 3),
        "`mesh` = \"x\" in [body] must be a table [body.NAME]; [body] holds bodies only"
    );
}

#[test]
fn colliders() {
    let tail = |lines: &str, line| refused(&format!("{MINIMAL}[[collider]]\n{lines}\n"), line);
    let ball = "shape = { kind = 'ball', radius = 1 }\n";
    assert_eq!(
        tail("", 11),
        "`shape` is missing in [[collider]] 1: its shape about its origin, y along the axis of what has one"
    );
    assert_eq!(
        tail("shape = { kind = 'ball', size = [1, 1, 1] }", 12),
        "`size` in [collider 1.shape] is no key of a ball, which has radius"
    );
    assert_eq!(
        tail("shape = { kind = 'capsule', radius = 1, height = 2 }", 12),
        "`height` = 2 in [collider 1.shape] must be above twice the radius of 1 [m]; use a ball"
    );
    assert_eq!(
        tail("shape = { kind = 'bal' }", 12),
        "`kind` = \"bal\" in [collider 1.shape] must be one of \"plane\", \"ball\", \"box\", \"capsule\", \"cylinder\", \
         \"hull\", \"mesh\"; did you mean `ball`?"
    );
    assert_eq!(
        tail(&format!("{ball}mass = 1"), 13),
        "`mass` in [[collider]] 1 goes with motion = \"free\", but motion is \"fixed\""
    );
    assert_eq!(tail(&format!("{ball}motion = 'free'"), 11), "[[collider]] 1 needs exactly one of `density`, `mass`");
    assert_eq!(
        tail(&format!("{ball}motion = 'free'\nmass = 0"), 14),
        "`mass` = 0 in [[collider]] 1 must be a finite number above 0 [kg]"
    );
    assert_eq!(
        tail("shape = { kind = 'plane', normal = [0, 1, 0] }\nmotion = 'free'\nmass = 1", 13),
        "[[collider]] 1 cannot be free: a plane has no mass; use a flat box"
    );
    let moved = format!("{ball}motion = 'keyframes'\n");
    let none = "[[collider]] 1 has motion = \"keyframes\" but none; add [[collider.keyframe]] tables";
    assert_eq!(tail(&moved, 13), none);
    let frame = |time: &str| format!("[[collider.keyframe]]\ntime = {time}\nposition = [0, 0, 0]\n");
    assert_eq!(
        tail(&format!("{moved}{}{}", frame("0.5"), frame("0.5")), 18),
        "`time` = 0.5 in [[collider 1.keyframe]] 2 must be later than the 0.5 s of the one before; sort them"
    );
    assert_eq!(
        tail(&format!("{moved}position = [0, 0, 0]\n{}", frame("0")), 14),
        "`position` in [[collider]] 1 is for what does not move; the keyframes say where this is"
    );
    assert_eq!(
        refused(&format!("{MINIMAL}[ground]\n[[collider]]\nname = 'ground'\n{ball}"), 13),
        "a second collider is called `ground`; give each its own `name`"
    );
    assert_eq!(
        refused(&format!("{MINIMAL}[contact]\nstiffness = 0\n"), 12),
        "`stiffness` = 0 in [contact] must be a finite number above 0"
    );
}

#[test]
fn contradictions() {
    let vase = |lines: &str, line| refused(&minimal("density", &format!("{lines}\ndensity")), line);
    assert_eq!(
        vase("shape = { kind = 'ball', radius = 1 }", 5),
        "both `mesh` and `shape` are given in [body.vase]; keep one of them"
    );
    assert_eq!(vase("size = 1\ntets = 5", 6), "both `size` and `tets` are given in [body.vase]; keep one of them");
    assert_eq!(
        vase("horizon_factor = 2\nhorizon = 1", 6),
        "both `horizon_factor` and `horizon` are given in [body.vase]; keep one of them"
    );
    assert_eq!(
        refused(&minimal("mesh = \"vase.ply\"", "shape = { kind = 'ball', radius = 1, height = 2 }"), 4),
        "`height` in [body.vase.shape] is no key of a ball, which has radius"
    );
    let tail = |lines: &str, line| refused(&format!("{MINIMAL}{lines}\n"), line);
    assert_eq!(
        tail("[output]\nframe_every = 1\nframes_per_second = 5", 13),
        "both `frame_every` and `frames_per_second` are given in [output]; keep one of them"
    );
    assert_eq!(
        tail("[[body.vase.cut]]\ntriangle = [[0,0,0],[1,1,1],[2,2,2]]", 11),
        "[[body.vase.cut]] 1 has no area: its corners lie in one line; move one of them"
    );
    let compare = |lines: &str, line| tail(&format!("[[compare]]\n{lines}"), line);
    assert_eq!(
        compare("field = 'f.csv'\nforce = 3", 13),
        "both `field` and `force` are given in [[compare]] 1; keep one of them"
    );
    assert_eq!(
        compare("field = 'f.csv'\nalong = [1, 0, 0]", 13),
        "`along` in [[compare]] 1 does not go with `field`, which has label, body, at, translate"
    );
    assert_eq!(
        compare("field = 'f.csv'\nat = 0.75", 13),
        "`at` = 0.75 in [[compare]] 1 is after the end: `duration` is 0.5 s"
    );
    assert_eq!(
        compare("force = 3\nalong = [1, 0, 0]\nanchor = 'end'", 14),
        "no anchor is called `end` in [[compare]] 1; none is known here"
    );
    let anchor = "[[anchor]]\nbody = 'vase'\n";
    assert_eq!(
        tail(&format!("{anchor}box = [[1, 0, 0], [0, 1, 1]]"), 13),
        "`box` in [[anchor]] 1 must be [lowest corner, highest corner]"
    );
    assert_eq!(
        tail(&format!("{anchor}all = true\nfrom = 2\nuntil = 1"), 15),
        "`until` = 1 in [[anchor]] 1 must be later than `from` = 2 [s]"
    );
    assert_eq!(
        tail("[[anchor]]\nbody = 'vse'\nall = true", 12),
        "no body is called `vse` in [[anchor]] 1; did you mean `vase`?"
    );
    assert_eq!(
        tail(&format!("{anchor}all = true\n{anchor}all = true\nname = 'anchor 1'"), 17),
        "a second anchor is called `anchor 1`; give each its own `name`"
    );
    assert_eq!(
        refused(&MINIMAL.replace("body.vase", "body.'a/b'"), 3),
        "a body cannot be called \"a/b\"; use letters, digits, spaces, `-` and `_`"
    );
}

#[test]
fn files_and_syntax() {
    let missing = Scene::load(Path::new("no/such.toml"), &[]).unwrap_err().to_string();
    assert!(missing.starts_with("no/such.toml: the scene cannot be read ("), "{missing}");
    assert!(missing.ends_with("; check the path and that it is a text file"), "{missing}");
    let binary = tempfile::NamedTempFile::new().unwrap();
    std::fs::write(binary.path(), [0xff, 0xfe, 0x00]).unwrap();
    assert!(matches!(Scene::load(binary.path(), &[]), Err(SceneError::NotReadable { .. })));
    assert_eq!(
        refused(&minimal("2400", "2400 kg"), 5),
        "this is not TOML: string values must be quoted, expected literal string, in `density = 2400 kg`"
    );
    assert_eq!(
        refused(&minimal("[body.vase]", "[body.vase"), 3),
        "this is not TOML: unclosed table, expected `]`, in `[body.vase`"
    );
    assert_eq!(refused(&minimal("mesh", "density = 1\nmesh"), 6), "the key `density` is given twice; keep one of them");
    let twice = "is given twice; keep one of them, or give the second its own name";
    assert_eq!(refused(&format!("{MINIMAL}[body.vase]\n"), 11), format!("[body.vase] {twice}"));
    assert!(matches!(parse("duration = "), Err(SceneError::Syntax { .. })));
}

#[test]
fn what_a_registry_says_gets_file_and_line() {
    let registry = fissure_materials::registry();
    let check = |text: &str| parse(text).unwrap().check(&registry).unwrap_err().to_string();
    assert_eq!(
        check(&minimal("bulk_modulus", "bulk_modulos")),
        "scenes/x.toml:9: [body.vase.material]: unknown key `bulk_modulos`; did you mean `bulk_modulus`?"
    );
    assert!(
        check(&minimal("isotropic", "isotrope"))
            .starts_with("scenes/x.toml:8: [body.vase.material]: no material is called `isotrope`")
    );
    let fracture = |lines: &str| check(&format!("{MINIMAL}[body.vase.fracture]\n{lines}\n"));
    assert!(
        fracture("criterion = 'critical'")
            .starts_with("scenes/x.toml:12: [body.vase.fracture]: no criterion is called `critical`")
    );
    assert!(
        fracture("").starts_with("scenes/x.toml:11: [body.vase.fracture]: `critical_stretch` [1] is missing"),
        "{}",
        fracture("")
    );
    assert!(
        fracture("critical_stretch = -1")
            .starts_with("scenes/x.toml:12: [body.vase.fracture]: `critical_stretch` = -1 must be above 0")
    );
    let scene = with(FULL, &["body.a.material.x=5"]).unwrap();
    let line = |body, table, key| scene.locate(body, table, key).to_string();
    let at = |start: &str| format!("scenes/x.toml:{}", line_of(start));
    assert_eq!(line("second", "", "density"), at("density = 1000.0"));
    assert_eq!(line("second", "", "no"), at("[body.second]"));
    assert_eq!(line("second", "material", "bulk_modulus"), at("bulk_modulus"));
    assert_eq!(line("second", "material", "no"), at("[body.second.material]"));
    assert_eq!(line("second", "shape", "kind"), at("shape"));
    assert_eq!(line("a", "fracture", "criterion"), at("[body.a]"));
    assert_eq!(line("a", "material", "x"), "--set body.a.material.x=5");
    assert!(scene.gives("second", "", "size") && !scene.gives("second", "", "tets"));
    let error = ParamError::new("critical_stretch", "is odd".into());
    let place = at("critical_stretch");
    assert_eq!(scene.blame("second", &error).to_string(), format!("{place}: [body.second.fracture]: is odd"));
}
