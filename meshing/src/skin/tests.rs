//! Skins of balls and boxes that are moved, turned, stretched and cut.

use super::*;
use crate::TetMesh;
use crate::family::tests::meshes::{ball, barycentres, kuhn, random};
use glam::Vec3Swizzles;

struct Body {
    crack: CrackMesh,
    rest: Vec<DVec3>,
    mass: Vec<f64>,
}

impl Body {
    fn new(mesh: &TetMesh) -> Self {
        let mass = (0..mesh.tets.len()).map(|t| 1000.0 * mesh.volume(t)).collect();
        Self { crack: CrackMesh::new(mesh).unwrap(), rest: barycentres(mesh), mass }
    }

    fn skin(&self, follow: Follow) -> Skin {
        Skin::new(follow, &self.crack, &self.rest, &self.mass)
    }

    fn links(&self, cut: impl Fn(usize, usize) -> bool) -> Vec<(u32, u32)> {
        let mut links = Vec::new();
        for (s, row) in self.crack.neighbours().iter().enumerate() {
            links.extend(row.iter().filter(|&&t| t != u32::MAX && cut(s, t as usize)).map(|&t| (s as u32, t)));
        }
        links
    }

    /// Updates the skin with every particle moved by `motion`, at the velocity `moving` of its rest position.
    fn moved(&self, skin: &mut Skin, motion: impl Fn(DVec3) -> DVec3, moving: impl Fn(DVec3) -> DVec3) {
        let position: Vec<DVec3> = self.rest.iter().map(|&x| motion(x)).collect();
        let velocity: Vec<DVec3> = self.rest.iter().map(|&x| moving(x)).collect();
        let particles = Particles { rest: &self.rest, position: &position, velocity: &velocity, mass: &self.mass };
        skin.update(&self.crack, &particles);
    }

    /// Largest distance of a vertex from where `motion` takes its rest position.
    fn error(&self, found: &[DVec3], motion: impl Fn(DVec3) -> DVec3) -> f64 {
        let miss = |v: usize| found[v].distance(motion(self.crack.rest_position(v as u32)));
        (0..found.len()).map(miss).fold(0.0, f64::max)
    }
}

fn turn(angle: f64) -> DMat3 {
    DMat3::from_axis_angle(DVec3::new(1.0, 2.0, -0.5).normalize(), angle)
}

#[test]
fn affine_motions_are_followed_exactly() {
    let stretch = DMat3::from_cols_array(&[1.4, 0.2, 0.0, -0.1, 0.7, 0.3, 0.1, 0.0, 1.1]);
    for mesh in [ball(4), kuhn([5, 4, 3], 0.3, |_| true)] {
        let body = Body::new(&mesh);
        for f in [turn(1.0), turn(3.1), turn(2.0) * stretch, stretch, DMat3::from_diagonal(DVec3::splat(3.0))] {
            let shift = DVec3::new(200.0, -50.0, 3.0);
            let (motion, moving) = (|x: DVec3| f * x + shift, |x: DVec3| turn(0.4) * f * x);
            let mut skin = body.skin(Follow::Affine);
            body.moved(&mut skin, motion, moving);
            let (x, v) = (body.error(skin.positions(), motion), body.error(skin.velocities(), moving));
            assert!(x < 1e-10 && v < 1e-10, "position off by {x}, velocity by {v}"); // measured
        }
    }
}

#[test]
fn the_paper_distorts_a_turned_surface_and_the_default_does_not() {
    let mesh = ball(4);
    let body = Body::new(&mesh);
    let motion = |x: DVec3| turn(1.0) * x;
    let miss = |follow| {
        let mut skin = body.skin(follow);
        body.moved(&mut skin, motion, |_| DVec3::ZERO);
        body.error(skin.positions(), motion) / mesh.mean_edge()
    };
    let (paper, ours) = (miss(Follow::AsWritten), miss(Follow::Affine));
    println!("turned by 1 rad: as written off by {paper:.2} edges, affine by {ours:.1e}");
    assert!(paper > 0.2 && ours < 1e-10);
}

