//! The surface of a body, which its particles carry along: that of tetrahedra, or that of the cells of a lattice.

use std::borrow::Cow;

use fissure_engine::{Body, Particles as All, Visitor};
use fissure_meshing::crack::{CrackMesh, Surface};
use fissure_meshing::lattice::{Facets, Follower, Lattice, Patchwork};
use fissure_meshing::skin::{Follow, Particles, Skin};
use glam::{DVec3, Vec3};
use rayon::prelude::*;

/// What a body looks like.
pub enum Embedded {
    /// Of a body of bonds.
    Tets(Tets),
    /// Of a lattice.
    Cells(Cells),
}

/// The mesh of a body of bonds.
#[derive(Default)]
pub struct Tets {
    /// The tetrahedra, in the order of the body's particles.
    pub mesh: CrackMesh,
    /// Where its vertices are.
    pub skin: Box<Skin>,
    /// Rest positions of the particles in the world [m].
    rest: Vec<DVec3>,
    /// The last cuts as pairs; scratch.
    links: Vec<(u32, u32)>,
}

/// The surface of a lattice and the faces between its cells.
#[derive(Default)]
pub struct Cells {
    /// All faces.
    pub facets: Facets,
    /// Makes them follow the nodes.
    follower: Box<Follower>,
    /// The surface and the fragments as of the last cut, once they have been asked for; scratch, as are the links.
    patchwork: Option<Patchwork>,
    fragments: Option<(Vec<u32>, usize)>,
    links: Vec<(u32, u32)>,
}

/// A surface that has been moved to where its particles are.
pub(crate) struct Moved<'a> {
    pub surface: &'a Surface,
    /// Positions of the mesh vertices [m] and their velocities [m/s].
    pub positions: &'a [DVec3],
    pub velocities: &'a [DVec3],
    /// Places at rest of the mesh vertices [m].
    pub rest: &'a (dyn Fn(u32) -> DVec3 + Sync),
    /// For each mesh vertex the vertex at rest, a tetrahedron or cell that it is a vertex of, and its damage.
    pub origin: &'a [u32],
    pub cell: Vec<u32>,
    pub damage: Vec<f32>,
}

impl Tets {
    /// The cracked mesh of the body `world` with the particles `all`.
    pub(super) fn new(mesh: CrackMesh, follow: Follow, world: &Body, all: &All) -> Self {
        let p = all.of(&world.range);
        let rest = rest_positions(world.origin, p.rest);
        let skin = Box::new(Skin::new(follow, &mesh, &rest, p.mass));
        Self { mesh, skin, rest, links: Vec::new() }
    }

    /// To be filled from a checkpoint.
    pub(super) fn empty(follow: Follow) -> Self {
        Self { skin: Box::new(Skin::new(follow, &CrackMesh::default(), &[], &[])), ..Self::default() }
    }

    fn particles<'a>(&'a self, body: &Body, all: &'a All) -> Particles<'a> {
        let p = all.of(&body.range);
        Particles { rest: &self.rest, position: p.position, velocity: p.velocity, mass: p.mass }
    }
}

impl Cells {
    /// The surface of a fresh lattice.
    pub(super) fn new(lattice: Lattice) -> Self {
        Self { facets: lattice.facets, follower: Box::new(lattice.follower), ..Self::default() }
    }
}

impl Embedded {
    /// The tetrahedra, unless it is a lattice.
    pub fn tets(&self) -> Option<&Tets> {
        match self {
            Self::Tets(tets) => Some(tets),
            Self::Cells(_) => None,
        }
    }

    /// The faces of the cells, if it is a lattice.
    pub fn cells(&self) -> Option<&Cells> {
        match self {
            Self::Tets(_) => None,
            Self::Cells(cells) => Some(cells),
        }
    }

    /// Splits where the last step broke links. Returns how many vertices, or triangles of a lattice, are new.
    pub(super) fn cut(&mut self, body: &Body, all: &All) -> usize {
        let links = match self {
            Self::Tets(tets) => &mut tets.links,
            Self::Cells(cells) => &mut cells.links,
        };
        links.clear();
        links.extend(body.cuts.iter().map(|l| (l.i, l.j)));
        match self {
            Self::Tets(tets) => {
                let copies = tets.mesh.cut(&tets.links);
                if copies > 0 {
                    let mut skin = std::mem::take(&mut tets.skin);
                    skin.split(&tets.mesh, &tets.particles(body, all));
                    tets.skin = skin;
                }
                copies
            }
            Self::Cells(cells) => {
                let opened = cells.facets.cut(&cells.links);
                if opened > 0 {
                    (cells.patchwork, cells.fragments) = (None, None);
                }
                opened
            }
        }
    }

    /// Moves the vertices to where the particles are.
    pub(crate) fn follow(&mut self, body: &mut Body, all: &All) {
        match self {
            Self::Tets(tets) => {
                let mut skin = std::mem::take(&mut tets.skin);
                skin.update(&tets.mesh, &tets.particles(body, all));
                tets.skin = skin;
            }
            Self::Cells(Cells { facets, follower, patchwork, fragments, .. }) => {
                let patchwork = patchwork.get_or_insert_with(|| facets.surface());
                fragments.get_or_insert_with(|| facets.fragments(follower.cells()));
                if let Some(pose) = body.material.lattice(&all.of(&body.range)) {
                    follower.follow(facets, patchwork, &pose, body.origin);
                }
            }
        }
    }

