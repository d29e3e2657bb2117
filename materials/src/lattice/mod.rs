//! Shape matching on lattices: uniform (Rivers and James 2007), adaptive (Steinemann et al. 2008; Ohta et al.), and in clusters
//! (Müller et al. 2005), with fracture and flow.
//!
//! ```text
//! cells      the finest cells, their links, and who carries them       (cells, presence)
//! nodes      what carries cells now: the particles of the body         (nodes; split and merged in adapt)
//! regions    who is matched with whom: lists (regions, lists) or cubes of a uniform lattice (uniform, block)
//! matching   sums → R, A → goals, four regions at once                 (matching, rotation; shapes flow in shapes)
//! step       v += α(g − x)/h, α for this step from that of a reference step (Eq. 3)
//! ```
//! The internal update keeps linear and angular momentum to round-off: see [`regions`] for the shares that do it, and
//! [`matching`] for the rotation. Splitting and merging keep both as well.

mod adapt;
mod block;
mod cells;
mod fracture;
mod lists;
mod matching;
mod nodes;
mod params;
mod presence;
mod regions;
mod rotation;
mod shapes;
mod spin;
mod uniform;

use fissure_engine::lattice::{LatticePose, NodeCounts};
use fissure_engine::material::Touching;
use fissure_engine::registry::{CriterionEntry, Wants};
use fissure_engine::{
    BodyParticles, Buffer, BuildError, Column, Geometry, Link, Material, Neighbourhood, Of, Present, Registry, Renewal,
    Visitor,
};
use glam::{DMat3, DVec3};
use rayon::prelude::*;

use self::cells::Finest;
use self::lists::Lists;
use self::matching::{STRAIGHT, Turn, Wanted, goal, lever};
use self::nodes::Nodes;
pub use self::params::{Method, Plastic, Settings};
use self::regions::Regions;
use self::shapes::Shapes;
use self::spin::Spins;
use self::uniform::{Step, Uniform};

/// Nodes that one task does at least, of loops that do little for each.
const TASK: usize = 4096;

/// The word in scene files.
pub const NAME: &str = "lattice";

/// Adds the lattice to a registry.
pub fn register(registry: Registry) -> Registry {
    let criteria = vec![
        CriterionEntry::whole("none", "nothing breaks", &[], |p, _, _| {
            Ok(Box::new(Lattice::new(Settings::new(p, f64::INFINITY)?)))
        }),
        CriterionEntry::whole(
            "critical_stretch",
            "a link between finest nodes breaks beyond a critical distance (Ohta et al.)",
            params::FRACTURE,
            |p, limit, _| Ok(Box::new(Lattice::new(Settings::new(p, limit.number("critical_stretch"))?))),
        ),
    ];
    let summary = "shape matching on an adaptive lattice, elastic or plastic (Ohta et al.)";
    registry.whole(NAME, summary, params::PARAMETERS, Wants::Cells, criteria)
}

/// A body whose goal shapes are matched to it.
#[derive(Debug, Default)]
pub struct Lattice {
    settings: Settings,
    finest: Finest,
    nodes: Nodes,
    /// Of each node, or each cluster: its rotation in the step before.
    turn: Buffer<[f32; 4]>,
    shapes: Shapes,
    derived: Derived,
    lists: Lists,
    /// What the last [`respond`](Material::respond) found: |S_ii − 1| of each node, and bits of links of finest nodes that break.
    strain: Vec<f32>,
    search: adapt::Search,
    breaking: Vec<u32>,
    breaks: bool,
    /// Positions within the passes of a step, mean deformations.
    moved: Vec<DVec3>,
    spins: Spins,
    /// How far all passes go [m]; empty where there is one.
    shift: Vec<DVec3>,
    deformation: Vec<DMat3>,
}

/// What follows from columns.
#[derive(Debug, Default)]
struct Derived {
    /// Whether the nodes are known, and the regions.
    nodes: bool,
    regions_known: bool,
    regions: Regions,
    uniform: Option<Uniform>,
    /// The coarsest level that each cell may be carried at.
    top: Vec<u8>,
    /// How far the region of each cell spreads in the uniform lattice [m²], where β needs it.
    fine: Vec<f64>,
    /// Connected piece of each node; empty while there is one.
    piece: Vec<u32>,
    pieces: usize,
    /// Nodes of each piece; empty while there is one.
    piece_nodes: Vec<u32>,
    version: u64,
}