#[test]
fn translations_are_exact_in_both_modes_however_cut() {
    let mut body = Body::new(&ball(2));
    let links = body.links(|s, t| random((s.min(t) * 4099 + s.max(t)) as u64) < 0.6);
    body.crack.cut(&links);
    assert!(body.crack.fragments().1 > 30);
    for follow in [Follow::AsWritten, Follow::Affine] {
        let mut skin = body.skin(follow);
        let motion = |x| x + DVec3::new(3.0, -1.0, 0.5);
        body.moved(&mut skin, motion, |_| DVec3::X);
        // Measured 2e-11: rounding errors of pairs of particles turn them a little about their axis.
        let (x, v) = (body.error(skin.positions(), motion), body.error(skin.velocities(), |_| DVec3::X));
        println!("{follow:?}: positions off by {x:.1e}, velocities by {v:.1e}");
        assert!(x < 1e-10 && v < 1e-12);
    }
}

#[test]
fn fragments_of_any_size_are_rigid_under_rotation() {
    // Fragments of one, two, three… tetrahedra: those of two or more turn with their particles, lone ones stay.
    let mut body = Body::new(&ball(2));
    let links = body.links(|s, t| random((s.min(t) * 4099 + s.max(t)) as u64) < 0.75);
    body.crack.cut(&links);
    let (fragment, count) = body.crack.fragments();
    let mut sizes = vec![0; count];
    fragment.iter().for_each(|&f| sizes[f as usize] += 1);
    for lone in 1..5 {
        assert!(sizes.contains(&lone), "no fragment of {lone}");
    }
    for angle in [0.3, 1.5, 3.0] {
        let mut skin = body.skin(Follow::Affine);
        let motion = |x| turn(angle) * x + DVec3::Y;
        body.moved(&mut skin, motion, |_| DVec3::ZERO);
        let (x, mut worst) = (skin.positions(), [0.0f64; 2]);
        for (t, tet) in body.crack.tets().iter().enumerate() {
            let (size, rest) = (sizes[fragment[t] as usize], tet.map(|v| body.crack.rest_position(v)));
            for i in 0..3 {
                let edge = x[tet[i] as usize].distance(x[tet[i + 1] as usize]) / rest[i].distance(rest[i + 1]);
                let few = usize::from(size > 1);
                worst[few] = worst[few].max((edge - 1.0).abs());
            }
            if size == 1 {
                let center = tet.iter().map(|&v| x[v as usize]).sum::<DVec3>() / 4.0;
                assert!(center.distance(motion(body.rest[t])) < 1e-12);
            }
        }
        println!(
            "turned by {angle}: edges of lone tetrahedra change by {:.1e}, of others by {:.1e}",
            worst[0], worst[1]
        );
        assert!(worst[0] < 1e-12 && worst[1] < 1e-2, "{worst:?}");
    }
}

#[test]
fn a_tetrahedron_that_breaks_off_keeps_its_last_rotation() {
    let mesh = kuhn([2, 2, 2], 0.2, |_| true);
    let mut body = Body::new(&mesh);
    let mut skin = body.skin(Follow::Affine);
    let motion = |x| turn(1.2) * x;
    body.moved(&mut skin, motion, |_| DVec3::ZERO);
    let links = body.links(|s, t| s == 7 || t == 7);
    assert!(body.crack.cut(&links) > 0);
    body.moved(&mut skin, motion, |_| DVec3::ZERO);
    // Measured 5e-5: the rotation is drawn towards the one before by one part in 10⁵.
    assert!(body.error(skin.positions(), motion) < 1e-4, "{}", body.error(skin.positions(), motion));
}

