//! Families and the embedded surface. All threads.

use criterion::Criterion;
use fissure_bench::{Lattice, SPACING};
use fissure_io::frames::Frame;
use fissure_meshing::crack::CrackMesh;
use fissure_meshing::family::{Clip, families as find};
use fissure_meshing::order::morton_order;
use fissure_meshing::shapes::{cubic_lattice, tet_box};
use fissure_meshing::skin::{Follow, Particles, Skin};
use fissure_meshing::{TetMesh, TriMesh};
use glam::DVec3;

use crate::{Per, group, measure, timed};

const EDGE: usize = 50;
/// Cells along each edge of a box of tetrahedra, six a cell.
const CELLS: usize = 24;
const TETS: Per = Per { unit: "tetrahedron", count: 6 * (CELLS * CELLS * CELLS) as u64 };

fn bytes(families: &fissure_engine::Families) -> usize {
    4 * (families.offsets.len() + families.neighbours.len())
}

/// Who is near whom: a lattice, and tetrahedra whose bonds are clipped at their surface and at a pre-cut.
pub fn families(c: &mut Criterion) {
    let mut group = group(c, "families");
    let lattice = Lattice { edge: EDGE as i32, ..Lattice::default() };
    let mut points: Option<Vec<DVec3>> = None;
    let per = Per { unit: "directed bond", count: lattice.directed() };
    measure(&mut group, "families of a lattice", per, || {
        let points = points.get_or_insert_with(|| {
            let points = cubic_lattice([EDGE; 3], SPACING);
            morton_order(&points).into_iter().map(|i| points[i as usize]).collect()
        });
        let (time, found) = timed(|| find(points, lattice.horizon * SPACING, None).expect("families"));
        (time, Some(bytes(&found) as f64 / lattice.directed() as f64))
    });
    let mut mesh: Option<TetMesh> = None;
    measure(&mut group, "families of tetrahedra, clipped", TETS, || {
        let mesh = mesh.get_or_insert_with(tetrahedra);
        let points: Vec<DVec3> = (0..mesh.tets.len()).map(|t| mesh.barycentre(t)).collect();
        let corners = [(-0.1, -1.0), (-0.1, 0.0), (0.1, 0.0)].map(|(y, z)| DVec3::new(0.01, 5.0 * y, z));
        let cut = TriMesh { vertices: corners.to_vec(), triangles: vec![[0, 1, 2]] };
        let (time, found) = timed(|| {
            let clip = Clip::new(mesh, Some(&cut)).expect("a sound mesh");
            find(&points, 1.5 * mesh.mean_edge(), Some(&clip)).expect("families")
        });
        (time, Some(bytes(&found) as f64 / mesh.tets.len() as f64))
    });
}

/// A box of jittered tetrahedra in Morton order.
fn tetrahedra() -> TetMesh {
    let mesh = tet_box(DVec3::ONE, [CELLS; 3], 0.3, 1).expect("a box");
    let points: Vec<DVec3> = (0..mesh.tets.len()).map(|t| mesh.barycentre(t)).collect();
    let tets = morton_order(&points).into_iter().map(|t| mesh.tets[t as usize]).collect();
    TetMesh { tets, ..mesh }
}

/// The box, torn through the middle and turned, with what its surface needs.
pub struct Torn {
    crack: CrackMesh,
    skin: Skin,
    rest: Vec<DVec3>,
    position: Vec<DVec3>,
    mass: Vec<f64>,
}

impl Torn {
    pub const TETS: Per = TETS;

    pub fn new() -> Self {
        let mesh = tetrahedra();
        let rest: Vec<DVec3> = (0..mesh.tets.len()).map(|t| mesh.barycentre(t)).collect();
        let mass: Vec<f64> = (0..mesh.tets.len()).map(|t| mesh.volume(t)).collect();
        let mut crack = CrackMesh::new(&mesh).expect("a sound mesh");
        let left = |t: u32| rest[t as usize].x < 0.0;
        let pairs = (0..rest.len() as u32).flat_map(|t| crack.neighbours()[t as usize].map(|s| (t, s)));
        let torn: Vec<(u32, u32)> = pairs.filter(|&(t, s)| t < s && s != u32::MAX && left(t) != left(s)).collect();
        assert!(crack.cut(&torn) > 0, "the box has a middle");
        let turn = glam::DQuat::from_rotation_y(0.3);
        let position = rest.iter().map(|&x| turn * x * 1.01).collect();
        let skin = Skin::new(Follow::Affine, &crack, &rest, &mass);
        Self { crack, skin, rest, position, mass }
    }

    /// Moves the vertices, puts the surface together, and makes what a frame holds of it.
    pub fn frame(&mut self) -> Frame {
        let particles =
            Particles { rest: &self.rest, position: &self.position, velocity: &self.position, mass: &self.mass };
        self.skin.update(&self.crack, &particles);
        let surface = self.crack.surface();
        let at = |of: &[DVec3]| surface.vertices.iter().map(|&v| of[v as usize].as_vec3().into()).collect();
        let n = surface.vertices.len();
        Frame {
            positions: at(self.skin.positions()),
            velocity: at(self.skin.velocities()),
            normals: surface.normals(self.skin.positions()).iter().map(|n| n.as_vec3().into()).collect(),
            id: surface.vertices.iter().map(|&v| self.crack.origin()[v as usize]).collect(),
            damage: vec![0.0; n],
            stretch: vec![0.0; n],
            piece: vec![0; n],
            inside: surface.inside,
            triangles: surface.triangles,
            ..Frame::default()
        }
    }
}

/// The surface of a torn box follows its particles.
pub fn surface(c: &mut Criterion) {
    let mut group = group(c, "surface");
    let mut torn: Option<Torn> = None;
    measure(&mut group, "surface update", Torn::TETS, || {
        let torn = torn.get_or_insert_with(Torn::new);
        (timed(|| torn.frame()).0, None)
    });
}
