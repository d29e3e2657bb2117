//! From a scene to a simulation at its start.

use std::path::Path;
use std::time::{Duration, Instant};

use fissure_engine::registry::Wants;
use fissure_engine::{Anchor, BodyInput, Registry, Surroundings, World};
use fissure_meshing::crack::CrackMesh;
use fissure_meshing::family::{Clip, FamilyError, families};
use fissure_meshing::order::morton_order;
use fissure_meshing::skin::Follow;
use fissure_meshing::{TetMesh, TriMesh};
use glam::DVec3;

use super::colliders::{check_start, colliders};
use super::pieces::Pieces;
use super::solid::cells;
use super::{Cells, Embedded, Fault, Simulation, SimulationError, Tets, regions, solid};
use crate::scene::{self, Body, Horizon, Scene, SceneError, Source, SurfaceMode};

/// What there is to say about the making of a body.
#[derive(Clone, Debug, Default)]
pub struct Making {
    /// Name of the body.
    pub body: String,
    /// Repairs, warnings and quality, one sentence each.
    pub notes: Vec<String>,
    /// Time for the tetrahedra or cells.
    pub meshing: Duration,
    /// Time for the families, of a body of bonds.
    pub families: Option<Duration>,
}

impl Simulation {
    /// Builds the world of `scene` at time 0; `tell` hears about each body as it is made.
    ///
    /// # Errors
    /// Meshes, materials or numbers that do not work out, with what helps.
    pub fn build(scene: &Scene, registry: &Registry, tell: &mut dyn FnMut(&Making)) -> Result<Self, SimulationError> {
        scene.check(registry)?;
        let mut simulation = Self { world: World::default(), meshes: Vec::new(), pieces: Pieces::default() };
        for body in &scene.bodies {
            let making = match wants(scene, registry, body)? {
                Wants::Bonds => simulation.add(scene, body, registry)?,
                Wants::Cells => simulation.add_lattice(scene, body, registry)?,
            };
            tell(&making);
        }
        simulation.pieces = Pieces::new(simulation.meshes.iter().map(Embedded::cells_or_tets));
        simulation.set_up(scene)?;
        simulation.world.dt = simulation.step_length(scene)?;
        Ok(simulation)
    }

    fn add(&mut self, scene: &Scene, body: &Body, registry: &Registry) -> Result<Making, SimulationError> {
        let fail = |fault: Fault| blame(scene, body, fault);
        let start = Instant::now();
        let made = solid(body, scene.seed).map_err(fail)?;
        let mesh = ordered(made.mesh);
        let meshing = start.elapsed();

        let spacing = mesh.tets.mean_edge();
        let horizon = match body.horizon {
            Horizon::Length(length) => length,
            Horizon::Factor(factor) => factor * spacing,
        };
        let start = Instant::now();
        let points: Vec<DVec3> = (0..mesh.tets.tets.len()).map(|t| mesh.tets.barycentre(t)).collect();
        let volumes: Vec<f64> = (0..mesh.tets.tets.len()).map(|t| mesh.tets.volume(t)).collect();
        let cuts = cut_surface(body);
        let clip = Clip::new(&mesh.tets, (!cuts.triangles.is_empty()).then_some(&cuts));
        let clip = clip.map_err(|e| fail(Fault::of("mesh")(e)))?;
        let rows = families(&points, horizon, Some(&clip)).map_err(|e| fail(family_fault(body, e, &mesh.ids)))?;
        let pre_cut = clip.cut_links().to_vec();
        let took = start.elapsed();

        let at = Surroundings { horizon, spacing };
        let labels = made.labels;
        let labels: Vec<i64> = mesh.ids.iter().filter_map(|&t| labels.get(t as usize).copied()).collect();
        let regions = regions::assign(body, &points, &labels).map_err(fail)?;
        let material = regions::material(scene, body, registry, regions.clone(), &at)?;
        let input = BodyInput {
            name: &body.name,
            points: &points,
            volumes: &volumes,
            ids: &mesh.ids,
            density: body.density,
            spacing,
            horizon,
            velocity: body.velocity,
            spin: body.spin,
            neighbourhood: rows.into(),
        };
        let range = self.world.add(input, material).map_err(|e| fail(Fault::of("mesh")(e)))?.range.clone();
        let mass = &mut self.world.particles.mass.to_mut()[range];
        for ((mass, volume), region) in mass.iter_mut().zip(&volumes).zip(regions) {
            *mass = volume * regions::density(body, region);
        }

        let mut crack = CrackMesh::new(&mesh.tets).map_err(|e| fail(Fault::of("mesh")(e)))?;
        crack.cut(&pre_cut);
        let world = self.world.bodies.last().expect("just added");
        self.meshes.push(Embedded::Tets(Tets::new(crack, follow(body), world, &self.world.particles)));
        Ok(Making { body: body.name.clone(), notes: made.notes, meshing, families: Some(took) })
    }

