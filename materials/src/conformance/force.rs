//! What is asked of forces: none at rest, none on itself, turning with the body, from an energy, in any precision.

use fissure_engine::World;
use glam::{DMat3, DVec3};

use super::body::{
    SPACING, Subject, difference, energy, exact_forces, flow, forces, largest, noise, put, reference_forces, strained,
};
use super::report::{Finding, Trouble, at_most, fail, skip};

/// A turn about no axis of the block.
fn turn(angle: f64) -> DMat3 {
    DMat3::from_axis_angle(DVec3::new(1.0, -2.0, 0.5).normalize(), angle)
}

/// A block with a past: its memory has flowed at 10 % strain, and it is now at `s`.
fn worked(subject: &Subject<'_>, s: f64) -> Result<World, Trouble> {
    let mut world = subject.world()?;
    let past = strained(&world, 0.1);
    put(&mut world, &past, |x| x);
    let dt = world.dt;
    flow(&mut world, dt);
    let now = strained(&world, s);
    put(&mut world, &now, |x| x);
    Ok(world)
}

/// No force at rest, upright and turned. The measure is the force at 1 % strain.
pub(super) fn nothing_at_rest(subject: &Subject<'_>) -> Finding {
    let mut world = subject.world()?;
    let (rest, little) = (strained(&world, 0.0), strained(&world, 0.01));
    put(&mut world, &little, |x| x);
    let scale = largest(&exact_forces(&mut world));
    if !(scale > 0.0 && scale.is_finite()) {
        return fail(format!("the largest force at 1 % strain is {scale} N"));
    }
    // measured 2e-13 for a law of lengths, in a frame that turns with the body; a law that asks for Λ has none, and its
    // f32 lanes keep 2e-6
    let places = [("upright", 0.0, DVec3::ZERO, 1e-9), ("turned and moved", 1.0, DVec3::new(3.0, 0.0, -1.0), 1e-5)];
    let mut notes = vec!["of the force at 1 % strain".to_string()];
    for (what, angle, away, limit) in places {
        put(&mut world, &rest, |x| turn(angle) * x + away);
        let (fast, exact) = (largest(&forces(&mut world)) / scale, largest(&exact_forces(&mut world)) / scale);
        notes.push(at_most(if fast > exact || fast.is_nan() { fast } else { exact }, limit, what)?);
    }
    Ok(notes.join("; "))
}

/// Σ f and Σ x × f, relative to the sums of their sizes, upright and far from the origin.
pub(super) fn momentum(subject: &Subject<'_>) -> Finding {
    let mut world = worked(subject, 0.2)?;
    let (exact, fast) = (exact_forces(&mut world), forces(&mut world));
    let of = |forces| self_force(&world, forces);
    let (exact, fast) = (of(&exact), of(&fast));
    if exact.is_nan() || fast.is_nan() {
        return fail("a force at 20 % strain is not a number");
    }
    // f32 sums of a row: measured 1e-8
    let note = at_most(fast, 1e-6, "f32")?;
    Ok(format!("{note}; {}", at_most(exact, 1e-12, "f64")?))
}

/// What a body does to itself: the larger of net force and torque, relative.
pub(super) fn self_force(world: &World, forces: &[DVec3]) -> f64 {
    let place = &world.particles.position;
    let middle = place.iter().sum::<DVec3>() / place.len() as f64;
    let (mut force, mut torque, mut size, mut arms) = (DVec3::ZERO, DVec3::ZERO, 0.0, 0.0);
    for (x, f) in place.iter().zip(forces) {
        let arm = *x - middle;
        force += *f;
        torque += arm.cross(*f);
        size += f.length();
        arms += arm.length() * f.length();
    }
    if size == 0.0 { 0.0 } else { (force.length() / size).max(torque.length() / arms) }
}

/// Strained, flowed, strained again, then turned by 90° and flowed there: forces turn with the body.
pub(super) fn objectivity(subject: &Subject<'_>) -> Finding {
    let mut worst = 0.0f64;
    for turn in [DMat3::from_rotation_z(std::f64::consts::FRAC_PI_2), turn(std::f64::consts::FRAC_PI_2)] {
        let answer = |turn: DMat3| -> Result<Vec<DVec3>, Trouble> {
            let mut world = worked(subject, 0.1)?;
            let (now, dt) = (strained(&world, 0.15), world.dt);
            put(&mut world, &now, |x| turn * x);
            flow(&mut world, dt);
            let last = strained(&world, 0.12);
            put(&mut world, &last, |x| turn * x);
            Ok(exact_forces(&mut world).iter().map(|f| turn.transpose() * *f).collect())
        };
        let (upright, turned) = (answer(DMat3::IDENTITY)?, answer(turn)?);
        worst = worst.max(difference(&upright, &turned));
        if difference(&upright, &turned).is_nan() {
            return fail("a force at 12 % strain is not a number");
        }
    }
    at_most(worst, 1e-5, "of the largest force:")
}

/// −F · d against the slope of the energy along d, for pieces d of the force itself. At 10 % strain after a past there, and
/// a little unloaded, so that no bond sits on the edge of its yield surface.
pub(super) fn gradient(subject: &Subject<'_>) -> Finding {
    let mut world = worked(subject, 0.097)?;
    if energy(&mut world).is_none() {
        return skip("the law says that it has no energy");
    }
    let force = exact_forces(&mut world);
    let home = world.particles.position.to_vec();
    let mut worst = 0.0f64;
    for piece in 0..6u64 {
        // all of it, then halves picked by chance
        let picked = |i: usize| piece == 0 || noise((piece << 32) + i as u64) > 0.0;
        let d: Vec<DVec3> = force.iter().enumerate().map(|(i, f)| if picked(i) { *f } else { DVec3::ZERO }).collect();
        let step = 1e-4 * SPACING / largest(&d);
        let mut at = |steps: f64| {
            for (i, x) in world.particles.position.iter_mut().enumerate() {
                *x = home[i] + d[i] * (step * steps);
            }
            energy(&mut world).unwrap_or(f64::NAN)
        };
        let slope = (8.0 * (at(1.0) - at(-1.0)) - (at(2.0) - at(-2.0))) / (12.0 * step);
        let work: f64 = force.iter().zip(&d).map(|(f, d)| f.dot(*d)).sum();
        let error = (slope + work).abs() / work.abs();
        if error.is_nan() {
            return fail("an energy or a force at 10 % strain is not a number");
        }
        worst = worst.max(error);
    }
    at_most(worst, 1e-3, "relative error of the slope")
}

/// f32 lanes against f64: at strain 1e-4 a hundred sizes away and turned by 1 rad, and at 20 % with a past.
pub(super) fn precision(subject: &Subject<'_>) -> Finding {
    let mut little = subject.world()?;
    let places = strained(&little, 1e-4);
    put(&mut little, &places, |x| turn(1.0) * x + DVec3::new(40.0, -40.0, 30.0));
    let large = worked(subject, 0.2)?;
    let mut notes = Vec::new();
    for (mut world, what) in [(little, "far, turned, strain 1e-4:"), (large, "strain 0.2:")] {
        let Some(exact) = reference_forces(&world) else {
            return skip("the material has no f64 reference");
        };
        notes.push(at_most(difference(&exact, &forces(&mut world)), 1e-5, what)?);
    }
    Ok(notes.join("; "))
}
