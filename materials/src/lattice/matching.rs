//! Shape matching of four regions at once: from sums over nodes to goal shapes (Ohta et al., Eqs. 1, 2, 5 and 6).
//!
//! Sums and goals are rows of 3 × 4 numbers. Over the nodes of a region, row a of the sums is Σ m x_a (1, r) with rest position
//! r; the goal of a node is the product of each row (t_a, G_a) with its (1, r). Rows add, so sums over regions of goals
//! are goals too.
//!
//! R comes from Σ m p qᵀ, the best rotation in the sense of least squares, and not from A: only so the goals turn nothing
//! (Σ m p × Rq = 0) where the spread of a region differs between axes.

use glam::{DMat3, DVec3};
use wide::f64x4;

use super::params::Settings;
use super::regions::Still;
use super::rotation::{Matrices, Turns, matrices, nearest};

/// Three rows of a vector and a matrix.
pub type Rows = [f64x4; 3];

/// No sum yet.
pub const EMPTY: Rows = [f64x4::ZERO; 3];

/// (1, r), with which rows are multiplied.
#[inline(always)]
pub fn lever(r: DVec3) -> f64x4 {
    f64x4::new([1.0, r.x, r.y, r.z])
}

/// What a node of mass `m` [kg] at `x` [m] adds to the sums of its regions.
#[inline(always)]
pub fn moment(m: f64, x: DVec3, lever: f64x4) -> Rows {
    [x.x * m, x.y * m, x.z * m].map(|x| lever * f64x4::splat(x))
}

/// The goal that rows give to a node.
#[inline(always)]
pub fn goal(rows: &Rows, lever: f64x4) -> DVec3 {
    let [x, y, z] = rows.map(|row| {
        let [t, a, b, c] = (row * lever).to_array();
        t + a + b + c
    });
    DVec3::new(x, y, z)
}

#[inline(always)]
pub fn add(to: &mut Rows, rows: &Rows) {
    (0..3).for_each(|a| to[a] += rows[a]);
}

#[inline(always)]
pub fn subtract(from: &mut Rows, rows: &Rows) {
    (0..3).for_each(|a| from[a] -= rows[a]);
}

/// Σ rows · share of those that `row` and `share` name.
#[inline(always)]
pub fn sum_of(rows: &[Rows], row: &[u32], share: &[f64]) -> Rows {
    let [mut x, mut y, mut z] = EMPTY;
    for (&k, &share) in row.iter().zip(share) {
        let (rows, share) = (&rows[k as usize], f64x4::splat(share));
        x += rows[0] * share;
        y += rows[1] * share;
        z += rows[2] * share;
    }
    [x, y, z]
}

/// The matrix of rows.
pub fn matrix(rows: &Rows) -> DMat3 {
    let rows = rows.map(|row| row.to_array());
    DMat3::from_cols_array_2d(&std::array::from_fn(|j| std::array::from_fn(|i| rows[i][j + 1])))
}

/// A remembered rotation x, y, z, w: a guess for the next, so half the digits do.
pub type Turn = [f32; 4];

/// No turn.
pub const STRAIGHT: Turn = [0.0, 0.0, 0.0, 1.0];

#[inline(always)]
fn guesses(turns: [Turn; 4]) -> Turns {
    f64x4::transpose(turns.map(|t| f64x4::new(t.map(f64::from))))
}

#[inline(always)]
fn remembered(q: Turns) -> [Turn; 4] {
    f64x4::transpose(q).map(|q| q.to_array().map(|x| x as f32))
}

/// Four sums about their centres: the centres [m] and Σ m p qᵀ. `over` is 1/mass, `rest` the centres at rest.
#[inline(always)]
fn centred(sums: [Rows; 4], over: f64x4, rest: &[f64x4; 3]) -> ([f64x4; 3], Matrices) {
    let lanes: [[f64x4; 4]; 3] = std::array::from_fn(|a| f64x4::transpose(std::array::from_fn(|l| sums[l][a])));
    let centre = std::array::from_fn(|a| lanes[a][0] * over);
    (centre, std::array::from_fn(|a| std::array::from_fn(|k| lanes[a][k + 1] - lanes[a][0] * rest[k])))
}