    fn add_lattice(&mut self, scene: &Scene, body: &Body, registry: &Registry) -> Result<Making, SimulationError> {
        let fail = |fault: Fault| blame(scene, body, fault);
        let start = Instant::now();
        let mut made = cells(body).map_err(fail)?;
        let meshing = start.elapsed();
        let size = made.cells.size;
        let at = Surroundings { horizon: size, spacing: size };
        let material = regions::material(scene, body, registry, Vec::new(), &at)?;
        let ids: Vec<u32> = (0..made.points.len() as u32).collect();
        let input = BodyInput {
            name: &body.name,
            points: &made.points,
            volumes: &made.volumes,
            ids: &ids,
            density: body.density,
            spacing: size,
            horizon: size,
            velocity: body.velocity,
            spin: body.spin,
            neighbourhood: std::mem::take(&mut made.cells).into(),
        };
        self.world.add(input, material).map_err(|e| fail(Fault::of("mesh")(e)))?;
        let notes = std::mem::take(&mut made.notes);
        self.meshes.push(Embedded::Cells(Cells::new(made)));
        Ok(Making { body: body.name.clone(), notes, meshing, families: None })
    }

    /// What is not in the columns: integrator, gravity, colliders, contact; and what anchors hold at the start.
    fn set_up(&mut self, scene: &Scene) -> Result<(), SimulationError> {
        self.world.integrator = scene.integrator;
        self.world.gravity = scene.gravity;
        self.world.colliders = colliders(scene, true)?;
        set_contact(scene, &mut self.world);
        check_start(scene, &self.world)?;
        let position = &self.world.particles.position;
        for (k, told) in scene.anchors.iter().enumerate() {
            let body = &self.world.bodies[told.body];
            let inside = body.range.clone().filter(|&i| told.region.contains(position[i]));
            let particles: Vec<u32> = inside.map(|i| i as u32).collect();
            if particles.is_empty() {
                let (name, body) = (&told.name, &body.name);
                let message = format!("anchor `{name}` holds no particle of body `{body}`; move or enlarge its region");
                return Err(SceneError::Wrong { place: scene.locate_anchor(k), message }.into());
            }
            let start: Vec<DVec3> = particles.iter().map(|&i| position[i as usize]).collect();
            self.world.anchors.push(Anchor { particles: particles.into(), start: start.into(), ..anchor(told) });
        }
        Ok(())
    }

    /// The time step: the scene's, or the stable one times its safety, shortened so that frames fall on steps. Where every
    /// step is an equilibrium, none is too long, and there is one for each frame.
    fn step_length(&self, scene: &Scene) -> Result<f64, SimulationError> {
        const MOST_STEPS: f64 = 1e12;
        let refuse = |message| Err(SimulationError::Whole { file: scene.file().into(), message });
        let (every, duration) = (scene.output.frame_every, scene.duration);
        let relaxed = self.world.relaxes().is_some();
        let stable = if relaxed { f64::INFINITY } else { self.world.stable_dt() };
        let dt = match scene.dt {
            Some(dt) => dt,
            None if relaxed => every.min(duration),
            None if stable.is_finite() => every / (every / (scene.safety * stable)).ceil(),
            None => return refuse("no body limits the time step; give `dt` in seconds".into()),
        };
        if dt > duration && scene.dt.is_some() {
            return refuse(format!("`dt` = {dt} s is longer than the duration of {duration} s; give a shorter one"));
        }
        if duration / dt > MOST_STEPS {
            let message = format!(
                "{duration} s in steps of {dt:.3e} s would never end; check density, stiffness and sizes of the bodies \
                 (stable is {stable:.3e} s)"
            );
            return refuse(message);
        }
        Ok(dt)
    }
}

