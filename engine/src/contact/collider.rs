//! Colliders: rigid things beside the bodies, fixed, moved on a given path, or free.
//!
//! A free one keeps its angular momentum, not its spin, as state: without a torque it then stays the same to the bit.

use glam::{DMat3, DQuat, DVec3};

use super::shape::Shape;
use crate::buffer::Buffer;
use crate::column::{Column, Of, Visitor};

/// A place on the path of a collider.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Keyframe {
    /// When [s].
    pub time: f64,
    /// Where its origin is then [m].
    pub position: DVec3,
    /// How it is turned then.
    pub orientation: DQuat,
}

/// How a collider moves.
#[derive(Clone, Debug, PartialEq)]
pub enum Motion {
    /// Not at all.
    Fixed,
    /// From keyframe to keyframe, evenly; before the first and after the last it stands. One or more, in order of time.
    Keyframes(Vec<Keyframe>),
    /// As forces will. The shape's origin must be its centre of mass.
    Free {
        /// Mass [kg], above 0.
        mass: f64,
        /// Moment of inertia in its own axes [kg m²], positive definite.
        inertia: DMat3,
    },
}

/// A rigid thing that particles and other colliders cannot enter.
#[derive(Debug)]
pub struct Collider {
    /// Name, unique among the colliders.
    pub name: String,
    /// Its shape in its own axes.
    pub shape: Shape,
    /// How it moves.
    pub motion: Motion,
    /// Coulomb friction coefficient, 0 or more.
    pub friction: f64,
    /// Restitution: share of the normal speed that returns, 0 ..= 1.
    pub restitution: f64,
    /// World position of the shape's origin [m].
    pub position: DVec3,
    /// From the shape's axes to the world's.
    pub orientation: DQuat,
    /// Velocity of the origin [m/s]; of free ones.
    pub velocity: DVec3,
    /// Angular momentum about the origin [kg m²/s]; of free ones.
    pub angular_momentum: DVec3,
}

impl Collider {
    /// A fixed collider at the origin, with friction 0.5 and restitution 0.1.
    pub fn new(name: &str, shape: Shape) -> Self {
        Self {
            name: name.into(),
            shape,
            motion: Motion::Fixed,
            friction: 0.5,
            restitution: 0.1,
            position: DVec3::ZERO,
            orientation: DQuat::IDENTITY,
            velocity: DVec3::ZERO,
            angular_momentum: DVec3::ZERO,
        }
    }

    /// A fixed plane with unit `normal` towards the free side, `height` [m] from the origin along it.
    pub fn plane(name: &str, normal: DVec3, height: f64) -> Self {
        Self { position: normal * height, ..Self::new(name, Shape::Plane { normal }) }
    }

    /// A free collider of the given density [kg/m³] with its origin at `position` [m]; a mesh is moved in its own axes so
    /// that its centre of mass is its origin, and stays where it was in the world. `None` for a plane, which has no mass.
    pub fn free(name: &str, mut shape: Shape, density: f64, position: DVec3, orientation: DQuat) -> Option<Self> {
        let m = shape.mass_properties()?;
        if let Shape::Mesh(mesh) = &mut shape {
            mesh.shift(-m.centre);
        }
        let motion = Motion::Free { mass: m.volume * density, inertia: m.inertia * density };
        Some(Self { motion, position: position + orientation * m.centre, orientation, ..Self::new(name, shape) })
    }

    /// Gives a free collider the angular velocity `spin` [rad/s].
    pub fn spun(mut self, spin: DVec3) -> Self {
        if let Motion::Free { inertia, .. } = self.motion {
            let turn = DMat3::from_quat(self.orientation);
            self.angular_momentum = turn * (inertia * (turn.transpose() * spin));
        }
        self
    }

    /// Whether forces move it.
    pub fn is_free(&self) -> bool {
        matches!(self.motion, Motion::Free { .. })
    }

    /// Mass [kg]; infinite unless it is free.
    pub fn mass(&self) -> f64 {
        match self.motion {
            Motion::Free { mass, .. } => mass,
            _ => f64::INFINITY,
        }
    }

    /// The inverse of the moment of inertia in the world's axes [1/(kg m²)]; zero unless it is free.
    pub fn inverse_inertia(&self) -> DMat3 {
        match self.motion {
            Motion::Free { inertia, .. } => {
                let turn = DMat3::from_quat(self.orientation);
                turn * inertia.inverse() * turn.transpose()
            }
            _ => DMat3::ZERO,
        }
    }

    /// Angular velocity [rad/s] of a free collider.
    pub fn spin(&self) -> DVec3 {
        self.spin_at(self.orientation)
    }

    fn spin_at(&self, orientation: DQuat) -> DVec3 {
        match self.motion {
            Motion::Free { inertia, .. } => {
                orientation * (inertia.inverse() * (orientation.inverse() * self.angular_momentum))
            }
            _ => DVec3::ZERO,
        }
    }

    /// Position and orientation at `time` [s] of a collider on a given path; of any other as they are.
    pub fn pose(&self, time: f64) -> (DVec3, DQuat) {
        let Motion::Keyframes(frames) = &self.motion else { return (self.position, self.orientation) };
        let after = frames.partition_point(|f| f.time <= time);
        let (a, b) = (&frames[after.saturating_sub(1)], &frames[after.min(frames.len() - 1)]);
        let span = b.time - a.time;
        let share = if span > 0.0 { (time - a.time) / span } else { 0.0 };
        (a.position.lerp(b.position, share), a.orientation.slerp(b.orientation, share))
    }

