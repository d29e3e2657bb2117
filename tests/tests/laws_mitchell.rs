//! The elastic–plastic law of Mitchell against Peridigm's `ep_cube`, and against the stress at which it says that it yields.

use fissure_engine::{Bond, BondLaw, Params, Surroundings, Value, World};
use fissure_materials::Mitchell;
use fissure_tests::given::{Given, deform};
use fissure_tests::{Block, block, columns};
use glam::{DMat3, DVec3};

fn number(name: &'static str, value: f64) -> (&'static str, Value) {
    (name, Value::Number(value))
}

/// Eight points of a unit cube, torn along z until they yield.
mod cube {
    use super::*;

    pub const VOLUME: f64 = 0.125;
    pub const DENSITY: f64 = 2.7e-3;
    pub const HORIZON: f64 = 1.75;
    pub const STEP: f64 = 1e-6;
    pub const STEPS: usize = 35_000;
    pub const SPEED: f64 = 200.0;
    /// |u_x|, |u_z| [m] and λ, as Peridigm's test has them.
    pub const SIDE: f64 = 0.171134307531;
    pub const LONG: f64 = 0.225327601238;
    pub const LAMBDA: f64 = 3.594500407e-3;

    pub fn law() -> Vec<(&'static str, Value)> {
        vec![
            number("bulk_modulus", 67549.0),
            number("shear_modulus", 25902.2),
            number("yield_stress", 351.79),
            ("yield_surface", Value::Word("ball".into())),
        ]
    }

    pub fn points() -> [DVec3; 8] {
        std::array::from_fn(|k| DVec3::new((k & 1) as f64, (k >> 1 & 1) as f64, (k >> 2) as f64) * 0.5 - 0.25)
    }

    /// The largest relative error of the displacements, of which every particle's are the same.
    pub fn error(position: &[DVec3]) -> f64 {
        let off = |(y, x): (&DVec3, DVec3)| {
            let u = (*y - x) * x.signum();
            [-u.x / SIDE - 1.0, -u.y / SIDE - 1.0, u.z / LONG - 1.0].map(f64::abs)
        };
        let all = position.iter().zip(points()).flat_map(off);
        all.fold(0.0, f64::max)
    }
}

/// The cube in f64 with loops of its own, so that nothing but the law is asked: positions and λ.
fn cube_by_hand() -> ([DVec3; 8], f64) {
    let given = cube::law().into_iter().map(|(k, v)| (k.to_string(), v)).collect();
    let at = Surroundings { horizon: cube::HORIZON, spacing: 0.5 };
    let law = Mitchell::from_params(&Params::new(Mitchell::PARAMETERS.to_vec(), given).unwrap(), &at).unwrap();
    let rest = cube::points();
    let others = |i: usize| (0..8).filter(move |&j| j != i);
    let inv_m = 1.0 / others(0).map(|j| rest[j].distance_squared(rest[0]) * cube::VOLUME).sum::<f64>();
    let (mut y, mut v) = (rest, rest.map(|x| DVec3::Z * cube::SPEED * x.z.signum()));
    let (mut past, mut lambda) = ([[0.0; 8]; 8], 0.0);
    for step in 0..=cube::STEPS {
        let bond = |i: usize, j: usize| {
            let length = rest[j].distance(rest[i]);
            let ext = y[j].distance(y[i]) - length;
            Bond { ext, ..Bond::at_rest(length, 1.0, inv_m) }
        };
        let sum = |i: usize, share: &dyn Fn(usize) -> f64| others(i).map(|j| share(j) * cube::VOLUME).sum::<f64>();
        let theta: [f64; 8] = std::array::from_fn(|i| sum(i, &|j| law.dilatation(&bond(i, j))));
        let dilated = |i: usize, j: usize| Bond { theta: theta[i], ..bond(i, j) };
        let norm: [f64; 8] = std::array::from_fn(|i| sum(i, &|j| law.norm_share(&dilated(i, j), [past[i][j]])).sqrt());
        let seen = |i: usize, j: usize| Bond { norm: norm[i], ..dilated(i, j) };
        let force: [DVec3; 8] = std::array::from_fn(|i| {
            let pair = |j: usize| law.force(&seen(i, j), [past[i][j]]) + law.force(&seen(j, i), [past[j][i]]);
            others(i).map(|j| (y[j] - y[i]).normalize() * (pair(j) * cube::VOLUME)).sum()
        });
        lambda += law.tally(norm[0], inv_m);
        let after = |i: usize, j: usize| if i == j { 0.0 } else { law.flow(&seen(i, j), [past[i][j]], cube::STEP)[0] };
        past = std::array::from_fn(|i| std::array::from_fn(|j| after(i, j)));
        if step < cube::STEPS {
            for i in 0..8 {
                v[i] += force[i] * (cube::STEP / cube::DENSITY);
                y[i] += v[i] * cube::STEP;
            }
        }
    }
    (y, lambda)
}

