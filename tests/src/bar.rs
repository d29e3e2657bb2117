//! Square bars of irregular tetrahedra along x, to be compared with finite elements.
//!
//! The bar of the reference is x in \[0, L\]. Ours goes on beyond its held ends, by more than a horizon: particles out there
//! are prescribed, so that those inside have whole families. The mesh has vertices on the planes x = 0 and x = L, so that
//! no tetrahedron is half held.

use fissure_engine::{Anchor, BodyInput, Integrator, Relax, Surroundings, Value, World};
use fissure_meshing::TetMesh;
use fissure_meshing::family::families;
use fissure_meshing::order::morton_order;
use glam::{DMat4, DVec3, DVec4};

use crate::noise;

/// Horizon δ as a multiple of the mean edge length.
const HORIZON: f64 = 1.45;
/// Mean edge length of the tetrahedra in sizes of the cell that they cut up.
const EDGE: f64 = 1.28;
/// Cells of a grip: 3.0 sizes, against a horizon of 1.86.
const GRIP: usize = 3;
/// Largest offset of an inner vertex along an axis, in cells.
const JITTER: f64 = 0.2;

/// A bar and what it is made of.
#[derive(Clone, Copy, Debug)]
pub struct Bar<'a> {
    /// Length L between the grips [m].
    pub length: f64,
    /// Edge of the section [m].
    pub width: f64,
    /// Elements across: the width over the mean edge length, nearly.
    pub across: usize,
    /// Whether the far end is held too.
    pub both_ends: bool,
    /// Bulk and shear modulus [Pa].
    pub moduli: (f64, f64),
    /// `formulation` of the law `isotropic`.
    pub formulation: &'a str,
}

impl Bar<'_> {
    /// Cells across and along, and along with grips: first and last.
    fn cells(&self) -> (usize, i64, i64) {
        let across = (self.across as f64 * EDGE).round() as usize;
        let along = (self.length / self.width * across as f64).round() as i64;
        (across, -(GRIP as i64), along + if self.both_ends { GRIP as i64 } else { 0 })
    }

    /// Six tetrahedra a cell (Kuhn 1960), the cells mirrored from one to the next so that no diagonal is favoured, with
    /// vertices moved at random: freely inside, along the planes on the surface and at x = 0 and x = L.
    fn mesh(&self) -> TetMesh {
        let (across, first, last) = self.cells();
        let size = self.width / across as f64;
        let along = (self.length / size).round() as i64;
        let n = across + 1;
        let number = |i: i64, j: usize, k: usize| (i - first) as usize * n * n + j * n + k;
        let mut mesh = TetMesh::default();
        for i in first..=last {
            for j in 0..n {
                for k in 0..n {
                    let seed = 3 * mesh.vertices.len() as u64;
                    let on_plane = [[first, 0, along, last].contains(&i), j == 0 || j == across, k == 0 || k == across];
                    let move_by = |axis: usize| if on_plane[axis] { 0.0 } else { JITTER * noise(seed + axis as u64) };
                    let half = across as f64 / 2.0;
                    let cell = DVec3::new(i as f64, j as f64 - half, k as f64 - half);
                    mesh.vertices.push((cell + DVec3::new(move_by(0), move_by(1), move_by(2))) * size);
                }
            }
        }
        const ORDERS: [[usize; 3]; 6] = [[0, 1, 2], [1, 2, 0], [2, 0, 1], [0, 2, 1], [2, 1, 0], [1, 0, 2]];
        for i in first..last {
            for j in 0..across {
                for k in 0..across {
                    let mirrored = [i.rem_euclid(2) as usize, j % 2, k % 2];
                    for order in ORDERS {
                        let mut at = mirrored;
                        let corner = |at: [usize; 3]| number(i + at[0] as i64, j + at[1], k + at[2]) as u32;
                        let mut tet = [corner(at); 4];
                        for (step, axis) in order.into_iter().enumerate() {
                            at[axis] = 1 - at[axis];
                            tet[step + 1] = corner(at);
                        }
                        mesh.tets.push(tet);
                        let t = mesh.tets.len() - 1;
                        if mesh.volume(t) < 0.0 {
                            mesh.tets[t].swap(2, 3);
                        }
                        assert!(mesh.volume(t) > 0.02 * size.powi(3), "the jitter squeezes a tetrahedron");
                    }
                }
            }
        }
        mesh
    }

    /// The bar as a world, at rest, ρ = 1000 kg/m³, with anchors `left` and, if both ends are held, `right`.
    pub fn world(&self) -> World {
        let mesh = self.mesh();
        let spacing = mesh.mean_edge();
        let horizon = HORIZON * spacing;
        let centres: Vec<DVec3> = (0..mesh.tets.len()).map(|t| mesh.barycentre(t)).collect();
        let ids = morton_order(&centres);
        let points: Vec<DVec3> = ids.iter().map(|&t| centres[t as usize]).collect();
        let volumes: Vec<f64> = ids.iter().map(|&t| mesh.volume(t as usize)).collect();
        let given = vec![
            ("bulk_modulus".into(), Value::Number(self.moduli.0)),
            ("shear_modulus".into(), Value::Number(self.moduli.1)),
            ("formulation".into(), Value::Word(self.formulation.into())),
        ];
        let at = Surroundings { horizon, spacing };
        let material = fissure_materials::registry().make(("isotropic", given), ("none", vec![]), &at);
        let input = BodyInput {
            name: "bar",
            points: &points,
            volumes: &volumes,
            ids: &ids,
            density: 1000.0,
            spacing,
            horizon,
            velocity: DVec3::ZERO,
            spin: DVec3::ZERO,
            neighbourhood: families(&points, horizon, None).expect("nobody is alone").into(),
        };
        let mut world = World::default();
        world.add(input, material.expect("valid parameters")).expect("positive volumes");
        world.anchors = vec![grip(&world, "left", |x| x < 0.0)];
        if self.both_ends {
            world.anchors.push(grip(&world, "right", |x| x > self.length));
        }
        println!(
            "bar, {} across, {}: {} particles, {:.0} neighbours each, width {:.2} mean edges",
            self.across,
            self.formulation,
            world.particles.len(),
            world.bond_counts().0 as f64 / world.particles.len() as f64,
            self.width / spacing
        );
        world
    }
}

