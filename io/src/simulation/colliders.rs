//! From what a scene says of rigid things to colliders.

use fissure_engine::contact::{Mesh, overlap};
use fissure_engine::{Collider, Integrator, Keyframe, Motion, Shape, World};
use fissure_meshing::surface::{PrepareOptions, prepare};
use fissure_meshing::{TriMesh, shapes};
use glam::{DMat3, DVec3};

use super::SimulationError;
use crate::frames::Frame;
use crate::mesh;
use crate::scene::{self, ColliderMotion, ColliderShape, Scene, SceneError, Stance, Weight};

/// The colliders of `scene`, the ground first. With `fresh` meshes are read from their files; else they are left empty, for a
/// restart brings them.
///
/// # Errors
/// A mesh that cannot be read or encloses nothing.
pub(super) fn colliders(scene: &Scene, fresh: bool) -> Result<Vec<Collider>, SimulationError> {
    let ground = scene.ground.map(|g| Collider {
        friction: g.friction,
        restitution: g.restitution,
        ..Collider::plane("ground", g.normal, g.height)
    });
    let mut all: Vec<Collider> = ground.into_iter().collect();
    for (k, told) in scene.colliders.iter().enumerate() {
        if let (Integrator::Relax(_), ColliderMotion::Free { .. }) = (scene.integrator, &told.motion) {
            let message = format!(
                "collider `{}` is free, and integrator = \"relax\" has no motion for it; give it `keyframes` or take another integrator",
                told.name
            );
            return Err(SceneError::Wrong { place: scene.locate_collider(k), message }.into());
        }
        let made = collider(told, fresh).map_err(|message| {
            let message = format!("collider `{}`: {message}", told.name);
            SceneError::Wrong { place: scene.locate_collider(k), message }
        })?;
        all.push(Collider { friction: told.friction, restitution: told.restitution, ..made });
    }
    Ok(all)
}

fn collider(told: &scene::Collider, fresh: bool) -> Result<Collider, String> {
    let shape = shape(&told.shape, fresh)?;
    let (position, orientation) = (told.start.position, told.start.orientation());
    let still = |shape| Collider { position, orientation, ..Collider::new(&told.name, shape) };
    Ok(match &told.motion {
        ColliderMotion::Fixed => still(shape),
        ColliderMotion::Keyframes(frames) => {
            let frame = |&(time, stance): &(f64, Stance)| Keyframe {
                time,
                position: stance.position,
                orientation: stance.orientation(),
            };
            Collider { motion: Motion::Keyframes(frames.iter().map(frame).collect()), ..still(shape) }
        }
        ColliderMotion::Free { .. } if !fresh && matches!(shape, Shape::Mesh(_)) => {
            // mass, inertia and state come with the columns
            Collider { motion: Motion::Free { mass: 1.0, inertia: DMat3::IDENTITY }, ..still(shape) }
        }
        ColliderMotion::Free { weight, inertia, velocity, spin } => {
            let volume = shape.mass_properties().map_or(0.0, |m| m.volume);
            let density = match *weight {
                Weight::Density(density) => density,
                Weight::Mass(mass) => mass / volume,
            };
            let made = Collider::free(&told.name, shape, density, position, orientation);
            let mut made = made.ok_or("a plane has no mass; use a flat box")?;
            if let (Motion::Free { inertia, .. }, Some(given)) = (&mut made.motion, inertia) {
                *inertia = DMat3::from_diagonal(*given);
            }
            Collider { velocity: *velocity, ..made }.spun(*spin)
        }
    })
}

fn shape(told: &ColliderShape, fresh: bool) -> Result<Shape, String> {
    Ok(match *told {
        ColliderShape::Plane { normal } => Shape::Plane { normal },
        ColliderShape::Ball { radius } => Shape::Ball { radius },
        ColliderShape::Box { size } => Shape::Box { half: size / 2.0 },
        ColliderShape::Capsule { radius, height } => Shape::Capsule { half: height / 2.0 - radius, radius },
        ColliderShape::Cylinder { radius, height } => Shape::Cylinder { half: height / 2.0, radius },
        ColliderShape::Mesh { .. } if !fresh => Shape::Mesh(Mesh::default()),
        ColliderShape::Mesh { ref path, scale, hull, .. } => {
            let surface = match mesh::read(path).map_err(|e| e.to_string())? {
                mesh::Mesh::Surface(surface) => surface,
                mesh::Mesh::Solid(_) => {
                    return Err(format!("{} holds tetrahedra; give the path of a surface", path.display()));
                }
            };
            let file = |e: &dyn ToString| format!("{}: {}", path.display(), e.to_string());
            let scaled = |vertices: Vec<DVec3>| vertices.into_iter().map(|v| v * scale).collect::<Vec<_>>();
            if hull {
                Shape::Mesh(Mesh::hull(&scaled(surface.vertices)).map_err(|e| file(&e))?)
            } else {
                let (surface, _) = prepare(surface, PrepareOptions::default()).map_err(|e| file(&e))?;
                Shape::Mesh(Mesh::new(scaled(surface.vertices), surface.triangles).map_err(|e| file(&e))?)
            }
        }
    })
}

