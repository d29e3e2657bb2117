//! The paper's claims at small size, and its limits: deviation from the uniform lattice, cost after fracture, propagation of
//! forces, volume, and jumps where levels change.

use fissure_engine::{Anchor, Collider, Value, World};
use glam::DVec3;

use crate::body::{SIZE, Solid, number, word};

/// Where every finest cell is.
fn cells(world: &mut World) -> Vec<DVec3> {
    let (body, p) = (&mut world.bodies[0], &world.particles);
    let rest: Vec<DVec3> = {
        let mut found = Vec::new();
        body.material.visit("", &mut |_, column, data| {
            if column.name == "cell_rest" {
                let numbers: Vec<f32> =
                    data.bytes().chunks(4).map(|b| f32::from_le_bytes(b.try_into().unwrap())).collect();
                found =
                    numbers.chunks(3).map(|x| DVec3::new(f64::from(x[0]), f64::from(x[1]), f64::from(x[2]))).collect();
            }
        });
        found
    };
    let pose = body.material.lattice(&p.of(&body.range)).unwrap();
    let at = |(cell, rest): (usize, &DVec3)| {
        let k = pose.carrier[cell] as usize;
        pose.position[k] + pose.deformation[k] * (*rest - pose.rest[k])
    };
    rest.iter().enumerate().map(at).collect()
}

fn dropped(given: &[(&str, Value)], w: f64, stiffness: f64, levels: f64, fill: f64) -> World {
    let mut all = vec![
        ("half_width", number(w)),
        ("stiffness", number(stiffness)),
        ("levels", number(levels)),
        ("fill", number(fill)),
    ];
    all.extend_from_slice(given);
    let mut world = Solid::ellipsoid([14, 10, 14]).world(&all);
    world.gravity = DVec3::NEG_Y * 9.81;
    world.colliders.push(Collider::plane("ground", DVec3::Y, -0.5));
    world
}

/// Time means over 500 steps of the mean deviation of cells from the uniform lattice, and of its standard deviation, as shares
/// of the box's diagonal, for each of the adaptive methods.
fn deviation<const N: usize>(methods: [(&str, &str); N], w: f64) -> [[f64; 2]; N] {
    let given = |(method, formulation): (&str, &str)| {
        vec![
            ("method", word(method)),
            ("formulation", word(formulation)),
            ("damping", number(0.3)),
            ("subdivide_at", number(50.0)),
            ("merge_below", number(40.0)),
        ]
    };
    let mut uniform = dropped(&given(("lsm", "default")), w, 0.7, 1.0, 0.95);
    let mut others = methods.map(|m| dropped(&given(m), w, 0.7, 1.0, 0.95));
    let diagonal = SIZE * DVec3::new(14.0, 10.0, 14.0).length();
    let mut means = [[0.0; 2]; N];
    for _ in 0..500 {
        uniform.step().unwrap();
        let want = cells(&mut uniform);
        for (other, mean) in others.iter_mut().zip(&mut means) {
            other.step().unwrap();
            let apart: Vec<f64> = cells(other).iter().zip(&want).map(|(a, b)| a.distance(*b) / diagonal).collect();
            let n = apart.len() as f64;
            let m = apart.iter().sum::<f64>() / n;
            let s = (apart.iter().map(|x| (x - m) * (x - m)).sum::<f64>() / n).sqrt();
            (mean[0], mean[1]) = (mean[0] + m / 500.0, mean[1] + s / 500.0);
        }
    }
    println!("w = {w}: {} of {} nodes, {means:.4?}", others[0].particles.len(), uniform.particles.len());
    means
}

