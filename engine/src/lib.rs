//! The Fissure engine: particle columns, bonds as compressed rows, the material traits, the peridynamic passes and the
//! world with its step. It knows no file format, no mesh and no law by name.
//!
//! A constitutive law implements [`BondLaw`] (the physics of one bond), is registered with [`Registry::bonds`], and gets
//! everything else from [`Peridynamic`]. A body that has no bonds implements [`Material`] itself.
//!
//! Promises: the same bits on any number of threads; force evaluation changes no state; a step after the first
//! allocates nothing; every array that must survive a restart is shown by [`World::visit`].

pub mod adapt;
pub mod anchor;
pub mod bonds;
pub mod buffer;
pub mod column;
pub mod contact;
pub mod erased;
pub mod fracture;
pub mod frame;
pub mod integrate;
pub mod lane;
pub mod lattice;
pub mod law;
pub mod material;
pub mod noise;
pub mod params;
pub mod particles;
pub mod peridynamic;
pub mod phase;
pub mod reaction;
pub mod registry;
pub mod relax;
pub mod several;
mod sum;
pub mod world;

pub use adapt::{Descent, Present, Renewal};
pub use anchor::Anchor;
pub use bonds::{Bonds, Families};
pub use buffer::Buffer;
pub use column::{Column, Life, Of, Visitor};
pub use contact::{Collider, Contact, Keyframe, Motion, Shape};
pub use fracture::Criterion;
pub use integrate::Integrator;
pub use lane::Lane;
pub use lattice::{CellError, Cells, LatticePose, NodeCounts};
pub use law::{Bond, BondLaw, Surroundings};
pub use material::{BuildError, Geometry, Link, Material, Neighbourhood, Touching};
pub use params::{Kind, ParamError, Parameter, Params, Range, Value};
pub use particles::{BodyParticles, Particles};
pub use peridynamic::Peridynamic;
pub use phase::{Phase, Profile};
pub use reaction::Reaction;
pub use registry::Registry;
pub use relax::{Relax, Relaxed};
pub use several::Interface;
pub use world::{Body, BodyInput, Energies, StepError, World};
