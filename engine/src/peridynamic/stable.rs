//! The largest stable step of any law, from its own derivatives at rest.
//!
//! With t_ij = ½A_ij as a function of e and θ_i = Σ g e V, the stiffness that particle i feels is bounded by
//! K_i = Σ_j V_i V_j (c_ij + c_ji + p⁺_ij G_i + p⁺_ji G_j) n nᵀ with c = ∂t/∂e, p⁺ = max(0, ∂t/∂θ), g = ∂θ/∂e / V and
//! G = Σ g V. A symplectic Euler step is stable below min √(2 m_i / λmax(K_i)) (Gershgorin, by blocks of particles). The
//! bound that looks at bonds alone (Silling and Askari 2005) is unsafe from ν = 0.45 on, where θ carries the stiffness.
//!
//! A sum of absolute values is short of the truth, 2/√λmax(M⁻¹K), by up to 1.4 on a jittered block. So the bound is
//! followed by one on the spectrum of M⁻¹K itself, whose action is a force evaluation at rest shaken by 1e-6 horizons; the
//! better of the two holds.

use glam::{DMat3, DVec3};
use rayon::prelude::*;

use super::parts::Laws;
use super::spectrum;
use crate::bonds::{Bonds, CHUNK};
use crate::law::{Bond, BondLaw};
use crate::noise::vector;
use crate::particles::BodyParticles;

/// Derivatives of a directed bond's law at rest.
struct Slope {
    c: f64,
    p: f64,
}

/// λmax is taken for so much more than its bound: just below the limit the fastest mode beats, with a v² that swings by
/// 1/(1 − λ h²/4).
const RESERVE: f64 = 1.02;

/// The step [s], infinite if nothing resists. `stiffness` is that of [`stiffness`]; `accelerations(u, out)` writes the
/// accelerations [m/s²] that small displacements u [m] from rest cause.
pub(super) fn largest_step(
    p: &BodyParticles<'_>,
    stiffness: &[f64],
    mut accelerations: impl FnMut(&[DVec3], &mut [DVec3]),
) -> f64 {
    // λmax(M⁻¹K) is at most twice the largest of these
    let share: Vec<f64> = stiffness.iter().zip(p.mass).map(|(k, m)| k / m).collect();
    let most = share.iter().copied().fold(0.0, f64::max);
    if most <= 0.0 {
        return f64::INFINITY;
    }
    // what limits the step sits where the bound is largest; noise has a share of every mode
    let start = (0..p.len()).map(|i| vector(i as u64) * (share[i] / most).powi(4)).collect();
    // M^-½ K M^-½ is symmetric and has the eigenvalues of M⁻¹K
    let mut u = vec![DVec3::ZERO; p.len()];
    let bound = spectrum::upper_bound(start, |q, out| {
        u.par_iter_mut().enumerate().with_min_len(1024).for_each(|(i, u)| *u = q[i] / p.mass[i].sqrt());
        accelerations(&u, out);
        out.par_iter_mut().enumerate().with_min_len(1024).for_each(|(i, a)| *a *= -p.mass[i].sqrt());
    });
    let largest = bound.map_or(2.0 * most, |b| (RESERVE * b).min(2.0 * most));
    if largest > 0.0 { 2.0 / largest.sqrt() } else { f64::INFINITY }
}

/// How much stiffer a bond is than at rest, at least 1, while it swings to and fro from step to step of `dt` [s]: the
/// memory, which a force sees as it was before the step, then lags behind by half a period.
pub(super) fn lag<T: BondLaw<M>, const M: usize>(
    laws: Laws<'_, T, M>,
    bonds: &Bonds,
    inv_m: &[f64],
    p: &BodyParticles<'_>,
    dt: f64,
) -> f64 {
    let stiffer = |i: usize, slot: usize| {
        let law = laws.own(i);
        let xi = p.rest[bonds.neighbours[slot] as usize].as_dvec3() - p.rest[i].as_dvec3();
        let de = 1e-6 * xi.length();
        let influence = f64::from(bonds.weight[slot]) / p.volume[bonds.neighbours[slot] as usize];
        let bond = |ext| Bond { ext, ..Bond::at_rest(xi.length(), influence, inv_m[i]) };
        let mut memory = [0.0; M];
        for swing in 0..64 {
            memory = law.flow(&bond(if swing % 2 == 0 { de } else { -de }), memory, dt);
        }
        law.force(&bond(de), memory) / law.force(&bond(de), [0.0; M])
    };
    // one particle of each law
    let rows = laws.examples(p.len(), |i| bonds.built(i).next().is_some());
    let slots = rows.flat_map(|i| bonds.built(i).map(move |slot| (i, slot)));
    slots.map(|(i, slot)| stiffer(i, slot)).filter(|s| s.is_finite()).fold(1.0, f64::max)
}

