//! Contacts of free colliders: sequential impulses over one list, in a fixed order.
//!
//! A contact is between a free collider and a particle, or a free collider and any other. Both sides get the same impulse at
//! the same point with opposite signs, so linear and angular momentum are kept to round-off. Rigid things pass impulses on
//! at once, so the list is gone through several times, each contact correcting the sum of its impulses (Catto 2005); that
//! is serial, and small beside the bonds.

use glam::{DMat3, DVec3};

use super::approach::{Approach, Pose, rebound};
use super::collider::Collider;

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
        let speed = at.speed.max(rebound(w.dot(at.normal), f64::NEG_INFINITY, restitution));
        Self { body, other, x, normal: at.normal, speed, friction, along: 0.0, across: DVec3::ZERO }
    }
}

/// Appends the contacts between colliders, the feelers of each against the surface of every other; `feelers` has those of all
/// colliders.
pub fn between(
    colliders: &[Collider],
    poses: &[Pose],
    movers: &[Mover],
    feelers: &[(Vec<DVec3>, f64)],
    contacts: &mut Vec<Contact>,
) {
    for (a, feeling) in colliders.iter().enumerate() {
        for (b, met) in colliders.iter().enumerate() {
            if a == b || !(feeling.is_free() || met.is_free()) {
                continue;
            }
            let (friction, restitution) =
                ((feeling.friction * met.friction).sqrt(), feeling.restitution.max(met.restitution));
            let (points, r) = &feelers[a];
            for &point in points {
                let (place, turn) = poses[a].place();
                let x = place + turn * point;
                let w = movers[a].at(x) + poses[a].velocity(x) - movers[b].at(x) - poses[b].velocity(x);
                let Some(at) = poses[b].approach(&met.shape, x, *r, w) else { continue };
                let contact = if met.is_free() {
                    let other = Other::Collider(a as u32, poses[a].velocity(x));
                    Contact::new(b as u32, other, x - at.normal * *r, at, w, friction, restitution)
                } else {
                    // seen from the free one, the normal points the other way
                    let at = Approach { normal: -at.normal, ..at };
                    let other = Other::Collider(b as u32, poses[b].velocity(x));
                    Contact::new(a as u32, other, x + at.normal * *r, at, -w, friction, restitution)
                };
                contacts.push(contact);
            }
        }
    }
}
