//! The last resort for flat tetrahedra: taking them away at the boundary, where that leaves a surface.
//!
//! What improvement could not mend lies at the boundary nearly always. A tetrahedron may go if it shows one face and the
//! vertex opposite is inside, or two faces and the edge between the others is inside: the boundary then stays a surface of the
//! same kind. Removing never makes an angle worse. More room for vertices is tried first.

use super::complex::angle_score;
use super::improve::Body;
use crate::tetmesh::FACES;

/// How far surface vertices may leave the surface at last, in element sizes.
const SLACK: [f64; 2] = [0.22, 0.3];

impl Body<'_> {
    /// Brings every angle above `degrees`, at the cost of the distance to the surface. Returns how many tetrahedra stay
    /// below.
    pub fn shave(&mut self, degrees: f64, seed: u64) -> usize {
        for slack in SLACK {
            if self.bad(angle_score(degrees)).is_empty() {
                return 0;
            }
            self.slack = slack;
            self.improve(degrees + 0.5, 6, seed);
        }
        for round in 0..4 {
            let bad = self.bad(angle_score(degrees));
            if bad.is_empty() {
                break;
            }
            for t in bad {
                if self.mesh.alive(t) && self.may_go(t) {
                    let tet = self.mesh.tets[t as usize];
                    self.mesh.remove(t);
                    for v in tet {
                        self.dim[v as usize] = self.dim[v as usize].min(2);
                    }
                }
            }
            self.unpinch(false);
            self.improve(degrees + 0.5, 3, seed ^ (round + 9));
        }
        self.bad(angle_score(degrees)).len()
    }

    /// Whether the boundary stays a surface of the same kind without tetrahedron `t`.
    fn may_go(&self, t: u32) -> bool {
        let tet = self.mesh.tets[t as usize];
        let shown: Vec<usize> = (0..4).filter(|&k| self.mesh.across(t, FACES[k].map(|i| tet[i])).is_none()).collect();
        match shown[..] {
            [k] => self.dim[tet[k] as usize] == 3,
            // faces k and l are opposite vertices k and l, so these two span the hidden edge
            [k, l] => self.mesh.ring(tet[k], tet[l]).is_some_and(|r| !r.open),
            [_, _, _] => true,
            _ => false,
        }
    }
}
