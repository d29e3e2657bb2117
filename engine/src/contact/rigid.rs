//! Contacts of free colliders: sequential impulses over one list, in a fixed order.
//!
//! A contact is between a free collider and a particle, or a free collider and any other. Both sides get the same impulse at
//! the same point with opposite signs, so linear and angular momentum are kept to round-off. Rigid things pass impulses on
//! at once, so the list is gone through several times, each contact correcting the sum of its impulses (Catto 2005), which
//! begins with that of the step before; that is serial, and small beside the bonds.

use glam::{DMat3, DVec3};

use super::approach::{Approach, Pose, rebound};
use super::collider::Collider;
use super::manifold::{Key, Side, Solids};
use crate::buffer::Buffer;
use crate::column::{Column, Of, Visitor};

/// Passes over the list. One stops what is light on what is heavy; a box on its corners needs some more.
const SWEEPS: usize = 8;
/// Sweeps end early where no impulse changed by more than this share of the largest.
const SETTLED: f64 = 1e-9;

/// A collider's motion while the contacts of a step are worked out.
#[derive(Clone, Copy, Debug)]
pub struct Mover {
    position: DVec3,
    velocity: DVec3,
    angular_momentum: DVec3,
    inv_mass: f64,
    inv_inertia: DMat3,
}

impl Mover {
    /// The collider after its own fall in the step.
    pub fn new(c: &Collider, fall: DVec3) -> Self {
        let free = c.is_free();
        Self {
            position: c.position,
            velocity: if free { c.velocity + fall } else { DVec3::ZERO },
            angular_momentum: c.angular_momentum,
            inv_mass: 1.0 / c.mass(),
            inv_inertia: c.inverse_inertia(),
        }
    }

    /// Velocity [m/s] at `x`.
    #[inline]
    pub fn at(&self, x: DVec3) -> DVec3 {
        self.velocity + (self.inv_inertia * self.angular_momentum).cross(x - self.position)
    }

    fn push(&mut self, impulse: DVec3, x: DVec3) {
        self.velocity += impulse * self.inv_mass;
        self.angular_momentum += (x - self.position).cross(impulse);
    }

    /// How much a unit impulse along `n` at `x` changes the velocity there along `n` [1/kg].
    fn yielding(&self, x: DVec3, n: DVec3) -> f64 {
        let turn = (x - self.position).cross(n);
        self.inv_mass + turn.dot(self.inv_inertia * turn)
    }

    /// Gives the collider its new motion.
    pub fn settle(&self, c: &mut Collider) {
        (c.velocity, c.angular_momentum) = (self.velocity, self.angular_momentum);
    }
}

/// What pushes against a free collider.
#[derive(Clone, Copy, Debug)]
pub enum Other {
    /// A particle, with the inverse of its mass, 0 while it is held [1/kg].
    Particle(u32, f64),
    /// Another collider, with the velocity of its path at the point [m/s].
    Collider(u32, DVec3),
}

/// One contact of the step.
#[derive(Clone, Copy, Debug)]
pub struct Contact {
    /// The free collider whose surface is met, or that meets another's.
    body: u32,
    other: Other,
    /// Where [m]; of a particle its middle, so that neither side is given a torque that the other is not.
    x: DVec3,
    /// From the collider `body` towards the other.
    normal: DVec3,
    speed: f64,
    friction: f64,
    /// Impulse on the other so far [kg m/s].
    along: f64,
    across: DVec3,
    /// What touches, of two colliders.
    key: Option<Key>,
}

/// The motion of everything that contacts change.
pub struct Motions<'a> {
    /// The colliders.
    pub movers: &'a mut [Mover],
    /// Velocities of the particles at the start of the step [m/s].
    pub velocity: &'a [DVec3],
    /// Velocity changes [m/s].
    pub dv: &'a mut [DVec3],
}

impl Motions<'_> {
    /// Velocity of a particle at the end of the step [m/s].
    #[inline]
    pub fn particle(&self, i: usize) -> DVec3 {
        self.velocity[i] + self.dv[i]
    }

    fn other(&self, other: Other, x: DVec3) -> DVec3 {
        match other {
            Other::Particle(i, _) => self.particle(i as usize),
            Other::Collider(k, path) => self.movers[k as usize].at(x) + path,
        }
    }

    fn relative(&self, c: &Contact) -> DVec3 {
        self.other(c.other, c.x) - self.movers[c.body as usize].at(c.x)
    }

    /// Applies `impulse` to the other side of `c`, and its opposite to the collider.
    fn apply(&mut self, c: &Contact, impulse: DVec3) {
        match c.other {
            Other::Particle(i, inv_mass) => self.dv[i as usize] += impulse * inv_mass,
            Other::Collider(k, _) => self.movers[k as usize].push(impulse, c.x),
        }
        self.movers[c.body as usize].push(-impulse, c.x);
    }

    fn yielding(&self, c: &Contact, n: DVec3) -> f64 {
        let other = match c.other {
            Other::Particle(_, inv_mass) => inv_mass,
            Other::Collider(k, _) => self.movers[k as usize].yielding(c.x, n),
        };
        other + self.movers[c.body as usize].yielding(c.x, n)
    }

    /// Works out all contacts.
    pub fn solve(&mut self, contacts: &mut [Contact]) {
        contacts.iter().filter(|c| c.along > 0.0).for_each(|c| self.apply(c, c.impulse()));
        for _ in 0..SWEEPS {
            let (mut largest, mut change) = (0.0_f64, 0.0_f64);
            for c in contacts.iter_mut() {
                let w = self.relative(c);
                let along = (c.along + (c.speed - w.dot(c.normal)) / self.yielding(c, c.normal)).max(0.0);
                let pushed = c.normal * (along - c.along);
                c.along = along;
                self.apply(c, pushed);
                // then friction: against the slip that is left, within the cone
                let w = self.relative(c);
                let slip = w - c.normal * w.dot(c.normal);
                let mut across = c.across;
                if let Some(t) = slip.try_normalize() {
                    across = (across - slip / self.yielding(c, t)).clamp_length_max(c.friction * along);
                }
                let rubbed = across - c.across;
                c.across = across;
                self.apply(c, rubbed);
                largest = largest.max(along);
                change = change.max(pushed.length()).max(rubbed.length());
            }
            if change <= SETTLED * largest {
                break;
            }
        }
    }
}

