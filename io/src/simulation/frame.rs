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
        for (body, embedded) in self.world.bodies.iter().zip(&self.meshes) {
            let damage = &self.world.particles.damage[body.range.clone()];
            let mesh = &embedded.mesh;
            let surface = mesh.surface();
            let (fragment, count) = mesh.fragments();
            let (places, speeds) = (embedded.skin.positions(), embedded.skin.velocities());
            let first = frame.positions.len() as u32;
            for (k, &v) in surface.vertices.iter().enumerate() {
                let around = mesh.tets_around(v);
                let (mut sum, mut n, mut piece) = (0.0, 0, 0);
                for t in around {
                    sum += damage[t as usize];
                    n += 1;
                    piece = fragment[t as usize];
                }
                frame.positions.push(places[v as usize].as_vec3().into());
                frame.velocity.push(speeds[v as usize].as_vec3().into());
                frame.damage.push(sum / n.max(1) as f32);
                frame.id.push(mesh.origin()[v as usize]);
                frame.inside.push(surface.inside[k]);
                frame.piece.push(pieces + piece);
            }
            frame.normals.extend(surface.normals(places).iter().map(|n| <[f32; 3]>::from(n.as_vec3())));
            frame.triangles.extend(surface.triangles.iter().map(|t| t.map(|v| first + v)));
            pieces += count as u32;
        }
        frame
    }
}
