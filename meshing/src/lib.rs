//! Meshes in memory: tetrahedra from surfaces, horizon families, and the embedded surface that splits along cracks.

pub mod crack;
pub mod distance;
pub mod family;
pub mod lattice;
pub mod order;
pub mod quality;
pub mod shapes;
pub mod skin;
pub mod surface;
pub mod tetmesh;
pub mod tetrahedralise;
pub mod trimesh;

pub use tetmesh::TetMesh;
pub use trimesh::TriMesh;