impl Derived {
    fn set_pieces(&mut self, piece: Vec<u32>, pieces: usize) {
        self.piece_nodes = vec![0; if pieces > 1 { pieces } else { 0 }];
        self.piece = if pieces > 1 { piece } else { Vec::new() };
        self.piece.iter().for_each(|&p| self.piece_nodes[p as usize] += 1);
        self.pieces = pieces;
        self.version += 1;
    }
}

impl Lattice {
    /// A lattice with these settings, before it is built or restored.
    pub fn new(settings: Settings) -> Self {
        Self { settings, ..Self::default() }
    }

    /// Makes what follows from columns, as far as it is not there.
    fn know_nodes(&mut self) {
        if self.derived.nodes {
            return;
        }
        self.finest.find_neighbours();
        self.nodes.derive(&self.finest);
        self.derived.top = adapt::tops(&self.finest, &self.settings);
        let settings = &self.settings;
        if settings.method == Method::Ohta && settings.levels > 0 && !settings.as_written {
            self.derived.fine = regions::fine_spread(&self.finest, settings.half_width);
        }
        self.find_pieces();
        self.search.forget();
        self.derived.nodes = true;
        self.derived.regions_known = false;
    }

    fn find_pieces(&mut self) {
        let (piece, pieces) = self.nodes.pieces(&self.finest);
        self.derived.set_pieces(piece, pieces);
    }

    fn know_regions(&mut self) {
        self.know_nodes();
        if self.derived.regions_known {
            return;
        }
        let uniform = self.settings.per_node() && self.settings.levels == 0;
        self.derived.uniform = if uniform { Uniform::new(&self.finest, self.settings.half_width) } else { None };
        self.connect(None, None);
    }

    /// Finds the regions: those that `before` does not know, and cubes near the cells in `changed` or all.
    fn connect(&mut self, before: Option<(&Regions, &[u32], &[u32])>, changed: Option<&[u32]>) {
        let Derived { regions, uniform, fine, .. } = &mut self.derived;
        let (finest, nodes, settings) = (&self.finest, &self.nodes, &self.settings);
        // a full cell weighs as much for its volume as all together
        let density = finest.mass.iter().sum::<f64>() / finest.volume.iter().sum::<f64>();
        let unit = density * finest.size().powi(3);
        let total = match uniform {
            Some(uniform) => {
                uniform.find_torn(finest, changed);
                regions.around(&uniform.torn, finest, nodes, settings.half_width, None);
                uniform.settle(finest, settings);
                (0..nodes.len()).map(|k| uniform.count(k) * nodes.mass[k]).collect()
            }
            None if settings.per_node() => {
                let all: Vec<u32> = (0..nodes.len() as u32).collect();
                regions.around(&all, finest, nodes, settings.half_width, before);
                regions.totals(nodes.len())
            }
            None => {
                regions.clusters(finest, nodes, settings);
                regions.totals(nodes.len())
            }
        };
        regions.divide(&total);
        regions.settle(nodes, settings, unit, fine, before.map(|(old, ..)| old));
        self.lists.settle(nodes);
        let slots = if settings.per_node() { nodes.len() } else { regions.len() };
        if self.turn.len() != slots {
            self.turn.set(vec![STRAIGHT; slots]);
        }
        if settings.plastic.is_some() && self.shapes.len() != slots {
            self.shapes.set((0..slots).map(|_| DMat3::IDENTITY));
        }
        self.derived.regions_known = true;
    }

    /// Finds the mean goals of nodes at `x` [m], and the deformations there if `all` is asked for.
    fn gather(&mut self, x: &[DVec3], all: bool) {
        let Self { settings, finest, nodes, turn, shapes, derived, lists, .. } = self;
        let origin = x[0];
        if let Some(uniform) = &mut derived.uniform {
            uniform.gather(&Step { x, origin, finest, turns: turn, shapes, settings });
        }
        if derived.regions.len() > 0 {
            lists.gather(x, nodes, &derived.regions, turn, shapes, Wanted { settings, all });
            lists.scatter(&derived.regions, nodes.len());
        }
    }

    /// From `x` to the mean goal of each node, by what [`gather`](Self::gather) has found.
    fn way(&self, i: usize, x: DVec3, origin: DVec3) -> DVec3 {
        match &self.derived.uniform {
            None => self.lists.way(i, x, origin),
            Some(uniform) => {
                let whole = uniform.goal(i) / uniform.count(i);
                let torn = match self.derived.regions.len() {
                    0 => DVec3::ZERO,
                    _ => goal(&self.lists.means[i], lever(self.nodes.rest[i])),
                };
                whole + torn - (x - origin)
            }
        }
    }

