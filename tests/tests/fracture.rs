//! Fracture criteria against energies: what the bonds across a plane hold, and the work of pulling and sliding a block apart.

use fissure_engine::fracture::Bulk;
use fissure_engine::{Bond, BondLaw, Params, Surroundings, Value};
use fissure_materials::{Anisotropic, Isotropic, Lps, Plastic, Pmb, Viscoelastic};
use fissure_tests::given::{Given, lane_forces};
use glam::DVec3;

type Values = Vec<(&'static str, Value)>;

fn law<T: BondLaw<M>, const M: usize>(given: &Values, horizon: f64) -> T {
    let pairs = given.iter().map(|(k, v)| (k.to_string(), v.clone())).collect();
    let p = Params::new(T::PARAMETERS.to_vec(), pairs).unwrap();
    T::from_params(&p, &Surroundings { horizon, spacing: 0.1 }).unwrap()
}

fn moduli(kappa: f64, mu: f64, more: &[(&'static str, Value)]) -> Values {
    [&[("bulk_modulus", Value::Number(kappa)), ("shear_modulus", Value::Number(mu))], more].concat()
}

fn influence(word: &str) -> (&'static str, Value) {
    ("influence", Value::Word(word.into()))
}

#[test]
fn moduli_and_release_of_every_law_follow_the_closed_forms() {
    let (kappa, mu, delta) = (3e6, 4e5, 0.3);
    let given = |more: &[(&'static str, Value)]| moduli(kappa, mu, more);
    let number = |key, x| (key, Value::Number(x));
    let plus = kappa - 5.0 / 3.0 * mu;
    let bulk = [
        Bulk::of(&law::<Isotropic, 0>(&given(&[]), delta), delta),
        Bulk::of(&law::<Plastic, 1>(&given(&[number("yield_stretch", 1e-2)]), delta), delta),
        Bulk::of(&law::<Anisotropic<Isotropic>, 0>(&given(&[]), delta), delta),
        Bulk::of(
            &law::<Viscoelastic, 2>(&given(&[number("relaxing_share", 0.3), number("relaxation_time", 1.0)]), delta),
            delta,
        ),
        Bulk::of(&law::<Isotropic, 0>(&given(&[("formulation", Value::Word("as_written".into()))]), delta), delta),
        Bulk::of(&law::<Lps, 0>(&given(&[influence("inverse")]), delta), delta),
        Bulk::of(&law::<Lps, 0>(&given(&[influence("one")]), delta), delta),
        Bulk::of(&law::<Pmb, 0>(&given(&[])[..1].to_vec(), delta), delta),
    ];
    let chen = 5.0 * mu + 33.0 / 35.0 * plus;
    let closed = [
        ("isotropic", chen, mu, 0.4),
        ("plastic", chen, mu, 0.4),
        ("anisotropic, G = I", chen, mu, 0.4),
        ("viscoelastic", chen, mu, 0.4),
        ("as written", 5.0 * mu + 81.0 / 80.0 * plus, mu, 0.4),
        ("lps inverse", 3.0 * mu + 26.0 / 45.0 * plus, mu, 0.4),
        ("lps one", 25.0 / 8.0 * mu + 375.0 / 616.0 * plus, mu, 5.0 / 12.0),
        ("pmb", 1.8 * kappa, 0.6 * kappa, 5.0 / 12.0),
    ];
    for (bulk, (name, release, mu, crossing)) in bulk.iter().zip(closed) {
        let off = [
            ("κ", bulk.bulk / kappa),
            ("μ", bulk.shear / mu),
            ("crossing", bulk.crossing / (delta * crossing)),
            ("release", bulk.release / (delta * release)),
        ];
        for (what, ratio) in off {
            println!("{name}: {what} off by {:+.1e}", ratio - 1.0);
            assert!((ratio - 1.0).abs() < 7e-3, "{name}: {what}"); // measured 6.0e-3
        }
    }
}

/// Energy per area and stretch² of the bonds across a plane of a lattice with δ = `across` spacings, by the law's energies.
fn across_a_plane(law: &impl BondLaw<0>, delta: f64, across: f64) -> f64 {
    const SMALL: f64 = 1e-6;
    let (h, reach) = (delta / across, across as i32);
    let side = 2 * reach + 1;
    let family: Vec<DVec3> = (0..side.pow(3))
        .map(|k| DVec3::new(f64::from(k / side / side), f64::from(k / side % side), f64::from(k % side)))
        .map(|cell| (cell - DVec3::splat(f64::from(reach))) * h)
        .filter(|xi| xi.length() > 0.0 && xi.length() <= delta)
        .collect();
    let volume = h.powi(3);
    let m: f64 = family.iter().map(|xi| law.influence(*xi, delta) * xi.length_squared() * volume).sum();
    let column: f64 = (0..reach)
        .map(|k| {
            let depth = (f64::from(k) + 0.5) * h;
            let bond = |xi: &DVec3, theta: f64| {
                let b = Bond { theta, ..Bond::at_rest(xi.length(), law.influence(*xi, delta), 1.0 / m) };
                Bond { ext: SMALL * law.gauge(&b), ..b }
            };
            let crossing = || family.iter().filter(|xi| xi.z > depth);
            let theta: f64 = crossing().map(|xi| law.dilatation(&bond(xi, 0.0)) * volume).sum();
            let bonds: f64 = crossing().map(|xi| law.bond_energy(&bond(xi, theta), []) * volume).sum();
            bonds + law.theta_energy(theta)
        })
        .sum();
    2.0 * column * h / (SMALL * SMALL)
}

#[test]
fn the_bonds_across_a_plane_of_a_lattice_hold_that_energy() {
    let delta = 0.3;
    for (kappa, mu) in [(1e6, 6e5), (1e6, 9e5), (1e6, 1e5)] {
        let given = |more: &[(&'static str, Value)]| moduli(kappa, mu, more);
        let check = |name: &str, bulk: Bulk, coarse: f64, fine: f64| {
            let off = |x: f64| x / bulk.release - 1.0;
            println!("κ/μ = {:.2}, {name}: {:+.4} at δ = 3.5 h, {:+.4} at 8.5 h", kappa / mu, off(coarse), off(fine));
            assert!(off(fine).abs() < 0.03 && off(coarse).abs() < 0.06, "{name}"); // measured -.022 and -.048
        };
        let isotropic: Isotropic = law(&given(&[]), delta);
        let sum = |across| across_a_plane(&isotropic, delta, across);
        check("isotropic", Bulk::of(&isotropic, delta), sum(3.5), sum(8.5));
        let lps: Lps = law(&given(&[influence("one")]), delta);
        let sum = |across| across_a_plane(&lps, delta, across);
        check("lps", Bulk::of(&lps, delta), sum(3.5), sum(8.5));
        let pmb: Pmb = law(&given(&[])[..1].to_vec(), delta);
        let sum = |across| across_a_plane(&pmb, delta, across);
        check("pmb", Bulk::of(&pmb, delta), sum(3.5), sum(8.5));
    }
}

/// What moving one half of a block along `way` took.
struct Parted {
    /// Work per area [J/m²], in the middle of the plane.
    work: f64,
    /// Bonds across the plane that hold, and bonds elsewhere that broke.
    left: usize,
    dust: usize,
}

/// Moves the right half of a lattice block along `way`, slowly, until all that will break has.
fn part(law: &'static str, values: &Values, criterion: &'static str, limits: &Values, way: DVec3) -> Parted {
    const N: [i32; 3] = [12, 17, 17];
    let h = 0.1;
    let points: Vec<DVec3> = (0..N[0] * N[1] * N[2])
        .map(|k| DVec3::new(f64::from(k / (N[1] * N[2])), f64::from(k / N[2] % N[1]), f64::from(k % N[2])) * h)
        .collect();
    let given = Given {
        points: &points,
        volume: h.powi(3),
        density: 1000.0,
        spacing: h,
        horizon: 3.01 * h,
        law: (law, values),
        criterion: (criterion, limits),
    };
    let mut world = given.world();
    let right: Vec<bool> = world.particles.rest.iter().map(|x| x.x > 0.0).collect();
    // two horizons away from every side, and the area that these columns stand for
    let middle = |x: glam::Vec3| x.y.abs().max(x.z.abs()) < 2.5 * h as f32;
    let area = 25.0 * h * h;
    let count = |w: &fissure_engine::World| {
        let bonds = w.bodies[0].material.bonds().unwrap();
        let all = (0..bonds.rows()).flat_map(|i| bonds.slots(i).map(move |s| (i, bonds.neighbours[s] as usize)));
        all.filter(|(i, j)| i < j).fold([0, 0], |mut n, (i, j)| {
            n[usize::from(right[i] != right[j])] += 1;
            n
        })
    };
    let inside = count(&world)[0];
    let (mut work, mut before, mut d) = (0.0, (0.0, 0.0), 1e-6);
    while d < 3.0 * h {
        for i in 0..points.len() {
            let away = if right[i] { way * d } else { DVec3::ZERO };
            world.particles.position[i] = world.particles.rest[i].as_dvec3() + away;
        }
        let force = lane_forces(&mut world);
        let (body, p) = (&mut world.bodies[0], &mut world.particles);
        body.material.fracture(&mut p.damage[..], &mut Vec::new());
        let pull: f64 = (0..points.len())
            .filter(|&i| right[i] && middle(p.rest[i]))
            .map(|i| -force[i].dot(way) * p.volume[i])
            .sum();
        work += 0.5 * (pull + before.1) * (d - before.0);
        before = (d, pull);
        d *= 1.02;
    }
    let [whole, left] = count(&world);
    Parted { work: work / area, left, dust: inside - whole }
}

fn number(key: &'static str, value: f64) -> (&'static str, Value) {
    (key, Value::Number(value))
}

#[test]
fn pulling_a_block_apart_takes_the_energy_that_was_asked_for() {
    let cost = 0.1; // small: s_c about 1e-3
    // measured -.022, -.004 and -.172: θ falls as bonds break one by one, which κ = 5μ/3 does not feel
    for (law, kappa, mu, values, band) in [
        ("isotropic", 1e6, 6e5, moduli(1e6, 6e5, &[]), 0.04),
        ("isotropic", 1e6, 9e5, moduli(1e6, 9e5, &[]), 0.04),
        ("isotropic", 1e6, 1e5, moduli(1e6, 1e5, &[]), 0.2),
        ("lps", 1e6, 6e5, moduli(1e6, 6e5, &[]), 0.08), // measured +.066
        // measured +.171: its micromodulus knows nothing of the lattice, whose families hold that much more
        ("pmb", 1e6, 6e5, vec![number("bulk_modulus", 1e6)], 0.19),
    ] {
        let got = part(law, &values, "energy_release", &vec![number("energy_release_rate", cost)], DVec3::X);
        println!("{law}, κ/μ = {:.2}: work {:+.3} of G₀", kappa / mu, got.work / cost - 1.0);
        assert_eq!((got.left, got.dust), (0, 0));
        assert!((got.work / cost - 1.0).abs() < band, "{law}");
    }
}

#[test]
fn opening_is_limited_by_tension_and_sliding_by_shear() {
    let limits = |tension, shear| vec![number("tension_release_rate", tension), number("shear_release_rate", shear)];
    let run =
        |law, values: &Values, tension, shear, way| part(law, values, "tension_shear", &limits(tension, shear), way);
    for (law, values) in [("isotropic", moduli(1e6, 6e5, &[])), ("pmb", vec![number("bulk_modulus", 1e6)])] {
        for (tension, shear) in [(0.1, 0.4), (0.4, 0.1)] {
            let open = run(law, &values, tension, shear, DVec3::X);
            let slide = run(law, &values, tension, shear, DVec3::Y);
            println!("{law}: limits {tension} and {shear}, opening {:.3}, sliding {:.3}", open.work, slide.work);
            assert_eq!((open.left, open.dust, slide.left, slide.dust), (0, 0, 0, 0));
            // measured: opening .72 to 1.33 of its limit, sliding .94 to 1.18; with the other limit equal 1.06 and 1.07
            assert!((0.7..1.4).contains(&(open.work / tension)), "{law}");
            assert!((0.93..1.2).contains(&(slide.work / shear)), "{law}");
        }
    }
}
