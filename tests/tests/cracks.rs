//! A crack in a strained strip runs at a speed between 0.4 and 1.0 of the Rayleigh wave's.

use fissure_engine::{Anchor, Families, Value, World};
use fissure_meshing::family::families;
use fissure_tests::given::{Given, lattice};
use glam::{DMat3, DVec3};

/// Glass: E [Pa], ν, ρ [kg/m³], G₀ [J/m²].
const YOUNG: f64 = 72e9;
const POISSON: f64 = 0.25;
const DENSITY: f64 = 2440.0;
const RELEASE: f64 = 3.8;

/// The families without the bonds through the plane y = 0 at x < `tip`: a notch.
fn notched(points: &[DVec3], whole: Families, tip: f64) -> Families {
    let mut out = Families { offsets: vec![0], neighbours: Vec::new() };
    for (i, p) in points.iter().enumerate() {
        let row = &whole.neighbours[whole.offsets[i] as usize..whole.offsets[i + 1] as usize];
        let holds = |j: &&u32| {
            let q = points[**j as usize];
            p.y * q.y > 0.0 || p.x + (q.x - p.x) * p.y / (p.y - q.y) > tip
        };
        out.neighbours.extend(row.iter().filter(holds));
        out.offsets.push(out.neighbours.len() as u32);
    }
    out
}

/// A strip of 60 × 20 mm, `rows` particles high and two thick, stretched upright between clamps until it stores `excess`
/// times the energy that a crack needs, with a notch to a third of its length.
fn strip(rows: usize, excess: f64) -> World {
    let (length, height) = (0.06, 0.02);
    let spacing = height / rows as f64;
    let horizon = 2.6 * spacing;
    let points = lattice([3 * rows, rows, 2], spacing);
    let (kappa, mu) = (YOUNG / (3.0 - 6.0 * POISSON), YOUNG / (2.0 + 2.0 * POISSON));
    // what all bonds across a unit of area store at this stretch is G₀ (Silling and Askari 2005; κ = 5μ/3)
    let stretch = (5.0 * RELEASE / (9.0 * kappa * horizon)).sqrt();
    let law = [("bulk_modulus", Value::Number(kappa)), ("shear_modulus", Value::Number(mu))];
    let law = [&law[..], &[("influence", Value::Word("inverse".into()))]].concat();
    let given = Given {
        points: &points,
        volume: spacing.powi(3),
        density: DENSITY,
        spacing,
        horizon,
        law: ("lps", &law),
        criterion: ("critical_stretch", &[("critical_stretch", Value::Number(stretch))]),
    };
    let whole = families(&points, horizon, None).expect("a lattice");
    let mut world = given.world_of(notched(&points, whole, -length / 6.0));
    world.dt = 0.8 * world.stable_dt();
    // plane stress, held sideways: E/(1 − ν²) ε²/2 per volume
    let strain = (2.0 * excess * RELEASE * (1.0 - POISSON * POISSON) / (YOUNG * height)).sqrt();
    let shape = DVec3::new(1.0, 1.0 + strain, 1.0 - strain * POISSON / (1.0 - POISSON));
    let shape = DMat3::from_diagonal(shape);
    let p = &mut world.particles;
    for i in 0..p.len() {
        p.position[i] = shape * p.rest[i].as_dvec3();
    }
    let edge = height / 2.0 - horizon;
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
    let rayleigh = (0.862 + 1.14 * POISSON) / (1.0 + POISSON) * (YOUNG / (2.0 + 2.0 * POISSON) / DENSITY).sqrt();
    // measured .566 and .867, and .566 also at 80 rows; 1 − G₀/G would be .5 and .667 in a plate without end
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