#[test]
fn the_torn_cube_of_peridigm_to_its_digits() {
    let (position, lambda) = cube_by_hand();
    let (error, off) = (cube::error(&position), (lambda / cube::LAMBDA - 1.0).abs());
    println!("law in f64: displacements off by {error:.1e}, λ by {off:.1e}");
    // measured 4.1e-13 and 4.4e-11: the digits that are printed
    assert!(error < 2e-12 && off < 1.5e-10, "{error:e} {off:e}");
}

#[test]
fn the_torn_cube_of_peridigm_as_steps_are_made() {
    let law = cube::law();
    let mut world = Given {
        points: &cube::points(),
        volume: cube::VOLUME,
        density: cube::DENSITY,
        spacing: 0.5,
        horizon: cube::HORIZON,
        law: ("mitchell", &law),
        criterion: ("none", &[]),
    }
    .world();
    for (v, x) in world.particles.velocity.iter_mut().zip(cube::points()) {
        *v = DVec3::Z * cube::SPEED * x.z.signum();
    }
    world.dt = cube::STEP;
    (0..cube::STEPS).for_each(|_| world.step().unwrap());
    let error = cube::error(&world.particles.position);
    world.step().unwrap(); // λ at the last place
    let off = tally(&mut world).iter().map(|l| (l / cube::LAMBDA - 1.0).abs()).fold(0.0, f64::max);
    println!("f32 lanes: displacements off by {error:.1e}, λ by {off:.1e}");
    // measured 3.7e-6 and 2.7e-6: e^p and lanes are f32
    assert!(error < 1e-5 && off < 1e-5, "{error:e} {off:e}");
}

fn column(world: &mut World, name: &str) -> Vec<f64> {
    let all = columns(world);
    let (_, bytes) = all.iter().find(|(n, _)| n.ends_with(name)).expect("the column");
    bytes.chunks_exact(8).map(|b| f64::from_le_bytes(b.try_into().unwrap())).collect()
}

fn tally(world: &mut World) -> Vec<f64> {
    column(world, "/tally/plastic_multiplier")
}

#[test]
fn it_yields_at_the_tensile_stress_it_says_also_at_surfaces() {
    let (kappa, mu, sigma) = (1e6, 4e5, 1e3);
    let (e, nu) = (9.0 * kappa * mu / (3.0 * kappa + mu), (3.0 * kappa - 2.0 * mu) / (6.0 * kappa + 2.0 * mu));
    let moduli = [number("bulk_modulus", kappa), number("shear_modulus", mu), number("yield_stress", sigma)];
    for (surface, inside, edges) in [("family", [0.92, 1.12], [0.8, 1.22]), ("ball", [0.88, 1.16], [0.4, 1.0])] {
        let law = [&moduli[..], &[("yield_surface", Value::Word(surface.into()))]].concat();
        let mut world = block(&Block { n: [12; 3], spacing: 1.0 / 12.0, law: ("mitchell", law), ..Block::default() });
        world.dt = 1e-12; // nothing moves
        let strain = 3.0 * sigma / e;
        deform(&mut world, DMat3::from_diagonal(DVec3::ONE + DVec3::new(1.0, -nu, -nu) * strain));
        world.step().unwrap();
        let (lambda, inv_m) = (tally(&mut world), column(&mut world, "/inverse_weighted_volume"));
        // λ = (norm − 1)/α, and the norm is proportional to the load
        let yields = |i: usize| 3.0 / (1.0 + lambda[i] * 15.0 * mu * inv_m[i]);
        let depth = |i: usize| 0.5 - (world.particles.rest[i].abs().max_element() as f64);
        let range = |inner: bool| {
            let some = (0..lambda.len()).filter(|&i| if inner { depth(i) > 0.22 } else { depth(i) < 0.06 });
            some.map(yields).fold([f64::MAX, 0.0f64], |[low, high], x| [low.min(x), high.max(x)])
        };
        let (inner, outer) = (range(true), range(false));
        println!("{surface}: yields at {inner:.3?} of σ_y inside, at {outer:.3?} at the surface");
        // measured .939 to 1.098 and .820 to 1.191, .906 to 1.140 and .405 to .965: few neighbours in uneven directions,
        // and a ball that is not there at the surface
        assert!(inner[0] > inside[0] && inner[1] < inside[1] && outer[0] > edges[0] && outer[1] < edges[1]);
    }
}
