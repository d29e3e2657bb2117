//! The surface of all bodies at one time.

use super::{Simulation, colliders};
use crate::frames::Frame;

impl Simulation {
    /// The surfaces of the colliders at the present state, each vertex with the number of its collider as its piece; without
    /// planes, so it may be empty.
    pub fn collider_frame(&self, number: u32) -> Frame {
        colliders::frame(&self.world, number)
    }

    /// The frame `number` of the present state. Skins remember rotations, so which frames are made is part of a run;
    /// checkpoints keep that.
    pub fn frame(&mut self, number: u32) -> Frame {
        let mut frame = Frame { time: self.world.time, number, ..Frame::default() };
        let mut pieces = 0;
        (0..self.meshes.len()).for_each(|k| self.follow(k));
        for (body, embedded) in self.world.bodies.iter_mut().zip(&self.meshes) {
            embedded.moved(body, &self.world.particles, |moved| {
                let first = frame.positions.len() as u32;
                for (&v, &inside) in moved.surface.vertices.iter().zip(&moved.surface.inside) {
                    let v = v as usize;
                    frame.positions.push(moved.positions[v].as_vec3().into());
                    frame.velocity.push(moved.velocities[v].as_vec3().into());
                    frame.damage.push(moved.damage[v]);
                    frame.id.push(moved.origin[v]);
                    frame.inside.push(inside);
                    frame.piece.push(pieces + moved.piece[v]);
                }
                let normals = moved.surface.normals(moved.positions);
                frame.normals.extend(normals.iter().map(|n| <[f32; 3]>::from(n.as_vec3())));
                frame.triangles.extend(moved.surface.triangles.iter().map(|t| t.map(|v| first + v)));
                pieces += moved.fragments as u32;
            });
        }
        frame
    }
}