/// Goals that put the rest centres onto `centre` with deformation `g`.
#[inline(always)]
fn goals(g: &Matrices, centre: &[f64x4; 3], rest: &[f64x4; 3]) -> [Rows; 4] {
    let rows: [[f64x4; 4]; 3] = std::array::from_fn(|a| {
        let t = centre[a] - g[a][0] * rest[0] - g[a][1] * rest[1] - g[a][2] * rest[2];
        f64x4::transpose([t, g[a][0], g[a][1], g[a][2]])
    });
    std::array::from_fn(|l| std::array::from_fn(|a| rows[a][l]))
}

/// Matches four rigid regions; `still` is mass [kg] and centre at rest [m] of each.
#[inline(always)]
pub fn rigid(sums: [Rows; 4], still: [[f64; 4]; 4], turns: [Turn; 4]) -> ([Rows; 4], [Turn; 4]) {
    let [mass, x, y, z] = f64x4::transpose(still.map(f64x4::new));
    let rest = [x, y, z];
    let (centre, a) = centred(sums, f64x4::ONE / mass, &rest);
    let q = nearest(&a, guesses(turns));
    (goals(&matrices(&q), &centre, &rest), remembered(q))
}

/// What a match finds beside the goals.
#[derive(Clone, Copy, Debug, Default)]
pub struct Found {
    /// The rotation R.
    pub turn: Turn,
    /// The largest |S_ii − 1| [1].
    pub strain: f32,
    /// S = RᵀA, the stretch of the plastic rest shape [1]. Neither this nor what follows is found in vain: only where rest shapes
    /// flow, or where all is asked for.
    pub stretch: DMat3,
    /// What rest vectors have become, by least squares: A of the elastic rest shape.
    pub gradient: DMat3,
}

/// What goals a match finds, and whether all of [`Found`] or no more than a step needs.
#[derive(Clone, Copy)]
pub struct Wanted<'a> {
    pub settings: &'a Settings,
    pub all: bool,
}

/// Matches up to four regions with what there may be: β, volume, a plastic rest shape (identity where there is none). As many as
/// `goal` and `found` have room for get an answer.
#[inline]
pub fn general(
    sums: [Rows; 4],
    still: [&Still; 4],
    turns: [Turn; 4],
    plastic: [DMat3; 4],
    Wanted { settings, all }: Wanted<'_>,
    goal: &mut [Rows],
    found: &mut [Found],
) {
    let number = |of: fn(&Still) -> f64| f64x4::new(still.map(of));
    let rest = [number(|s| s.centre.x), number(|s| s.centre.y), number(|s| s.centre.z)];
    let (centre, moment) = centred(sums, f64x4::ONE / number(|s| s.mass), &rest);
    let flows = settings.plastic.is_some();
    let shape = if flows { lanes(plastic) } else { [[f64x4::ZERO; 3]; 3] };
    let a_plastic = if flows { product(&moment, &transposed(&shape)) } else { moment };
    let q = nearest(&a_plastic, guesses(turns));
    let r = matrices(&q);
    // A of the plastic shape; along axes in which the region has no extent it is R
    let spread = product(&moment, &lanes(still.map(|s| s.inverse)));
    let mut a = if flows {
        let kept = product(&product(&r, &shape), &lanes(still.map(|s| s.lost)));
        product(&sum(&spread, &kept), &inverted(&shape))
    } else if still.iter().any(|s| s.flat) {
        sum(&spread, &product(&r, &lanes(still.map(|s| s.lost))))
    } else {
        spread
    };
    let stretch = product(&transposed(&r), &a);
    let gradient = a;
    let det = determinant(&a);
    if settings.volume_preserving {
        let size = det.to_array().map(|d| if d > LEAST { d.cbrt().recip() } else { 1.0 });
        a = a.map(|row| row.map(|x| x * f64x4::new(size)));
    }
    // what is pressed flat or inside out must not be its own goal
    let sound = (det * f64x4::splat(1.0 / SOUND)).max(f64x4::ZERO).min(f64x4::ONE);
    let beta = number(|s| s.beta) * sound;
    let g: Matrices = std::array::from_fn(|i| std::array::from_fn(|j| r[i][j] + beta * (a[i][j] - r[i][j])));
    let g = if flows { product(&g, &shape) } else { g };
    goal.iter_mut().zip(goals(&g, &centre, &rest)).for_each(|(to, goal)| *to = goal);
    let off = |k: usize| (stretch[k][k] - f64x4::ONE).abs();
    let strain = off(0).max(off(1)).max(off(2)).to_array();
    for ((found, turn), strain) in found.iter_mut().zip(remembered(q)).zip(strain) {
        (found.turn, found.strain) = (turn, strain as f32);
    }
    if all || flows {
        unlane(&stretch, found, |found| &mut found.stretch);
        unlane(&if flows { product(&gradient, &shape) } else { gradient }, found, |found| &mut found.gradient);
    }
}

