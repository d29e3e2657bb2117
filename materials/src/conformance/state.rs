//! What is asked of state: that evaluating leaves it alone, that it is all in the columns, that no thread matters.

use fissure_engine::World;
use glam::DVec3;

use super::body::{
    Columns, Given, Subject, columns, energy, first_difference, forces, put, reference_forces, strained,
};
use super::report::{Finding, Trouble, fail};

/// Steps before and after a restart.
const STEPS: usize = 16;

/// The criteria to run with: the calm one, and all others whose parameters are known.
fn criteria(subject: &Subject<'_>) -> Vec<(String, Given)> {
    let known = subject.breaking.iter().filter_map(|(name, given)| Some((name.clone(), given.clone().ok()?)));
    std::iter::once(subject.calm.clone()).chain(known).collect()
}

/// A block of `edges` that is being torn: in `STEPS` steps one side of it would be strained by 0.4 if nothing held it.
fn torn(subject: &Subject<'_>, edges: [usize; 3], criterion: &(String, Given)) -> Result<World, Trouble> {
    let mut world = subject.block(edges, &subject.given, criterion)?;
    let rate = 0.4 / (STEPS as f64 * world.dt);
    for i in 0..world.particles.len() {
        let x = world.particles.rest[i].as_dvec3();
        let pull = DVec3::new(x.x + 0.5 * x.y.abs(), -0.2 * x.y, 0.3 * x.x - x.z) * rate;
        world.particles.velocity[i] = if x.x > 0.1 { pull } else { DVec3::ZERO };
    }
    Ok(world)
}

fn run(world: &mut World, steps: usize) -> Result<(), Trouble> {
    (0..steps).try_for_each(|_| world.step()).map_err(Trouble::from)
}

/// The same bits, and no column changes, whether forces are evaluated once, twice, or after energies and references.
pub(super) fn repeat(subject: &Subject<'_>) -> Finding {
    let mut world = torn(subject, [7, 6, 5], &subject.calm)?;
    run(&mut world, STEPS)?;
    let places = strained(&world, 0.1);
    put(&mut world, &places, |x| x);
    let before = columns(&mut world);
    let first = forces(&mut world);
    if first != forces(&mut world) {
        return fail("the second evaluation gives other forces");
    }
    let (energies, references) = (energy(&mut world), reference_forces(&world));
    if energies != energy(&mut world) || references != reference_forces(&world) {
        return fail("the second evaluation gives another energy or other reference forces");
    }
    if first != forces(&mut world) {
        return fail("the forces are others after the energy was asked for");
    }
    match first_difference(&before, &columns(&mut world)) {
        Some(column) => fail(format!("evaluating changes the column {column}")),
        None => Ok("forces, energy and all columns to the bit".into()),
    }
}

/// Influence and memory of i→j, kept by i, are what j keeps of the same direction; so are those of j→i.
pub(super) fn twins(subject: &Subject<'_>) -> Finding {
    let mut world = torn(subject, [7, 6, 5], &subject.calm)?;
    run(&mut world, STEPS)?;
    let saved = columns(&mut world);
    let Some(bonds) = world.bodies[0].material.bonds() else {
        return Ok("no bonds".into());
    };
    let at = |bytes: &[u8], slot: usize| bytes.get(4 * slot..4 * slot + 4).map(<[u8]>::to_vec);
    let memories: Vec<(&str, &[u8], &[u8])> = saved
        .iter()
        .filter_map(|(name, own)| {
            let twin = name.replace("/memory/", "/twin_memory/");
            let found = saved.iter().find(|(n, _)| *n == twin && *n != *name);
            found.map(|(_, twin)| (name.as_str(), &own[..], &twin[..]))
        })
        .collect();
    for i in 0..bonds.rows() {
        for slot in bonds.slots(i) {
            let j = bonds.neighbours[slot] as usize;
            let Some(back) = bonds.slots(j).find(|&s| bonds.neighbours[s] as usize == i) else {
                return fail(format!("{i} is bound to {j}, but not {j} to {i}"));
            };
            let volume = |i: usize| world.particles.volume[i];
            let influence = |slot: usize, end: usize| f64::from(bonds.weight[slot]) / volume(end);
            let (there, here) = (influence(slot, j), influence(back, i));
            if (there - here).abs() > 1e-6 * here.abs() {
                return fail(format!(
                    "ω is {there} from {i} to {j} and {here} back; it must not change with the sign of ξ"
                ));
            }
            for (name, own, twin) in &memories {
                if at(own, slot) != at(twin, back) || at(twin, slot) != at(own, back) {
                    return fail(format!("{name} of the bond from {i} to {j} is another one in the row of {j}"));
                }
            }
        }
    }
    Ok(format!("influence and {} remembered numbers to the bit", memories.len()))
}

/// Runs 2N steps; and N, restores the columns into a fresh world, and runs N.
pub(super) fn restart(subject: &Subject<'_>) -> Finding {
    let mut broken = 0;
    for criterion in criteria(subject) {
        let mut straight = torn(subject, [7, 6, 5], &criterion)?;
        run(&mut straight, STEPS)?;
        let saved = columns(&mut straight);
        run(&mut straight, STEPS)?;
        let mut fresh = subject.block([7, 6, 5], &subject.given, &criterion)?;
        restore(&mut fresh, &saved)?;
        run(&mut fresh, STEPS)?;
        broken += straight.bond_counts().1;
        if let Some(column) = first_difference(&columns(&mut straight), &columns(&mut fresh)) {
            return fail(format!("with `{}` the column {column} is another one after a restart", criterion.0));
        }
    }
    Ok(format!("all columns to the bit, {broken} bonds broken"))
}

fn restore(world: &mut World, saved: &Columns) -> Result<(), Trouble> {
    let (mut k, mut wrong) = (0, None);
    world.visit(&mut |scope, column, data| {
        match saved.get(k) {
            Some((name, bytes)) if *name == format!("{scope}/{}", column.name) && data.set_bytes(bytes) => {}
            _ => wrong = wrong.take().or(Some(format!("{scope}/{}", column.name))),
        }
        k += 1;
    });
    match wrong {
        Some(name) => fail(format!("the column {name} cannot be restored")),
        None => Ok(()),
    }
}

/// One, two and five threads.
pub(super) fn threads(subject: &Subject<'_>) -> Finding {
    let mut broken = 0;
    for criterion in criteria(subject) {
        let mut answers = Vec::new();
        for threads in [1, 2, 5] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
            let pool = pool.or_else(|e| fail(format!("no pool of {threads} threads: {e}")))?;
            let mut world = torn(subject, [9, 8, 7], &criterion)?;
            pool.install(|| run(&mut world, STEPS))?;
            broken += world.bond_counts().1;
            answers.push((threads, columns(&mut world)));
        }
        for (threads, columns) in &answers[1..] {
            if let Some(column) = first_difference(&answers[0].1, columns) {
                return fail(format!("with `{}` the column {column} is another one on {threads} threads", criterion.0));
            }
        }
    }
    Ok(format!("1, 2 and 5 to the bit, {} bonds broken", broken / 3))
}
