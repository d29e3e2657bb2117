//! Forces of the isotropic law against LAMMPS's linear peridynamic solid, through a law from outside the workspace's
//! registry: both normalise by the discrete weighted volume and weigh by 1/|ξ|, and LAMMPS tapers volumes at the horizon.

use fissure_engine::{
    BodyInput, Bond, BondLaw, Column, Lane, ParamError, Parameter, Params, Registry, Surroundings, Value, World,
};
use fissure_materials::Isotropic;
use fissure_tests::naive_families;
use glam::DVec3;

const LATTICE: f64 = 5e-4;
const HORIZON: f64 = 1.5001e-3;

/// The isotropic law with LAMMPS's volume taper, which is only another influence.
struct Tapered(Isotropic);

impl BondLaw<0> for Tapered {
    const NAME: &'static str = "tapered";
    const SUMMARY: &'static str = "linear peridynamic solid as LAMMPS computes it";
    const PARAMETERS: &'static [Parameter] = Isotropic::PARAMETERS;
    const MEMORY: [Column; 0] = [];

    fn from_params(p: &Params, at: &Surroundings) -> Result<Self, ParamError> {
        Isotropic::from_params(p, at).map(Self)
    }

    fn influence(&self, xi: DVec3, horizon: f64) -> f64 {
        let r = xi.length();
        let near_horizon = (r - horizon).abs() <= LATTICE / 2.0;
        let taper = if near_horizon { (horizon + LATTICE / 2.0 - r) / LATTICE } else { 1.0 };
        self.0.influence(xi, horizon) * taper
    }

    fn dilatation<L: Lane>(&self, b: &Bond<L>) -> L {
        self.0.dilatation(b)
    }

    fn force<L: Lane>(&self, b: &Bond<L>, memory: [L; 0]) -> L {
        self.0.force(b, memory)
    }
}

#[test]
fn forces_agree_with_lammps() {
    let table = include_str!("../reference/lammps_lps_forces.csv");
    let rows: Vec<Vec<f64>> =
        table.lines().skip(1).map(|line| line.split(',').map(|x| x.parse().unwrap()).collect()).collect();
    let vector = |row: &[f64], k: usize| DVec3::new(row[k], row[k + 1], row[k + 2]);
    let points: Vec<DVec3> = rows.iter().map(|r| vector(r, 0)).collect();
    let (horizon, spacing) = (HORIZON, LATTICE);
    let number = |name: &str, value: f64| (name.to_string(), Value::Number(value));
    let material = Registry::default()
        .bonds::<Tapered, _>()
        .make(
            ("tapered", vec![number("bulk_modulus", 14.9e9), number("shear_modulus", 8.0e9)]),
            ("none", vec![]),
            &Surroundings { horizon, spacing },
        )
        .unwrap();
    let families = naive_families(&points, horizon);
    let input = BodyInput {
        name: "block",
        points: &points,
        volumes: &vec![1.25e-10; points.len()],
        ids: &(0..points.len() as u32).collect::<Vec<_>>(),
        density: 2200.0,
        spacing,
        horizon,
        velocity: DVec3::ZERO,
        spin: DVec3::ZERO,
        families,
    };
    let mut world = World::default();
    world.add(input, material).unwrap();
    // rest positions are kept as f32; the displacement is LAMMPS's
    for (i, row) in rows.iter().enumerate() {
        world.particles.position[i] += vector(row, 3) - vector(row, 0);
    }
    let n = points.len();
    let p = world.particles.of(&(0..n));
    let want: Vec<DVec3> = rows.iter().map(|r| vector(r, 6)).collect();
    let largest = want.iter().map(|f| f.length()).fold(0.0, f64::max);
    let error = |got: &dyn Fn(usize) -> DVec3| (0..n).map(|i| got(i).distance(want[i])).fold(0.0, f64::max) / largest;

    let reference = world.bodies[0].material.reference_forces(&p).unwrap();
    let in_f64 = error(&|i| reference[i]);
    let mut dv = vec![DVec3::ZERO; n];
    world.bodies[0].material.respond(&p, 1.0, &mut dv);
    let in_lanes = error(&|i| dv[i] * 2200.0);
    println!("largest relative difference: {in_f64:.1e} in f64, {in_lanes:.1e} in eight f32 lanes");
    assert!(in_f64 < 1e-6 && in_lanes < 1e-6); // measured 1.4e-7 and 1.7e-7: rest positions and influences are f32
}
