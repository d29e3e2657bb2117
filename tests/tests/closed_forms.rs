//! Bars on plain lattices against closed forms: speed of a wave, frequency of torsion, elongation under a load.
//!
//! The horizon is 2.6 spacings and ω = δ/|ξ|: with those 80 neighbours the moments of the lattice are isotropic, to .4 % of E
//! and μ. At 3.015 spacings, as is usual, E along the axes is 11 % low (14 % with ω = 1) and μ 9 % high at any refinement.
//! What is measured here is then the surface: a solid that is normalised by its weighted volume is stiff within a horizon
//! of it.

use std::f64::consts::PI;

use fissure_engine::{Value, World};
use fissure_meshing::family::families;
use fissure_tests::given::{Given, lattice};
use glam::DVec3;

const HORIZON: f64 = 2.6;

/// A bar along x of `cells` particles, of Young's modulus `young` [Pa], Poisson's ratio ¼.
fn bar(law: &str, cells: [usize; 3], spacing: f64, young: f64, density: f64) -> World {
    let points = lattice(cells, spacing);
    let mut values = vec![("young_modulus", Value::Number(young)), ("poisson_ratio", Value::Number(0.25))];
    values.extend((law == "lps").then(|| ("influence", Value::Word("inverse".into()))));
    let horizon = HORIZON * spacing;
    let given = Given {
        points: &points,
        volume: spacing.powi(3),
        density,
        spacing,
        horizon,
        law: (law, &values),
        criterion: ("none", &[]),
    };
    let mut world = given.world_of(families(&points, horizon, None).expect("a lattice"));
    world.dt = 0.8 * world.stable_dt();
    world
}

/// Speed [m/s] of a sine pulse of 2 m/s and 10 µs along a bar of 0.2 × 0.002² m of steel, `n` particles across.
fn wave_speed(law: &str, n: usize) -> f64 {
    let (side, speed, time) = (0.002, 2.0, 10e-6);
    let spacing = side / n as f64;
    let mut world = bar(law, [100 * n, n, n], spacing, 210e9, 7850.0);
    let plane = |x: f64| (x / spacing) as usize * n * n..((x / spacing) as usize + 1) * n * n;
    let stations = [0.05, 0.13];
    // when the energy of the pulse passes: Σ v² t / Σ v²
    let mut passed = [[0.0; 2]; 2];
    while world.time < 37e-6 {
        world.step().unwrap();
        let middle = world.time - 0.5 * world.dt;
        let v = if middle < time { speed * (2.0 * PI * middle / time).sin() } else { 0.0 };
        let before = world.time - world.dt;
        for i in plane(0.0) {
            let p = &mut world.particles;
            p.position[i].x += (v - p.velocity[i].x) * world.dt;
            p.velocity[i].x = v;
        }
        for (passed, x) in passed.iter_mut().zip(stations) {
            let v = plane(x).map(|i| world.particles.velocity[i].x).sum::<f64>();
            passed[0] += v * v * (before + 0.5 * world.dt);
            passed[1] += v * v;
        }
    }
    (stations[1] - stations[0]) / (passed[1][0] / passed[1][1] - passed[0][0] / passed[0][1])
}

/// Angular frequency [rad/s] of the first torsion of a bar of 0.1² × 0.5 m that is held at one end, `n` particles across:
/// half of a bar of twice the length that is held nowhere.
fn torsion(law: &str, n: usize) -> f64 {
    let (side, length) = (0.1, 0.5);
    let spacing = side / n as f64;
    let mut world = bar(law, [10 * n, n, n], spacing, 17e6, 1100.0);
    let rest: Vec<DVec3> = world.particles.rest.iter().map(|x| x.as_dvec3()).collect();
    let shape = |x: &DVec3| DVec3::X.cross(*x) * (PI * x.x / (2.0 * length)).sin();
    for (v, x) in world.particles.velocity.iter_mut().zip(&rest) {
        *v = shape(x) * 0.1;
    }
    let twist =
        |w: &World| -> f64 { (0..rest.len()).map(|i| (w.particles.position[i] - rest[i]).dot(shape(&rest[i]))).sum() };
    // five half periods
    let (mut crossed, mut before) = (Vec::new(), f64::MIN_POSITIVE);
    while crossed.len() < 5 {
        world.step().unwrap();
        let now = twist(&world);
        if before * now < 0.0 {
            crossed.push(world.time - world.dt * now / (now - before));
        }
        before = now;
    }
    5.0 * PI / crossed[4]
}

