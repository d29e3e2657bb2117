//! Running cracks in thin plates: their speed, when they stand, where they branch and which way they turn.

use fissure_engine::{Anchor, Families, Value, World};
use fissure_meshing::family::families;
use fissure_tests::given::{Given, lattice};
use glam::{DMat3, DVec3};

/// What a plate is made of.
struct Solid {
    /// E [Pa].
    young: f64,
    /// ν [1].
    poisson: f64,
    /// ρ [kg/m³].
    density: f64,
    /// G₀ [J/m²].
    release: f64,
}

const GLASS: Solid = Solid { young: 72e9, poisson: 0.25, density: 2440.0, release: 3.8 };
const STEEL: Solid = Solid { young: 191e9, poisson: 1.0 / 3.0, density: 8000.0, release: 42408.0 };

/// Horizon [spacings].
const FAMILY: f64 = 2.6;

/// A notch: no bonds through the plane y = `y` [m] at x < `tip` [m]. It must lie between two rows, for one on it holds it shut.
struct Notch {
    y: f64,
    tip: f64,
}

impl Notch {
    fn cuts(&self, p: DVec3, q: DVec3) -> bool {
        let (below, above) = (self.y - p.y, q.y - self.y);
        below * above > 0.0 && p.x + (q.x - p.x) * below / (below + above) < self.tip
    }
}

/// A plate around the origin, two particles thick, with notches from the left.
fn plate(solid: &Solid, cells: [usize; 2], spacing: f64, notches: &[Notch]) -> World {
    let horizon = FAMILY * spacing;
    let points = lattice([cells[0], cells[1], 2], spacing);
    let kappa = solid.young / (3.0 - 6.0 * solid.poisson);
    let mu = solid.young / (2.0 + 2.0 * solid.poisson);
    // what all bonds across a unit of area store at this stretch is G₀ (Silling and Askari 2005; Madenci and Oterkus 2014)
    let stretch = (solid.release / ((3.0 * mu + 0.75f64.powi(4) * (kappa - 5.0 / 3.0 * mu)) * horizon)).sqrt();
    let law = [
        ("bulk_modulus", Value::Number(kappa)),
        ("shear_modulus", Value::Number(mu)),
        ("influence", Value::Word("inverse".into())),
    ];
    let given = Given {
        points: &points,
        volume: spacing.powi(3),
        density: solid.density,
        spacing,
        horizon,
        law: ("lps", &law),
        criterion: ("critical_stretch", &[("critical_stretch", Value::Number(stretch))]),
    };
    let whole = families(&points, horizon, None).expect("a lattice");
    let mut cut = Families { offsets: vec![0], neighbours: Vec::new() };
    for (i, p) in points.iter().enumerate() {
        let row = &whole.neighbours[whole.offsets[i] as usize..whole.offsets[i + 1] as usize];
        let holds = |j: &&u32| !notches.iter().any(|n| n.cuts(*p, points[**j as usize]));
        cut.neighbours.extend(row.iter().filter(holds));
        cut.offsets.push(cut.neighbours.len() as u32);
    }
    let mut world = given.world_of(cut);
    world.dt = 0.8 * world.stable_dt();
    world
}

/// A strip of 60 × 20 mm, `rows` particles high, stretched upright between clamps until it stores `excess`
/// times the energy that a crack needs, with a notch to a third of its length.
fn strip(rows: usize, excess: f64) -> World {
    let (length, height) = (0.06, 0.02);
    let spacing = height / rows as f64;
    let mut world = plate(&GLASS, [3 * rows, rows], spacing, &[Notch { y: 0.0, tip: -length / 6.0 }]);
    let Solid { young, poisson, density: _, release } = GLASS;
    // plane stress, held sideways: E/(1 − ν²) ε²/2 per volume
    let strain = (2.0 * excess * release * (1.0 - poisson * poisson) / (young * height)).sqrt();
    let shape = DVec3::new(1.0, 1.0 + strain, 1.0 - strain * poisson / (1.0 - poisson));
    let shape = DMat3::from_diagonal(shape);
    let p = &mut world.particles;
    for i in 0..p.len() {
        p.position[i] = shape * p.rest[i].as_dvec3();
    }
    let edge = height / 2.0 - FAMILY * spacing;
    let held: Vec<u32> = (0..p.len() as u32).filter(|&i| f64::from(p.rest[i as usize].y.abs()) > edge).collect();
    let start: Vec<DVec3> = held.iter().map(|&i| p.position[i as usize]).collect();
    let clamps = Anchor {
        name: "clamps".into(),
        particles: held.into(),
        start: start.into(),
        until: f64::INFINITY,
        ..Anchor::default()
    };
    world.anchors.push(clamps);
    world
}

/// Where the crack has come to [m]: the farthest particle beside y = 0 that has lost a quarter of its bonds.
fn tip(world: &World) -> f64 {
    let p = &world.particles;
    let broken = (0..p.len()).filter(|&i| p.damage[i] > 0.25);
    broken.map(|i| f64::from(p.rest[i].x)).fold(f64::MIN, f64::max)
}

/// Speed [m/s] between x = 0 and x = 15 mm.
fn crack_speed(world: &mut World) -> f64 {
    let mut passed = [0.0; 2];
    for (time, x) in passed.iter_mut().zip([0.0, 0.015]) {
        while tip(world) < x {
            world.step().unwrap();
            assert!(world.time < 60e-6, "it stands at {} m", tip(world));
        }
        *time = world.time;
    }
    0.015 / (passed[1] - passed[0])
}

