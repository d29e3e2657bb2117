//! Comparison of a run with numbers that it did not make: `[[compare]]` in scenes.
//!
//! A reference becomes rows, each a time, a place at rest and a vector. While the run goes on, [`Comparison::sample`] takes
//! our vector for each row whose time has come. In the end [`Comparison::table`] lists errors, and [`Comparison::figure`]
//! draws both. Displacements are those of the mesh that the particles carry along, as it is seen in frames.
//!
//! Ours are kept in files `compare_N.csv` that look like the references, so a fine run can be the reference of a coarse
//! one; for a first run give a reference without columns ux, uy, uz.

mod figure;
mod report;
mod seat;
mod table;

#[cfg(test)]
mod tests;

use std::collections::BTreeSet;
use std::io;
use std::path::{Path, PathBuf};

use fissure_engine::{Reaction, World};
use fissure_meshing::crack::CrackMesh;
use glam::DVec3;

pub use report::Row;

use crate::atomic::write_atomically;
use crate::scene::{Quantity, Reference, Scene, SceneError};
use crate::simulation::{Simulation, Tets};
use seat::Seat;
use table::Numbers;

/// Names of the columns of displacements, and of places.
const MOVED: [&str; 3] = ["ux", "uy", "uz"];
const PLACE: [&str; 3] = ["x", "y", "z"];

/// All references of a scene with what the run has to say to them.
#[derive(Clone, Debug, Default)]
pub struct Comparison {
    title: String,
    items: Vec<Item>,
    /// Time [s], kinetic, elastic and gravity energy [J]; none where nothing promises to keep their sum.
    energies: Option<Vec<[f64; 4]>>,
}

/// One reference.
#[derive(Clone, Debug)]
struct Item {
    label: String,
    kind: Reference,
    /// In the order of time.
    due: Vec<Due>,
    /// Where the places of `due` sit in the mesh of the body; a single one for all, none for forces.
    seats: Vec<Seat>,
    /// Diagonal of the part of the body that moves freely [m].
    size: f64,
    /// Ours, of the first of `due`; NaN for what was missed.
    ours: Vec<DVec3>,
}

/// What is wanted at a time.
#[derive(Clone, Copy, Debug)]
struct Due {
    time: f64,
    place: DVec3,
    /// NaN for components that the reference does not give.
    reference: DVec3,
}

/// Where the numbers of reference `k` are kept in a run folder, counted from 0: its own, and ours.
fn kept(run: &Path, k: usize) -> [PathBuf; 2] {
    [run.join(format!("reference_{}.csv", k + 1)), run.join(format!("compare_{}.csv", k + 1))]
}

fn energies_in(run: &Path) -> PathBuf {
    run.join("energies.csv")
}

impl Comparison {
    /// Reads the references of a scene, with copies of their files in the folder `run` taking precedence, and finds their
    /// places in the bodies.
    ///
    /// # Errors
    /// Files that cannot be read or lack columns, and places outside the body.
    pub fn new(scene: &Scene, run: &Path, simulation: &mut Simulation) -> Result<Self, SceneError> {
        let mut items = Vec::new();
        for (k, told) in scene.compares.iter().enumerate() {
            let blame = |message| SceneError::Wrong { place: scene.locate_compare(k), message };
            let due = due(&told.reference, &kept(run, k)[0]).map_err(blame)?;
            let (mut seats, mut size) = (Vec::new(), 0.0);
            if let Some(body) = told.reference.body() {
                let Some(Tets { mesh, .. }) = simulation.meshes[body].tets() else {
                    let name = &scene.bodies[body].name;
                    let message = format!(
                        "body `{name}` is a lattice, in which no place can be compared; compare the force of an anchor, or \
                         give it a law of bonds"
                    );
                    return Err(blame(message));
                };
                let one = !matches!(told.reference, Reference::Field { .. });
                let places: Vec<DVec3> = due.iter().take(if one { 1 } else { due.len() }).map(|d| d.place).collect();
                seats = Seat::find(mesh, &places).map_err(|place| {
                    let name = &scene.bodies[body].name;
                    blame(format!("the place {place} [m] lies outside body `{name}`; move it or the body"))
                })?;
                size = diagonal(simulation, body, mesh);
            }
            items.push(Item {
                label: told.label.clone(),
                kind: told.reference.clone(),
                due,
                seats,
                size,
                ours: Vec::new(),
            });
        }
        let rests = scene.anchors.iter().all(|a| a.velocity == DVec3::ZERO && a.spin == DVec3::ZERO);
        let world = &mut simulation.world;
        let particles = &world.particles;
        let counted = world.bodies.iter_mut().all(|b| b.material.energy(&particles.of(&b.range)).is_some());
        let keeps = !items.is_empty() && world.relaxes().is_none() && world.colliders.is_empty() && rests && counted;
        Ok(Self { title: scene.title.clone(), items, energies: keeps.then(Vec::new) })
    }