/// β counts fully down to this det A, and nothing at 0: at β = 0.9, a body that falls on its side otherwise stays folded into
/// itself.
const SOUND: f64 = 0.5;
/// A det A below this says nothing about volume: the region is flat or inside out.
const LEAST: f64 = 1e-3;

fn lanes(m: [DMat3; 4]) -> Matrices {
    let at = |i: usize, j: usize| f64x4::new(std::array::from_fn(|l| m[l].col(j)[i]));
    std::array::from_fn(|i| std::array::from_fn(|j| at(i, j)))
}

/// Puts four matrices where they belong.
#[inline(always)]
fn unlane(m: &Matrices, found: &mut [Found], place: impl Fn(&mut Found) -> &mut DMat3) {
    for j in 0..3 {
        let columns = f64x4::transpose([m[0][j], m[1][j], m[2][j], f64x4::ZERO]);
        for (found, column) in found.iter_mut().zip(columns) {
            let [x, y, z, _] = column.to_array();
            *place(found).col_mut(j) = DVec3::new(x, y, z);
        }
    }
}

#[inline(always)]
fn transposed(m: &Matrices) -> Matrices {
    std::array::from_fn(|i| std::array::from_fn(|j| m[j][i]))
}

#[inline(always)]
fn sum(a: &Matrices, b: &Matrices) -> Matrices {
    std::array::from_fn(|i| std::array::from_fn(|j| a[i][j] + b[i][j]))
}

#[inline(always)]
fn product(a: &Matrices, b: &Matrices) -> Matrices {
    std::array::from_fn(|i| std::array::from_fn(|j| a[i][0] * b[0][j] + a[i][1] * b[1][j] + a[i][2] * b[2][j]))
}

#[inline(always)]
fn cofactor(m: &Matrices, i: usize, j: usize) -> f64x4 {
    let (i1, i2, j1, j2) = ((i + 1) % 3, (i + 2) % 3, (j + 1) % 3, (j + 2) % 3);
    m[i1][j1] * m[i2][j2] - m[i1][j2] * m[i2][j1]
}

#[inline(always)]
fn determinant(m: &Matrices) -> f64x4 {
    (0..3).fold(f64x4::ZERO, |sum, j| sum + m[0][j] * cofactor(m, 0, j))
}

#[inline(always)]
fn inverted(m: &Matrices) -> Matrices {
    let over = f64x4::ONE / determinant(m);
    std::array::from_fn(|i| std::array::from_fn(|j| cofactor(m, j, i) * over))
}