impl Contact {
    /// A contact with the velocity `w` of the other relative to the collider, before any impulse.
    pub fn new(body: u32, other: Other, x: DVec3, at: Approach, w: DVec3, friction: f64, restitution: f64) -> Self {
        let along = w.dot(at.normal);
        let hits = along < at.speed;
        let speed = if hits { at.speed.max(rebound(along, f64::NEG_INFINITY, restitution)) } else { at.speed };
        Self { body, other, x, normal: at.normal, speed, friction, along: 0.0, across: DVec3::ZERO, key: None }
    }

    /// The same, beginning with the impulse that these features had in the step before.
    fn remembering(mut self, key: Key, kept: &Kept) -> Self {
        let impulse = kept.of(key);
        let along = impulse.dot(self.normal);
        self.along = along.max(0.0);
        self.across = (impulse - self.normal * along).clamp_length_max(self.friction * self.along);
        self.key = Some(key);
        self
    }

    /// Impulse on the other so far [kg m/s].
    fn impulse(&self) -> DVec3 {
        self.normal * self.along + self.across
    }
}

/// Appends the contacts between colliders, with the impulses that they had in the step before.
pub fn between(
    colliders: &[Collider],
    poses: &[Pose],
    movers: &[Mover],
    solids: &mut Solids,
    kept: &Kept,
    dt: f64,
    contacts: &mut Vec<Contact>,
) {
    let side = |k: usize| {
        let (pose, mover, shape) = (&poses[k], &movers[k], &colliders[k].shape);
        let velocity = mover.velocity + pose.velocity(mover.position);
        let spin = (mover.inv_inertia * mover.angular_momentum).length();
        let turning = pose.turning() + if spin > 0.0 { spin * shape.radius() } else { 0.0 };
        Side { shape, pose, velocity, turning }
    };
    for a in 0..colliders.len() {
        for b in a + 1..colliders.len() {
            let pair = [&colliders[a], &colliders[b]];
            if !pair.iter().any(|c| c.is_free()) {
                continue;
            }
            let friction = (pair[0].friction * pair[1].friction).sqrt();
            let restitution = pair[0].restitution.max(pair[1].restitution);
            solids.meet((a, b), [side(a), side(b)], dt, |spot| {
                // seen from a free one
                let (body, other, sign) = if pair[0].is_free() { (a, b, 1.0) } else { (b, a, -1.0) };
                let path = poses[other].velocity(spot.x);
                let w = movers[other].at(spot.x) + path - movers[body].at(spot.x);
                let at = Approach { normal: spot.at.normal * sign, speed: spot.at.speed };
                let other = Other::Collider(other as u32, path);
                let contact = Contact::new(body as u32, other, spot.x, at, w, friction, restitution);
                contacts.push(contact.remembering(spot.key, kept));
            });
        }
    }
}

/// The impulses between colliders in the last step and in the one before it, by the features that touched: resting things
/// then need few sweeps, and a stack stands. Survives a restart.
#[derive(Debug, Default)]
pub struct Kept {
    /// In order of keys.
    last: Vec<(Key, DVec3)>,
    before: Vec<(Key, DVec3)>,
}

impl Kept {
    /// Keeps the impulses of a step.
    pub fn keep(&mut self, contacts: &[Contact]) {
        std::mem::swap(&mut self.last, &mut self.before);
        self.last.clear();
        let pushed = contacts.iter().filter(|c| c.along > 0.0).filter_map(|c| Some((c.key?, c.impulse())));
        self.last.extend(pushed);
        self.last.sort_unstable_by_key(|k| k.0);
    }

    /// Room for as many.
    pub fn reserve(&mut self, n: usize) {
        self.last.reserve(n);
        self.before.reserve(n);
    }

    /// Back to the step before.
    pub fn undo(&mut self) {
        std::mem::swap(&mut self.last, &mut self.before);
    }

    fn of(&self, key: Key) -> DVec3 {
        self.last.binary_search_by_key(&key, |k| k.0).map_or(DVec3::ZERO, |k| self.last[k].1)
    }

    /// Shows every impulse. Without them, as checkpoints from before they were kept are, a step starts from none: resting things
    /// need more sweeps, once.
    pub fn visit(&mut self, v: &mut Visitor<'_>) {
        const SCOPE: &str = "contact";
        let mut keys = Buffer::new(self.last.iter().flat_map(|k| k.0).collect());
        let mut impulses = Buffer::new(self.last.iter().map(|k| k.1).collect());
        v(SCOPE, &Column::live("rigid_features", "1", Of::Thing).late(), &mut keys);
        v(SCOPE, &Column::live("rigid_impulse", "kg m/s", Of::Thing).late(), &mut impulses);
        self.last.clear();
        self.last.extend(keys.as_chunks().0.iter().copied().zip(impulses.iter().copied()));
    }
}