/// λmax(K_i) [N/m] of every particle of the unbroken body: what its own displacement is resisted by, at most twice that
/// with its neighbours moving against it.
pub(super) fn stiffness<T: BondLaw<M>, const M: usize>(
    laws: Laws<'_, T, M>,
    bonds: &Bonds,
    inv_m: &[f64],
    p: &BodyParticles<'_>,
) -> Vec<f64> {
    let at_rest = |i: usize, slot: usize| {
        let xi = p.rest[bonds.neighbours[slot] as usize].as_dvec3() - p.rest[i].as_dvec3();
        let influence = f64::from(bonds.weight[slot]) / p.volume[bonds.neighbours[slot] as usize];
        (xi, Bond::at_rest(xi.length(), influence, inv_m[i]))
    };
    let slope = |law: &T, b: Bond<f64>| {
        let (de, dt) = (1e-6 * b.rest, 1e-6);
        let t = |b: Bond<f64>| law.force(&b, [0.0; M]);
        let c = (t(Bond { ext: de, ..b }) - t(Bond { ext: -de, ..b })) / (2.0 * de);
        let p = (t(Bond { theta: dt, ..b }) - t(Bond { theta: -dt, ..b })) / (2.0 * dt);
        Slope { c, p: p.max(0.0) }
    };
    // G_i = Σ g V
    let gain: Vec<f64> = (0..p.len())
        .into_par_iter()
        .map(|i| {
            let share = |slot: usize| {
                let (_, b) = at_rest(i, slot);
                let de = 1e-6 * b.rest;
                let law = laws.own(i);
                let g = law.dilatation(&Bond { ext: de, ..b }) - law.dilatation(&Bond { ext: -de, ..b });
                g / (2.0 * de) * p.volume[bonds.neighbours[slot] as usize]
            };
            if T::NEEDS_THETA { bonds.built(i).map(share).sum::<f64>().abs() } else { 0.0 }
        })
        .collect();
    let felt = |i: usize| {
        let mut k = DMat3::ZERO;
        for slot in bonds.built(i) {
            let j = bonds.neighbours[slot] as usize;
            let (xi, own) = at_rest(i, slot);
            let here = slope(laws.own(i), own);
            let there = slope(laws.other(laws.own(i), slot / CHUNK), Bond { inv_m: inv_m[j], ..own });
            let n = xi / own.rest;
            let stiffness = here.c + there.c + here.p * gain[i] + there.p * gain[j];
            k += DMat3::from_cols(n * n.x, n * n.y, n * n.z) * (stiffness * p.volume[i] * p.volume[j]);
        }
        largest_eigenvalue(k).max(0.0)
    };
    (0..p.len()).into_par_iter().map(felt).collect()
}

/// Largest eigenvalue of a symmetric matrix, in closed form (Smith 1961).
pub(crate) fn largest_eigenvalue(a: DMat3) -> f64 {
    let mean = (a.x_axis.x + a.y_axis.y + a.z_axis.z) / 3.0;
    let b = a - DMat3::from_diagonal(DVec3::splat(mean));
    let p = ((b.x_axis.length_squared() + b.y_axis.length_squared() + b.z_axis.length_squared()) / 6.0).sqrt();
    if p <= 1e-14 * mean.abs() {
        return mean;
    }
    let r = ((b * (1.0 / p)).determinant() / 2.0).clamp(-1.0, 1.0);
    mean + 2.0 * p * (r.acos() / 3.0).cos()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn eigenvalues_of_known_matrices() {
        assert_eq!(largest_eigenvalue(DMat3::from_diagonal(DVec3::splat(4.0))), 4.0);
        let turn = DMat3::from_axis_angle(DVec3::new(1.0, 2.0, 3.0).normalize(), 0.7);
        let a = turn * DMat3::from_diagonal(DVec3::new(1.0, 7.0, 3.0)) * turn.transpose();
        assert!((largest_eigenvalue(a) - 7.0).abs() < 1e-12); // measured 2e-15
    }
}