    /// Notes how far each node's region is stretched.
    fn measure(&mut self) {
        self.strain.clear();
        if self.settings.levels > 0 {
            self.strain.extend(self.lists.found.iter().map(|f| f.strain));
        }
    }

    /// Goals of where nodes will be, by as much as damping asks, and then of where they are after each pass. A pass turns nothing
    /// as a whole about the places that it starts from, which are not those of the step: what all together turn is taken back.
    fn shift_by_passes(&mut self, p: &BodyParticles<'_>, share: f64, dt: f64) {
        let mut x = std::mem::take(&mut self.moved);
        let mut shift = std::mem::take(&mut self.shift);
        shift.resize(p.len(), DVec3::ZERO);
        x.clear();
        x.extend(p.position.iter().zip(p.velocity).map(|(x, v)| *x + *v * (dt * self.settings.damping)));
        for pass in 0..self.settings.passes {
            self.gather(&x, false);
            if pass == 0 {
                self.measure();
            }
            let (this, origin) = (&*self, x[0]);
            x.par_iter_mut().zip(&mut shift).enumerate().with_min_len(TASK).for_each(|(i, (x, shift))| {
                let step = this.way(i, *x, origin) * share;
                *shift += step;
                *x += step;
            });
        }
        self.shift = shift;
        let moved = x;
        self.moved = moved;
        let piece = |i: usize| self.derived.piece.get(i).map_or(0, |&k| k as usize);
        let spins = &mut self.spins;
        spins.reset(self.derived.pieces, (0..p.len()).map(|i| (piece(i), p.mass[i], p.position[i])));
        (0..p.len()).for_each(|i| spins.gain(piece(i), p.mass[i], p.position[i], self.shift[i]));
        spins.solve();
        self.shift.iter_mut().enumerate().for_each(|(i, shift)| *shift += spins.at(piece(i), p.position[i]));
    }

    /// S of a region or cube, where rest shapes flow; for nodes of a uniform lattice by node.
    fn flow_shapes(&mut self, dt: f64) {
        let Some(told) = self.settings.plastic else { return };
        let Self { derived, shapes, lists, .. } = self;
        if let Some(uniform) = &derived.uniform {
            let whole = (0..shapes.len()).filter(|&k| uniform.is_whole(k));
            whole.for_each(|k| shapes.flow(k, uniform.stretch(k), told, dt));
        }
        for region in 0..derived.regions.len() {
            shapes.flow(derived.regions.slot(region), lists.found[region].stretch, told, dt);
        }
    }
}

impl Material for Lattice {
    fn build(&mut self, g: Geometry<'_>) -> Result<(), BuildError> {
        let p = g.particles;
        let Neighbourhood::Cells(cells) = g.neighbourhood else {
            return Err(BuildError::Unfit { wanted: "the cells of a lattice" });
        };
        cells.check(p.len())?;
        for (what, column) in [("volume", p.volume), ("mass", p.mass)] {
            if let Some(particle) = column.iter().position(|&x| !(x > 0.0 && x.is_finite())) {
                return Err(BuildError::NotPositive { particle, what, value: column[particle] });
            }
        }
        self.nodes = Nodes::finest(cells.len());
        self.finest = Finest::new(cells, p.rest, p.volume, p.mass);
        self.derived = Derived::default();
        self.know_nodes();
        Ok(())
    }

    fn stable_dt(&self, _: &BodyParticles<'_>) -> f64 {
        f64::INFINITY
    }

    fn position_based(&self) -> bool {
        true
    }

    fn wake(&mut self) {
        self.know_nodes();
    }

    fn respond(&mut self, p: &BodyParticles<'_>, dt: f64, dv: &mut [DVec3]) {
        self.know_regions();
        let share = self.settings.share(dt);
        self.shift.clear();
        if self.settings.passes > 1 || self.settings.damping > 0.0 {
            self.shift_by_passes(p, share, dt);
        } else {
            self.gather(p.position, false);
            self.measure();
        }
        let (this, origin) = (&*self, p.position[0]);
        dv.par_iter_mut().enumerate().with_min_len(TASK).for_each(|(i, dv)| {
            *dv += match this.shift.get(i) {
                None => this.way(i, p.position[i], origin) * (share / dt),
                Some(shift) => *shift / dt,
            };
        });
        self.judge(p);
    }

