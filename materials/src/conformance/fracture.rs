//! What is asked of breaking: both directions together, every cut reported once, and no force across.

use fissure_engine::{Link, World};
use glam::DVec3;

use super::body::{Given, Subject, difference, exact_forces, forces, put, strained, vector};
use super::force::self_force;
use super::report::{Finding, Trouble, at_most, fail, skip};

/// Every criterion beside the law.
pub(super) fn together(subject: &Subject<'_>) -> Finding {
    if subject.breaking.is_empty() {
        return skip("no criterion that breaks is registered with it");
    }
    let mut notes = Vec::new();
    for (name, given) in &subject.breaking {
        let Ok(given) = given else {
            return fail(format!("`{name}`: {}", given.as_ref().unwrap_err()));
        };
        let criterion = (name.clone(), given.clone());
        let what = |t| match t {
            Trouble::Fail(note) => Trouble::Fail(format!("`{name}`: {note}")),
            Trouble::Skip(note) => Trouble::Skip(format!("`{name}`: {note}")),
        };
        let partial = tear(subject, &criterion).map_err(what)?;
        part(subject, &criterion).map_err(what)?;
        notes.push(format!("`{name}`: {:.0} % broken on the way", 100.0 * partial));
    }
    Ok(notes.join("; "))
}

/// Evaluates, flows and breaks at the present positions; the cuts.
fn breaks(world: &mut World) -> Vec<Link> {
    forces(world);
    let (body, p) = (&mut world.bodies[0], &mut world.particles);
    body.material.flow(world.dt);
    let mut cuts = Vec::new();
    body.material.fracture(&mut p.damage[body.range.clone()], &mut cuts);
    cuts
}

/// Undirected bonds that hold. Fails if only one direction of a bond does.
fn holding(world: &World) -> Result<Vec<Link>, Trouble> {
    let Some(bonds) = world.bodies[0].material.bonds() else {
        return skip("the material has no bonds");
    };
    let mut out = Vec::new();
    for i in 0..bonds.rows() {
        for slot in bonds.slots(i) {
            let j = bonds.neighbours[slot] as usize;
            if !bonds.slots(j).any(|s| bonds.neighbours[s] as usize == i) {
                return fail(format!("the bond from {i} to {j} holds, that from {j} to {i} is broken"));
            }
            if i < j {
                out.push(Link { i: i as u32, j: j as u32 });
            }
        }
    }
    out.sort_unstable_by_key(|l| (l.i, l.j));
    Ok(out)
}

/// Tears the block further and further, unevenly. After each stage both directions agree, the cuts are the bonds that are
/// gone, damage is the share of them, and what is left exerts no force on itself. Answers with the share that was broken
/// at the stage nearest to half.
fn tear(subject: &Subject<'_>, criterion: &(String, Given)) -> Result<f64, Trouble> {
    let mut world = subject.block([7, 6, 5], &subject.given, criterion)?;
    let whole = holding(&world)?;
    let mut before = whole.clone();
    let mut nearest = 0.0f64;
    let mut size = 1e-4;
    while size < 3.0 {
        let mut places = strained(&world, size);
        for (i, x) in places.iter_mut().enumerate() {
            let rest = world.particles.rest[i].as_dvec3();
            *x += (vector(i, 11) * 0.3 + DVec3::new(rest.x * rest.x, 0.0, rest.y * rest.x)) * size;
        }
        put(&mut world, &places, |x| x);
        let mut cuts = breaks(&mut world);
        let now = holding(&world)?;
        cuts.sort_unstable_by_key(|l| (l.i, l.j));
        let gone: Vec<Link> =
            before.iter().filter(|l| now.binary_search_by_key(&(l.i, l.j), |n| (n.i, n.j)).is_err()).copied().collect();
        if cuts != gone {
            return fail(format!("{} cuts are reported of {} bonds that broke", cuts.len(), gone.len()));
        }
        damage(&world)?;
        let force = exact_forces(&mut world);
        at_most(self_force(&world, &force), 1e-12, "half torn, it exerts on itself")?;
        let share = 1.0 - now.len() as f64 / whole.len() as f64;
        if (share - 0.5).abs() < (nearest - 0.5).abs() {
            nearest = share;
        }
        before = now;
        size *= 1.25;
    }
    if nearest == 0.0 {
        return fail("nothing breaks at strains up to 3; give the criterion other parameters with `Case::criterion`");
    }
    Ok(nearest)
}

/// φ = 1 − n/N.
fn damage(world: &World) -> Result<(), Trouble> {
    let Some(bonds) = world.bodies[0].material.bonds() else { return Ok(()) };
    for i in 0..bonds.rows() {
        let want = 1.0 - bonds.slots(i).count() as f32 / bonds.family[i] as f32;
        let is = world.particles.damage[i];
        if (is - want).abs() > 1e-6 {
            return fail(format!("the damage of particle {i} is {is}, but {want} of its bonds are broken"));
        }
    }
    Ok(())
}

/// Pulls the halves apart: every bond between them breaks, and then neither feels where the other is.
fn part(subject: &Subject<'_>, criterion: &(String, Given)) -> Result<(), Trouble> {
    let mut world = subject.block([7, 6, 5], &subject.given, criterion)?;
    let right: Vec<bool> = world.particles.rest.iter().map(|x| x.x > 0.0).collect();
    // little strain, so that the halves themselves hold
    let rest = strained(&world, 1e-4);
    let at = |world: &mut World, away: DVec3| {
        let places: Vec<DVec3> = rest.iter().zip(&right).map(|(x, r)| if *r { *x + away } else { *x }).collect();
        put(world, &places, |x| x);
    };
    at(&mut world, DVec3::new(3.0, 0.5, 0.0));
    breaks(&mut world);
    let across = holding(&world)?.iter().filter(|l| right[l.i as usize] != right[l.j as usize]).count();
    if across > 0 {
        let horizon = super::body::HORIZON;
        return fail(format!(
            "{across} bonds hold across a gap of 3 m, at a horizon of {horizon} m; if they rightly flow instead, give the \
             criterion parameters at which they break with `Case::criterion`"
        ));
    }
    let mut left = |away: DVec3| -> Vec<DVec3> {
        at(&mut world, away);
        let all = exact_forces(&mut world);
        all.into_iter().zip(&right).filter(|(_, r)| !**r).map(|(f, _)| f).collect()
    };
    let (near, far) = (left(DVec3::new(3.0, 0.5, 0.0)), left(DVec3::new(0.0, -4.0, 2.0)));
    at_most(difference(&near, &far), 1e-6, "of the force, one half feels the other by")?;
    Ok(())
}
