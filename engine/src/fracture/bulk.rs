//! What a law amounts to inside a large body, found from the law itself: moduli, and the energy that crosses a plane.

use std::f64::consts::TAU;

use glam::{DMat3, DVec3};

use crate::law::{Bond, BondLaw};

/// Nodes along the radius (shells of equal volume, in which the moments that matter are nearly linear), the cosine and
/// around; midpoints. Errors of all numbers are below 7e-3 (`tests/tests/fracture.rs`).
const NODES: [usize; 3] = [10, 16, 24];
/// Strain of the differences that derivatives are taken by: below any yield stretch.
const SMALL: f64 = 1e-6;

/// A law's response at small strain in a full family, memory 0; for an anisotropic law the mean over directions.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Bulk {
    /// Bulk modulus κ [Pa].
    pub bulk: f64,
    /// Shear modulus μ [Pa].
    pub shear: f64,
    /// 2 ∫ω|ξ|²/m over the bonds that cross a unit area, each once [m].
    pub crossing: f64,
    /// Energy per area of the bonds that cross a plane, per square of their fracture stretch [J/m²]; bonds that don't
    /// cross are unstretched.
    pub release: f64,
}

/// A bond ξ of half a family (the other half is its mirror image) with what it adds per strain.
struct Node {
    xi: DVec3,
    volume: f64,
    /// ∂T/∂e, ∂T/∂θ, ∂θ/∂e per volume.
    c: f64,
    p: f64,
    g: f64,
    /// ω [1].
    weight: f64,
    /// The extension at a fracture stretch of 1 [m].
    gauge: f64,
}

impl Bulk {
    /// Integrates `law` over a family of radius `horizon` [m].
    pub fn of<T: BondLaw<M>, const M: usize>(law: &T, horizon: f64) -> Self {
        let (m, nodes) = family(law, horizon);
        let full = |f: &dyn Fn(&Node) -> f64| 2.0 * nodes.iter().map(|n| f(n) * n.volume).sum::<f64>();
        // uniform dilatation e = |ξ|: W = ½ Σ T e V = (9/2) κ
        let swelling = full(&|n| n.g * n.xi.length());
        let bulk = full(&|n| (n.c * n.xi.length() + n.p * swelling) * n.xi.length()) / 9.0;
        // mean over the five deviatoric strains E:E = 1, e = ξ·Eξ/|ξ|, of which each stores μ
        let tensor = |f: &dyn Fn(&Node) -> f64| {
            let sum = nodes.iter().map(|n| outer(n.xi) * (2.0 * f(n) * n.volume / n.xi.length())).sum::<DMat3>();
            sum - DMat3::from_diagonal(DVec3::splat(trace(sum) / 3.0))
        };
        let (grows, pulls) = (tensor(&|n| n.g), tensor(&|n| n.p));
        let coupled = trace(grows.transpose() * pulls);
        let shear = (full(&|n| n.c * n.xi.length_squared()) / 3.0 + 0.5 * coupled) / 5.0;
        let axes = [DVec3::X, DVec3::Y, DVec3::Z];
        let mean = |f: &dyn Fn(DVec3) -> f64| axes.map(f).iter().sum::<f64>() / 3.0;
        Self {
            bulk,
            shear,
            crossing: mean(&|normal| {
                let across = |n: &Node| n.weight * n.xi.length_squared() * n.xi.dot(normal).abs() * n.volume;
                2.0 / m * nodes.iter().map(across).sum::<f64>()
            }),
            release: mean(&|normal| release(&nodes, normal)),
        }
    }
}

/// The weighted volume m [m⁵] and half a family.
fn family<T: BondLaw<M>, const M: usize>(law: &T, horizon: f64) -> (f64, Vec<Node>) {
    let [radii, cosines, turns] = NODES;
    let middle = |k: usize, n: usize| (k as f64 + 0.5) / n as f64;
    let mut nodes = Vec::with_capacity(radii * cosines * turns);
    for k in 0..radii * cosines * turns {
        let (a, b) = (k / (cosines * turns), k / turns % cosines);
        let (r, z) = (horizon * middle(a, radii).cbrt(), middle(b, cosines));
        let turn = TAU * middle(k, turns);
        let (flat, (y, x)) = ((1.0 - z * z).sqrt(), turn.sin_cos());
        let xi = DVec3::new(flat * x, flat * y, z) * r;
        let volume = TAU / 3.0 * horizon.powi(3) / (radii * cosines * turns) as f64;
        let weight = law.influence(xi, horizon);
        nodes.push(Node { xi, volume, c: 0.0, p: 0.0, g: 0.0, weight, gauge: 0.0 });
    }
    let m = 2.0 * nodes.iter().map(|n| n.weight * n.xi.length_squared() * n.volume).sum::<f64>();
    for n in &mut nodes {
        let at_rest = Bond::at_rest(n.xi.length(), n.weight, 1.0 / m);
        let step = SMALL * at_rest.rest;
        let slope = |f: &dyn Fn(f64) -> f64, step: f64| (f(step) - f(-step)) / (2.0 * step);
        n.c = slope(&|ext| law.force(&Bond { ext, ..at_rest }, [0.0; M]), step);
        n.p = slope(&|theta| law.force(&Bond { theta, ..at_rest }, [0.0; M]), SMALL);
        n.g = slope(&|ext| law.dilatation(&Bond { ext, ..at_rest }), step);
        n.gauge = law.gauge(&at_rest);
    }
    (m, nodes)
}

/// Energy of the bonds with ξ·n > z summed over the depth z below the plane, on both sides of it.
fn release(nodes: &[Node], normal: DVec3) -> f64 {
    let mut crossing: Vec<(f64, &Node)> = nodes.iter().map(|n| (n.xi.dot(normal).abs(), n)).collect();
    crossing.sort_by(|a, b| a.0.total_cmp(&b.0));
    // the dilatational part is 2 ∫ ½ θ(z) P(z) dz with θ and P sums over ξ·n > z: from the longest reach down
    let (mut sum, mut theta, mut pull, mut above) = (0.0, 0.0, 0.0, 0.0);
    for (reach, n) in crossing.into_iter().rev() {
        sum += (above - reach) * theta * pull;
        above = reach;
        theta += n.g * n.gauge * n.volume;
        pull += n.p * n.gauge * n.volume;
        sum += n.c * n.gauge * n.gauge * reach * n.volume;
    }
    sum + above * theta * pull
}

fn outer(v: DVec3) -> DMat3 {
    DMat3::from_cols(v * v.x, v * v.y, v * v.z)
}

fn trace(a: DMat3) -> f64 {
    a.x_axis.x + a.y_axis.y + a.z_axis.z
}