/// How particles meet.
pub(super) fn set_contact(scene: &Scene, world: &mut World) {
    let scene::Contact { particles, friction, restitution, stiffness } = scene.contact;
    world.contact.between = particles;
    (world.contact.friction, world.contact.restitution, world.contact.stiffness) = (friction, restitution, stiffness);
}

/// The anchor that a scene tells of, holding nothing yet.
pub(super) fn anchor(told: &scene::Anchor) -> Anchor {
    Anchor {
        name: told.name.clone(),
        velocity: told.velocity,
        spin: told.spin,
        centre: told.centre,
        from: told.from,
        until: told.until,
        ..Anchor::default()
    }
}

/// The tetrahedra in the order of a space-filling curve, with their numbers before.
struct Ordered {
    tets: TetMesh,
    ids: Vec<u32>,
}

fn ordered(mesh: TetMesh) -> Ordered {
    let points: Vec<DVec3> = (0..mesh.tets.len()).map(|t| mesh.barycentre(t)).collect();
    let ids = morton_order(&points);
    let tets = ids.iter().map(|&t| mesh.tets[t as usize]).collect();
    Ordered { tets: TetMesh { tets, vertices: mesh.vertices }, ids }
}

fn cut_surface(body: &Body) -> TriMesh {
    let mut surface = TriMesh::default();
    for corners in body.cuts.iter().flat_map(|c| c.triangles()) {
        let first = surface.vertices.len() as u32;
        surface.vertices.extend(corners);
        surface.triangles.push([first, first + 1, first + 2]);
    }
    surface
}

/// What the law of `body` is built from.
pub(super) fn wants(scene: &Scene, registry: &Registry, body: &Body) -> Result<Wants, SceneError> {
    registry.entry(&body.law.name).map(|entry| entry.wants).map_err(|e| scene.blame(&body.name, &e))
}

pub(super) fn follow(body: &Body) -> Follow {
    match body.surface {
        SurfaceMode::Smooth => Follow::Affine,
        SurfaceMode::AsWritten => Follow::AsWritten,
    }
}

/// What is wrong with the families, with particles by their numbers in the input.
fn family_fault(body: &Body, mut error: FamilyError, ids: &[u32]) -> Fault {
    if let FamilyError::Isolated { first, particles, .. } = &mut error {
        if *particles == 1 {
            return Fault::of("mesh")("it has a single tetrahedron, with nothing to be bonded to; give a finer mesh");
        }
        *first = ids[*first] as usize;
    }
    let key = match body.horizon {
        Horizon::Length(_) => "horizon",
        Horizon::Factor(_) => "horizon_factor",
    };
    Fault::of(key)(error)
}

fn blame(scene: &Scene, body: &Body, Fault { key, message }: Fault) -> SimulationError {
    // a mesh made from a shape is at fault where the shape is, and a default where the mesh is
    let of = if matches!(body.source, Source::Shape(_)) { "shape" } else { "mesh" };
    let key = if scene.gives(&body.name, "", key) { key } else { of };
    // readers of files begin with the file, of a pair of files with the one at fault
    let names = |path: &Path| {
        let pair = format!("{}.", path.with_extension("").display());
        message.starts_with(&path.display().to_string()) || message.starts_with(&pair)
    };
    let source_file = match &body.source {
        Source::Mesh { path, .. } if !names(path) => format!(" ({})", path.display()),
        _ => String::new(),
    };
    let place = scene.locate(&body.name, "", key);
    SimulationError::Body { place, body: body.name.clone(), source_file, message }
}