    /// Takes what is due at the present time of the simulation. Call it at the start and after each step.
    pub fn sample(&mut self, simulation: &mut Simulation) {
        let now = simulation.world.time + 0.5 * simulation.world.dt;
        let mut followed = vec![false; simulation.meshes.len()];
        for item in &mut self.items {
            while item.due.get(item.ours.len()).is_some_and(|due| due.time <= now) {
                if let Some(body) = item.kind.body().filter(|&body| !followed[body]) {
                    simulation.follow(body);
                    followed[body] = true;
                }
                let ours = match item.kind {
                    Reference::Number { of: Quantity::Force(k), .. } => reaction(simulation, k).map(|r| r.force),
                    Reference::Number { of: Quantity::Torque(k), .. } => reaction(simulation, k).map(|r| r.torque),
                    Reference::Field { body, .. }
                    | Reference::Track { body, .. }
                    | Reference::Number { of: Quantity::Displacement { body, .. }, .. } => {
                        let seat = &item.seats[item.ours.len().min(item.seats.len() - 1)];
                        let tets = simulation.meshes[body].tets();
                        tets.map(|tets| seat.displacement(&tets.mesh, tets.skin.positions()))
                    }
                };
                // an anchor that does not hold at this time takes nothing
                let ours = ours.unwrap_or(DVec3::ZERO);
                item.ours.push(ours);
            }
        }
    }

    /// Notes the energies of the present state, where their sum is compared.
    pub fn sample_energies(&mut self, simulation: &mut Simulation) {
        if let Some(energies) = &mut self.energies {
            let world = &mut simulation.world;
            let e = world.energies();
            energies.push([world.time, e.kinetic - held_energy(world), e.elastic, e.gravity]);
        }
    }

    /// Copies the files of the references into the run folder, which then can be moved.
    ///
    /// # Errors
    /// Whatever the file system answers.
    pub fn keep_references(&self, run: &Path) -> io::Result<()> {
        for (k, item) in self.items.iter().enumerate() {
            if let Some(table) = item.kind.table() {
                write_atomically(&kept(run, k)[0], &std::fs::read(&table.path)?)?;
            }
        }
        Ok(())
    }

    /// Writes ours into the run folder. Do so before each checkpoint.
    ///
    /// # Errors
    /// Whatever the file system answers.
    pub fn save(&self, run: &Path) -> io::Result<()> {
        for (k, item) in self.items.iter().enumerate() {
            write_atomically(&kept(run, k)[1], item.ours_as_csv().as_bytes())?;
        }
        if let Some(energies) = &self.energies {
            let rows = energies.iter().map(|row| row.as_slice());
            write_atomically(
                &energies_in(run),
                table::write(&["t", "kinetic", "elastic", "gravity"], rows).as_bytes(),
            )?;
        }
        Ok(())
    }

    /// Takes up what [`Self::save`] wrote, up to the present time of a simulation that goes on. What was due before and is
    /// not in the files counts as missed.
    pub fn restore(&mut self, run: &Path, simulation: &Simulation) {
        let now = simulation.world.time + 0.5 * simulation.world.dt;
        for (k, item) in self.items.iter_mut().enumerate() {
            let past = item.due.iter().take_while(|due| due.time <= now).count();
            let numbers = Numbers::read(&kept(run, k)[1]).unwrap_or_default();
            item.ours = (0..past.min(numbers.rows.len())).map(|row| numbers.vector(row, item.columns())).collect();
            item.ours.resize(past, DVec3::NAN);
        }
        if let Some(energies) = &mut self.energies {
            let numbers = Numbers::read(&energies_in(run)).unwrap_or_default();
            let rows = numbers.rows.iter().filter_map(|row| <[f64; 4]>::try_from(row.as_slice()).ok());
            *energies = rows.filter(|row| row[0] <= now).collect();
        }
    }
}

impl Item {
    /// Names of the columns of ours.
    fn columns(&self) -> [&'static str; 3] {
        match self.kind {
            Reference::Number { of: Quantity::Force(_) | Quantity::Torque(_), .. } => PLACE,
            _ => MOVED,
        }
    }