    fn flow(&mut self, dt: f64) {
        let Self { derived, turn, lists, .. } = self;
        if let Some(uniform) = &derived.uniform {
            turn.par_iter_mut().enumerate().with_min_len(TASK).for_each(|(k, turn)| *turn = uniform.turn(k));
        }
        let turn = &mut turn[..];
        for region in 0..derived.regions.len() {
            turn[derived.regions.slot(region)] = lists.found[region].turn;
        }
        self.flow_shapes(dt);
    }

    fn fracture(&mut self, damage: &mut [f32], cuts: &mut Vec<Link>) {
        self.part(damage, cuts);
    }

    fn adapts(&self) -> bool {
        self.settings.levels > 0
    }

    fn adapt(&mut self, now: &Present<'_>, next: &mut Renewal) -> bool {
        self.know_nodes();
        self.renew(now, next)
    }

    fn touching(&self) -> Option<Touching<'_>> {
        let Derived { piece, version, .. } = &self.derived;
        (self.nodes.exposed.len() == self.nodes.len()).then_some(Touching {
            piece,
            exposed: &self.nodes.exposed,
            version: *version,
        })
    }

    fn lattice<'a>(&'a mut self, p: &BodyParticles<'a>) -> Option<LatticePose<'a>> {
        self.know_regions();
        self.gather(p.position, true);
        let mut deformation = std::mem::take(&mut self.deformation);
        deformation.resize(p.len(), DMat3::IDENTITY);
        // of a torn cell the cube is not asked any more: what it last said would not survive a restart
        let mut turns: Vec<Turn> = Vec::new();
        if let Some(uniform) = &self.derived.uniform {
            turns.extend((0..p.len()).map(|k| uniform.turn(k)));
            for region in 0..self.derived.regions.len() {
                turns[self.derived.regions.slot(region)] = self.lists.found[region].turn;
            }
        }
        deformation.par_iter_mut().enumerate().with_min_len(256).for_each(|(i, to)| {
            *to = match turns.get(i) {
                Some(turn) => self.finest.gradient(i, p.position, *turn),
                None => self.lists.gradient(i, &self.derived.regions),
            };
        });
        self.deformation = deformation;
        Some(LatticePose {
            carrier: &self.finest.carrier,
            rest: &self.nodes.rest,
            position: p.position,
            velocity: p.velocity,
            deformation: &self.deformation,
            links: &self.finest.links,
        })
    }

    fn carrier(&self) -> &[u32] {
        &self.finest.carrier
    }

    fn nodes(&self) -> Option<NodeCounts> {
        let mut levels = vec![0; self.settings.levels as usize + 1];
        self.nodes.level.iter().for_each(|&l| levels[usize::from(l)] += 1);
        Some(NodeCounts { levels, pieces: self.derived.pieces })
    }

    fn consistent(&self, particles: usize) -> bool {
        let sound = |t: &Turn| (t.iter().map(|x| x * x).sum::<f32>() - 1.0).abs() < 1e-3;
        let most = self.settings.levels;
        if self.nodes.len() != particles
            || !self.finest.consistent(particles)
            || !self.nodes.consistent(&self.finest, most)
        {
            return false;
        }
        let slots = match self.settings.per_node() {
            true => particles,
            false => {
                // clusters are counted by finding them
                let mut fresh = self.finest.clone();
                fresh.find_neighbours();
                let mut nodes = Nodes::finest(particles);
                nodes.derive(&fresh);
                let mut regions = Regions::default();
                regions.clusters(&fresh, &nodes, &self.settings);
                regions.len()
            }
        };
        // a lattice that has not made a step yet remembers nothing
        let fits = |n: usize| n == slots || n == 0;
        fits(self.turn.len())
            && self.turn.iter().all(sound)
            && fits(self.shapes.len())
            && self.shapes.consistent(self.shapes.len())
            && (self.settings.plastic.is_some() || self.shapes.len() == 0)
    }

    fn visit(&mut self, scope: &str, v: &mut Visitor<'_>) {
        let scope = format!("{scope}/lattice");
        let here = |l: &Self| [l.finest.links.as_ptr() as usize, l.finest.carrier.as_ptr() as usize];
        let before = here(self);
        self.finest.visit(&scope, v);
        self.nodes.visit(&scope, v);
        v(&scope, &Column::live("turn", "1", Of::Thing), &mut self.turn);
        self.shapes.visit(&scope, v);
        if here(self) != before {
            self.derived = Derived::default();
            self.strain.clear();
            self.breaks = false;
        }
    }
}
