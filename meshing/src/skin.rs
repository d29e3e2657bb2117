//! Vertices of the embedded mesh follow the particles, one particle at the barycentre of each tetrahedron.
//!
//! As the paper writes it (Chen et al., Eqs. 20–22), a vertex moves with the mass-weighted mean velocity of its
//! tetrahedra. Integrated, that is the rest position plus the mean displacement since the last split; and as the mean
//! of the barycentres lies off a vertex of the surface by up to half an element, that vertex misses the part of a
//! rotation that acts on this arm: a turned body shrinks and wrinkles at its surface. By default vertices therefore
//! follow the local affine motion,
//!
//! x_v = Σ m_p (y_p + F_p (X_v − X_p)) / Σ m_p,
//!
//! with F_p fitted over the tetrahedra that share a current vertex with p: exact for every affine motion, rigid for a
//! tetrahedron that has broken off alone (it keeps its last rotation, for a point cannot turn), and never mirrored.

pub(crate) mod fit;
pub(crate) mod rotation;

use fissure_engine::buffer::Buffer;
use fissure_engine::column::{Column, Of, Visitor};
use glam::{DMat3, DQuat, DVec3};
use rayon::prelude::*;

use crate::crack::{CrackMesh, Stars};
use fit::Moments;

/// How vertices follow particles.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Follow {
    /// Eqs. 20–22 as printed. Their sum over the steps telescopes: between splits x_v minus the mean position of its
    /// particles does not change, so one offset per vertex replaces a pass in each step, for the same positions up to
    /// rounding.
    AsWritten,
    /// The local affine motion; see the head of this file.
    #[default]
    Affine,
}

/// The particles of the mesh, one per tetrahedron and in the same order.
#[derive(Clone, Copy, Debug)]
pub struct Particles<'a> {
    /// Rest positions, the barycentres of the rest mesh [m].
    pub rest: &'a [DVec3],
    /// Current positions [m].
    pub position: &'a [DVec3],
    /// Velocities [m/s].
    pub velocity: &'a [DVec3],
    /// Masses [kg]; any positive multiple will do.
    pub mass: &'a [f64],
}

impl Particles<'_> {
    /// The weight of particle `t`; particles without mass count next to nothing, but still say where they are.
    fn weight(&self, t: u32) -> f64 {
        let mass = self.mass[t as usize];
        if mass > 0.0 { mass } else { 1e-30 }
    }
}

/// Positions and velocities of the current vertices of a [`CrackMesh`].
#[derive(Clone, Debug, Default)]
pub struct Skin {
    follow: Follow,
    /// Affine: the last rotation of each tetrahedron, as quaternion x y z w.
    rotation: Buffer<[f32; 4]>,
    /// As written: vertex minus mean of its particles [m].
    offset: Buffer<DVec3>,
    stars: Stars,
    positions: Vec<DVec3>,
    velocities: Vec<DVec3>,
    moments: Vec<Moments>,
    motions: Vec<Motion>,
}

/// What a vertex needs to know of a tetrahedron.
#[derive(Clone, Copy, Debug)]
struct Motion {
    gradient: DMat3,
    rate: DMat3,
}

impl Skin {
    /// The skin of a mesh at rest. `rest` [m] and `mass` [kg] are those of the particles, one per tetrahedron.
    pub fn new(follow: Follow, crack: &CrackMesh, rest: &[DVec3], mass: &[f64]) -> Self {
        let mut skin = Self { follow, ..Self::default() };
        match follow {
            Follow::Affine => skin.rotation.set(vec![[0.0, 0.0, 0.0, 1.0]; crack.tets().len()]),
            Follow::AsWritten => {
                let particles = Particles { rest, position: rest, velocity: rest, mass };
                let vertices = 0..crack.origin().len() as u32;
                let stars = Stars::of(vertices.len(), crack.tets());
                let offset = |v| crack.rest_position(v) - mean(stars.around(v), &particles, rest);
                skin.offset.set(vertices.into_par_iter().map(offset).collect());
            }
        }
        skin
    }

    /// How vertices follow.
    pub fn follow(&self) -> Follow {
        self.follow
    }

    /// Tells the skin of the last [`CrackMesh::cut`]: call it after each that returned more than 0, with the
    /// particles as they are at that moment. Copies then start where the vertex was.
    pub fn split(&mut self, crack: &CrackMesh, particles: &Particles) {
        if self.follow == Follow::Affine {
            return; // x_v is a function of the present alone
        }
        let y = particles.position;
        let offset = self.offset.to_mut();
        offset.resize(crack.origin().len(), DVec3::ZERO);
        for split in crack.splits() {
            let group = || std::iter::once(split.vertex).chain(split.first..split.first + split.count);
            let star = |v| crack.tets_around(v).collect::<Vec<_>>();
            let x = offset[split.vertex as usize] + mean(&group().flat_map(star).collect::<Vec<_>>(), particles, y);
            for v in group() {
                offset[v as usize] = x - mean(&star(v), particles, y);
            }
        }
    }

