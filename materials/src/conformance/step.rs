//! What is asked of the time step: that it is stable, and not much shorter than it need be.

use fissure_engine::World;

use super::body::{SPACING, Subject, vector};
use super::report::{Finding, Trouble, fail, skip};

/// Steps to blow up in. At 1.04 times its limit the fastest mode grows by 1.7 in a step.
const STEPS: usize = 200;

/// How much v² of small noise grows at most when steps are `factor` times what the material offers.
fn growth(subject: &Subject<'_>, factor: f64) -> Result<f64, Trouble> {
    let mut world = subject.world()?;
    world.dt = factor * world.stable_dt();
    for i in 0..world.particles.len() {
        world.particles.velocity[i] = vector(i, 3) * (1e-7 * SPACING / world.dt);
    }
    let kinetic = |w: &World| w.particles.velocity.iter().map(|v| v.length_squared()).sum::<f64>();
    let start = kinetic(&world);
    let mut most = 1.0f64;
    for _ in 0..STEPS {
        if world.step().is_err() {
            return Ok(f64::INFINITY);
        }
        let now = kinetic(&world) / start;
        most = if now.is_nan() { f64::INFINITY } else { most.max(now) };
    }
    Ok(most)
}

/// How much longer than offered a step must be to blow up.
const TOO_LONG: f64 = 1.3;

/// Noise keeps its energy at the offered step, and gains more than a hundredfold at some step up to 1.3 times as long.
pub(super) fn stable(subject: &Subject<'_>) -> Finding {
    let dt = subject.world()?.stable_dt();
    if dt == f64::INFINITY {
        return skip("any step is stable, it says");
    }
    if dt.is_nan() || dt <= 0.0 {
        return fail(format!("the stable step is {dt} s"));
    }
    let here = growth(subject, 1.0)?;
    if here > 10.0 {
        return fail(format!("the offered step of {dt:.2e} s is not stable: noise grows {here:.0e}-fold"));
    }
    for factor in [1.05, 1.1, 1.2, TOO_LONG, 1.4, 1.5, 2.0] {
        if growth(subject, factor)? > 100.0 {
            let note = format!("{dt:.2e} s is stable, {factor} times that is not, at most {TOO_LONG}");
            return if factor <= TOO_LONG { Ok(note) } else { fail(note) };
        }
    }
    fail(format!("{dt:.2e} s is much too short: twice that is stable too"))
}
