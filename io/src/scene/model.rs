//! What a scene says, as plain data. SI units throughout; ranges are those of [`keys()`](super::keys()).

use std::path::PathBuf;

use fissure_engine::Interface;
use fissure_engine::params::Value;
use glam::{DQuat, DVec3};

use super::cells::Lattice;
use super::error::Place;
use super::parts::Part;
use crate::export::Format;

/// One solid, `[body.NAME]`.
#[derive(Clone, Debug)]
pub struct Body {
    /// The NAME of its table.
    pub name: String,
    /// Where its geometry comes from.
    pub source: Source,
    /// How finely a surface is filled with tetrahedra; says nothing where the source has tetrahedra already.
    pub resolution: Resolution,
    /// The same of a lattice, and what its cracks look like.
    pub lattice: Lattice,
    /// Thickness [m] of the wall that the surface becomes; none for a solid.
    pub shell: Option<f64>,
    /// How the geometry is put into the world.
    pub placement: Placement,
    /// Density [kg/m³].
    pub density: f64,
    /// Velocity at the start [m/s].
    pub velocity: DVec3,
    /// Angular velocity at the start, about the centre of mass [rad/s].
    pub spin: DVec3,
    /// Radius of the families.
    pub horizon: Horizon,
    /// How the embedded surface follows the particles.
    pub surface: SurfaceMode,
    /// The constitutive law with the keys that the scene gives for it, checked by [`Scene::check`](super::Scene::check).
    pub law: Chosen,
    /// The fracture criterion likewise; `none` where the scene has no `[body.NAME.fracture]`.
    pub criterion: Chosen,
    /// Regions of it that are made of something else, in the order of the file.
    pub parts: Vec<Part>,
    /// How strong the bonds between regions are; the rest of the body is region 0, `parts` count from 1.
    pub interface: Interface,
    /// Cuts that the body starts with, where it stands after `placement`.
    pub cuts: Vec<Cut>,
}

/// Where the geometry of a body comes from.
#[derive(Clone, Debug, PartialEq)]
pub enum Source {
    /// A file with a surface or with tetrahedra.
    Mesh {
        /// The path to open: relative to the current folder or absolute.
        path: PathBuf,
        /// The path as the scene has it, relative to the scene file.
        written: String,
    },
    /// A generated shape.
    Shape(Shape),
}

/// A generated shape; lengths in m, above 0.
#[derive(Clone, Debug, PartialEq)]
#[allow(missing_docs)] // the fields are documented in the table of keys
pub enum Shape {
    /// A box with edges along the axes.
    Box { size: DVec3 },
    /// A beam with a square cross-section.
    Beam { length: f64, width: f64 },
    /// A standing plate.
    Wall { width: f64, height: f64, thickness: f64 },
    /// A thin plate.
    Sheet { width: f64, height: f64, thickness: f64 },
    /// A ball.
    Ball { radius: f64 },
    /// A cylinder about the y axis.
    Cylinder { radius: f64, height: f64 },
    /// An outline of points [r, y] turned about the y axis.
    Revolution { profile: Vec<[f64; 2]>, segments: u32 },
    /// The vase of our own.
    Vase { height: f64, wall: f64 },
}

/// How finely a surface is filled.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Resolution {
    /// Edge length wanted [m].
    Size(f64),
    /// Number of tetrahedra wanted.
    Tets(u64),
}

/// Scale, then turn, then shift.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placement {
    /// Factor about the origin, above 0.
    pub scale: f64,
    /// Axis of the turn through the origin, of any length but 0.
    pub axis: DVec3,
    /// Angle of the turn [°].
    pub degrees: f64,
    /// Shift [m].
    pub translate: DVec3,
}

impl Placement {
    /// The turn alone.
    pub fn rotation(&self) -> DQuat {
        match self.axis.try_normalize() {
            Some(axis) if self.degrees != 0.0 => DQuat::from_axis_angle(axis, self.degrees.to_radians()),
            _ => DQuat::IDENTITY,
        }
    }

    /// Moves a point of the mesh into the world.
    pub fn place(&self, x: DVec3) -> DVec3 {
        self.rotation() * (x * self.scale) + self.translate
    }
}

/// Radius of the families.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Horizon {
    /// In metres.
    Length(f64),
    /// As a multiple of the mean edge length of the tetrahedra.
    Factor(f64),
}

/// How the embedded surface follows the particles (Chen et al., Eqs. 20-22).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SurfaceMode {
    /// Our smooth reading.
    Smooth,
    /// As the paper prints it.
    AsWritten,
}

/// A law or criterion by name, with the keys that the scene gives for it.
#[derive(Clone, Debug)]
pub struct Chosen {
    /// The name in the registry.
    pub name: String,
    /// Its own keys in the order of the file, finite but not otherwise checked.
    pub given: Vec<Given>,
}