/// A blob is dropped; its interior is merged once. The printed claim is a third after 500 steps (.203 ± .113 and .077 ± .036);
/// single moments swing with the phase of the bounce, so the mean over time is judged. Without damping the bounces drift
/// apart for good and nothing can be said (ratios of .5 to .8 at w = 1). Where coarse nodes lie at the surface, their balls
/// are larger, and what is measured is where these come to lie.
#[test]
fn with_beta_a_blob_falls_more_like_the_uniform_one() {
    let all = [("steinemann", "default"), ("ohta", "as_written"), ("ohta", "default")];
    let [without, printed, spread] = deviation(all, 1.0);
    // measured .0430 ± .0133, .0192 ± .0073 and .0113 ± .0045: ratios .45 and .26
    assert!(spread[0] < without[0] / 3.0 && spread[1] < 0.4 * without[1], "{spread:?} {without:?}");
    assert!(printed[0] < 0.5 * without[0] && printed[0] > spread[0], "{printed:?} {without:?}");
    // at w = 2 Eq. 10 is further from what regions of these cells need than no β at all; measured ratios 1.14 and .65
    let [without, printed, spread] = deviation(all, 2.0);
    assert!(spread[0] < 0.75 * without[0] && printed[0] > spread[0], "{spread:?} {printed:?} {without:?}");
}

