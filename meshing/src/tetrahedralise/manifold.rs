//! Making the boundary a surface: no pinched vertices or edges, no crumbs.
//!
//! Where pieces of a mesh hang together by a vertex or an edge only, small pieces go and larger ones get a vertex of
//! their own. Removing a tetrahedron never makes an angle worse, so this may run after everything else.

use super::complex::{angle_score, score};
use super::improve::Body;
use crate::tetmesh::FACES;
use glam::DVec3;

/// Pieces of at most this many tetrahedra at a pinched vertex are removed.
const CRUMB: usize = 2;
/// Separate parts of fewer tetrahedra than this are removed.
const ISLAND: usize = 12;

impl Body<'_> {
    /// Removes pinches and crumbs; with `thicken`, walls that are pinched get thicker instead. Returns how many vertices were treated.
    pub fn unpinch(&mut self, thicken: bool) -> usize {
        let mut treated = self.drop_islands();
        for _ in 0..20 {
            let bad: Vec<u32> =
                (0..self.dim.len() as u32).filter(|&v| self.dim[v as usize] < 3 && self.pinched(v)).collect();
            if bad.is_empty() {
                break;
            }
            treated += bad.len();
            for v in bad {
                if self.pinched(v) {
                    self.part(v, thicken);
                }
            }
            self.settle();
        }
        treated + self.drop_islands()
    }

    /// Whether the boundary faces at `v` form more than one fan.
    fn pinched(&self, v: u32) -> bool {
        let fan: Vec<(u32, u32)> = self
            .outer_faces(v)
            .into_iter()
            .map(|f| {
                let k = f.iter().position(|&w| w == v).unwrap_or(0);
                (f[(k + 1) % 3], f[(k + 2) % 3])
            })
            .collect();
        let Some(&(start, mut at)) = fan.first() else { return false };
        for step in 1..fan.len() {
            let mut next = fan.iter().filter(|f| f.0 == at);
            let (one, more) = (next.next(), next.next());
            match (one, more) {
                (Some(f), None) if at != start => at = f.1,
                _ => return step < fan.len(),
            }
        }
        at != start
    }

    /// Separates the pieces of a star that share no face.
    fn part(&mut self, v: u32, thicken: bool) {
        let mut pieces: Vec<Vec<u32>> = Vec::new();
        let mut left = self.mesh.star(v).to_vec();
        left.sort_unstable();
        while let Some(t) = left.pop() {
            let mut piece = vec![t];
            let mut at = 0;
            while at < piece.len() {
                let s = piece[at];
                let tet = self.mesh.tets[s as usize];
                for f in FACES.map(|f| f.map(|k| tet[k])) {
                    if f.contains(&v)
                        && let Some(n) = self.mesh.across(s, f)
                        && let Some(k) = left.iter().position(|&x| x == n)
                    {
                        piece.push(left.swap_remove(k));
                    }
                }
                at += 1;
            }
            pieces.push(piece);
        }
        pieces.sort_by_key(|p| std::cmp::Reverse(p.len()));
        if let [only] = &pieces[..] {
            if thicken && self.thicken(v) {
                return;
            }
            // a ring closed around a hole: open it at the tetrahedron that most of the boundary touches
            let open = |t: &u32| {
                let tet = self.mesh.tets[*t as usize];
                FACES.iter().filter(|f| self.mesh.across(*t, f.map(|k| tet[k])).is_none()).count()
            };
            if let Some(&t) = only.iter().max_by_key(|t| (open(t), std::cmp::Reverse(**t))) {
                self.mesh.remove(t);
            }
            return;
        }
        for piece in &pieces[1..] {
            if piece.len() <= CRUMB {
                piece.iter().for_each(|&t| self.mesh.remove(t));
                continue;
            }
            let twin = self.mesh.add_point(self.mesh.points[v as usize]);
            self.dim.push(self.dim[v as usize]);
            let new: Vec<[u32; 4]> =
                piece.iter().map(|&t| self.mesh.tets[t as usize].map(|w| if w == v { twin } else { w })).collect();
            self.mesh.replace(piece, &new);
        }
    }

    /// Where two sides of a wall meet in `v`: puts a new vertex before the smaller of its fans of boundary faces.
    fn thicken(&mut self, v: u32) -> bool {
        let mut left = self.outer_faces(v);
        let mut fans: Vec<Vec<[u32; 3]>> = Vec::new();
        while let Some(face) = left.pop() {
            let mut fan = vec![face];
            let mut at = 0;
            while at < fan.len() {
                let from = fan[at];
                let shares = |f: &[u32; 3]| f.iter().filter(|w| from.contains(w)).count() == 2;
                while let Some(k) = left.iter().position(shares) {
                    fan.push(left.swap_remove(k));
                }
                at += 1;
            }
            fans.push(fan);
        }
        fans.sort_by_key(|f| f.len());
        let start = self.mesh.points[v as usize];
        for fan in fans {
            let corners = |f: &[u32; 3]| f.map(|w| self.mesh.points[w as usize]);
            let normal = |[a, b, c]: [DVec3; 3]| (b - a).cross(c - a).normalize_or_zero();
            let up = fan.iter().map(|f| normal(corners(f))).sum::<DVec3>().normalize_or_zero();
            let worst = |height: f64| {
                let top = start + up * height * self.size;
                fan.iter().map(corners).fold(1.0, |m: f64, [a, b, c]| m.min(score(a, b, c, top)))
            };
            let outside =
                |h: &f64| self.solid.signed_distance(start + up * *h * self.size, self.size) > 0.25 * self.size;
            let best = [0.6, 0.45, 0.3, 0.2, 0.1]
                .into_iter()
                .filter(|h| !outside(h))
                .max_by(|&x, &y| worst(x).total_cmp(&worst(y)));
            if let Some(height) = best.filter(|&h| worst(h) > angle_score(2.0)) {
                let top = self.mesh.add_point(start + up * height * self.size);
                self.dim.push(2);
                let new: Vec<[u32; 4]> = fan.iter().map(|&[a, b, c]| [a, b, c, top]).collect();
                self.mesh.replace(&[], &new);
                return true;
            }
        }
        false
    }

    /// Removes separate parts that the solid hasn't got (the larger ones stay), so that what was torn off grows again from the
    /// rest; where their number isn't known, parts that are too small to mean anything.
    fn drop_islands(&mut self) -> usize {
        let mut part = vec![u32::MAX; self.mesh.tets.len()];
        let mut sizes: Vec<usize> = Vec::new();
        for t in 0..part.len() as u32 {
            if !self.mesh.alive(t) || part[t as usize] != u32::MAX {
                continue;
            }
            let number = sizes.len() as u32;
            sizes.push(0);
            part[t as usize] = number;
            let mut stack = vec![t];
            while let Some(s) = stack.pop() {
                sizes[number as usize] += 1;
                let tet = self.mesh.tets[s as usize];
                for f in FACES {
                    if let Some(n) = self.mesh.across(s, f.map(|k| tet[k]))
                        && part[n as usize] == u32::MAX
                    {
                        part[n as usize] = number;
                        stack.push(n);
                    }
                }
            }
        }
        let mut by_size: Vec<usize> = (0..sizes.len()).collect();
        by_size.sort_by_key(|&k| std::cmp::Reverse(sizes[k]));
        let mut keep = vec![false; sizes.len()];
        for &k in by_size.iter().take(self.solid.parts().unwrap_or(usize::MAX)) {
            keep[k] = sizes[k] >= ISLAND || k == by_size[0];
        }
        let mut gone = 0;
        for t in 0..part.len() as u32 {
            if self.mesh.alive(t) && !keep[part[t as usize] as usize] {
                self.mesh.remove(t);
                gone += 1;
            }
        }
        gone
    }
}
