//! The plastic law against closed forms: where it yields, how it hardens, the dent that stays, what it may never do.

use fissure_engine::{Bond, BondLaw, Params, Surroundings, Value, World};
use fissure_materials::{Isotropic, Plastic};
use fissure_tests::given::{Given, deform, pull_through_middle, reference_forces};
use fissure_tests::{Block, block, noise};
use glam::{DMat3, DVec3};

const KAPPA: f64 = 1e6;
const MU: f64 = 4e5;
const STRETCH: f64 = 2e-3;

fn number(name: &'static str, value: f64) -> (&'static str, Value) {
    (name, Value::Number(value))
}

fn given(more: &[(&'static str, Value)]) -> Vec<(&'static str, Value)> {
    [&[number("bulk_modulus", KAPPA), number("shear_modulus", MU)], more].concat()
}

fn law<const M: usize, T: BondLaw<M>>(more: &[(&'static str, Value)]) -> Result<T, String> {
    let pairs = given(more).into_iter().map(|(k, v)| (k.to_string(), v)).collect();
    let p = Params::new(T::PARAMETERS.to_vec(), pairs).map_err(|e| e.message)?;
    T::from_params(&p, &Surroundings { horizon: HORIZON, spacing: 0.1 }).map_err(|e| e.message)
}

const HORIZON: f64 = 0.26;

fn bond(k: u64) -> Bond<f64> {
    let rest = 0.1 + 0.07 * (1.0 + noise(k));
    Bond {
        rest,
        ext: 0.02 * rest * noise(k + 1),
        cos: 1.0,
        weight: HORIZON / rest,
        influence: HORIZON / rest,
        theta: 0.01 * noise(k + 2),
        inv_m: 3e3,
        norm: 0.0,
    }
}

#[test]
fn the_return_lands_on_the_yield_surface_and_plastic_work_is_never_negative() {
    let plastic: Plastic = law(&[number("yield_stretch", STRETCH), number("plastic_cap", 0.1)]).unwrap();
    let elastic: Isotropic = law(&[]).unwrap();
    let (mut worst, mut yielded, mut least_work) = (0.0f64, 0, f64::MAX);
    for k in 0..10_000 {
        let b = bond(5 * k);
        let before = 0.015 * b.rest * noise(5 * k + 3);
        let [after] = plastic.flow(&b, [before], 0.0);
        // flowing again changes nothing, and the force is that of the memory to come
        let surface = elastic.force(&Bond { ext: STRETCH * b.rest, theta: 0.0, ..b }, []);
        assert!((plastic.flow(&b, [after], 0.0)[0] - after).abs() < 1e-15 * b.rest);
        assert!((plastic.force(&b, [before]) - plastic.force(&b, [after])).abs() < 1e-11 * surface);
        // the deviatoric force, by what a bond without deviatoric extension answers
        let spherical = Bond { ext: b.theta * b.rest / 3.0, ..b };
        let deviatoric = plastic.force(&b, [before]) - elastic.force(&spherical, []);
        if after == before {
            assert!(deviatoric.abs() <= surface * (1.0 + 1e-12));
        } else {
            yielded += 1;
            worst = worst.max((deviatoric.abs() / surface - 1.0).abs());
            least_work = least_work.min(deviatoric * (after - before));
        }
    }
    println!("{yielded} of 10000 yield; off the surface by {worst:.1e} at most; least plastic work {least_work:.1e}");
    assert!(yielded > 5000 && worst < 1e-11 && least_work > 0.0); // measured 4e-15
}

#[test]
fn the_cap_of_eq_16_stops_the_flow_and_the_force_grows_again() {
    let plastic: Plastic = law(&[number("yield_stretch", STRETCH), number("plastic_cap", 0.01)]).unwrap();
    let elastic: Isotropic = law(&[]).unwrap();
    let b =
        Bond { ext: 0.1 * 0.05, rest: 0.1, cos: 1.0, weight: 2.6, influence: 2.6, theta: 0.0, inv_m: 3e3, norm: 0.0 };
    assert_eq!(plastic.flow(&b, [0.0], 0.0), [0.01 * 0.1]);
    // what is left beyond the cap is elastic
    assert_eq!(plastic.force(&b, [0.0]), elastic.force(&Bond { ext: b.ext - 0.001, ..b }, []));
    assert_eq!(plastic.elastic_extension(&b, [0.0]), b.ext - 0.001); // Eq. 18
}

#[test]
fn as_written_overshoots_by_two_omega() {
    // PHYSICS, item 4: Eq. 15 lands at A_c + (1 − 2ω)(A − A_c)
    let word = ("formulation", Value::Word("as_written".into()));
    let plastic: Plastic = law(&[word.clone(), number("yield_stretch", STRETCH)]).unwrap();
    let elastic: Isotropic = law(std::slice::from_ref(&word)).unwrap();
    let b =
        Bond { ext: 0.1 * 0.01, rest: 0.1, cos: 1.0, weight: 2.6, influence: 2.6, theta: 0.0, inv_m: 3e3, norm: 0.0 };
    let force = |stretch: f64| elastic.force(&Bond { ext: stretch * b.rest, ..b }, []);
    let (trial, surface) = (force(0.01), force(STRETCH));
    let want = surface + (1.0 - 2.0 * b.weight) * (trial - surface);
    assert!((plastic.force(&b, [0.0]) / want - 1.0).abs() < 1e-12);
    // Ψ0 says the same as the stretch: s_y = πδ⁴√(2Ψ0)/(30μ)
    let psi = (30.0 * MU * STRETCH / (std::f64::consts::PI * HORIZON.powi(4))).powi(2) / 2.0;
    let by_psi: Plastic = law(&[word, number("psi0", psi)]).unwrap();
    assert!((by_psi.force(&b, [0.0]) / want - 1.0).abs() < 1e-12);
}

#[test]
fn bad_parameters_get_one_sentence() {
    let refused = |more: &[(&'static str, Value)]| law::<1, Plastic>(more).err().expect("refused");
    for (more, say) in [
        (vec![], "give either `yield_stress` [Pa] or `yield_stretch`"),
        (vec![number("yield_stress", 1e3), number("yield_stretch", 0.1)], "give either `yield_stress`"),
        (vec![number("psi0", 1e9)], "`psi0` with formulation = \"as_written\""),
        (vec![number("yield_stress", -1.0)], "`yield_stress` = -1 must be above 0 [Pa]"),
        (vec![number("yield_stress", 1.0)], "`yield_stress` means yield at a stretch of 8.3e-7"),
        (vec![number("yield_stretch", 0.1), number("plastic_cap", 0.0)], "`plastic_cap` = 0 must be above 0 [1]"),
    ] {
        let message = refused(&more);
        assert!(message.contains(say), "{message}");
    }
}

fn plastic_block(n: usize) -> World {
    let stress = given(&[number("yield_stress", 3.0 * MU * STRETCH)]);
    let mut world = block(&Block { n: [n; 3], spacing: 1.0 / n as f64, law: ("plastic", stress), ..Block::default() });
    world.dt = 1e-12; // nothing moves
    world
}

/// Shear stress over 15 μ of bonds that yield at `s` under a simple shear `gamma`: ⟨p · clamp(γp, ±s)⟩ over all directions,
/// p = n_x n_y.
fn capped(gamma: f64, s: f64) -> f64 {
    let (rings, sectors) = (400, 400);
    let mut sum = 0.0;
    for r in 0..rings {
        let z = (f64::from(r) + 0.5) / f64::from(rings); // even in z
        for k in 0..sectors {
            let (sin, cos) = ((f64::from(k) + 0.5) / f64::from(sectors) * std::f64::consts::TAU).sin_cos();
            let p = (1.0 - z * z) * sin * cos;
            sum += p * (gamma * p).clamp(-s, s);
        }
    }
    sum / f64::from(rings * sectors)
}

#[test]
fn a_sheared_block_keeps_the_dent_of_the_closed_form() {
    let shear = |gamma: f64| DMat3::from_cols(DVec3::X, DVec3::new(gamma, 1.0, 0.0), DVec3::Z);
    // all bonds at yield: 10/π μ s_y
    assert!((15.0 * capped(1e3, 1.0) - 10.0 / std::f64::consts::PI).abs() < 1e-3);
    for (n, family, bound) in [(10, 3.6, 0.015), (16, 5.6, 0.012)] {
        let spacing = 1.0 / f64::from(n);
        let points: Vec<DVec3> = (0..n * n * n)
            .map(|k| {
                let cell = DVec3::new(f64::from(k / (n * n)), f64::from(k / n % n), f64::from(k % n));
                let k = 3 * k as u64;
                (cell + DVec3::new(noise(k), noise(k + 1), noise(k + 2)) * 0.5) * spacing
            })
            .collect();
        let law = given(&[number("yield_stress", 3.0 * MU * STRETCH)]);
        let mut world = Given {
            points: &points,
            volume: spacing.powi(3),
            density: 1000.0,
            spacing,
            horizon: family * spacing,
            law: ("plastic", &law),
            criterion: ("none", &[]),
        }
        .world();
        world.dt = 1e-12; // nothing moves
        let stress = |world: &mut World, gamma: f64| {
            deform(world, shear(gamma));
            // the traction on a plane x = const along y
            pull_through_middle(world).y
        };
        let small = 0.5 * STRETCH;
        let modulus = stress(&mut world, small) / small; // elastic; the same surfaces as below
        let gamma = 10.0 * STRETCH;
        deform(&mut world, shear(gamma));
        world.step().unwrap();
        let loaded = stress(&mut world, gamma) / modulus;
        let want = 15.0 * capped(gamma, STRETCH);
        // unloading is elastic: where the secant crosses zero
        let back = stress(&mut world, gamma - loaded) / modulus;
        let dent = gamma - loaded - back;
        world.step().unwrap();
        let again = stress(&mut world, dent) / modulus;
        println!(
            "{n} across, family {family}: loaded to {:.4} of the closed form, dent {:.4} of it, left there {:+.1e}",
            loaded / want,
            dent / (gamma - want),
            again / loaded
        );
        // measured .9979 and .9910, dents 1.0008 and 1.0040 (without surface factors 1.0098 and .9966): how evenly directions are sampled. A plain lattice with a
        // family of 2.6 is 5 % soft at any size
        assert!((loaded / want - 1.0).abs() < bound && (dent / (gamma - want) - 1.0).abs() < bound);
        assert!((again / loaded).abs() < 1e-6); // measured 6e-8
    }
}

#[test]
fn it_gives_way_at_the_tensile_stress_it_says() {
    let sigma = 3e3;
    let plastic: Plastic = law(&[number("yield_stress", sigma)]).unwrap();
    let (e, nu) = (9.0 * KAPPA * MU / (3.0 * KAPPA + MU), (3.0 * KAPPA - 2.0 * MU) / (6.0 * KAPPA + 2.0 * MU));
    // under uniaxial stress the bond along it has the largest deviatoric stretch
    let flowed = |stress: f64| {
        let strain = stress / e;
        let b = Bond {
            ext: strain * 0.1,
            theta: (1.0 - 2.0 * nu) * strain,
            rest: 0.1,
            cos: 1.0,
            weight: 2.6,
            influence: 2.6,
            inv_m: 3e3,
            norm: 0.0,
        };
        plastic.flow(&b, [0.0], 0.0)[0]
    };
    assert_eq!(flowed(0.9999 * sigma), 0.0);
    assert!(flowed(1.0001 * sigma) > 0.0);
    // pure dilatation yields nothing, at any size
    let b = Bond { ext: 0.01, theta: 0.3, rest: 0.1, cos: 1.0, weight: 2.6, influence: 2.6, inv_m: 3e3, norm: 0.0 };
    assert_eq!(plastic.flow(&b, [0.0], 0.0), [0.0]);
}

#[test]
fn unloading_force_is_minus_the_gradient_of_the_energy() {
    let mut world = plastic_block(5);
    let shape = DMat3::from_cols(DVec3::new(0.02, 0.01, 0.0), DVec3::new(0.0, -0.01, 0.01), DVec3::ZERO);
    deform(&mut world, DMat3::IDENTITY + shape);
    world.step().unwrap();
    deform(&mut world, DMat3::IDENTITY + shape * 0.95);
    let force = reference_forces(&world);
    let largest = force.iter().map(|f| f.length()).fold(0.0, f64::max);
    let (mut worst, h) = (0.0f64, 2e-5);
    for i in [0, 31, 62, 124] {
        for axis in [DVec3::X, DVec3::Y, DVec3::Z] {
            let home = world.particles.position[i];
            let mut energy = |h: f64| {
                world.particles.position[i] = home + axis * h;
                world.energies().elastic
            };
            let slope = (energy(h) - energy(-h)) / (2.0 * h) / world.particles.volume[i];
            world.particles.position[i] = home;
            worst = worst.max((slope + force[i].dot(axis)).abs() / largest);
        }
    }
    println!("force and slope of the energy differ by {worst:.1e} of the largest force");
    assert!(worst < 2e-4, "{worst:e}"); // measured 4.8e-5: f32 energies are differenced
}
