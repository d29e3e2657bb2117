//! Tetrahedra that can be changed in place: edge removal, face removal, contraction, splitting.
//!
//! Each vertex keeps the list of its tetrahedra, and every operation swaps a small cavity for another filling of the
//! same cavity. A filling counts as valid if all its volumes are positive; since cavity and surroundings share their
//! boundary, no orientation predicate beyond that is needed. With `period` the same operations run on a torus, where
//! vertex positions are understood modulo the period; the background tile is made that way.

use crate::tetmesh::FACES;
use glam::DVec3;
use rayon::prelude::*;

/// Marks a removed tetrahedron.
const DEAD: [u32; 4] = [u32::MAX; 4];
/// Longest ring around an edge that edge removal looks at.
const RING: usize = 9;

/// The cosine-like quality of a tetrahedron: −cos of the smallest dihedral angle, or, where that is worse, what the
/// largest angle deserves (150° counts as 40°). −2 if the volume isn't positive. See [`angle_score`].
pub fn score(a: DVec3, b: DVec3, c: DVec3, d: DVec3) -> f64 {
    let (ab, ac, ad) = (b - a, c - a, d - a);
    let (n3, n2, n1) = (ac.cross(ab), ab.cross(ad), ad.cross(ac));
    let volume = -ad.dot(n3);
    let n0 = -(n1 + n2 + n3);
    let squares = n0.length_squared() * n1.length_squared();
    let others = n2.length_squared() * n3.length_squared();
    if volume <= 0.0 || squares * others <= 0.0 {
        return -2.0;
    }
    let [n0, n1, n2, n3] = [n0, n1, n2, n3].map(|n| n / n.length());
    let d = [n0.dot(n1), n0.dot(n2), n0.dot(n3), n1.dot(n2), n1.dot(n3), n2.dot(n3)];
    let low = d.iter().fold(1.0, |m: f64, &x| m.min(x));
    let high = d.iter().fold(-1.0, |m: f64, &x| m.max(x));
    low.min(0.1 - high)
}

/// The score of a smallest dihedral angle given in degrees.
pub fn angle_score(degrees: f64) -> f64 {
    -degrees.to_radians().cos()
}

/// Tetrahedra under change.
pub struct Complex {
    /// Vertex positions.
    pub points: Vec<DVec3>,
    /// Vertices of each tetrahedron; removed ones are skipped by [`Complex::alive`].
    pub tets: Vec<[u32; 4]>,
    stars: Vec<Vec<u32>>,
    free: Vec<u32>,
    period: Option<f64>,
}

/// The tetrahedra around an edge, in order.
pub struct Ring {
    /// Their numbers.
    pub tets: Vec<u32>,
    /// The vertices opposite the edge; one more than tetrahedra if the edge is on the boundary.
    pub link: Vec<u32>,
    /// Whether the edge is on the boundary.
    pub open: bool,
}

impl Complex {
    /// Takes over a mesh. On a torus, give its period; no tetrahedron may be wider than half of it.
    pub fn new(points: Vec<DVec3>, tets: Vec<[u32; 4]>, period: Option<f64>) -> Self {
        let mut stars = vec![Vec::with_capacity(24); points.len()];
        for (t, tet) in tets.iter().enumerate() {
            for &v in tet {
                stars[v as usize].push(t as u32);
            }
        }
        Self { points, tets, stars, free: Vec::new(), period }
    }

    /// Whether tetrahedron `t` still exists.
    pub fn alive(&self, t: u32) -> bool {
        self.tets[t as usize][0] != u32::MAX
    }