fn grip(world: &World, name: &str, holds: impl Fn(f64) -> bool) -> Anchor {
    let position = &world.particles.position;
    let held: Vec<u32> = (0..position.len()).filter(|&i| holds(position[i].x)).map(|i| i as u32).collect();
    let start: Vec<DVec3> = held.iter().map(|&i| position[i as usize]).collect();
    Anchor { name: name.into(), particles: held.into(), start: start.into(), until: f64::INFINITY, ..Anchor::default() }
}

/// Relaxes the world over `steps` load steps to the time 1 s: coarsely on the way, to a residual of 1e-5 at the end.
pub fn relax(world: &mut World, steps: u32) {
    world.dt = 1.0 / f64::from(steps);
    let mut iterations = 0;
    for step in 1..=steps {
        let residual = if step == steps { 1e-5 } else { 1e-3 };
        world.integrator = Integrator::Relax(Relax { residual, ..Relax::default() });
        world.step().expect("an equilibrium");
        iterations += world.relaxed.iterations;
    }
    println!("  relaxed in {iterations} iterations");
}

/// Displacement [m] at the point `x` of the bar at rest [m]: that of the affine motion of the particles within a horizon,
/// near ones counting more.
pub fn displacement(world: &World, x: DVec3) -> DVec3 {
    let (body, p) = (&world.bodies[0], &world.particles);
    let (mut normal, mut right) = (DMat4::ZERO, [DVec4::ZERO; 3]);
    for i in body.range.clone() {
        let rest = body.origin + p.rest[i].as_dvec3();
        let share = 1.0 - rest.distance_squared(x) / body.horizon.powi(2);
        if share > 0.0 {
            let (arm, u) = (((rest - x) / body.horizon).extend(1.0), p.position[i] - rest);
            let weight = share * share;
            normal += DMat4::from_cols(arm * arm.x, arm * arm.y, arm * arm.z, arm) * weight;
            (0..3).for_each(|k| right[k] += arm * (u[k] * weight));
        }
    }
    let inverse = normal.inverse();
    DVec3::from_array(right.map(|r| (inverse * r).w))
}

/// A turn by `degrees` in 1 s about the x axis for the anchor `right`.
pub fn twist(world: &mut World, degrees: f64) {
    world.anchors[1].spin = DVec3::X * degrees.to_radians();
}

/// Relative error, printed as a row of the table.
pub fn row(what: &str, bar: &Bar<'_>, ours: f64, reference: f64) -> f64 {
    let error = ours / reference - 1.0;
    let (across, law) = (bar.across, bar.formulation);
    println!("| {what:<24} | {across} | {law:<10} | {ours:>11.4e} | {reference:>11.4e} | {:+6.1} % |", 100.0 * error);
    error
}
