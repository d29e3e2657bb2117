//! Anisotropy by influence (Eq. 17) against the closed form of its stiffness.
//!
//! In a full family directions count by w(n) = 1/|Gn|, so with ⟨f⟩ = ∫ w f/∫ w the stiffness along an axis is
//! (κ − 5μ/3)(3⟨n²⟩)² + 15μ⟨n⁴⟩, and of a pure dilatation κ.

use fissure_engine::{Bond, BondLaw, Params, Surroundings, Value};
use fissure_materials::{Anisotropic, Isotropic, Plastic};
use fissure_tests::given::{deform, lane_forces, pull_through_middle, reference_forces, relative_error};
use fissure_tests::{Block, block};
use glam::{DMat3, DVec3};

const KAPPA: f64 = 1e6;
const MU: f64 = 4e5;

fn given(more: &[(&'static str, Value)]) -> Vec<(&'static str, Value)> {
    [&[("bulk_modulus", Value::Number(KAPPA)), ("shear_modulus", Value::Number(MU))], more].concat()
}

fn matrix(numbers: &[f64]) -> (&'static str, Value) {
    ("matrix", Value::List(numbers.to_vec()))
}

fn law<T: BondLaw<M>, const M: usize>(more: &[(&'static str, Value)]) -> Result<T, String> {
    let pairs = given(more).into_iter().map(|(k, v)| (k.to_string(), v)).collect();
    let p = Params::new(T::PARAMETERS.to_vec(), pairs).map_err(|e| e.message)?;
    T::from_params(&p, &Surroundings { horizon: 1.0, spacing: 0.1 }).map_err(|e| e.message)
}

/// Twice the energy density over strain² [Pa] of a full family, under strain `f` − I, by the law's own words.
fn stiffness(law: &Anisotropic<Isotropic>, f: DMat3, strain: f64) -> f64 {
    const ACROSS: i32 = 12; // horizon in spacings
    let spacing = 1.0 / f64::from(ACROSS);
    let side = 2 * ACROSS + 1;
    let family: Vec<DVec3> = (0..side.pow(3))
        .map(|k| DVec3::new(f64::from(k / side / side), f64::from(k / side % side), f64::from(k % side)))
        .map(|cell| (cell - DVec3::splat(f64::from(ACROSS))) * spacing)
        .filter(|xi| xi.length() > 0.0 && xi.length() <= 1.0)
        .collect();
    let volume = spacing.powi(3);
    let m: f64 = family.iter().map(|xi| law.influence(*xi, 1.0) * xi.length_squared() * volume).sum();
    let bond = |xi: &DVec3, theta: f64| {
        let rest = xi.length();
        Bond { ext: (f * *xi - *xi).dot(*xi) / rest, theta, ..Bond::at_rest(rest, law.influence(*xi, 1.0), 1.0 / m) }
    };
    let theta: f64 = family.iter().map(|xi| law.dilatation(&bond(xi, 0.0)) * volume).sum();
    let bonds: f64 = family.iter().map(|xi| law.bond_energy(&bond(xi, theta), []) * volume).sum();
    2.0 * (bonds + law.theta_energy(theta)) / (strain * strain)
}

/// Closed form along z and across it for G = diag(1, 1, g): ⟨⟩ over the sphere by its height.
fn closed_form(kappa: f64, g: f64) -> (f64, f64) {
    let mean = |f: fn(f64) -> f64| {
        let n = 10_000;
        let parts = (0..n).map(|k| {
            let zz = ((f64::from(k) + 0.5) / f64::from(n)).powi(2);
            let w = 1.0 / (1.0 - zz + g * g * zz).sqrt();
            (w * f(zz), w)
        });
        let (sum, all) = parts.fold((0.0, 0.0), |a, b| (a.0 + b.0, a.1 + b.1));
        sum / all
    };
    let stiff = |second: f64, fourth: f64| (kappa - 5.0 / 3.0 * MU) * (3.0 * second).powi(2) + 15.0 * MU * fourth;
    let along = stiff(mean(|zz| zz), mean(|zz| zz * zz));
    let across = stiff(mean(|zz| (1.0 - zz) / 2.0), mean(|zz| 0.375 * (1.0 - zz).powi(2)));
    (along, across)
}

#[test]
fn stiffness_moves_between_directions_and_the_bulk_modulus_stays() {
    let isotropic = KAPPA + 4.0 / 3.0 * MU;
    let axis = |a: DVec3| (DMat3::from_diagonal(DVec3::ONE + a * 1e-3), 1e-3);
    let solid = law::<Anisotropic<Isotropic>, 0>(&[matrix(&[1.0, 1.0, 2.0])]).unwrap();
    let measure = |(f, strain)| stiffness(&solid, f, strain);
    let (along, across) = closed_form(KAPPA, 2.0);
    for (what, got, want) in [
        ("along z", measure(axis(DVec3::Z)), along),
        ("across", measure(axis(DVec3::X)), across),
        ("bulk", measure(axis(DVec3::ONE)), 9.0 * KAPPA),
    ] {
        println!(
            "{what}: {:.4} of the isotropic solid, off the closed form by {:+.1e}",
            got / isotropic,
            got / want - 1.0
        );
        assert!((got / want - 1.0).abs() < 5e-3, "{what}"); // measured 1e-3 and 4e-3: the family is a lattice; bulk 2e-13
    }
    // a throwaway prototype measured .76 and 1.15 on a mesh, at κ = 5μ/3
    let (along, across) = closed_form(5.0 / 3.0 * MU, 2.0);
    println!("closed form at κ = 5μ/3: {:.3} and {:.3}", along / (3.0 * MU), across / (3.0 * MU));
    assert!((closed_form(KAPPA, 1.0).0 / isotropic - 1.0).abs() < 1e-6);
    assert!((measure(axis(DVec3::ONE)) / (9.0 * KAPPA) - 1.0).abs() < 1e-11);
}

#[test]
fn a_block_is_weak_along_its_long_direction() {
    let pull = |numbers: &[f64]| {
        let law = ("anisotropic", given(&[matrix(numbers)]));
        let mut world = block(&Block { n: [12; 3], spacing: 1.0 / 12.0, law, ..Block::default() });
        deform(&mut world, DMat3::from_diagonal(DVec3::new(1.001, 1.0, 1.0)));
        pull_through_middle(&world).x
    };
    let (along, across) = closed_form(KAPPA, 2.0);
    // the soft direction turned into the direction of the pull, by 9 numbers
    let ratio = pull(&[2.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]) / pull(&[1.0, 1.0, 2.0]);
    println!("pull along the weak over pull across: {ratio:.4}, closed form {:.4}", along / across);
    assert!((ratio / (along / across) - 1.0).abs() < 0.02); // measured .005
}

#[test]
fn a_multiple_of_the_identity_is_isotropic_by_default_and_softer_as_written() {
    let strained = |name: &'static str, more: &[(&'static str, Value)]| {
        let mut world = block(&Block { law: (name, given(more)), ..Block::default() });
        deform(&mut world, DMat3::from_cols(DVec3::new(1.01, 0.02, 0.0), DVec3::Y, DVec3::new(0.0, 0.01, 0.99)));
        world
    };
    let forces = |name, more: &[_]| lane_forces(&mut strained(name, more));
    let plain = forces("isotropic", &[]);
    let error = relative_error(&forces("anisotropic", &[matrix(&[3.0, 3.0, 3.0])]), &plain);
    println!("G = 3I differs from isotropic by {error:.1e}");
    assert!(error < 1e-6, "{error:e}"); // measured 8.5e-8
    let written = ("formulation", Value::Word("as_written".into()));
    let whole = reference_forces(&strained("isotropic", std::slice::from_ref(&written)));
    let half = reference_forces(&strained("anisotropic", &[written, matrix(&[2.0, 2.0, 2.0])]));
    // without change of volume A_dev = 4ωb e is all there is, and ω halves; with it θ halves once more
    let (a, b): (f64, f64) = (whole.iter().map(|f| f.length()).sum(), half.iter().map(|f| f.length()).sum());
    println!("as written G = 2I answers with {:.3} of the force of G = I", b / a);
    assert!((b / a - 0.5).abs() < 0.01); // measured .500
}

#[test]
fn around_plasticity_it_yields_at_the_same_force() {
    let isotropic = law::<Plastic, 1>(&[("yield_stretch", Value::Number(2e-3))]).unwrap();
    let solid =
        law::<Anisotropic<Plastic<true>>, 1>(&[("yield_stretch", Value::Number(2e-3)), matrix(&[1.0, 1.0, 2.0])])
            .unwrap();
    for xi in [DVec3::X * 0.4, DVec3::Z * 0.4, DVec3::new(0.1, 0.2, -0.3)] {
        let bond = |influence: f64| Bond { ext: 0.05, ..Bond::at_rest(xi.length(), influence, 1.0) };
        let g = DMat3::from_diagonal(DVec3::new(1.0, 1.0, 2.0));
        let weight = solid.influence(xi, 1.0);
        assert!((weight - 1.0 / (g * xi).length()).abs() < 1e-15); // Eq. 17
        // the constant force of Eq. 14 whatever the direction, so the yield extension is s_y|Gξ|
        let (a, b) = (solid.force(&bond(weight), [0.0]), isotropic.force(&bond(1.0 / xi.length()), [0.0]));
        assert!((a / b - 1.0).abs() < 1e-12);
        let stays = solid.flow(&bond(weight), [0.0], 0.0)[0];
        assert!((stays - (0.05 - 2e-3 * (g * xi).length())).abs() < 1e-15);
    }
}

#[test]
fn singular_matrices_are_refused() {
    for numbers in [
        vec![1.0, 1.0, 0.0],
        vec![0.0; 3],
        vec![1e200, 0.0, 0.0, 0.0, 1e200, 0.0, 1e200, 1e200, 0.0],
        vec![1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0],
    ] {
        let message = law::<Anisotropic<Isotropic>, 0>(&[matrix(&numbers)]).err().expect("refused");
        assert!(message.starts_with("`matrix` is singular"), "{message}");
    }
    let message = law::<Anisotropic<Isotropic>, 0>(&[matrix(&[1.0, 2.0])]).err().expect("refused");
    assert!(message.contains("3 (diagonal) or 9"), "{message}");
    law::<Anisotropic<Isotropic>, 0>(&[matrix(&[1e-3, 1e-3, 2e-3])]).unwrap();
}

#[test]
fn directions_follow_the_field() {
    let made = |field: &str, centre: &[f64]| {
        let more = [
            matrix(&[2.0, 1.0, 0.5]),
            ("field", Value::Word(field.into())),
            ("axis", Value::List(vec![0.0, 0.0, 3.0])),
            ("centre", Value::List(centre.to_vec())),
        ];
        law::<Anisotropic<Isotropic>, 0>(&more).unwrap()
    };
    let share = |law: &Anisotropic<Isotropic>, at: DVec3, n: DVec3| 1.0 / law.influence_at(at, n, 1.0);
    let near = |got: f64, want: f64| assert!((got - want).abs() < 1e-12, "{got} instead of {want}");
    let diagonal = DVec3::new(1.0, 1.0, 0.0).normalize();
    let wood = made("cylindrical", &[1.0, 0.0, 0.0]);
    for (at, outwards) in [(DVec3::new(3.0, 0.0, 5.0), DVec3::X), (DVec3::new(1.0, -2.0, 0.0), DVec3::NEG_Y)] {
        near(share(&wood, at, outwards), 2.0);
        near(share(&wood, at, DVec3::Z.cross(outwards)), 1.0);
        near(share(&wood, at, DVec3::Z), 0.5);
    }
    near(share(&wood, DVec3::new(2.0, 1.0, 0.0), diagonal), 2.0);
    let onion = made("spherical", &[0.0; 3]);
    let at = DVec3::new(1.0, 1.0, 2f64.sqrt());
    near(share(&onion, at, at.normalize()), 2.0);
    near(share(&onion, at, DVec3::new(-1.0, 1.0, 0.0).normalize()), 1.0);
    near(share(&onion, at, DVec3::new(-0.5, -0.5, 0.5f64.sqrt())), 0.5);
    // where there is no direction there is still a right-angled frame: the shares along any three directions add up
    for law in [&wood, &onion] {
        let at = if share(law, DVec3::new(5.0, 0.0, 0.0), DVec3::X) == 2.0 { DVec3::X } else { DVec3::ZERO };
        let sum: f64 = [DVec3::X, DVec3::Y, DVec3::Z].map(|n| share(law, at, n).powi(2)).iter().sum();
        near(sum, 4.0 + 1.0 + 0.25);
    }
    near(share(&made("uniform", &[9.0, 9.0, 9.0]), at, DVec3::X), 2.0);
    let flat = law::<Anisotropic<Isotropic>, 0>(&[("axis", Value::List(vec![0.0; 3]))]).err().expect("refused");
    assert!(flat.contains("`axis`"), "{flat}");
}

#[test]
fn rings_make_a_disc_the_same_in_all_directions() {
    // G = diag(2, 1, 1) outwards: pulled along x as along y, unlike the uniform field
    let pulls = |field: &str| {
        let more = [
            matrix(&[2.0, 1.0, 1.0]),
            ("field", Value::Word(field.into())),
            ("axis", Value::List(vec![0.0, 0.0, 1.0])),
        ];
        let law = ("anisotropic", given(&more));
        let mut world = block(&Block { n: [12, 12, 5], spacing: 0.1, jitter: 0.0, law, ..Block::default() });
        deform(&mut world, DMat3::from_diagonal(DVec3::new(1.001, 1.0, 1.0)));
        let x = pull_through_middle(&world).x;
        deform(&mut world, DMat3::from_diagonal(DVec3::new(1.0, 1.001, 1.0)));
        let (p, force) = (&world.particles, reference_forces(&world));
        let y: f64 = (0..p.len()).filter(|&i| p.rest[i].y < 0.0).map(|i| force[i].y * p.volume[i]).sum();
        x / y
    };
    let (rings, grain) = (pulls("cylindrical"), pulls("uniform"));
    println!("x over y: {rings:.6} with rings, {grain:.3} with a grain");
    assert!((rings - 1.0).abs() < 1e-6 && grain < 0.8); // measured below 1e-9 and .68
}