impl Chosen {
    /// Keys and values as [`Registry::make`](fissure_engine::Registry::make) takes them.
    pub fn values(&self) -> Vec<(String, Value)> {
        self.given.iter().map(|g| (g.key.clone(), g.value.clone())).collect()
    }
}

/// A key of a law or criterion.
#[derive(Clone, Debug)]
pub struct Given {
    /// The key.
    pub key: String,
    /// Its value; a list of lists comes flattened, row after row.
    pub value: Value,
    /// Where it stands.
    pub place: Place,
}

/// A cut that a body starts with, in world coordinates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Cut {
    /// Three corners [m], not in one line.
    Triangle([DVec3; 3]),
    /// A parallelogram.
    Rectangle {
        /// One corner [m].
        corner: DVec3,
        /// Edge from the corner [m].
        u: DVec3,
        /// Other edge from the corner [m].
        v: DVec3,
    },
}

impl Cut {
    /// The cut as one or two triangles [m].
    pub fn triangles(&self) -> Vec<[DVec3; 3]> {
        match *self {
            Self::Triangle(corners) => vec![corners],
            Self::Rectangle { corner, u, v } => {
                vec![[corner, corner + u, corner + u + v], [corner, corner + u + v, corner + v]]
            }
        }
    }
}

/// Particles that are held or moved, `[[anchor]]`.
#[derive(Clone, Debug, PartialEq)]
pub struct Anchor {
    /// Name for messages and output.
    pub name: String,
    /// The body, as an index into the bodies of the scene.
    pub body: usize,
    /// Which of its particles, where it stands at the start.
    pub region: Region,
    /// Velocity of the motion [m/s].
    pub velocity: DVec3,
    /// Angular velocity of the motion [rad/s].
    pub spin: DVec3,
    /// Point about which it turns [m].
    pub centre: DVec3,
    /// Holds from this time [s].
    pub from: f64,
    /// Lets go at this time [s], above `from`; infinite for never.
    pub until: f64,
}

/// A part of space in world coordinates [m].
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Region {
    /// From the lowest to the highest corner, both included.
    Box {
        /// Lowest corner.
        min: DVec3,
        /// Highest corner.
        max: DVec3,
    },
    /// A ball, its surface included.
    Ball {
        /// Centre.
        centre: DVec3,
        /// Radius.
        radius: f64,
    },
    /// Everything.
    All,
}

impl Region {
    /// Whether `x` lies in the region.
    pub fn contains(&self, x: DVec3) -> bool {
        match *self {
            Self::Box { min, max } => x.cmpge(min).all() && x.cmple(max).all(),
            Self::Ball { centre, radius } => x.distance(centre) <= radius,
            Self::All => true,
        }
    }
}

/// The plane `[ground]`: the collider called `ground`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ground {
    /// Unit normal, pointing to the free side.
    pub normal: DVec3,
    /// Signed distance of the plane from the origin along the normal [m].
    pub height: f64,
    /// Restitution, 0 ..= 1.
    pub restitution: f64,
    /// Coulomb friction coefficient, 0 or more.
    pub friction: f64,
}

/// A rigid thing, `[[collider]]`.
#[derive(Clone, Debug, PartialEq)]
pub struct Collider {
    /// Name for messages and output.
    pub name: String,
    /// Its shape about its origin.
    pub shape: ColliderShape,
    /// Where it is at the start; of one that moves on keyframes the first of them.
    pub start: Stance,
    /// How it moves.
    pub motion: ColliderMotion,
    /// Coulomb friction coefficient, 0 or more.
    pub friction: f64,
    /// Restitution, 0 ..= 1.
    pub restitution: f64,
}

/// The shape of a collider; lengths in m, above 0.
#[derive(Clone, Debug, PartialEq)]
#[allow(missing_docs)] // the fields are documented in the table of keys
pub enum ColliderShape {
    /// A half space; unit normal.
    Plane { normal: DVec3 },
    /// A ball.
    Ball { radius: f64 },
    /// A box.
    Box { size: DVec3 },
    /// A cylinder with round ends; `height` above twice the radius.
    Capsule { radius: f64, height: f64 },
    /// A cylinder.
    Cylinder { radius: f64, height: f64 },
    /// A surface of a file, or with `hull` the convex hull of its vertices.
    Mesh { path: PathBuf, written: String, scale: f64, hull: bool },
}

/// A place and a turn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stance {
    /// Where the origin is [m].
    pub position: DVec3,
    /// Axis of the turn, of any length but 0.
    pub axis: DVec3,
    /// Angle of the turn [°].
    pub degrees: f64,
}

impl Stance {
    /// The turn alone.
    pub fn orientation(&self) -> DQuat {
        let placement = Placement { scale: 1.0, axis: self.axis, degrees: self.degrees, translate: DVec3::ZERO };
        placement.rotation()
    }
}