/// Refuses a scene in which a collider holds the middle of a particle, or two bodies have particles in one place. The ground
/// pushes such ones out instead.
///
/// # Errors
/// The collider and the body, or the bodies, that overlap most, and how deep.
pub(super) fn check_start(scene: &Scene, world: &World) -> Result<(), SimulationError> {
    let first = usize::from(scene.ground.is_some());
    for (k, c) in world.colliders[first..].iter().enumerate() {
        let (position, orientation) = c.pose(0.0);
        for body in &world.bodies {
            let depth = |i: usize| {
                let x = orientation.inverse() * (world.particles.position[i] - position);
                if x.length() > c.shape.radius() {
                    f64::INFINITY
                } else {
                    c.shape.distance(x, f64::MAX).map_or(f64::INFINITY, |d| d.0)
                }
            };
            let deepest = body.range.clone().map(depth).fold(f64::INFINITY, f64::min);
            if deepest < 0.0 {
                let message = format!(
                    "collider `{}` starts {:.3e} m deep inside body `{}`; move one of them apart",
                    c.name, -deepest, body.name
                );
                return Err(SceneError::Wrong { place: scene.locate_collider(k), message }.into());
            }
        }
    }
    if world.contact.between
        && let Some(found) = overlap::deepest(world)
    {
        let [a, b] = found.bodies.map(|b| &world.bodies[b].name);
        let (depth, DVec3 { x, y, z }) = (found.depth, found.place);
        let message = format!(
            "body `{b}` starts {depth:.3e} m deep inside body `{a}`, at ({x:.4}, {y:.4}, {z:.4}); move one of them apart, \
             or set contact.particles = \"off\""
        );
        return Err(SceneError::Wrong { place: scene.locate(b, "translate", ""), message }.into());
    }
    Ok(())
}

/// The surfaces of the colliders as they stand in `world`, for pictures; planes are left out, for they have no end.
pub(super) fn frame(world: &World, number: u32) -> Frame {
    let mut frame = Frame { time: world.time, number, ..Frame::default() };
    for (k, c) in world.colliders.iter().enumerate() {
        let Some(surface) = surface(&c.shape) else { continue };
        let (first, spin) = (frame.positions.len() as u32, c.spin());
        let mut normals = vec![DVec3::ZERO; surface.vertices.len()];
        for t in 0..surface.triangles.len() {
            let [a, b, d] = surface.corners(t);
            surface.triangles[t].iter().for_each(|&v| normals[v as usize] += (b - a).cross(d - a));
        }
        for (v, normal) in surface.vertices.iter().zip(normals) {
            let arm = c.orientation * *v;
            frame.positions.push((c.position + arm).as_vec3().into());
            frame.normals.push((c.orientation * normal).normalize_or_zero().as_vec3().into());
            frame.velocity.push((c.velocity + spin.cross(arm)).as_vec3().into());
            frame.damage.push(0.0);
            frame.stretch.push(0.0);
            frame.id.push(frame.id.len() as u32);
            frame.inside.push(0);
            frame.piece.push(k as u32);
        }
        frame.triangles.extend(surface.triangles.iter().map(|t| t.map(|v| first + v)));
    }
    frame
}

fn surface(shape: &Shape) -> Option<TriMesh> {
    const SEGMENTS: usize = 64;
    match shape {
        Shape::Plane { .. } => None,
        Shape::Ball { radius } => shapes::ball(*radius, 4).ok(),
        Shape::Box { half } => shapes::cuboid(*half * 2.0, DVec3::ZERO).ok(),
        Shape::Cylinder { half, radius } => shapes::cylinder(*radius, 2.0 * half, SEGMENTS).ok(),
        Shape::Capsule { half, radius } => {
            let arc = (0..=SEGMENTS / 2).map(|k| {
                let angle = std::f64::consts::PI * (k as f64 / (SEGMENTS / 2) as f64 - 0.5);
                (radius * angle.cos().max(0.0), half.copysign(angle) + radius * angle.sin())
            });
            // the ends lie on the axis, and the profile closes along it
            let mut profile: Vec<(f64, f64)> = arc.collect();
            let last = profile.len() - 1;
            (profile[0].0, profile[last].0) = (0.0, 0.0);
            shapes::revolution(&profile, SEGMENTS).ok()
        }
        Shape::Mesh(mesh) => Some(TriMesh { vertices: mesh.vertices.to_vec(), triangles: mesh.triangles.to_vec() }),
    }
}