    /// The fragment of each tetrahedron or cell, and how many there are.
    pub fn fragments(&self) -> (Cow<'_, [u32]>, usize) {
        let owned = |(fragment, count): (Vec<u32>, usize)| (fragment.into(), count);
        match self {
            Self::Tets(tets) => owned(tets.mesh.fragments()),
            Self::Cells(Cells { fragments: Some((fragment, count)), .. }) => (fragment.into(), *count),
            Self::Cells(cells) => owned(cells.facets.fragments(cells.follower.cells())),
        }
    }

    /// How many tetrahedra or finest cells there are.
    pub(super) fn cells_or_tets(&self) -> usize {
        match self {
            Self::Tets(tets) => tets.mesh.tets().len(),
            Self::Cells(cells) => cells.follower.cells(),
        }
    }

    /// The particle of each tetrahedron or finest cell, counted from the body's first.
    pub(super) fn particles<'a>(&self, body: &'a Body) -> Cow<'a, [u32]> {
        match self {
            Self::Tets(_) => (0..body.range.len() as u32).collect(),
            Self::Cells(_) => body.material.carrier().into(),
        }
    }

    /// The surface after [`follow`](Self::follow), put into `with`.
    pub(super) fn moved<R>(&self, body: &Body, all: &All, with: impl FnOnce(Moved<'_>) -> R) -> R {
        let damage = &all.damage[body.range.clone()];
        match self {
            Self::Tets(Tets { mesh, skin, .. }) => {
                let vertices = (0..mesh.origin().len() as u32).into_par_iter();
                let star = |v| skin.stars().around(v).iter().copied();
                with(Moved {
                    surface: &mesh.surface(),
                    positions: skin.positions(),
                    velocities: skin.velocities(),
                    rest: &|v| mesh.rest_position(v),
                    origin: mesh.origin(),
                    cell: vertices.clone().map(|v| star(v).next_back().unwrap_or(0)).collect(),
                    damage: vertices.map(|v| mean(star(v), damage)).collect(),
                })
            }
            Self::Cells(Cells { facets, follower, patchwork, .. }) => {
                let none = Patchwork::default();
                let patchwork = patchwork.as_ref().unwrap_or(&none);
                let carrier = body.material.carrier();
                let copies = 0..patchwork.origin.len();
                let nodes = |v: usize| patchwork.cells_of(v).iter().filter_map(|&c| carrier.get(c as usize).copied());
                with(Moved {
                    surface: &patchwork.surface,
                    positions: follower.positions(),
                    velocities: follower.velocities(),
                    rest: &|v| facets.rest_position(patchwork.origin[v as usize]),
                    origin: &patchwork.origin,
                    cell: copies.clone().map(|v| patchwork.cells_of(v)[0]).collect(),
                    damage: copies.map(|v| mean(nodes(v), damage)).collect(),
                })
            }
        }
    }

    /// Makes what follows from restored columns; false if those of a lattice tell of other cells than its material.
    pub(super) fn restored(&mut self, body: &Body, all: &All) -> bool {
        match self {
            Self::Tets(tets) => {
                tets.rest = rest_positions(body.origin, all.of(&body.range).rest);
                true
            }
            Self::Cells(cells) => body.material.carrier().len() == cells.follower.cells(),
        }
    }

    /// Whether the columns fit each other and the body: a file with right checksums may still lie.
    pub(super) fn consistent(&self, body: &Body) -> bool {
        match self {
            Self::Tets(Tets { mesh, skin, .. }) => {
                mesh.tets().len() == body.range.len() && mesh.consistent() && skin.consistent(mesh)
            }
            Self::Cells(Cells { facets, follower, .. }) => {
                let cells = follower.cells();
                body.range.len() <= cells && follower.consistent(cells) && facets.consistent(cells)
            }
        }
    }

    /// Shows every column of the body called `name` to `v`.
    pub(super) fn visit(&mut self, name: &str, v: &mut Visitor<'_>) {
        match self {
            Self::Tets(tets) => {
                tets.mesh.visit(&format!("bodies/{name}/mesh"), v);
                tets.skin.visit(&format!("bodies/{name}/skin"), v);
            }
            Self::Cells(cells) => {
                cells.facets.visit(&format!("bodies/{name}/facets"), v);
                cells.follower.visit(&format!("bodies/{name}/skin"), v);
            }
        }
    }
}

fn mean(of: impl Iterator<Item = u32>, values: &[f32]) -> f32 {
    let (sum, n) = of.fold((0.0, 0), |(sum, n), p| (sum + values[p as usize], n + 1));
    sum / n.max(1) as f32
}

pub(super) fn rest_positions(origin: DVec3, rest: &[Vec3]) -> Vec<DVec3> {
    rest.iter().map(|x| origin + x.as_dvec3()).collect()
}
