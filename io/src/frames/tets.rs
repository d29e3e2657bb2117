//! The tetrahedra of all bodies of bonds at one instant, for programs that look inside.

/// Tetrahedra whose vertices have split along the cracks. They are handed to exports while a run goes on, for only the run
/// knows where vertices inside are.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TetFrame {
    /// Where the vertices are (m).
    pub positions: Vec<[f32; 3]>,
    /// Velocities of the vertices (m/s).
    pub velocity: Vec<[f32; 3]>,
    /// Vertex numbers of each tetrahedron.
    pub tets: Vec<[u32; 4]>,
    /// Damage of each tetrahedron, 0 (whole) to 1 (every bond broken).
    pub damage: Vec<f32>,
    /// Number of each tetrahedron in its body's input.
    pub id: Vec<u32>,
    /// The fragment of each tetrahedron, under an id that lasts.
    pub piece: Vec<u32>,
    /// Number of the body of each tetrahedron in the scene, from 0.
    pub body: Vec<u32>,
    /// Simulated time (s).
    pub time: f64,
    /// Number of the frame in its run, from 0.
    pub number: u32,
}