#[test]
fn a_crack_runs_slower_than_surface_waves() {
    let Solid { young, poisson, density, .. } = GLASS;
    let rayleigh = (0.862 + 1.14 * poisson) / (1.0 + poisson) * (young / (2.0 + 2.0 * poisson) / density).sqrt();
    // measured .547, .867 and .554, and .566 at 80 rows; 1 − G₀/G would be .5 and .667 in a plate without end
    for (rows, excess) in [(40, 2.0), (40, 3.0), (60, 2.0)] {
        let speed = crack_speed(&mut strip(rows, excess)) / rayleigh;
        println!("{rows} rows, {excess} times the energy of a crack: {speed:.3} of the speed of Rayleigh's wave");
        assert!(speed > 0.4 && speed < 1.0, "{speed}");
    }
}

#[test]
fn a_crack_stands_where_less_is_stored_than_it_costs() {
    let mut world = strip(40, 0.7);
    while world.time < 40e-6 {
        world.step().unwrap();
    }
    println!("the notch ends at -10 mm, the crack at {:.1} mm", 1e3 * tip(&world));
    // measured -8.8 mm, a horizon on: the notch opens all at once, which drives it a little; twice the energy drives it 70 mm
    assert!(tip(&world) < -0.008);
}

#[test]
#[ignore = "54 000 particles, half a minute"]
fn a_crack_under_tension_branches() {
    let (height, stress) = (0.04, 2e6);
    let spacing = 1e-3 / FAMILY;
    let rows = (height / spacing) as usize;
    let mut world = plate(&GLASS, [(0.1 / spacing) as usize, rows], spacing, &[Notch { y: 0.0, tip: 0.0 }]);
    let top = 0.5 * (rows as f64 - 1.0) * spacing - 0.1 * spacing;
    let kick = stress / (GLASS.density * spacing) * world.dt;
    while world.time < 43e-6 {
        let p = &mut world.particles;
        for (v, x) in p.velocity.iter_mut().zip(&p.rest[..]).filter(|(_, x)| f64::from(x.y.abs()) > top) {
            v.y += kick * f64::from(x.y.signum());
        }
        world.step().unwrap();
    }
    // measured: it runs straight to 26 mm, then in two to 45 mm, 9 mm from the middle each
    let (straight, branched) = (crossings(&world, 0.02), crossings(&world, 0.042));
    println!("through x = 20 mm at {straight:.4?}, through 42 mm at {branched:.4?} m");
    assert!(straight.len() == 1 && straight[0].abs() < 1e-3);
    assert!(branched.len() == 2 && branched.iter().all(|y| (y.abs() - 0.009).abs() < 0.003));
}

/// Where cracks pass through the section at `x` [m]: the middle y of each run of damaged particles.
fn crossings(world: &World, x: f64) -> Vec<f64> {
    let p = &world.particles;
    let spacing = world.bodies[0].spacing;
    let near = |i: &usize| (f64::from(p.rest[*i].x) - x).abs() < spacing && p.damage[*i] > 0.25;
    let mut places: Vec<f64> = (0..p.len()).filter(near).map(|i| f64::from(p.rest[i].y)).collect();
    places.sort_by(f64::total_cmp);
    let runs = places.chunk_by(|a, b| b - a < 2.0 * FAMILY * spacing);
    runs.map(|run| run.iter().sum::<f64>() / run.len() as f64).collect()
}

#[test]
#[ignore = "67 000 particles, half a minute"]
fn kalthoff_and_winkler_see_cracks_turn_away_by_seventy_degrees() {
    // 0.1 × 0.2 m of steel, hit at 16 m/s between two notches of 50 mm
    let spacing = 2e-3 / FAMILY;
    let notch = 32.0 * spacing; // 24.6 mm, between two rows
    let cells = [0.1, 0.2].map(|size: f64| (size / spacing) as usize);
    let notches = [-notch, notch].map(|y| Notch { y, tip: 0.0 });
    let mut world = plate(&STEEL, cells, spacing, &notches);
    let p = &world.particles;
    let edge = -0.5 * (cells[0] as f64 - 1.1) * spacing;
    let hit = |i: &u32| f64::from(p.rest[*i as usize].x) < edge && f64::from(p.rest[*i as usize].y.abs()) < notch;
    let struck: Vec<u32> = (0..p.len() as u32).filter(hit).collect();
    while world.time < 70e-6 {
        world.step().unwrap();
        let (p, dt) = (&mut world.particles, world.dt);
        for i in struck.iter().map(|&i| i as usize) {
            p.position[i].x += (16.0 - p.velocity[i].x) * dt;
            p.velocity[i].x = 16.0;
        }
    }
    let p = &world.particles;
    let broken = (0..p.len()).filter(|&i| p.damage[i] > 0.25).map(|i| p.rest[i].as_dvec3());
    for side in [1.0, -1.0] {
        let ways = broken.clone().filter(|x| x.y * side > 0.0).map(|x| DVec3::new(x.x, x.y * side - notch, 0.0));
        let way = ways.max_by(|a, b| a.length().total_cmp(&b.length())).expect("a crack");
        let degrees = way.y.atan2(way.x).to_degrees();
        println!("turned by {degrees:.1}° over {:.1} mm", 1e3 * way.length());
        assert!((degrees - 70.0).abs() < 5.0 && way.length() > 0.02); // measured 71.6° over 33 mm
    }
}