    fn ours_as_csv(&self) -> String {
        let columns = self.columns();
        let (first, shift) = match self.kind {
            Reference::Field { translate, .. } => (PLACE.to_vec(), translate),
            _ => (vec!["t"], DVec3::ZERO),
        };
        let rows = self.due.iter().zip(&self.ours).map(|(due, ours)| match self.kind {
            Reference::Field { .. } => [(due.place - shift).to_array().to_vec(), ours.to_array().to_vec()].concat(),
            _ => [vec![due.time], ours.to_array().to_vec()].concat(),
        });
        table::write(&[first, columns.to_vec()].concat(), rows)
    }
}

impl Reference {
    /// The body whose displacements are compared.
    fn body(&self) -> Option<usize> {
        match *self {
            Self::Field { body, .. } | Self::Track { body, .. } => Some(body),
            Self::Number { of: Quantity::Displacement { body, .. }, .. } => Some(body),
            Self::Number { .. } => None,
        }
    }

    /// The file that it is read from.
    fn table(&self) -> Option<&crate::scene::Table> {
        match self {
            Self::Field { table, .. } | Self::Track { table, .. } => Some(table),
            Self::Number { .. } => None,
        }
    }
}

/// Kinetic energy [J] that particles have at the start and lose at once, because an anchor holds them.
fn held_energy(world: &World) -> f64 {
    let p = &world.particles;
    let holding = world.anchors.iter().filter(|a| world.step == 0 && a.holds(0.5 * world.dt));
    let held: BTreeSet<u32> = holding.flat_map(|a| a.particles.iter().copied()).collect();
    held.iter().map(|&i| 0.5 * p.mass[i as usize] * p.velocity[i as usize].length_squared()).sum()
}

/// What holding takes of anchor `k`; none where it does not hold.
fn reaction(simulation: &mut Simulation, k: usize) -> Option<Reaction> {
    let all = simulation.world.reactions();
    all.into_iter().find(|r| r.anchor == simulation.world.anchors[k].name)
}

/// The rows of a reference; from the file `copy` if there is one.
fn due(reference: &Reference, copy: &Path) -> Result<Vec<Due>, String> {
    let numbers = match reference.table() {
        Some(table) => Numbers::read(if copy.is_file() { copy } else { &table.path })?,
        None => Numbers::default(),
    };
    match *reference {
        Reference::Field { translate, at, .. } => {
            numbers.need(&PLACE)?;
            let row =
                |k| Due { time: at, place: numbers.vector(k, PLACE) + translate, reference: numbers.vector(k, MOVED) };
            Ok((0..numbers.rows.len()).map(row).collect())
        }
        Reference::Track { point, .. } => {
            numbers.need(&["t"])?;
            let time = |k: usize| numbers.vector(k, ["t", "", ""]).x;
            if let Some(k) = (1..numbers.rows.len()).find(|&k| time(k) <= time(k - 1)) {
                return Err(format!("{}: `t` must grow from row to row, but row {} does not", numbers.file, k + 1));
            }
            let row = |k| Due { time: time(k), place: point, reference: numbers.vector(k, MOVED) };
            Ok((0..numbers.rows.len()).map(row).collect())
        }
        Reference::Number { of, along, value, at } => {
            let place = if let Quantity::Displacement { point, .. } = of { point } else { DVec3::ZERO };
            Ok(vec![Due { time: at, place, reference: along * value }])
        }
    }
}

/// Diagonal [m] of the box around what no anchor holds for ever, at rest: the paper's measure of errors of position
/// (Chen et al., Sec. 6) without the grips.
fn diagonal(simulation: &Simulation, body: usize, mesh: &CrackMesh) -> f64 {
    let range = &simulation.world.bodies[body].range;
    let mut free = vec![true; range.len()];
    for anchor in simulation.world.anchors.iter().filter(|a| a.until.is_infinite()) {
        let own = anchor.particles.iter().map(|&i| i as usize).filter(|i| range.contains(i));
        own.for_each(|i| free[i - range.start] = false);
    }
    let all_held = free.iter().all(|free| !free);
    let corners = mesh.tets().iter().zip(&free).filter(|(_, free)| **free || all_held).flat_map(|(tet, _)| tet);
    let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    for x in corners.map(|&v| mesh.rest_position(v)) {
        (low, high) = (low.min(x), high.max(x));
    }
    (high - low).length()
}
