//! What is asked of the time step: that it is stable, and not much shorter than it need be.

use super::body::{SPACING, Subject, vector};
use super::report::{Finding, Trouble, fail, skip};

/// Steps to blow up in. At 1.04 times its limit the fastest mode grows by 1.7 in a step.
const STEPS: usize = 400;

/// How much the kinetic energy of small noise grows at most when steps are `factor` times what the material offers.
fn growth(subject: &Subject<'_>, factor: f64) -> Result<f64, Trouble> {
    let mut world = subject.world()?;
    world.dt = factor * world.stable_dt();
    for i in 0..world.particles.len() {
        world.particles.velocity[i] = vector(i, 3) * (1e-7 * SPACING / world.dt);
    }
    let start = world.energies().kinetic;
    let mut most = 1.0f64;
    for _ in 0..STEPS {
        if world.step().is_err() {
            return Ok(f64::INFINITY);
        }
        let kinetic = world.energies().kinetic / start;
        most = if kinetic.is_nan() { f64::INFINITY } else { most.max(kinetic) };
    }
    Ok(most)
}

/// Noise keeps its energy at the offered step and gains more than a hundredfold at 1.5 times that. The bound is a sum of
/// absolute values (Gershgorin), which on a jittered block is short of the truth by up to 1.35, so 1.3 times would not
/// blow up under every law.
pub(super) fn stable(subject: &Subject<'_>) -> Finding {
    let dt = subject.world()?.stable_dt();
    if dt == f64::INFINITY {
        return skip("any step is stable, it says");
    }
    if !(dt > 0.0) {
        return fail(format!("the stable step is {dt} s"));
    }
    let (at, beyond) = (growth(subject, 1.0)?, growth(subject, 1.5)?);
    if at > 10.0 {
        return fail(format!("the offered step of {dt:.3e} s is not stable: noise grows {at:.1e}-fold"));
    }
    if beyond < 100.0 {
        return fail(format!(
            "the offered step of {dt:.3e} s is much too short: noise grows only {beyond:.1}-fold at 1.5 of it"
        ));
    }
    Ok(format!("{dt:.3e} s: noise grows {at:.1}-fold, at 1.5 of it beyond {:.0e}-fold", beyond.min(1e9)))
}
