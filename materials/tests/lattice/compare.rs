//! The paper's claims at small size, and its limits: deviation from the uniform lattice, cost after fracture, propagation of
//! forces, volume, and jumps where levels change.

use fissure_engine::{Anchor, Collider, Value, World};
use glam::DVec3;

use crate::body::{SIZE, Solid, number, word};

/// Where every finest cell is, and how fast it moves.
fn cells(world: &mut World) -> Vec<DVec3> {
    let (body, p) = (&mut world.bodies[0], &world.particles);
    let rest: Vec<DVec3> = {
        let mut found = Vec::new();
        body.material.visit("", &mut |_, column, data| {
            if column.name == "cell_rest" {
                let numbers: Vec<f32> = data.bytes().chunks(4).map(|b| f32::from_le_bytes(b.try_into().unwrap())).collect();
                found = numbers.chunks(3).map(|x| DVec3::new(f64::from(x[0]), f64::from(x[1]), f64::from(x[2]))).collect();
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
    let mut all = vec![("half_width", number(w)), ("stiffness", number(stiffness)), ("levels", number(levels)), ("fill", number(fill))];
    all.extend_from_slice(given);
    let mut world = Solid::ellipsoid([14, 10, 14]).world(&all);
    world.gravity = DVec3::NEG_Y * 9.81;
    world.colliders.push(Collider::plane("ground", DVec3::Y, -0.5));
    world
}

#[test]
fn probe_deviation() {
    for (w, stiffness, levels, fill) in [
        (1.0, 0.7, 1.0, 0.95), (2.0, 0.7, 1.0, 0.95), (3.0, 0.7, 1.0, 0.95),
        (1.0, 0.7, 2.0, 0.9), (2.0, 0.7, 2.0, 0.9), (1.0, 0.7, 1.0, 0.4), (1.0, 0.3, 1.0, 0.95), (2.0, 0.3, 1.0, 0.95), (1.0, 0.7, 2.0, 0.4), (2.0, 0.7, 2.0, 0.4)
    ] {
        for damping in [0.0, 0.3] {
        let more = [("subdivide_at", number(50.0)), ("merge_below", number(40.0)), ("damping", number(damping))];
        let given = |method, f| { let mut v = vec![("method", word(method)), ("formulation", word(f))]; v.extend_from_slice(&more); v };
        let mut lsm = dropped(&given("lsm", "default"), w, stiffness, levels, fill);
        let mut others = [("steinemann", "default"), ("ohta", "as_written"), ("ohta", "default")].map(|(m, f)| dropped(&given(m, f), w, stiffness, levels, fill));
        let size = 0.1 * DVec3::new(14.0, 10.0, 14.0).length();
        let mut mean = [0.0; 3];
        let mut spread = [0.0; 3];
        for _ in 0..500 {
            lsm.step().unwrap();
            let want = cells(&mut lsm);
            for (k, other) in others.iter_mut().enumerate() {
                other.step().unwrap();
                let apart: Vec<f64> = cells(other).iter().zip(&want).map(|(a, b)| a.distance(*b) / size).collect();
                let m = apart.iter().sum::<f64>() / apart.len() as f64;
                let s = (apart.iter().map(|x| (x - m) * (x - m)).sum::<f64>() / apart.len() as f64).sqrt();
                mean[k] += m / 500.0;
                spread[k] += s / 500.0;
            }
        }
        println!("w {w} alpha {stiffness} levels {levels} fill {fill} damping {damping}: {} of {}; time mean {:.4} {:.4} {:.4} ratio {:.2} {:.2}; spread {:.4} {:.4} {:.4} ratio {:.2} {:.2}",
            others[0].particles.len(), lsm.particles.len(), mean[0], mean[1], mean[2], mean[1] / mean[0], mean[2] / mean[0], spread[0], spread[1], spread[2], spread[1] / spread[0], spread[2] / spread[0]);
        }
    }
}

#[test]
fn probe_propagation() {
    for (method, w, passes) in [("lsm", 1.0, 1.0), ("lsm", 1.0, 4.0), ("lsm", 2.0, 1.0), ("ohta", 1.0, 1.0), ("ohta", 1.0, 4.0), ("single", 1.0, 1.0)] {
        let given = [("method", word(method)), ("half_width", number(w)), ("passes", number(passes)), ("stiffness", number(0.5))];
        let mut world = Solid::block([48, 4, 4]).world(&given);
        world.step().unwrap();
        let far: Vec<usize> = (0..world.particles.len()).filter(|&i| world.particles.rest[i].x > 2.1).collect();
        let near: Vec<u32> = (0..world.particles.len()).filter(|&i| world.particles.rest[i].x < -2.1).map(|i| i as u32).collect();
        let start: Vec<DVec3> = near.iter().map(|&i| world.particles.position[i as usize]).collect();
        world.anchors.push(Anchor { name: "pull".into(), particles: near.into(), start: start.into(), velocity: DVec3::NEG_X, from: world.time - 1e-9, until: f64::INFINITY, ..Anchor::default() });
        let before: Vec<DVec3> = far.iter().map(|&i| world.particles.position[i]).collect();
        let n = world.particles.len();
        let mut steps = 0;
        while steps < 2000 {
            world.step().unwrap();
            steps += 1;
            if world.particles.len() != n { println!("count changed"); break; }
            let moved = far.iter().zip(&before).map(|(&i, b)| (world.particles.position[i] - *b).length()).sum::<f64>() / far.len() as f64;
            if moved > 1e-6 * SIZE { break; }
        }
        println!("{method} w {w} passes {passes}: {n} nodes, far end moves after {steps} steps");
    }
}

#[test]
fn probe_volume() {
    for (method, keep) in [("lsm", "no"), ("ohta", "no"), ("ohta", "yes"), ("steinemann", "no")] {
        let given = [("method", word(method)), ("volume_preserving", word(keep)), ("subdivide_at", number(50.0)), ("merge_below", number(40.0))];
        let mut world = dropped(&given, 1.0, 0.3, 2.0, 0.5);
        let (mut least, mut most, mut sum) = (f64::INFINITY, 0.0_f64, 0.0);
        for _ in 0..300 {
            world.step().unwrap();
            let (body, p) = (&mut world.bodies[0], &world.particles);
            let pose = body.material.lattice(&p.of(&body.range)).unwrap();
            let det: f64 = pose.deformation.iter().zip(p.volume.iter()).map(|(g, v)| g.determinant() * v).sum::<f64>() / p.volume.iter().sum::<f64>();
            least = least.min(det); most = most.max(det); sum += det / 300.0;
        }
        println!("{method} {keep}: volume {least:.3} .. {most:.3}, mean {sum:.3}");
    }
}

#[test]
fn probe_merging() {
    for damping in [0.0, 0.3] {
    for merge in ["yes", "no"] {
        for method in ["ohta", "lsm"] {
            let solid = Solid::new([16, 24, 8], |[x, y, _]| y > 17 || y < 10 || (5..11).contains(&x));
            let given = [("method", word(method)), ("stiffness", number(0.5)), ("reference_step", number(0.004)), ("critical_stretch", number(0.3)), ("merge", word(merge)), ("damping", number(damping)), ("fill", number(0.3))];
            let mut world = solid.world(&given);
            world.gravity = DVec3::NEG_Y * 9.81;
            world.dt = 0.004;
            let held: Vec<u32> = (0..world.particles.len()).filter(|&i| world.particles.rest[i].y > 0.95).map(|i| i as u32).collect();
            let start: Vec<DVec3> = held.iter().map(|&i| world.particles.position[i as usize]).collect();
            world.anchors.push(Anchor { name: "top".into(), particles: held.into(), start: start.into(), from: -1.0, until: f64::INFINITY, ..Anchor::default() });
            let (mut counts, mut jump, mut usual) = (Vec::new(), 0.0_f64, 0.0_f64);
            let mut first = None;
            let mut before = cells(&mut world);
            let mut speed: Vec<DVec3> = vec![DVec3::ZERO; before.len()];
            for k in 0..400 {
                let n = world.particles.len();
                world.step().unwrap();
                if first.is_none() && !world.bodies[0].cuts.is_empty() { first = Some(k); }
                if k % 20 == 0 { counts.push(world.particles.len()); }
                let now = cells(&mut world);
                let v: Vec<DVec3> = now.iter().zip(&before).map(|(a, b)| (*a - *b) / world.dt).collect();
                let most = v.iter().zip(&speed).map(|(a, b)| (*a - *b).length()).fold(0.0, f64::max);
                if world.particles.len() != n { jump = jump.max(most) } else { usual = usual.max(most) }
                (before, speed) = (now, v);
            }
            println!("damping {damping} merge {merge} {method}: cells {}, first cut {first:?}, {counts:?}, {:?}, jump {jump:.2} usual {usual:.2}", speed.len(), world.bodies[0].material.nodes());
        }
    }
    }
}
