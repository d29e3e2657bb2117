//! Bodies of cells that we measure shape matching with.

use fissure_engine::lattice::{Cells, NEIGHBOURS, morton};
use fissure_engine::world::BodyInput;
use fissure_engine::{Surroundings, Value, World};
use glam::DVec3;

/// Edge of a cell [m].
const SIZE: f64 = 0.01;

/// A cube of cells, slightly bent.
#[derive(Clone, Copy, Debug)]
pub struct Cube<'a> {
    /// Cells along an edge.
    pub edge: u32,
    /// The method of the lattice.
    pub method: &'a str,
    /// w of its regions.
    pub half_width: f64,
    /// Coarser levels.
    pub levels: f64,
}

impl Default for Cube<'_> {
    fn default() -> Self {
        Self { edge: 100, method: "lsm", half_width: 1.0, levels: 2.0 }
    }
}

impl Cube<'_> {
    /// The world with this body, in free flight.
    pub fn world(&self) -> World {
        body(self, |_| true)
    }
}

/// A ball of about 2250 cells.
pub fn ball(method: &str, levels: f64) -> World {
    let cube = Cube { edge: 16, method, half_width: 1.0, levels };
    body(&cube, |i| i.map(|x| (f64::from(x) - 7.5).powi(2)).iter().sum::<f64>() <= 8.13 * 8.13)
}

fn body(cube: &Cube<'_>, inside: impl Fn([u32; 3]) -> bool) -> World {
    let n = cube.edge;
    let all = (0..n * n * n).map(|k| [k % n, k / n % n, k / n / n]);
    let mut index: Vec<[u32; 3]> = all.filter(|&i| inside(i)).collect();
    index.sort_unstable_by_key(|&i| morton(i));
    let mut cells = Cells { size: SIZE, origin: DVec3::ZERO, index, links: vec![] };
    let there = |i: [u32; 3]| i.iter().all(|&x| x < n) && inside(i);
    let links = |i: &[u32; 3]| {
        let linked = (0..NEIGHBOURS.len()).filter(|&bit| Cells::across(*i, bit).is_some_and(there));
        linked.map(|bit| 1 << bit).sum::<u32>()
    };
    cells.links = cells.index.iter().map(links).collect();
    let middle = |i: &[u32; 3]| DVec3::from_array(i.map(f64::from)) * SIZE;
    let points: Vec<DVec3> = cells.index.iter().map(middle).collect();
    let word = |key: &str, word: &str| (key.to_string(), Value::Word(word.into()));
    let number = |key: &str, x: f64| (key.to_string(), Value::Number(x));
    let given = vec![word("method", cube.method), number("half_width", cube.half_width), number("levels", cube.levels)];
    let at = Surroundings { horizon: SIZE, spacing: SIZE };
    let material =
        fissure_materials::registry().make(("lattice", given), ("none", vec![]), &at).expect("valid parameters");
    let mut world = World::default();
    world.dt = 0.01;
    let input = BodyInput {
        name: "body",
        points: &points,
        volumes: &vec![SIZE.powi(3); points.len()],
        ids: &(0..points.len() as u32).collect::<Vec<_>>(),
        density: 1000.0,
        spacing: SIZE,
        horizon: SIZE,
        velocity: DVec3::ZERO,
        spin: DVec3::new(0.1, 0.05, 0.0),
        neighbourhood: cells.into(),
    };
    world.add(input, material).expect("a lattice");
    let side = f64::from(n) * SIZE;
    for (v, x) in world.particles.velocity.iter_mut().zip(&points) {
        v.y += 0.05 * (x.x / side * 6.0).sin();
    }
    world
}