    /// Computes positions and velocities of all current vertices. Vertices of no tetrahedron stay at rest. The same
    /// bits on any number of threads; allocates only when there are more vertices than ever before.
    ///
    /// # Panics
    /// If there are fewer particles than tetrahedra, or [`Skin::split`] was left out after a cut.
    pub fn update(&mut self, crack: &CrackMesh, particles: &Particles) {
        self.stars.fill(crack.origin().len(), crack.tets());
        let vertices = (0..crack.origin().len() as u32).into_par_iter();
        if self.follow == Follow::AsWritten {
            let (offset, stars) = (&self.offset, &self.stars);
            assert_eq!(offset.len(), crack.origin().len(), "Skin::split must follow each cut");
            let follow = |v| {
                let of = |values| mean(stars.around(v), particles, values);
                (offset[v as usize] + of(particles.position), of(particles.velocity))
            };
            vertices.map(follow).unzip_into_vecs(&mut self.positions, &mut self.velocities);
            return;
        }
        self.fit(crack, particles);
        let (motions, stars) = (&self.motions, &self.stars);
        let follow = |v: u32| {
            let rest = crack.rest_position(v);
            let (mut weight, mut position, mut velocity) = (0.0, DVec3::ZERO, DVec3::ZERO);
            for &t in stars.around(v) {
                let (p, motion) = (t as usize, &motions[t as usize]);
                let (m, arm) = (particles.weight(t), rest - particles.rest[p]);
                weight += m;
                position += (particles.position[p] + motion.gradient * arm) * m;
                velocity += (particles.velocity[p] + motion.rate * arm) * m;
            }
            if weight > 0.0 { (position / weight, velocity / weight) } else { (rest, DVec3::ZERO) }
        };
        vertices.map(follow).unzip_into_vecs(&mut self.positions, &mut self.velocities);
    }

    /// Fits the motion around each tetrahedron and remembers its rotation.
    fn fit(&mut self, crack: &CrackMesh, particles: &Particles) {
        let stars = &self.stars;
        let around = |v: u32| {
            Moments::join(stars.around(v).iter().map(|&t| {
                let p = t as usize;
                Moments::one(particles.weight(t), particles.rest[p], particles.position[p], particles.velocity[p])
            }))
        };
        (0..crack.origin().len() as u32).into_par_iter().map(around).collect_into_vec(&mut self.moments);
        let (moments, rotation) = (&self.moments, &mut self.rotation);
        crack
            .tets()
            .par_iter()
            .zip(&mut rotation[..])
            .enumerate()
            .map(|(t, (tet, stored))| {
                let own = tet.map(|v| crack.rest_position(v).distance_squared(particles.rest[t]));
                let old = DQuat::from_array(stored.map(f64::from)).normalize();
                let old = if old.is_finite() { old } else { DQuat::IDENTITY };
                let fit =
                    Moments::join(tet.iter().map(|&v| moments[v as usize])).fit(own.iter().sum::<f64>() / 4.0, old);
                *stored = fit.rotation.to_array().map(|x| x as f32);
                Motion { gradient: fit.gradient, rate: fit.rate }
            })
            .collect_into_vec(&mut self.motions);
    }

    /// The tetrahedra of each vertex at the last update.
    pub fn stars(&self) -> &Stars {
        &self.stars
    }

    /// Positions of the current vertices at the last update [m].
    pub fn positions(&self) -> &[DVec3] {
        &self.positions
    }

    /// Velocities of the current vertices at the last update [m/s].
    pub fn velocities(&self) -> &[DVec3] {
        &self.velocities
    }

    /// Whether the restored columns fit `crack`.
    pub fn consistent(&self, crack: &CrackMesh) -> bool {
        match self.follow {
            Follow::Affine => self.rotation.len() == crack.tets().len(),
            Follow::AsWritten => self.offset.len() == crack.origin().len(),
        }
    }

    /// Shows every column to `v`, under `scope`. Positions and velocities follow from the particles and are none.
    pub fn visit(&mut self, scope: &str, v: &mut Visitor) {
        match self.follow {
            Follow::Affine => v(scope, &Column::live("tet_rotation", "1", Of::Tet), &mut self.rotation),
            Follow::AsWritten => v(scope, &Column::live("vertex_offset", "m", Of::Vertex), &mut self.offset),
        }
    }
}

/// Mass-weighted mean of a quantity over the particles of a vertex: Eqs. 20 and 21, where the ¼ cancels.
fn mean(star: &[u32], particles: &Particles, of: &[DVec3]) -> DVec3 {
    let (mut weight, mut sum) = (0.0, DVec3::ZERO);
    for &t in star {
        let m = particles.weight(t);
        weight += m;
        sum += of[t as usize] * m;
    }
    if weight > 0.0 { sum / weight } else { DVec3::ZERO }
}

#[cfg(test)]
mod tests;
