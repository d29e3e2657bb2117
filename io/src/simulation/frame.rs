//! The surface of all bodies at one time.

use super::{Simulation, colliders};
use crate::frames::{Frame, ParticleFrame, TetFrame};

impl Simulation {
    /// The surfaces of the colliders at the present state, each vertex with the number of its collider as its piece; without
    /// planes, so it may be empty.
    pub fn collider_frame(&self, number: u32) -> Frame {
        colliders::frame(&self.world, number)
    }

    /// The frame `number` of the present state. Skins remember rotations, and fragments get their ids here, so which frames
    /// are made is part of a run; checkpoints keep that.
    pub fn frame(&mut self, number: u32) -> Frame {
        let mut frame = Frame { time: self.world.time, number, ..Frame::default() };
        (0..self.meshes.len()).for_each(|k| self.follow(k));
        self.name_pieces();
        for (k, (body, embedded)) in self.world.bodies.iter().zip(&self.meshes).enumerate() {
            let piece = self.pieces.of(k);
            embedded.moved(body, &self.world.particles, |moved| {
                let first = frame.positions.len() as u32;
                for (&v, &inside) in moved.surface.vertices.iter().zip(&moved.surface.inside) {
                    let v = v as usize;
                    frame.positions.push(moved.positions[v].as_vec3().into());
                    frame.velocity.push(moved.velocities[v].as_vec3().into());
                    frame.damage.push(moved.damage[v]);
                    frame.id.push(moved.origin[v]);
                    frame.inside.push(inside);
                    frame.piece.push(piece[moved.cell[v] as usize]);
                }
                let (normals, stretches) = rayon::join(
                    || moved.surface.normals(moved.positions),
                    || moved.surface.stretches(moved.positions, moved.rest),
                );
                frame.normals.extend(normals.iter().map(|n| <[f32; 3]>::from(n.as_vec3())));
                frame.stretch.extend(stretches.iter().map(|&s| s as f32));
                frame.triangles.extend(moved.surface.triangles.iter().map(|t| t.map(|v| first + v)));
            });
        }
        frame
    }

    /// The particles of all bodies at the present state, of a lattice its nodes; their pieces are those of the last
    /// [`frame`](Self::frame).
    pub fn particle_frame(&mut self, number: u32) -> ParticleFrame {
        let Self { world, meshes, pieces } = self;
        let p = &world.particles;
        let mut frame = ParticleFrame { time: world.time, number, ..ParticleFrame::default() };
        frame.piece = vec![0; p.len()];
        for (k, (body, embedded)) in world.bodies.iter().zip(&*meshes).enumerate() {
            let start = body.range.start;
            frame.body.extend(body.range.clone().map(|_| k as u32));
            // the lowest cell of a node is the last to be asked
            for (&i, &piece) in embedded.particles(body).iter().zip(pieces.of(k)).rev() {
                frame.piece[start + i as usize] = piece;
            }
        }
        frame.positions = p.position.iter().map(|x| x.as_vec3().into()).collect();
        frame.velocity = p.velocity.iter().map(|v| v.as_vec3().into()).collect();
        frame.damage = p.damage.to_vec();
        frame.id = p.id.to_vec();
        frame.mass = p.mass.iter().map(|&m| m as f32).collect();
        frame.volume = p.volume.iter().map(|&v| v as f32).collect();
        frame
    }

    /// The tetrahedra of all bodies of bonds, as the last [`frame`](Self::frame) moved them and named their pieces.
    pub fn tet_frame(&self, number: u32) -> TetFrame {
        let p = &self.world.particles;
        let mut frame = TetFrame { time: self.world.time, number, ..TetFrame::default() };
        for (k, (body, embedded)) in self.world.bodies.iter().zip(&self.meshes).enumerate() {
            let Some(tets) = embedded.tets() else { continue };
            let first = frame.positions.len() as u32;
            frame.positions.extend(tets.skin.positions().iter().map(|x| <[f32; 3]>::from(x.as_vec3())));
            frame.velocity.extend(tets.skin.velocities().iter().map(|v| <[f32; 3]>::from(v.as_vec3())));
            frame.tets.extend(tets.mesh.tets().iter().map(|t| t.map(|v| first + v)));
            frame.damage.extend(&p.damage[body.range.clone()]);
            frame.id.extend(&p.id[body.range.clone()]);
            frame.piece.extend(self.pieces.of(k));
            frame.body.extend(body.range.clone().map(|_| k as u32));
        }
        frame
    }

    /// Gives ids to fragments that are new since the last frame.
    fn name_pieces(&mut self) {
        let Self { world, meshes, pieces } = self;
        for (k, (body, embedded)) in world.bodies.iter().zip(&*meshes).enumerate() {
            let start = body.range.start;
            let mut share = vec![0_u32; body.range.len()];
            let particles = embedded.particles(body);
            particles.iter().for_each(|&i| share[i as usize] += 1);
            let mass = |&i: &u32| world.particles.mass[start + i as usize] / f64::from(share[i as usize]);
            let mass: Vec<f64> = particles.iter().map(mass).collect();
            let (fragment, count) = embedded.fragments();
            pieces.update(k, &fragment, count, &mass);
        }
    }
}
