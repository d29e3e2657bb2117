//! Local affine motion of the particles, by least squares over a tetrahedron and those that share a vertex with it.
//!
//! Sums over a tetrahedron's surroundings are the sums around its four vertices put together (parallel-axis theorem),
//! so a particle counts once for each vertex it shares, the own one four times, and nothing is gathered twice.
//!
//! The gradient starts from a rotation R and takes from the data only what the data know: with the second moments Q
//! of the rest positions and A of current by rest ones, F ← F + (A − F Q)(Q + ε)⁻¹, eight times from F = R. Where the
//! particles spread, the error shrinks by ε/λ each time, to nothing; across a flat or straight set, where λ ≪ ε, F
//! stays at R. One step of a tiny ε instead (Tikhonov) would be exact as well, but divides rounding errors by it.

use glam::{DMat3, DQuat, DVec3};

use super::rotation::nearest_rotation;

/// ε relative to the squared size of the surroundings.
const RIDGE: f64 = 1e-3;
/// Weight of the last rotation, relative to the squared size: it decides only what the particles leave open, such as
/// the twist of two of them about their axis.
const TIE: f64 = 1e-5;
/// Largest |F − R| (Frobenius) where particles lie in a plane or on a line, and where they fill space.
const STRETCH: (f64, f64) = (0.3, 5.0);
/// Particles with 27 det Q / (tr Q)³ above this fill space: 1 for a ball, 0.16 for a sheet of 1 : 1 : 0.2.
const FILLED: f64 = 0.05;

/// Weighted means and second central moments of a set of particles.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Moments {
    weight: f64,
    rest: DVec3,
    position: DVec3,
    velocity: DVec3,
    /// Σ w (X − X̄)(X − X̄)ᵀ
    spread: DMat3,
    /// Σ w (y − ȳ)(X − X̄)ᵀ
    moved: DMat3,
    /// Σ w (v − v̄)(X − X̄)ᵀ
    moving: DMat3,
}

fn outer(a: DVec3, b: DVec3) -> DMat3 {
    DMat3::from_cols(a * b.x, a * b.y, a * b.z)
}

impl Moments {
    /// One particle: no spread.
    pub(crate) fn one(weight: f64, rest: DVec3, position: DVec3, velocity: DVec3) -> Self {
        let zero = DMat3::ZERO; // the default matrix is the unit matrix
        Self { weight, rest, position, velocity, spread: zero, moved: zero, moving: zero }
    }

    /// Weighted particles with rest position, position and velocity, all near `origin` of these three.
    pub(crate) fn of(particles: impl Iterator<Item = (f64, [DVec3; 3])>, origin: [DVec3; 3]) -> Self {
        let zero = (DVec3::ZERO, DMat3::ZERO);
        let (mut weight, mut rest, mut position, mut velocity) = (0.0, zero, zero, zero);
        for (w, particle) in particles {
            let arm = particle[0] - origin[0];
            let weighted = arm * w;
            weight += w;
            let add = |sum: &mut (DVec3, DMat3), value: DVec3| {
                sum.0 += value * w;
                sum.1 += outer(value, weighted);
            };
            add(&mut rest, arm);
            add(&mut position, particle[1] - origin[1]);
            add(&mut velocity, particle[2] - origin[2]);
        }
        let scale = if weight > 0.0 { 1.0 / weight } else { 0.0 };
        let central = |sum: (DVec3, DMat3)| sum.1 - outer(sum.0, rest.0 * scale);
        Self {
            weight,
            rest: origin[0] + rest.0 * scale,
            position: origin[1] + position.0 * scale,
            velocity: origin[2] + velocity.0 * scale,
            spread: central(rest),
            moved: central(position),
            moving: central(velocity),
        }
    }

    /// The parts together.
    pub(crate) fn join(parts: impl Iterator<Item = Self> + Clone) -> Self {
        let mut all = Self::one(0.0, DVec3::ZERO, DVec3::ZERO, DVec3::ZERO);
        for p in parts.clone() {
            all.weight += p.weight;
            all.rest += p.rest * p.weight;
            all.position += p.position * p.weight;
            all.velocity += p.velocity * p.weight;
        }
        if all.weight > 0.0 {
            all.rest /= all.weight;
            all.position /= all.weight;
            all.velocity /= all.weight;
        }
        for p in parts {
            let arm = p.rest - all.rest;
            let weighted = arm * p.weight;
            all.spread += p.spread + outer(arm, weighted);
            all.moved += p.moved + outer(p.position - all.position, weighted);
            all.moving += p.moving + outer(p.velocity - all.velocity, weighted);
        }
        all
    }

    /// Position and velocity that the motion of `fit` gives to what rests at `rest`.
    pub(crate) fn moved(&self, fit: &Fit, rest: DVec3) -> (DVec3, DVec3) {
        let arm = rest - self.rest;
        (self.position + fit.gradient * arm, self.velocity + fit.rate * arm)
    }

