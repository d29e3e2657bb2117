//! Check and repair of triangle meshes before they are turned into solids.
//!
//! [`prepare`] does what can be done without guessing: it merges vertices stored twice, drops triangles without area,
//! closes small holes and winds every piece outwards (cavities inwards), and says each in a sentence. What is left is an
//! error with its place and its cure. [`check`] looks without touching.
//!
//! Order matters: topology is read after merging (an STL is a soup of single triangles), holes after the winding is made
//! consistent (borders are directed), and inside or outside only of closed pieces.

mod bvh;
mod edges;
mod error;
mod holes;
mod intersect;
mod nesting;
mod overlap;
pub(crate) mod predicates;
mod tidy;
mod winding;

#[cfg(test)]
mod tests;

use std::collections::BTreeSet;

use glam::DVec3;

use edges::Edges;
pub use error::SurfaceError;
use error::suggested_wall;
pub(crate) use error::{counted, place, short};
pub use holes::Hole;
use holes::Limits;

use crate::TriMesh;

/// How [`prepare`] repairs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PrepareOptions {
    /// Vertices this close count as one, as a fraction of the diagonal of the bounding box; 0 to 1e-3. The same length
    /// is the height of triangles without area.
    pub merge_within: f64,
    /// Holes no wider than this fraction of the diagonal are closed; 0 to 1.
    pub fill_below: f64,
    /// The surface will be thickened to a wall: it may be open, one-sided, flat or cross itself. Holes stay.
    pub for_shell: bool,
}

impl Default for PrepareOptions {
    fn default() -> Self {
        Self { merge_within: 1e-9, fill_below: 0.05, for_shell: false }
    }
}

/// What [`check`] found. Counts of what [`prepare`] would repair, and the errors it would not.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Findings {
    /// Vertices within 1e-9 of the size of another one.
    pub duplicate_vertices: usize,
    /// Vertices that no triangle uses.
    pub unused_vertices: usize,
    /// Triangles with a repeated corner or without area.
    pub degenerate_triangles: usize,
    /// Triangles over the same three vertices as another one.
    pub duplicate_triangles: usize,
    /// Triangles wound against the majority of their piece.
    pub turned_triangles: usize,
    /// Border loops, small ones that would be closed included. Vertex numbers are those after merging.
    pub holes: Vec<Hole>,
    /// Pieces connected by edges.
    pub pieces: usize,
    /// Closed pieces that are inside out: solids with negative, cavities with positive volume.
    pub inside_out_pieces: usize,
    /// What keeps the surface from becoming a solid, an open border of any size included.
    pub errors: Vec<SurfaceError>,
}

impl Findings {
    /// Is the surface closed, manifold, outward-wound and free of crossings, with nothing to repair?
    pub fn is_clean(&self) -> bool {
        *self == Self { pieces: self.pieces, ..Self::default() } && self.pieces > 0
    }
}

/// Looks for every fault of a surface without changing it. Stops early only at indices or coordinates that can't be used.
pub fn check(mesh: &TriMesh) -> Findings {
    let options = PrepareOptions::default();
    let mut found = Findings::default();
    if let Err(error) = usable(mesh) {
        found.errors.push(error);
        return found;
    }
    let mut mesh = mesh.clone();
    let mut ids: Vec<u32> = (0..mesh.triangles.len() as u32).collect();
    let size = size(&mesh);
    let within = options.merge_within * size;
    let tidied = tidy::tidy(&mut mesh, &mut ids, within);
    found.duplicate_vertices = tidied.merged_vertices;
    found.unused_vertices = tidied.unused_vertices;
    found.degenerate_triangles = tidied.degenerate_triangles;
    found.duplicate_triangles = tidied.duplicate_triangles;
    if mesh.triangles.is_empty() {
        found.errors.push(SurfaceError::Empty);
        return found;
    }
    let edges = Edges::of(&mesh);
    found.errors.extend(edges.manifold(&mesh).err());
    let winding = winding::unify(&mut mesh, &edges);
    found.turned_triangles = winding.turned;
    found.pieces = winding.pieces;
    found.errors.extend(winding.one_sided.map(|at| SurfaceError::NonOrientable { at, wall: suggested_wall(size) }));
    let edges = Edges::of(&mesh);
    found.holes = holes::holes(&mesh, &edges);
    found.errors.extend(open(&found.holes, size));
    if found.errors.is_empty() {
        match nesting::turn_inside_out_pieces(&mut mesh, &winding.piece, winding.pieces, within) {
            Ok(turned) => found.inside_out_pieces = turned.len(),
            Err(error) => found.errors.push(error),
        }
    }
    found.errors.extend(crossing(&mesh, &ids, within));
    found
}

