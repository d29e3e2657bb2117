//! Why a surface cannot become a solid: where it fails and what would help.

use glam::DVec3;
use thiserror::Error;

/// A fault that [`prepare`](super::prepare) does not repair. Triangle numbers count from 0 in the mesh as it was given;
/// numbers past its last triangle are fillings of holes. Places and lengths are in metres.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum SurfaceError {
    /// No triangles, or only degenerate ones.
    #[error("the surface has no triangles with an area; check that the file holds a mesh and not points or lines")]
    Empty,
    /// A coordinate is NaN, infinite or beyond 1e30 m.
    #[error("vertex {vertex} has a coordinate that is not a usable number ({coordinate}); mend or re-export the mesh")]
    NotFinite {
        /// Index of the first such vertex, from 0.
        vertex: usize,
        /// Its first bad coordinate.
        coordinate: f64,
    },
    /// A triangle refers to a vertex that does not exist.
    #[error(
        "triangle {triangle} uses vertex {index}, but there are only {vertices} vertices, counted from 0; re-export the \
         mesh or check that its indices start at 0"
    )]
    IndexOutOfRange {
        /// The first such triangle.
        triangle: usize,
        /// The index it asks for.
        index: u32,
        /// Number of vertices.
        vertices: usize,
    },
    /// More than two triangles meet at an edge.
    #[error(
        "{triangles} triangles meet at one edge near {}, the first of {} with more than two; remove inner walls or part \
         the pieces there",
        place(*at), counted(*edges, "edge")
    )]
    NonManifold {
        /// Number of such edges.
        edges: usize,
        /// Number of triangles at the first of them.
        triangles: usize,
        /// Middle of the first of them.
        at: DVec3,
    },
    /// The surface is one-sided, like a Möbius strip.
    #[error(
        "the surface has no inside: followed around near {}, its front becomes its back; give `shell = {wall}` to make \
         it a wall",
        place(*at)
    )]
    NonOrientable {
        /// Middle of an edge where front and back meet.
        at: DVec3,
        /// A wall thickness to begin with: 2 % of the size.
        wall: f64,
    },
    /// The surface has borders too long to be closed without asking.
    #[error(
        "the surface is open along {} in {}, the widest near {} and {} across; close it or give `shell = {wall}` to \
         make it a wall",
        counted(*edges, "edge"), counted(*loops, "loop"), place(*at), short(*across)
    )]
    Open {
        /// Number of edges with one triangle only.
        edges: usize,
        /// Number of loops they form.
        loops: usize,
        /// Centre of the widest loop.
        at: DVec3,
        /// Diagonal of its bounding box.
        across: f64,
        /// A wall thickness to begin with: 2 % of the size.
        wall: f64,
    },
    /// A closed piece encloses nothing.
    #[error(
        "the piece of {} near {} is flat and encloses no volume; remove it or give `shell = {wall}` \
         to make it a wall",
        counted(*triangles, "triangle"), place(*at)
    )]
    ZeroVolume {
        /// Number of triangles of the piece.
        triangles: usize,
        /// Centre of its bounding box.
        at: DVec3,
        /// A wall thickness to begin with: 2 % of the size.
        wall: f64,
    },
    /// The surface crosses or touches itself.
    #[error(
        "the surface cuts itself: triangles {} and {} meet near {}, the first of {}; part them or unite the \
         pieces (boolean union, remesh) in the program the mesh comes from",
        first[0], first[1], place(*at), counted(*pairs, "pair")
    )]
    SelfIntersecting {
        /// Number of pairs of triangles that meet beyond common vertices.
        pairs: usize,
        /// The first such pair.
        first: [u32; 2],
        /// A point where the first pair meets.
        at: DVec3,
    },
}

/// `1 edge`, `2 edges`.
pub(crate) fn counted(n: usize, what: &str) -> String {
    format!("{n} {what}{}", if n == 1 { "" } else { "s" })
}

/// A length with four significant digits.
pub(crate) fn short(x: f64) -> f64 {
    if x == 0.0 || !x.is_finite() {
        return x;
    }
    significant(x, 4)
}

/// A round wall thickness of about 2 % of `size` to suggest to the user.
pub(super) fn suggested_wall(size: f64) -> f64 {
    if size > 0.0 { significant(0.02 * size, 1) } else { 0.02 }
}

/// A point as `(x, y, z)` with four significant digits each.
pub(crate) fn place(p: DVec3) -> String {
    format!("({}, {}, {})", short(p.x), short(p.y), short(p.z))
}

fn significant(x: f64, digits: usize) -> f64 {
    format!("{x:.*e}", digits - 1).parse().unwrap_or(x)
}