/// How a collider moves.
#[derive(Clone, Debug, PartialEq)]
pub enum ColliderMotion {
    /// Not at all.
    Fixed,
    /// From place to place at times [s] that grow; one or more.
    Keyframes(Vec<(f64, Stance)>),
    /// As it is pushed.
    Free {
        /// Mass.
        weight: Weight,
        /// Moments of inertia about its own axes [kg m²]; none for those of an evenly filled shape.
        inertia: Option<DVec3>,
        /// Velocity at the start [m/s].
        velocity: DVec3,
        /// Angular velocity at the start [rad/s].
        spin: DVec3,
    },
}

/// Mass, or what it follows from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Weight {
    /// Mass [kg].
    Mass(f64),
    /// Density [kg/m³].
    Density(f64),
}

/// How particles meet, `[contact]`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact {
    /// Whether they do.
    pub particles: bool,
    /// Coulomb friction coefficient, 0 or more.
    pub friction: f64,
    /// Restitution, 0 ..= 1.
    pub restitution: f64,
    /// Stiffness over bulk modulus times distance, above 0.
    pub stiffness: f64,
}

impl Default for Contact {
    /// As the table of keys has it.
    fn default() -> Self {
        Self { particles: true, friction: 0.5, restitution: 0.0, stiffness: 1.0 }
    }
}

/// A reference that the run is compared with, `[[compare]]`.
#[derive(Clone, Debug, PartialEq)]
pub struct Compare {
    /// What is compared.
    pub label: String,
    /// The reference.
    pub reference: Reference,
}

/// What a run is compared with.
#[derive(Clone, Debug, PartialEq)]
pub enum Reference {
    /// Displacements at many places at one time.
    Field {
        /// Index of the body.
        body: usize,
        /// The CSV file.
        table: Table,
        /// Added to the places of the file [m].
        translate: DVec3,
        /// When [s].
        at: f64,
    },
    /// Displacements of one place at many times.
    Track {
        /// Index of the body.
        body: usize,
        /// The CSV file.
        table: Table,
        /// The place at the start [m].
        point: DVec3,
    },
    /// One number.
    Number {
        /// Of what.
        of: Quantity,
        /// The component that is compared, a direction of length 1.
        along: DVec3,
        /// The number [m, N or N m].
        value: f64,
        /// When [s].
        at: f64,
    },
}

/// What a number is compared with.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Quantity {
    /// Displacement [m] of the place `point` [m] of a body.
    Displacement {
        /// Index of the body.
        body: usize,
        /// The place at the start [m].
        point: DVec3,
    },
    /// Force [N] of the anchor with this index.
    Force(usize),
    /// Torque [N m] of the anchor with this index, about its centre.
    Torque(usize),
}

/// The path of a file of numbers.
#[derive(Clone, Debug, PartialEq)]
pub struct Table {
    /// The path to open: relative to the current folder or absolute.
    pub path: PathBuf,
    /// The path as the scene has it, relative to the scene file.
    pub written: String,
}

/// What a run writes.
#[derive(Clone, Debug, PartialEq)]
pub struct Output {
    /// Simulated time from frame to frame [s].
    pub frame_every: f64,
    /// Simulated time from checkpoint to checkpoint [s].
    pub checkpoint_every: f64,
    /// Steps from checkpoint to checkpoint, instead.
    pub checkpoint_steps: Option<u64>,
    /// Minutes on the clock after which there is a checkpoint whatever else.
    pub checkpoint_minutes: Option<f64>,
    /// How many of the newest checkpoints stay; 0 for all.
    pub keep: u32,
    /// What a file that cannot be written does to the run.
    pub on_write_error: OnFailure,
    /// What else frames are written as.
    pub export: Vec<Format>,
    /// Whether frames have their particles beside them.
    pub particles: bool,
    /// The picture of the last frame.
    pub picture: Picture,
}

/// What a frame or a checkpoint that cannot be written does to the run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OnFailure {
    /// It ends, with an error.
    Stop,
    /// It goes on, with a warning; only the last checkpoint must be written.
    GoOn,
}

/// The picture of the last frame.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// Where the camera stands [m]; none to choose one that shows everything.
    pub camera: Option<DVec3>,
    /// Where the camera looks [m]; none for the middle of what is shown.
    pub target: Option<DVec3>,
    /// What the colours show.
    pub colouring: Colouring,
    /// Red, green, blue of the outer surface, 0 ..= 1; none for the picture's own.
    pub outside: Option<[f64; 3]>,
    /// Red, green, blue of crack faces, 0 ..= 1; none for the picture's own.
    pub inside: Option<[f64; 3]>,
}

/// What the colours of a picture show.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Colouring {
    /// Outer surface and crack faces.
    Material,
    /// Share of broken bonds.
    Damage,
    /// How much longer the surface is than at rest.
    Stretch,
    /// Speed.
    Speed,
    /// Connected pieces.
    Piece,
}
