//! The block that we measure with: particles on a cubic lattice, with nothing of a file or a mesher in it.

use std::f64::consts::TAU;

use fissure_engine::column::Of;
use fissure_engine::{BodyInput, Families, Parameter, Registry, Surroundings, Value, World};
use glam::{DVec3, IVec3};

/// Distance of the particles [m].
pub const SPACING: f64 = 5e-4;

/// Values for the keys of laws and criteria: glass-like, and such that nothing yields. LAMMPS's influence and taper.
const NUMBERS: [(&str, f64); 9] = [
    ("bulk_modulus", 14.9e9),
    ("shear_modulus", 14.9e9),
    ("yield_stress", 14.9e9),
    ("relaxing_share", 0.5),
    ("relaxation_time", 1e-3),
    ("energy_release_rate", 1e9),
    ("tension_release_rate", 1e9),
    ("shear_release_rate", 1e9),
    ("taper", SPACING),
];

/// A cubic block of `edge`³ particles with everybody within `horizon`, in Morton order; ρ = 2200 kg/m³, a smooth motion of
/// at most 0.5 m/s, dt = 5e-8 s: what LAMMPS simulates beside us.
#[derive(Clone, Copy, Debug)]
pub struct Lattice<'a> {
    /// The constitutive law.
    pub law: &'a str,
    /// The fracture criterion.
    pub criterion: &'a str,
    /// Particles along an edge.
    pub edge: i32,
    /// Horizon in spacings.
    pub horizon: f64,
    /// Critical stretch, for the criterion of that name; by default nothing breaks.
    pub critical_stretch: f64,
}

impl Default for Lattice<'_> {
    /// 67³ particles with 161 neighbours on average (170 inside), isotropic, bits of fracture read.
    fn default() -> Self {
        Self { law: "isotropic", criterion: "critical_stretch", edge: 67, horizon: 3.4, critical_stretch: 0.5 }
    }
}