/// Strain in the middle of a bar of 1 × 0.2² m whose ends are pulled by a stress of 1e-3 E, over 1e-3; `n` particles across.
fn elongation(law: &str, n: usize) -> f64 {
    let (side, young, strain) = (0.2, 1e6, 1e-3);
    let spacing = side / n as f64;
    let mut world = bar(law, [5 * n, n, n], spacing, young, 1000.0);
    let rest: Vec<DVec3> = world.particles.rest.iter().map(|x| x.as_dvec3()).collect();
    let end = 0.5 - 3.0 * spacing;
    let ends: Vec<usize> = (0..rest.len()).filter(|&i| rest[i].x.abs() > end).collect();
    let pull = strain * young * side * side / (ends.len() as f64 / 2.0);
    let kick = pull * world.dt / world.particles.mass[0];
    let gauge: Vec<usize> = (0..rest.len()).filter(|&i| (rest[i].x.abs() - 0.2).abs() < 0.51 * spacing).collect();
    let stretch = |w: &World| {
        let moved = |i: &usize| [w.particles.position[*i].x * rest[*i].x.signum(), rest[*i].x.abs()];
        let [now, then] = gauge.iter().map(moved).fold([0.0; 2], |[a, b], [x, y]| [a + x, b + y]);
        now / then - 1.0
    };
    // the load comes on so slowly that little swings, and that is averaged away
    let period = 2.0 / (young / 1000.0).sqrt();
    let (mut sum, mut times) = (0.0, 0);
    while world.time < 8.0 * period {
        let load = if world.time < 6.0 * period { 0.5 - 0.5 * (PI * world.time / (6.0 * period)).cos() } else { 1.0 };
        for &i in &ends {
            world.particles.velocity[i].x += load * kick * rest[i].x.signum();
        }
        world.step().unwrap();
        if world.time > 6.0 * period {
            sum += stretch(&world);
            times += 1;
        }
    }
    sum / f64::from(times) / strain
}

/// Relative errors of `measure` over `exact` for each number of particles across, each within its tolerance.
fn errors(what: &str, exact: f64, limits: &[(usize, f64)], measure: impl Fn(usize) -> f64) -> Vec<f64> {
    let error = |&(n, limit): &(usize, f64)| {
        let error = measure(n) / exact - 1.0;
        println!("{what}, {n} across: {:+.2} %", 100.0 * error);
        assert!(error.abs() < limit, "{what}, {n} across: {error}");
        error.abs()
    };
    limits.iter().map(error).collect()
}

fn falling(errors: &[f64]) -> bool {
    errors.windows(2).all(|e| e[1] < e[0])
}

/// √(E/ρ) of steel [m/s].
fn steel() -> f64 {
    (210e9f64 / 7850.0).sqrt()
}

#[test]
fn a_pulse_runs_along_a_bar_with_the_speed_of_its_modulus() {
    // measured .160 and .106: a plain solid is stiff within a horizon of its surface
    let limits = [(4, 0.17), (6, 0.115)];
    let error = errors("lps: wave", steel(), &limits, |n| wave_speed("lps", n));
    assert!(falling(&error), "{error:?}");
    // measured .047 and .038, with its surface treatment; .029 at 8
    let error = errors("isotropic: wave", steel(), &[(4, 0.05), (6, 0.04)], |n| wave_speed("isotropic", n));
    assert!(falling(&error), "{error:?}");
}

#[test]
#[ignore = "finer bars, half a minute"]
fn the_speed_of_a_pulse_in_a_finer_bar() {
    // measured .106 and .079
    let error = errors("lps: wave", steel(), &[(6, 0.115), (8, 0.085)], |n| wave_speed("lps", n));
    assert!(falling(&error), "{error:?}");
}

/// (π/2L)√(GJ/(ρI)) of the square bar [rad/s], J/I = .8435 after Saint-Venant; for a round one it is 1.
fn square() -> f64 {
    std::f64::consts::PI * (0.8435 * 17e6 / 2.5 / 1100.0f64).sqrt()
}

#[test]
fn a_bar_swings_in_torsion_with_the_frequency_of_its_shear_modulus() {
    // measured -.014 and .025: stiff surfaces, by cancellation with a coarse section. About .7/n - 4/n² all along
    let limits = [(4, 0.02), (8, 0.03)];
    errors("lps: torsion", square(), &limits, |n| torsion("lps", n));
    // measured .0009 and -.0011: nothing is left to fall
    errors("isotropic: torsion", square(), &[(4, 0.005), (8, 0.005)], |n| torsion("isotropic", n));
}

#[test]
#[ignore = "finer bars, a minute"]
fn the_torsion_of_a_finer_bar() {
    // measured .0291 and .0283
    let error = errors("lps: torsion", square(), &[(12, 0.031), (16, 0.03)], |n| torsion("lps", n));
    assert!(falling(&error), "{error:?}");
    // measured .0043
    errors("isotropic: torsion", square(), &[(12, 0.006)], |n| torsion("isotropic", n));
}

#[test]
fn a_bar_lengthens_by_its_load_over_modulus_and_section() {
    // measured .259, .144 and .100
    let limits = [(4, 0.27), (8, 0.15), (12, 0.105)];
    let error = errors("lps: elongation", 1.0, &limits, |n| elongation("lps", n));
    assert!(falling(&error), "{error:?}");
    // measured -.091 and -.057, -.047 at 10
    let error = errors("isotropic: elongation", 1.0, &[(4, 0.1), (8, 0.06)], |n| elongation("isotropic", n));
    assert!(falling(&error), "{error:?}");
}