/// Steps until the far end of a bar of 48 cells moves by a millionth of a cell, when the other end is pulled.
fn steps_to_the_far_end(given: &[(&'static str, Value)]) -> usize {
    let mut all = vec![("stiffness", number(0.5))];
    all.extend_from_slice(given);
    let mut world = Solid::block([48, 4, 4]).world(&all);
    world.step().unwrap();
    let rest: Vec<f64> = world.particles.rest.iter().map(|x| f64::from(x.x)).collect();
    let end = |way: f64| (0..rest.len()).filter(|&i| rest[i] * way > 2.1).collect::<Vec<_>>();
    let (near, far) = (end(-1.0), end(1.0));
    let place = |all: &[usize], w: &World| all.iter().map(|&i| w.particles.position[i]).collect::<Vec<_>>();
    let (start, before) = (place(&near, &world), place(&far, &world));
    let particles: Vec<u32> = near.iter().map(|&i| i as u32).collect();
    let (from, until) = (world.time - 1e-9, f64::INFINITY);
    let anchor = Anchor { particles: particles.into(), start: start.into(), from, until, ..Anchor::default() };
    world.anchors.push(Anchor { velocity: DVec3::NEG_X, ..anchor });
    (1..)
        .find(|_| {
            world.step().unwrap();
            let moved = place(&far, &world).iter().zip(&before).map(|(a, b)| a.distance(*b)).sum::<f64>();
            moved > 1e-6 * SIZE * far.len() as f64
        })
        .expect("it is connected")
}

#[test]
fn forces_travel_further_with_passes_wider_regions_and_coarse_nodes() {
    let steps = [
        vec![("method", word("lsm"))],
        vec![("method", word("lsm")), ("passes", number(4.0))],
        vec![("method", word("lsm")), ("half_width", number(2.0))],
        vec![("method", word("ohta"))],
        vec![("method", word("single"))],
    ]
    .map(|given| steps_to_the_far_end(&given));
    println!(
        "uniform {}, four passes {}, w = 2 {}, adaptive {}, one region {}",
        steps[0], steps[1], steps[2], steps[3], steps[4]
    );
    // measured 54, 45, 27, 13, 2: passes keep the stiffness, and with it the speed of the wave behind its front
    assert!(steps.is_sorted_by(|a, b| a > b) && steps[1] * 6 < steps[0] * 5 + 6 && steps[3] * 4 < steps[0]);
}

#[test]
fn volume_is_kept_where_it_is_asked_for() {
    let mean = |method: &str, keep: &str| {
        let given = [
            ("method", word(method)),
            ("volume_preserving", word(keep)),
            ("subdivide_at", number(50.0)),
            ("merge_below", number(40.0)),
        ];
        let mut world = dropped(&given, 1.0, 0.7, 1.0, 0.5);
        let (mut least, mut mean) = (f64::INFINITY, 0.0);
        for _ in 0..300 {
            world.step().unwrap();
            let (body, p) = (&mut world.bodies[0], &world.particles);
            let pose = body.material.lattice(&p.of(&body.range)).unwrap();
            let (mut now, mut rest) = (0.0, 0.0);
            for (g, v) in pose.deformation.iter().zip(&p.volume[..]) {
                (now, rest) = (now + g.determinant() * v, rest + v);
            }
            (least, mean) = (f64::min(least, now / rest), mean + now / rest / 300.0);
        }
        println!("{method}, volume_preserving = {keep}: mean volume {mean:.3}, least {least:.3}");
        (mean, least)
    };
    let (uniform, free, kept) = (mean("lsm", "no"), mean("ohta", "no"), mean("ohta", "yes"));
    // measured means .913, .917 and .954, least (on the first impact) .512, .487 and .700; nothing resists volume in the uniform
    // lattice, whose goals are rigid
    assert!(kept.0 > free.0 + 0.02 && kept.0 > uniform.0 + 0.02, "{kept:?} {free:?} {uniform:?}");
    assert!(kept.1 > free.1 + 0.1 && kept.1 > uniform.1 + 0.1, "{kept:?} {free:?} {uniform:?}");
}

/// A dumb-bell is pulled in two and let go. Nodes after every tenth step, steps at which levels changed with the largest change
/// of a cell's velocity then and in the step before [m/s], cuts, and
/// the largest such change where no level does.
fn pulled_apart(merge: &str) -> (Vec<usize>, Vec<[f64; 2]>, usize, f64) {
    let solid =
        Solid::new([8, 32, 8], |[x, y, z]| !(12..20).contains(&y) || ((2..6).contains(&x) && (2..6).contains(&z)));
    let given = [
        ("method", word("ohta")),
        ("merge", word(merge)),
        ("stiffness", number(0.8)),
        ("reference_step", number(0.004)),
        ("damping", number(0.5)),
        ("subdivide_at", number(0.15)),
        ("merge_below", number(0.05)),
        ("critical_stretch", number(0.4)),
    ];
    let mut world = solid.world(&given);
    world.dt = 0.004;
    for way in [-1.0, 1.0] {
        let end = (0..world.particles.len()).filter(|&i| f64::from(world.particles.rest[i].y) * way > 1.3);
        let particles: Vec<u32> = end.map(|i| i as u32).collect();
        let start: Vec<DVec3> = particles.iter().map(|&i| world.particles.position[i as usize]).collect();
        let anchor =
            Anchor { particles: particles.into(), start: start.into(), from: -1e-9, until: 0.6, ..Anchor::default() };
        world.anchors.push(Anchor { velocity: DVec3::Y * way, ..anchor });
    }
    let (mut counts, mut jumps, mut cuts, mut steady) = (Vec::new(), Vec::new(), 0, 0.0f64);
    let (mut before, mut speed, mut last) = (cells(&mut world), Vec::new(), 0.0);
    for k in 0..500 {
        let n = world.particles.len();
        world.step().unwrap();
        cuts += world.bodies[0].cuts.len();
        let now = cells(&mut world);
        let v: Vec<DVec3> = now.iter().zip(&before).map(|(a, b)| (*a - *b) / world.dt).collect();
        let jump = v.iter().zip(&speed).map(|(a, b): (&DVec3, &DVec3)| a.distance(*b)).fold(0.0, f64::max);
        if world.particles.len() != n && k > 1 {
            println!(
                "{k}: {n} -> {}, jump {jump:.2} after {last:.2}, {} cuts",
                world.particles.len(),
                world.bodies[0].cuts.len()
            );
            jumps.push([jump, last]);
        } else if k > 1 {
            steady = steady.max(jump);
        }
        if k % 10 == 9 {
            counts.push(world.particles.len());
        }
        (before, speed, last) = (now, v, jump);
    }
    (counts, jumps, cuts, steady)
}

#[test]
fn merging_halves_the_nodes_after_fracture() {
    let ((merged, jumps, cuts, _), (kept, _, _, steady)) = (pulled_apart("yes"), pulled_apart("no"));
    println!("merged {merged:?}\nkept {kept:?}\n{cuts} cuts, jumps {jumps:.2?}");
    let (last, most) = (merged[merged.len() - 1], kept[kept.len() - 1]);
    assert!(cuts > 50 && 2 * last <= most, "{last} of {most}"); // measured 328 of 880, from 320
    // what shows of a change of levels, also while both halves recoil, is no more than the recoil of a body that keeps its nodes:
    // measured 6.26 and 6.28 m/s, 2.5 before the tear
    println!("at most {steady:.2} where no level changes");
    assert!(jumps.iter().all(|[jump, _]| *jump < 1.1 * steady), "{jumps:?}");
}