impl Lattice<'_> {
    /// Number of particles.
    pub fn particles(&self) -> u64 {
        (self.edge as u64).pow(3)
    }

    /// Number of directed bonds, without building any.
    pub fn directed(&self) -> u64 {
        let pairs = |s: &IVec3| s.to_array().iter().map(|d| (self.edge - d.abs()).max(0) as u64).product::<u64>();
        self.reach().iter().map(pairs).sum()
    }

    /// From a particle to the members of a whole family, in spacings.
    fn reach(&self) -> Vec<IVec3> {
        let (reach, squared) = (self.horizon as i32 + 1, self.horizon * self.horizon);
        let width = 2 * reach + 1;
        (0..width.pow(3))
            .map(|k| IVec3::new(k / (width * width), k / width % width, k % width) - reach)
            .filter(|s| *s != IVec3::ZERO && s.as_dvec3().length_squared() <= squared)
            .collect()
    }

    /// Places in Morton order, and who is near whom.
    pub fn families(&self) -> (Vec<DVec3>, Families) {
        let n = self.edge;
        let mut cells: Vec<IVec3> = (0..n.pow(3)).map(|k| IVec3::new(k / (n * n), k / n % n, k % n)).collect();
        let spread = |x: i32| (0..10).fold(0u32, |m, b| m | ((x as u32 >> b & 1) << (3 * b)));
        cells.sort_unstable_by_key(|c| spread(c.x) << 2 | spread(c.y) << 1 | spread(c.z));
        let mut number = vec![0u32; cells.len()];
        let place = |c: IVec3| ((c.x * n + c.y) * n + c.z) as usize;
        cells.iter().enumerate().for_each(|(k, &c)| number[place(c)] = k as u32);
        let reach = self.reach();
        let mut families = Families { offsets: vec![0], neighbours: Vec::with_capacity(self.directed() as usize) };
        for &c in &cells {
            let start = families.neighbours.len();
            let inside = reach.iter().map(|s| c + s).filter(|t| t.min_element() >= 0 && t.max_element() < n);
            families.neighbours.extend(inside.map(|t| number[place(t)]));
            families.neighbours[start..].sort_unstable();
            families.offsets.push(families.neighbours.len() as u32);
        }
        (cells.iter().map(|c| c.as_dvec3() * SPACING).collect(), families)
    }

    /// What `parameters` ask for, of what is known here.
    fn given(&self, parameters: &[Parameter]) -> Vec<(String, Value)> {
        let numbers = NUMBERS.iter().map(|&(key, value)| (key, Value::Number(value)));
        let others = [
            ("critical_stretch", Value::Number(self.critical_stretch)),
            ("influence", Value::Word("inverse".into())),
            ("matrix", Value::List(vec![1.0, 1.0, 2.0])),
        ];
        let asked = |key: &str| parameters.iter().any(|p| p.name == key);
        numbers.chain(others).filter(|(key, _)| asked(key)).map(|(key, value)| (key.to_string(), value)).collect()
    }

    /// The block as a world.
    ///
    /// # Panics
    /// If `registry` has no such law or criterion, or it wants a parameter that is not known here.
    pub fn world(&self, registry: &Registry) -> World {
        let (points, families) = self.families();
        let volumes = vec![SPACING.powi(3); points.len()];
        self.world_of(registry, &Cloud { points, volumes, spacing: SPACING }, families)
    }

    /// The same law and motion in other particles; the horizon is in mean spacings of those.
    ///
    /// # Panics
    /// As [`world`](Self::world); and if a volume is not positive, or `families` are of other particles.
    pub fn world_of(&self, registry: &Registry, cloud: &Cloud, families: Families) -> World {
        let ids: Vec<u32> = (0..cloud.points.len() as u32).collect();
        let entry = registry.entry(self.law).expect("a registered law");
        let breaks = entry.criteria.iter().find(|c| c.name == self.criterion).expect("a registered criterion");
        let at = Surroundings { horizon: self.horizon * cloud.spacing, spacing: cloud.spacing };
        let (law, criterion) = (self.given(entry.parameters), self.given(breaks.parameters));
        let material = registry.make((self.law, law), (self.criterion, criterion), &at).expect("valid parameters");
        let mut world = World::default();
        world.dt = 5e-8;
        let input = BodyInput {
            name: "block",
            points: &cloud.points,
            volumes: &cloud.volumes,
            ids: &ids,
            density: 2200.0,
            spacing: cloud.spacing,
            horizon: at.horizon,
            velocity: DVec3::ZERO,
            spin: DVec3::ZERO,
            neighbourhood: families.into(),
        };
        world.add(input, material).expect("volumes are positive");
        let side = f64::from(self.edge) * SPACING;
        for (v, point) in world.particles.velocity.iter_mut().zip(&cloud.points) {
            let w = *point * (TAU / side);
            *v = DVec3::new(w.x.sin() * w.y.cos(), w.y.sin() * w.z.cos(), w.z.sin() * w.x.cos()) * 0.5;
        }
        world
    }
}

/// Particles that need not be a lattice, in an order that keeps neighbours together.
#[derive(Clone, Debug)]
pub struct Cloud {
    /// Places [m].
    pub points: Vec<DVec3>,
    /// Volumes [m³].
    pub volumes: Vec<f64>,
    /// Mean distance of neighbours [m].
    pub spacing: f64,
}

/// Bytes in columns per directed bond: those of bonds alone, and those of everything.
pub fn bytes_per_bond(world: &mut World) -> (f64, f64) {
    let (mut bonds, mut all) = (0, 0);
    world.visit(&mut |_, column, buffer| {
        let bytes = buffer.bytes().len();
        all += bytes;
        if matches!(column.of, Of::Bond | Of::Chunk | Of::Row) {
            bonds += bytes;
        }
    });
    let directed = world.bond_counts().0.max(1) as f64;
    (bonds as f64 / directed, all as f64 / directed)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bonds_are_as_many_as_lammps_makes() {
        let of = |edge, horizon| Lattice { edge, horizon, ..Lattice::default() };
        assert_eq!(of(37, 3.0001).directed(), 5_620_962);
        assert_eq!(of(67, 3.0001).directed(), 34_837_302);
        assert_eq!(of(67, 3.4).directed(), 48_320_310);
        let small = of(9, 3.4);
        let world = small.world(&fissure_materials::registry());
        assert_eq!((world.bond_counts().0, world.particles.len() as u64), (small.directed(), small.particles()));
    }
}
