//! What contact costs: the fall on the ground of a block that stays whole (3e5 particles) and of one that shatters (6.4e4).

use criterion::Criterion;
use fissure_bench::{Lattice, SPACING};
use fissure_engine::{Collider, Phase, World};
use glam::DVec3;

use super::{Per, group, measure};

/// A block just above the ground, and `steps` of its fall at 300 m/s: 8 % of its speed of sound, so that it crosses a
/// particle in 30 steps.
fn fall(lattice: Lattice<'_>, steps: usize) -> World {
    let mut world = lattice.world(&fissure_materials::registry());
    let lowest = world.particles.position.iter().map(|x| x.y).fold(f64::INFINITY, f64::min);
    world.colliders.push(Collider::plane("ground", DVec3::Y, lowest - 0.52 * SPACING));
    world.particles.velocity.iter_mut().for_each(|v| *v += DVec3::NEG_Y * 300.0);
    (0..steps).for_each(|_| world.step().expect("stable"));
    world
}

/// Contact per particle and step, and its share of the rest of the step: at most 15 % intact and 50 % shattered are wanted.
pub fn contact(c: &mut Criterion) {
    let mut group = group(c, "contact");
    let whole = Lattice::default();
    let brittle = Lattice { edge: 40, critical_stretch: 0.004, ..whole };
    for (name, lattice, steps) in [("intact", whole, 10), ("shattered", brittle, 300)] {
        let mut fallen = None;
        let per = Per { unit: "particle", count: lattice.particles() };
        measure(&mut group, &format!("contact {name}"), per, || {
            let (world, _) = fallen.get_or_insert_with(|| {
                let world = fall(lattice, steps);
                let profile = world.profile;
                (world, profile)
            });
            let before = world.profile;
            world.step().expect("stable");
            (world.profile.spent(Phase::Contact) - before.spent(Phase::Contact), None)
        });
        if let Some((world, before)) = fallen {
            let contact = world.profile.spent(Phase::Contact) - before.spent(Phase::Contact);
            let rest = world.profile.total() - before.total() - contact;
            let (share, (bonds, broken)) = (100.0 * contact.as_secs_f64() / rest.as_secs_f64(), world.bond_counts());
            println!(
                "{name}: {broken} of {bonds} bonds broken, {} of {} particles exposed, {} builds in {} steps; contact adds \
                 {share:.1} % to a step",
                world.contact.exposed(),
                lattice.particles(),
                world.contact.builds(),
                world.step
            );
        }
    }
    group.finish();
}