    /// Moves it through a step of `dt` [s] that ends at `time` [s].
    pub fn advance(&mut self, time: f64, dt: f64) {
        if self.is_free() {
            self.position += self.velocity * dt;
            // the midpoint rule: the spin changes with the orientation even where no torque acts
            let half = DQuat::from_scaled_axis(self.spin() * (0.5 * dt)) * self.orientation;
            let middle = self.spin_at(half.normalize());
            self.orientation = (DQuat::from_scaled_axis(middle * dt) * self.orientation).normalize();
        } else {
            (self.position, self.orientation) = self.pose(time);
        }
    }

    /// Whether what a restart brought fits together: numbers that are finite, triangles of vertices that exist.
    pub fn consistent(&self) -> bool {
        let whole = match &self.shape {
            Shape::Mesh(mesh) => mesh.consistent(),
            _ => true,
        };
        let state = self.position.is_finite() && self.velocity.is_finite() && self.angular_momentum.is_finite();
        whole && state && self.orientation.is_normalized() && self.mass() > 0.0
    }

    /// Makes ready what is not in the columns, after a restart.
    pub fn prepare(&mut self) {
        if let Shape::Mesh(mesh) = &mut self.shape {
            mesh.prepare();
        }
    }

    /// Kinetic energy [J] of a free collider.
    pub fn kinetic(&self) -> f64 {
        match self.motion {
            Motion::Free { mass, .. } => {
                0.5 * mass * self.velocity.length_squared() + 0.5 * self.spin().dot(self.angular_momentum)
            }
            _ => 0.0,
        }
    }

    /// Shows every column: a mesh, and the state of a free collider. What moves on a path is where the time says.
    pub fn visit(&mut self, v: &mut Visitor<'_>) {
        let scope = format!("colliders/{}", self.name);
        if let Shape::Mesh(mesh) = &mut self.shape {
            v(&scope, &Column::frozen("vertices", "m", Of::Thing), &mut mesh.vertices);
            v(&scope, &Column::frozen("triangles", "1", Of::Thing), &mut mesh.triangles);
        }
        let Motion::Free { mass, inertia } = &mut self.motion else { return };
        let mut weight = Buffer::new(vec![*mass]);
        let mut moment = Buffer::new(inertia.to_cols_array().to_vec());
        let mut place = Buffer::new(vec![self.position]);
        let mut turn = Buffer::new(self.orientation.to_array().to_vec());
        let mut motion = Buffer::new(vec![self.velocity]);
        let mut spin = Buffer::new(vec![self.angular_momentum]);
        v(&scope, &Column::frozen("mass", "kg", Of::Thing), &mut weight);
        v(&scope, &Column::frozen("inertia", "kg m^2", Of::Thing), &mut moment);
        v(&scope, &Column::live("position", "m", Of::Thing), &mut place);
        v(&scope, &Column::live("orientation", "1", Of::Thing), &mut turn);
        v(&scope, &Column::live("velocity", "m/s", Of::Thing), &mut motion);
        v(&scope, &Column::live("angular_momentum", "kg m^2/s", Of::Thing), &mut spin);
        if let ([m], [x], [u], [l]) = (&weight[..], &place[..], &motion[..], &spin[..]) {
            (*mass, self.position, self.velocity, self.angular_momentum) = (*m, *x, *u, *l);
        }
        if let (Ok(columns), Ok(q)) = (<&[f64; 9]>::try_from(&moment[..]), <[f64; 4]>::try_from(&turn[..])) {
            (*inertia, self.orientation) = (DMat3::from_cols_array(columns), DQuat::from_array(q));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tumbling_box_keeps_its_angular_momentum_and_energy() {
        let shape = Shape::Box { half: DVec3::new(0.1, 0.2, 0.4) };
        let c = Collider::free("box", shape, 500.0, DVec3::ZERO, DQuat::IDENTITY).unwrap();
        let mut c = c.spun(DVec3::new(0.1, 5.0, 0.1)); // about the middle axis: it flips
        let (l, energy) = (c.angular_momentum, c.kinetic());
        let (mut low, mut high) = (1.0_f64, -1.0_f64);
        for k in 0..20_000 {
            c.advance(f64::from(k) * 1e-3, 1e-3);
            let up = (c.orientation * DVec3::Y).y;
            (low, high) = (low.min(up), high.max(up));
        }
        assert_eq!(c.angular_momentum, l);
        assert!((c.kinetic() / energy - 1.0).abs() < 1e-5, "{}", c.kinetic() / energy - 1.0); // measured 2e-7
        assert!(low < -0.9 && high > 0.9, "it flips over: {low} {high}");
    }

    #[test]
    fn keyframes_are_passed_evenly_and_held_at_the_ends() {
        let frame =
            |time, x: f64, angle| Keyframe { time, position: DVec3::X * x, orientation: DQuat::from_rotation_y(angle) };
        let motion = Motion::Keyframes(vec![frame(1.0, 0.0, 0.0), frame(2.0, 4.0, 1.0), frame(3.0, 4.0, 1.0)]);
        let c = Collider { motion, ..Collider::new("press", Shape::Ball { radius: 1.0 }) };
        let at = |t| (c.pose(t).0.x, c.pose(t).1.to_axis_angle().1);
        assert_eq!((at(0.0), at(1.0), at(9.0).0), ((0.0, 0.0), (0.0, 0.0), 4.0));
        assert!((at(1.25).0 - 1.0).abs() < 1e-12 && (at(1.25).1 - 0.25).abs() < 1e-12);
    }
}