#[test]
fn as_written_equals_the_equations_step_by_step() {
    let mut body = Body::new(&kuhn([3, 2, 2], 0.3, |_| true));
    let mut skin = body.skin(Follow::AsWritten);
    let mut y = body.rest.clone();
    let mut x: Vec<DVec3> = (0..body.crack.origin().len() as u32).map(|v| body.crack.rest_position(v)).collect();
    let (dt, mut splits) = (0.01, 0);
    for step in 0..60 {
        let number = |t: usize, k: u64| random((step * 1000 + t) as u64 * 3 + k) - 0.5;
        let velocity: Vec<DVec3> =
            (0..y.len()).map(|t| DVec3::new(number(t, 0), number(t, 1), number(t, 2)) * 5.0).collect();
        let links = body.links(|s, t| random((step * 77777 + s.min(t) * 311 + s.max(t)) as u64) < 0.04);
        splits += body.crack.cut(&links);
        let now = Particles { rest: &body.rest, position: &y, velocity: &velocity, mass: &body.mass };
        skin.split(&body.crack, &now);
        for split in body.crack.splits() {
            assert_eq!(x.len(), split.first as usize);
            x.extend(std::iter::repeat_n(x[split.vertex as usize], split.count as usize));
        }
        for (v, x) in x.iter_mut().enumerate() {
            let (mut omega, mut sum) = (0.0, DVec3::ZERO); // Eqs. 20 to 22
            for t in (0..body.rest.len()).filter(|&t| body.crack.tets()[t].contains(&(v as u32))) {
                omega += 0.25 * body.mass[t];
                sum += 0.25 * body.mass[t] * velocity[t];
            }
            *x += dt * sum / omega;
        }
        y.iter_mut().zip(&velocity).for_each(|(y, v)| *y += dt * *v);
        let after = Particles { rest: &body.rest, position: &y, velocity: &velocity, mass: &body.mass };
        skin.update(&body.crack, &after);
        let worst = x.iter().zip(skin.positions()).map(|(a, b)| a.distance(*b)).fold(0.0, f64::max);
        assert!(worst < 1e-13, "step {step}: {worst}"); // measured 3e-15
    }
    assert!(splits > 50, "{splits}");
}

#[test]
fn wild_particles_make_no_spikes() {
    // Fragments of all sizes, flat and straight ones too. The barycentres lie 0.1 apart, vertices up to 0.34 off them.
    let mut body = Body::new(&ball(3));
    let links = body.links(|s, t| random((s.min(t) * 4099 + s.max(t)) as u64) < 0.7);
    body.crack.cut(&links);
    let miss = |amplitude: f64| {
        let shake = |x: DVec3| {
            let seed = (x.x * 1e6) as i64 as u64 ^ ((x.y * 1e6) as i64 as u64) << 20;
            x + amplitude * (DVec3::new(random(seed), random(seed + 1), random(seed + 2)) - 0.5)
        };
        let mut skin = body.skin(Follow::Affine);
        body.moved(&mut skin, shake, |x| x);
        let x = skin.positions();
        let all = (0..x.len() as u32).map(|v| x[v as usize].distance(body.crack.rest_position(v)));
        (all.clone().fold(0.0, f64::max), all.sum::<f64>() / x.len() as f64)
    };
    let (worst, mean) = miss(0.02);
    println!("shaken by 0.017 at most: vertices off by {worst:.3} at most and {mean:.3} in the mean");
    assert!(worst < 0.25 && mean < 0.025); // measured 0.181, 0.016
    let (worst, _) = miss(2.0);
    println!("shaken to dust: off by {worst:.2}");
    assert!(worst < 1.75 + 0.34 * 7.0, "{worst}"); // what the limits on F allow; measured 2.7
}

#[test]
fn degenerate_bodies_give_finite_numbers() {
    let mut mesh = kuhn([2, 1, 1], 0.0, |_| true);
    mesh.vertices.push(DVec3::splat(9.0)); // used by nobody
    let flat = TetMesh { vertices: mesh.vertices.iter().map(|v| DVec3::new(v.x, v.y, 0.0)).collect(), ..mesh.clone() };
    let point = TetMesh { vertices: vec![DVec3::ONE; mesh.vertices.len()], ..mesh.clone() };
    for mesh in [mesh, flat, point] {
        let mut body = Body::new(&mesh);
        body.mass[3] = 0.0;
        for follow in [Follow::Affine, Follow::AsWritten] {
            let mut skin = body.skin(follow);
            for f in
                [DMat3::IDENTITY, DMat3::ZERO, DMat3::from_diagonal(DVec3::new(1.0, 1.0, -1.0)), DMat3::IDENTITY * 1e9]
            {
                body.moved(&mut skin, |x| f * x, |x| f * x);
                assert!(skin.positions().iter().chain(skin.velocities()).all(|x| x.is_finite()), "{follow:?} {f}");
            }
            let last = *skin.positions().last().unwrap();
            assert!(last == mesh.vertices[mesh.vertices.len() - 1], "a vertex of no tetrahedron stays");
        }
    }
}

