//! What is asked of memory: that its flow costs work, and that forces already knew of it.

use glam::{DMat3, DVec3};

use super::body::{Columns, Subject, columns, difference, energy, first_difference, flow, forces, put, strained};
use super::report::{Finding, Trouble, at_most, fail, skip};
use fissure_engine::World;

/// Points of a cycle of strain.
const POINTS: usize = 96;

/// Work done on the body over one closed loop in the plane of stretch and shear, which starts and ends at rest, and
/// the most energy that came from nowhere in a part of it. Both relative to the work that went to and fro.
fn cycle(subject: &Subject<'_>, size: f64, sense: f64, dt: f64) -> Result<(f64, f64), Trouble> {
    let mut world = subject.world()?;
    world.dt = dt;
    let rest: Vec<DVec3> = world.particles.rest.iter().map(|x| x.as_dvec3()).collect();
    let places = |t: f64| -> Vec<DVec3> {
        let (stretch, shear) = (size * (1.0 - t.cos()), size * sense * t.sin());
        let f = DMat3::from_cols(
            DVec3::new(1.0 + stretch, 0.0, 0.0),
            DVec3::new(shear, 1.0 - 0.3 * stretch, 0.0),
            DVec3::new(0.0, 0.2 * shear, 1.0),
        );
        rest.iter().map(|x| f * *x).collect()
    };
    let mut before = (places(0.0), vec![DVec3::ZERO; rest.len()], energy(&mut world).unwrap_or(0.0));
    let (mut total, mut moved, mut worst) = (0.0, 0.0, 0.0f64);
    let mut parts = Vec::with_capacity(POINTS);
    for k in 1..=POINTS {
        let now = places(k as f64 / POINTS as f64 * std::f64::consts::TAU);
        put(&mut world, &now, |x| x);
        let force = forces(&mut world);
        world.bodies[0].material.flow(dt);
        let work: f64 = (0..rest.len()).map(|i| -0.5 * (force[i] + before.1[i]).dot(now[i] - before.0[i])).sum();
        let stored = energy(&mut world);
        parts.push(stored.map(|e| work - (e - before.2)));
        total += work;
        moved += work.abs();
        before = (now, force, stored.unwrap_or(0.0));
    }
    for lost in parts.into_iter().flatten() {
        // relative to a part of average size; a NaN counts as the worst
        worst = if lost.is_nan() { f64::INFINITY } else { worst.max(-lost / (moved / POINTS as f64)) };
    }
    Ok((total / moved, worst))
}

/// No closed cycle of strain yields work, whichever way round, fast or slow; and where the law has an energy, no part of a
/// cycle stores more of it than was put in. An elastic body gives back all.
pub(super) fn work(subject: &Subject<'_>) -> Finding {
    let dt = subject.world()?.dt;
    let (mut least, mut most, mut made) = (f64::INFINITY, 0.0f64, 0.0f64);
    for size in [0.01, 0.06] {
        for sense in [1.0, -1.0] {
            for slower in [1.0, 100.0] {
                let (total, worst) = cycle(subject, size, sense, dt * slower)?;
                if total.is_nan() {
                    return fail("the work of a cycle is not a number");
                }
                (least, most, made) = (least.min(total), most.max(total), made.max(worst));
            }
        }
    }
    let kept = at_most((-least).max(0.0), 1e-4, "work gained over a cycle")?;
    let parts = at_most(made, 0.05, "energy made in a part of it")?;
    Ok(format!("{kept}; {parts}; up to {:.0} % lost", 100.0 * most.max(0.0)))
}

/// The force knows the memory that the flow will leave: evaluated again after it at the same place, it is the same, and a
/// second flow changes nothing. The time is next to none, so that what flows with time stands still.
pub(super) fn consistent_return(subject: &Subject<'_>) -> Finding {
    let mut world = subject.world()?;
    let memory = |world: &mut World| -> Columns {
        columns(world).into_iter().filter(|(name, _)| name.contains("memory/")).collect()
    };
    let fresh = memory(&mut world);
    if fresh.is_empty() {
        return skip("the law has no memory");
    }
    let mut worst = [0.0f64; 2];
    let mut flowed = false;
    for s in [0.1, -0.1, 0.2] {
        let places = strained(&world, s);
        put(&mut world, &places, |x| x);
        // some time, to have a past
        let dt = world.dt;
        flow(&mut world, dt);
        let places = strained(&world, 0.8 * s);
        put(&mut world, &places, |x| x);
        let before = forces(&mut world);
        world.bodies[0].material.flow(1e-15);
        let after = forces(&mut world);
        world.bodies[0].material.flow(1e-15);
        let again = forces(&mut world);
        for (worst, now) in worst.iter_mut().zip([difference(&before, &after), difference(&after, &again)]) {
            *worst = if now.is_nan() { f64::INFINITY } else { worst.max(now) };
        }
        flowed |= first_difference(&fresh, &memory(&mut world)).is_some();
    }
    if !flowed {
        return fail("the memory never changes, up to strains of 20 %; give parameters at which it does with `Case`");
    }
    let first = at_most(worst[0], 1e-4, "the flow changes the force by")?;
    Ok(format!("{first}; {}", at_most(worst[1], 1e-4, "a second one by")?))
}