/// Repairs a surface so that it bounds a solid: closed, manifold, outward-wound, free of crossings. Returns it with one
/// sentence for each kind of repair; a surface without faults comes back bit for bit.
///
/// # Errors
/// What it can't repair, see [`SurfaceError`]; the first in the order of that list.
pub fn prepare(mut mesh: TriMesh, options: PrepareOptions) -> Result<(TriMesh, Vec<String>), SurfaceError> {
    usable(&mesh)?;
    let mut said = Vec::new();
    let given = mesh.triangles.len() as u32;
    let mut ids: Vec<u32> = (0..given).collect();
    let size = size(&mesh);
    let within = options.merge_within * size;
    let tidied = tidy::tidy(&mut mesh, &mut ids, within);
    for (count, one, many, done) in [
        (tidied.merged_vertices, "vertex", "vertices", "stored more than once: merged"),
        (tidied.degenerate_triangles, "triangle", "triangles", "without area: removed"),
        (tidied.duplicate_triangles, "triangle", "triangles", "stored more than once: removed"),
        (tidied.unused_vertices, "vertex", "vertices", "in no triangle: removed"),
    ] {
        if count > 0 {
            said.push(format!("{count} {} {done}.", if count == 1 { one } else { many }));
        }
    }
    if mesh.triangles.is_empty() {
        return Err(SurfaceError::Empty);
    }
    let mut edges = Edges::of(&mesh);
    edges.manifold(&mesh)?;
    let mut winding = winding::unify(&mut mesh, &edges);
    if winding.turned > 0 {
        said.push(format!("{} wound against the neighbours: turned.", counted(winding.turned, "triangle")));
    }
    if options.for_shell {
        return Ok((mesh, said));
    }
    if let Some(at) = winding.one_sided {
        return Err(SurfaceError::NonOrientable { at, wall: suggested_wall(size) });
    }
    edges = Edges::of(&mesh);
    let holes = holes::holes(&mesh, &edges);
    if !holes.is_empty() {
        let (filled, left) = close(&mut mesh, &edges, &winding.piece, holes, options.fill_below * size, within);
        if let Some(error) = open(&left, size) {
            return Err(error);
        }
        if let Some(widest) = widest(&filled) {
            let (holes, at, across) = (counted(filled.len(), "hole"), place(widest.at), short(widest.across));
            said.push(format!("{holes} closed, the widest {across} across near {at}."));
        }
        ids.extend(given..given + (mesh.triangles.len() - ids.len()) as u32);
        tidy::dissolve_slivers(&mut mesh, &mut ids, within);
        edges = Edges::of(&mesh);
        edges.manifold(&mesh)?;
        winding = winding::unify(&mut mesh, &edges);
    }
    let turned = nesting::turn_inside_out_pieces(&mut mesh, &winding.piece, winding.pieces, within)?;
    for (is_cavity, what) in [(false, "inside-out piece"), (true, "cavity wound like a solid")] {
        let places: Vec<_> = turned.iter().filter(|(_, cavity)| *cavity == is_cavity).collect();
        if let Some((at, _)) = places.first() {
            let at = place(*at);
            said.push(match places.len() {
                1 => format!("1 {what} near {at}: turned over."),
                n => format!("{n} times a {what}, the first near {at}: turned over."),
            });
        }
    }
    match crossing(&mesh, &ids, within) {
        Some(error) => Err(error),
        None => Ok((mesh, said)),
    }
}