#[test]
fn a_restart_from_the_columns_goes_on_the_same() {
    for follow in [Follow::Affine, Follow::AsWritten] {
        let mut body = Body::new(&ball(2));
        let mut skin = body.skin(follow);
        let still = vec![DVec3::ZERO; body.rest.len()];
        let shifted: Vec<DVec3> = body.rest.iter().map(|&x| turn(0.8) * x).collect();
        let links = body.links(|s, t| random((s.min(t) * 4099 + s.max(t)) as u64) < 0.7);
        body.crack.cut(&links);
        let now = Particles { rest: &body.rest, position: &shifted, velocity: &still, mass: &body.mass };
        skin.split(&body.crack, &now);
        skin.update(&body.crack, &now);
        let mut saved = Vec::new();
        skin.visit("ball", &mut |_, _, b| saved.push(b.bytes().to_vec()));
        let mut again = body.skin(follow);
        again.visit("ball", &mut |_, _, b| assert!(b.set_bytes(&saved.pop().unwrap())));
        for skin in [&mut skin, &mut again] {
            body.moved(skin, |x| turn(1.5) * x, |x| x);
        }
        assert!(skin.positions() == again.positions() && skin.velocities() == again.velocities());
    }
}

#[test]
fn columns_and_threads() {
    let body = Body::new(&ball(4));
    let motion = |x: DVec3| turn(0.7) * x + 0.1 * x.yzx() * x.x;
    let run = |threads: usize| {
        let mut skin = body.skin(Follow::Affine);
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| body.moved(&mut skin, motion, |x| x));
        let mut columns = Vec::new();
        skin.visit("ball", &mut |_, c, b| columns.push((c.name, b.bytes().to_vec())));
        (skin.positions().to_vec(), columns)
    };
    let (one, three) = (run(1), run(3));
    assert!(one == three);
    assert_eq!((one.1.len(), one.1[0].0, one.1[0].1.len()), (1, "tet_rotation", 16 * body.rest.len()));
    let mut names = Vec::new();
    body.skin(Follow::AsWritten).visit("ball", &mut |_, c, _| names.push(c.name));
    assert_eq!(names, ["vertex_offset"]);
}

/// Speed of a frame at the size that matters; by hand: `cargo test -p fissure-meshing --release -- --ignored big`.
#[test]
#[ignore = "takes seconds and is worth reading only in a release build"]
fn big_body() {
    let mut body = Body::new(&kuhn([37; 3], 0.4, |_| true));
    for share in [0.0, 0.5] {
        let links = body.links(|s, t| random((s.min(t) * 524_309 + s.max(t)) as u64) < share);
        let clock = std::time::Instant::now();
        let new = body.crack.cut(&links);
        let cut = clock.elapsed().as_secs_f64();
        let mut skin = body.skin(Follow::Affine);
        body.moved(&mut skin, |x| turn(0.1) * x, |x| x);
        let clock = std::time::Instant::now();
        body.moved(&mut skin, |x| turn(0.2) * x, |x| x);
        let update = clock.elapsed().as_secs_f64();
        let clock = std::time::Instant::now();
        let surface = body.crack.surface();
        println!(
            "{} links, {new} new vertices: cut {cut:.2} s, skin {update:.2} s, surface of {} triangles {:.2} s",
            links.len(),
            surface.triangles.len(),
            clock.elapsed().as_secs_f64()
        );
        assert!(body.error(skin.positions(), |x| turn(0.2) * x).is_finite());
    }
}