    /// Fits the gradient; `own` is the squared size of the tetrahedron itself [m²], `old` its last rotation.
    pub(crate) fn fit(&self, own: f64, old: DQuat) -> Fit {
        let scale = if self.weight > 0.0 { 1.0 / self.weight } else { 0.0 };
        let (spread, moved, moving) = (self.spread * scale, self.moved * scale, self.moving * scale);
        let (trace, filled) = filling(spread);
        let ridge = RIDGE * (trace + own);
        let mut rotation = old;
        for _ in 0..if filled < 1.0 { 3 } else { 1 } {
            // Again from the result: each time, the last rotation pulls on what is known by TIE times less.
            rotation = nearest_rotation(moved + DMat3::from_quat(rotation) * (TIE * (trace + own)), rotation);
        }
        let r = DMat3::from_quat(rotation);
        let Some(pull) = pull(spread, ridge).filter(|_| moved.is_finite()) else {
            return Fit { rotation, gradient: r, rate: DMat3::ZERO };
        };
        let (mut gradient, mut rate) = (r + (moved - r * spread) * pull, moving * pull);
        let limit = STRETCH.0 + (STRETCH.1 - STRETCH.0) * filled;
        let strain = gradient - r;
        let size =
            (strain.x_axis.length_squared() + strain.y_axis.length_squared() + strain.z_axis.length_squared()).sqrt();
        if size > limit {
            gradient = r + strain * (limit / size);
            rate *= limit / size;
        }
        Fit { rotation, gradient, rate }
    }
}

/// Rest positions alone: weight, mean and second central moments of weighted particles.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Spread {
    weight: f64,
    mean: DVec3,
    /// Σ w (X − X̄)(X − X̄)ᵀ
    spread: DMat3,
}

impl Spread {
    /// Of weighted rest positions, all near `origin`.
    pub(crate) fn of(particles: impl Iterator<Item = (f64, DVec3)>, origin: DVec3) -> Self {
        let (mut weight, mut sum, mut spread) = (0.0, DVec3::ZERO, DMat3::ZERO);
        for (w, x) in particles {
            let arm = x - origin;
            let weighted = arm * w;
            weight += w;
            sum += weighted;
            spread += outer(arm, weighted);
        }
        let mean = sum / weight;
        Self { weight, mean: origin + mean, spread: spread - outer(sum, mean) }
    }

    /// P with which the fit of particles in something of squared size `own` [m²] is F = R + (A − R Q) P; `None` where they fill so
    /// little space that the result also depends on R, how they have turned. That goes with 1 − Q P, where space is filled 4e-8 at
    /// the most.
    fn pull(&self, own: f64) -> Option<DMat3> {
        let spread = self.spread * (1.0 / self.weight);
        let (trace, filled) = filling(spread);
        if filled < 1.0 { None } else { pull(spread, RIDGE * (trace + own)) }
    }

    /// Which share a particle of weight w at rest at X has in the position and velocity that [`Moments::moved`] gives to what
    /// rests at `rest`, where particles fill space.
    pub(crate) fn shares(&self, own: f64, rest: DVec3) -> Option<impl Fn(f64, DVec3) -> f64> {
        let Self { weight, mean, .. } = *self;
        let lever = self.pull(own)? * (rest - mean);
        Some(move |w: f64, x: DVec3| w / weight * (1.0 + lever.dot(x - mean)))
    }

    /// The vector l of such a particle with which the gradient of [`Moments::fit`] is Σ y lᵀ, and its rate Σ v lᵀ.
    pub(crate) fn levers(&self, own: f64) -> Option<impl Fn(f64, DVec3) -> DVec3> {
        let (Self { weight, mean, .. }, pull) = (*self, self.pull(own)?);
        Some(move |w: f64, x: DVec3| pull * (x - mean) * (w / weight))
    }
}

/// P of F = R + (A − R Q) P: eight of the steps at the head of this file at once, for the spread Q and the ridge ε. A step leaves the
/// share X = ε (Q + ε)⁻¹ of the error, and 1 + X + … + X⁷ = (1 + X)(1 + X²)(1 + X⁴). `None` for what is not finite.
fn pull(spread: DMat3, ridge: f64) -> Option<DMat3> {
    let inverse = (spread + DMat3::from_diagonal(DVec3::splat(ridge))).inverse();
    let once = inverse * ridge;
    let twice = once * once;
    let grow = |sum: DMat3, by: DMat3| sum + sum * by;
    Some(grow(grow(grow(inverse, once), twice), twice * twice)).filter(|pull| pull.is_finite())
}

/// The trace of a spread, and how well it fills space: 1 from [`FILLED`] on.
fn filling(spread: DMat3) -> (f64, f64) {
    let trace = spread.x_axis.x + spread.y_axis.y + spread.z_axis.z;
    (trace, (27.0 * spread.determinant() / trace.powi(3).max(f64::MIN_POSITIVE) / FILLED).clamp(0.0, 1.0))
}

/// What [`Moments::fit`] finds.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Fit {
    pub(crate) rotation: DQuat,
    /// F.
    pub(crate) gradient: DMat3,
    /// dF/dt [1/s].
    pub(crate) rate: DMat3,
}