/// Closes the holes no wider than `widest`, and slits; returns those closed and the others. `pieces` has the piece of each
/// triangle.
fn close(
    mesh: &mut TriMesh,
    edges: &Edges,
    pieces: &[u32],
    holes: Vec<Hole>,
    widest: f64,
    within: f64,
) -> (Vec<Hole>, Vec<Hole>) {
    let mut areas = vec![0.0; pieces.len()];
    for (t, &piece) in pieces.iter().enumerate() {
        let [a, b, c] = mesh.corners(t);
        areas[piece as usize] += (b - a).cross(c - a).length() / 2.0;
    }
    let mut added = BTreeSet::new();
    holes.into_iter().partition(|hole| {
        let beside = edges.on(hole.vertices[0], hole.vertices[1])[0].triangle;
        let piece = areas[pieces[beside as usize] as usize];
        let taken = |[u, v]: [u32; 2]| !edges.on(u, v).is_empty() || added.contains(&[u.min(v), u.max(v)]);
        let before = mesh.triangles.len();
        let filled = holes::fill(mesh, taken, hole, Limits { widest, within, piece });
        for &[a, b, c] in &mesh.triangles[before..] {
            added.extend([[a.min(b), a.max(b)], [b.min(c), b.max(c)], [c.min(a), c.max(a)]]);
        }
        filled
    })
}

/// Refuses what no later stage could even read.
fn usable(mesh: &TriMesh) -> Result<(), SurfaceError> {
    for (vertex, p) in mesh.vertices.iter().enumerate() {
        let bad = |x: &f64| !x.is_finite() || x.abs() > 1e30;
        if let Some(coordinate) = p.to_array().into_iter().find(bad) {
            return Err(SurfaceError::NotFinite { vertex, coordinate });
        }
    }
    let vertices = mesh.vertices.len();
    for (triangle, corners) in mesh.triangles.iter().enumerate() {
        if let Some(&index) = corners.iter().find(|&&v| v as usize >= vertices) {
            return Err(SurfaceError::IndexOutOfRange { triangle, index, vertices });
        }
    }
    if mesh.triangles.is_empty() { Err(SurfaceError::Empty) } else { Ok(()) }
}

/// Diagonal of the bounding box of the vertices in use [m].
fn size(mesh: &TriMesh) -> f64 {
    let mut corners = mesh.triangles.iter().flatten().map(|&v| mesh.vertices[v as usize]);
    let Some(first) = corners.next() else { return 0.0 };
    let (lo, hi) = corners.fold((first, first), |(lo, hi), p| (lo.min(p), hi.max(p)));
    hi.distance(lo)
}

fn widest(holes: &[Hole]) -> Option<&Hole> {
    holes.iter().reduce(|a, b| if b.across > a.across { b } else { a })
}

fn open(holes: &[Hole], size: f64) -> Option<SurfaceError> {
    let widest = widest(holes)?;
    Some(SurfaceError::Open {
        edges: holes.iter().map(|h| h.vertices.len()).sum(),
        loops: holes.len(),
        at: widest.at,
        across: widest.across,
        wall: suggested_wall(size),
    })
}

/// How many edges have no partner that runs the other way, and the middle of the first [m].
pub(crate) fn unpaired(mesh: &TriMesh) -> (usize, DVec3) {
    let edges = Edges::of(mesh);
    let alone = |sides: &&[edges::Side]| sides.iter().map(|s| if s.forward { 1 } else { -1 }).sum::<i32>() != 0;
    let mut found = edges.iter().filter(alone).map(|sides| {
        let [a, b] = sides[0].edge.map(|v| mesh.vertices[v as usize]);
        (a + b) / 2.0
    });
    let first = found.next();
    (usize::from(first.is_some()) + found.count(), first.unwrap_or_default())
}

fn crossing(mesh: &TriMesh, ids: &[u32], within: f64) -> Option<SurfaceError> {
    let found = intersect::crossings(mesh, within)?;
    let first = found.first.map(|t| ids.get(t as usize).copied().unwrap_or(t));
    Some(SurfaceError::SelfIntersecting { pairs: found.pairs, first, at: found.at })
}