    /// The numbers of all tetrahedra that exist.
    pub fn living(&self) -> impl Iterator<Item = u32> + '_ {
        (0..self.tets.len() as u32).filter(|&t| self.alive(t))
    }

    /// The tetrahedra around a vertex.
    pub fn star(&self, v: u32) -> &[u32] {
        &self.stars[v as usize]
    }

    /// Position of `v`, on a torus the image nearest to `anchor`.
    pub fn near(&self, anchor: DVec3, v: u32) -> DVec3 {
        let p = self.points[v as usize];
        self.period.map_or(p, |l| p - ((p - anchor) / l).round() * l)
    }

    /// Corners of a tetrahedron given by vertices, in one piece on a torus.
    pub fn corners(&self, tet: [u32; 4]) -> [DVec3; 4] {
        let a = self.points[tet[0] as usize];
        [a, self.near(a, tet[1]), self.near(a, tet[2]), self.near(a, tet[3])]
    }

    /// Quality of a tetrahedron given by vertices.
    pub fn score(&self, tet: [u32; 4]) -> f64 {
        let [a, b, c, d] = self.corners(tet);
        score(a, b, c, d)
    }

    /// Lowest quality among some tetrahedra.
    pub fn worst(&self, tets: &[u32]) -> f64 {
        tets.iter().fold(1.0, |m: f64, &t| m.min(self.score(self.tets[t as usize])))
    }

    /// Vertices that share a tetrahedron with `v`, ascending.
    pub fn neighbours(&self, v: u32) -> Vec<u32> {
        let mut all: Vec<u32> = self.star(v).iter().flat_map(|&t| self.tets[t as usize]).filter(|&w| w != v).collect();
        all.sort_unstable();
        all.dedup();
        all
    }

    /// The other tetrahedron at a face of `t`, if there is one.
    pub fn across(&self, t: u32, face: [u32; 3]) -> Option<u32> {
        let [a, b, c] = face;
        self.star(a)
            .iter()
            .copied()
            .find(|&s| s != t && self.tets[s as usize].contains(&b) && self.tets[s as usize].contains(&c))
    }

    /// All faces with one tetrahedron only, wound outwards. `outer` may rule out vertices that are known to be inside.
    pub fn boundary(&self, outer: impl Fn(u32) -> bool + Sync + Copy) -> Vec<[u32; 3]> {
        let faces = |t: u32| {
            let tet = self.tets[t as usize];
            FACES.into_iter().map(move |f| f.map(|k| tet[k]))
        };
        (0..self.tets.len() as u32)
            .into_par_iter()
            .with_min_len(1024)
            .filter(|&t| self.alive(t) && self.tets[t as usize].iter().filter(|&&v| outer(v)).count() > 2)
            .flat_map_iter(|t| faces(t).filter(move |f| f.iter().all(|&v| outer(v)) && self.across(t, *f).is_none()))
            .collect()
    }

    /// Whether no face would have more than two tetrahedra with `new` in the place of `old`. Where the mesh overlaps
    /// itself, as a thickened wall may, angles alone let flips make the same tetrahedron twice.
    pub fn conforms(&self, old: &[u32], new: &[[u32; 4]]) -> bool {
        new.iter().flat_map(|tet| FACES.map(|f| f.map(|k| tet[k]))).all(|[a, b, c]| {
            let stays = |&t: &u32| self.tets[t as usize].contains(&c) && !old.contains(&t);
            let comes = new.iter().filter(|tet| [a, b, c].iter().all(|v| tet.contains(v))).count();
            self.around(a, b).filter(stays).count() + comes <= 2
        })
    }

    /// Swaps tetrahedra for others.
    pub fn replace(&mut self, old: &[u32], new: &[[u32; 4]]) {
        for &t in old {
            self.remove(t);
        }
        for &tet in new {
            let t = match self.free.pop() {
                Some(t) => {
                    self.tets[t as usize] = tet;
                    t
                }
                None => {
                    self.tets.push(tet);
                    self.tets.len() as u32 - 1
                }
            };
            for v in tet {
                self.stars[v as usize].push(t);
            }
        }
    }

    /// Removes one tetrahedron, leaving a hole.
    pub fn remove(&mut self, t: u32) {
        for v in self.tets[t as usize] {
            let star = &mut self.stars[v as usize];
            let at = star.iter().position(|&s| s == t).expect("a tetrahedron is listed at its vertices");
            star.swap_remove(at);
        }
        self.tets[t as usize] = DEAD;
        self.free.push(t);
    }

    /// Adds a vertex that belongs to nothing yet.
    pub fn add_point(&mut self, p: DVec3) -> u32 {
        self.points.push(p);
        self.stars.push(Vec::with_capacity(16));
        self.points.len() as u32 - 1
    }

    /// Takes back the last [`Complex::add_point`]; the vertex must belong to nothing.
    pub fn drop_last_point(&mut self) {
        self.points.pop();
        self.stars.pop();
    }

    /// Tetrahedra that contain both vertices.
    pub fn around(&self, a: u32, b: u32) -> impl Iterator<Item = u32> + '_ {
        self.star(a).iter().copied().filter(move |&t| self.tets[t as usize].contains(&b))
    }

    /// The ring of an edge; `None` if there is no such edge, or it is too long or touches itself.
    pub fn ring(&self, a: u32, b: u32) -> Option<Ring> {
        let mut parts: Vec<(u32, u32, u32)> = Vec::with_capacity(RING);
        for t in self.around(a, b) {
            if parts.len() == RING {
                return None;
            }
            let (c, d) = opposite(self.tets[t as usize], a, b);
            parts.push((c, d, t));
        }
        let mut start = *parts.first()?;
        let mut open = false;
        for &part in &parts {
            if !parts.iter().any(|q| q.1 == part.0) {
                (start, open) = (part, true);
            }
        }
        let mut ring = Ring { tets: vec![start.2], link: vec![start.0, start.1], open };
        while ring.tets.len() < parts.len() {
            let end = *ring.link.last()?;
            let next = parts.iter().find(|q| q.0 == end && !ring.tets.contains(&q.2))?;
            ring.tets.push(next.2);
            ring.link.push(next.1);
        }
        if !open && ring.link.pop()? != ring.link[0] {
            return None;
        }
        Some(ring)
    }

    /// Edge removal (de l'Isle and George 1995; Klincsek's optimum): refills the ring around an edge without the edge.
    /// Done if the worst new tetrahedron is better than `floor`. An edge on the boundary is turned, where `allow`
    /// accepts the two vertices of the boundary edge that appears.
    pub fn remove_edge(&mut self, a: u32, b: u32, floor: Option<f64>, allow: impl Fn(&Self, &Ring) -> bool) -> bool {
        let Some(ring) = self.ring(a, b) else { return false };
        let m = ring.link.len();
        if m < 3 || (ring.open && !allow(self, &ring)) {
            return false;
        }
        if ring.open && self.around(ring.link[0], ring.link[m - 1]).next().is_some() {
            return false;
        }
        let floor = floor.unwrap_or_else(|| self.worst(&ring.tets) + 1e-9);
        let pa = self.points[a as usize];
        let pb = self.near(pa, b);
        let mut at = [DVec3::ZERO; RING + 1];
        for (p, &v) in at.iter_mut().zip(&ring.link) {
            *p = self.near(pa, v);
        }
        let mut best = [[(f64::NEG_INFINITY, 0usize); RING + 1]; RING + 1];
        for i in 0..m - 1 {
            best[i][i + 1] = (1.0, 0);
        }
        for width in 2..m {
            for i in 0..m - width {
                let j = i + width;
                for k in i + 1..j {
                    let parts = best[i][k].0.min(best[k][j].0);
                    if parts <= floor || parts <= best[i][j].0 {
                        continue;
                    }
                    let q = score(at[i], at[k], at[j], pb);
                    if q <= floor || q <= best[i][j].0 {
                        continue;
                    }
                    let q = q.min(score(at[i], at[j], at[k], pa)).min(parts);
                    if q > floor && q > best[i][j].0 {
                        best[i][j] = (q, k);
                    }
                }
            }
        }
        if best[0][m - 1].0 <= floor {
            return false;
        }
        let mut new = Vec::with_capacity(2 * m);
        let mut stack = vec![(0, m - 1)];
        while let Some((i, j)) = stack.pop() {
            if j == i + 1 {
                continue;
            }
            let k = best[i][j].1;
            let [x, y, z] = [i, k, j].map(|n| ring.link[n]);
            new.extend([[x, y, z, b], [x, z, y, a]]);
            stack.extend([(i, k), (k, j)]);
        }
        if !self.conforms(&ring.tets, &new) {
            return false;
        }
        self.replace(&ring.tets, &new);
        true
    }

    /// Puts an edge through an inner face (the 2-3 flip), if that beats `floor` or the present worst.
    pub fn remove_face(&mut self, t: u32, k: usize, floor: Option<f64>) -> bool {
        let tet = self.tets[t as usize];
        let [p, q, r] = FACES[k].map(|i| tet[i]);
        let Some(s) = self.across(t, [p, q, r]) else { return false };
        let inner = tet[k];
        let outer = self.tets[s as usize].into_iter().find(|v| ![p, q, r].contains(v)).unwrap_or(inner);
        if outer == inner {
            return false;
        }
        let floor = floor.unwrap_or_else(|| self.worst(&[t, s]) + 1e-9);
        let new = [[inner, outer, p, q], [inner, outer, q, r], [inner, outer, r, p]];
        if new.iter().any(|&n| self.score(n) <= floor) || !self.conforms(&[t, s], &new) {
            return false;
        }
        self.replace(&[t, s], &new);
        true
    }

    /// Moves vertex `a` into `b`, if every tetrahedron that stays beats `floor`. The caller has checked that the
    /// boundary allows it.
    pub fn contract(&mut self, a: u32, b: u32, floor: f64) -> bool {
        let mut new = Vec::with_capacity(24);
        for &t in self.star(a) {
            let tet = self.tets[t as usize];
            if tet.contains(&b) {
                continue;
            }
            let moved = tet.map(|v| if v == a { b } else { v });
            if self.score(moved) <= floor {
                return false;
            }
            new.push(moved);
        }
        let old = self.star(a).to_vec();
        if !self.conforms(&old, &new) {
            return false;
        }
        self.replace(&old, &new);
        true
    }

    /// Puts a vertex on an edge, at `p`, if every new tetrahedron beats `floor`.
    pub fn split(&mut self, a: u32, b: u32, p: DVec3, floor: f64) -> Option<u32> {
        let old: Vec<u32> = self.around(a, b).collect();
        let mut new = Vec::with_capacity(2 * old.len());
        for &t in &old {
            let tet = self.tets[t as usize];
            for end in [a, b] {
                let half = tet.map(|v| if v == end { u32::MAX } else { v });
                let [w, x, y, z] = half.map(|v| if v == u32::MAX { p } else { self.points[v as usize] });
                if score(w, x, y, z) <= floor {
                    return None;
                }
                new.push(half);
            }
        }
        if old.is_empty() {
            return None;
        }
        let v = self.add_point(p);
        for tet in &mut new {
            *tet = tet.map(|w| if w == u32::MAX { v } else { w });
        }
        self.replace(&old, &new);
        Some(v)
    }

    /// The tetrahedra of a vertex as triangles that it looks at from the inside: `(v, x, y, z)` is positive.
    pub fn view(&self, v: u32) -> Vec<[DVec3; 3]> {
        let p = self.points[v as usize];
        self.star(v)
            .iter()
            .map(|&t| {
                let tet = self.tets[t as usize];
                let k = tet.iter().position(|&w| w == v).unwrap_or(0);
                FACES[k].map(|i| self.near(p, tet[i]))
            })
            .collect()
    }
}

/// Worst quality of a vertex at `p` that sees these triangles; may stop early once it is below `enough`.
pub fn worst_from(p: DVec3, view: &[[DVec3; 3]], enough: f64) -> f64 {
    let mut worst = 1.0;
    for &[x, y, z] in view {
        let q = score(p, x, y, z);
        if q < worst {
            worst = q;
            if q <= enough {
                break;
            }
        }
    }
    worst
}

/// The other two vertices of a tetrahedron, so that `(a, b, c, d)` is positive.
fn opposite(tet: [u32; 4], a: u32, b: u32) -> (u32, u32) {
    const EVEN: [[usize; 4]; 12] = [
        [0, 1, 2, 3],
        [0, 2, 3, 1],
        [0, 3, 1, 2],
        [1, 0, 3, 2],
        [1, 2, 0, 3],
        [1, 3, 2, 0],
        [2, 0, 1, 3],
        [2, 1, 3, 0],
        [2, 3, 0, 1],
        [3, 0, 2, 1],
        [3, 1, 0, 2],
        [3, 2, 1, 0],
    ];
    EVEN.iter().find(|e| tet[e[0]] == a && tet[e[1]] == b).map_or((a, b), |e| (tet[e[2]], tet[e[3]]))
}
