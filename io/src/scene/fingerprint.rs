//! A stable hash of what a scene means.
//!
//! Structures are taken apart without `..`, so a field cannot be added and forgotten here. Every variable part is
//! preceded by its length or a tag, so no two scenes give the same bytes.

use fissure_engine::params::Value;
use fissure_engine::{Integrator, Interface, Relax};
use fissure_meshing::lattice::{CrackFaces, Noise};
use glam::DVec3;
use xxhash_rust::xxh3::Xxh3;

use super::Scene;
use super::cells::{Fineness, Lattice};
use super::model::*;
use super::parts::{Part, Where};

pub(super) fn of(scene: &Scene) -> u64 {
    let mut hash = Digest(Xxh3::new());
    let Scene {
        title,
        duration,
        gravity,
        dt,
        safety,
        integrator,
        seed,
        bodies,
        anchors,
        ground,
        colliders,
        contact,
        compares,
        output,
        file: _,
        text: _,
        tree: _,
    } = scene;
    hash.text("fissure scene 1");
    hash.text(title);
    hash.number(*duration);
    hash.vector(*gravity);
    hash.optional(*dt);
    hash.number(*safety);
    hash.whole(*seed);
    hash.whole(bodies.len() as u64);
    bodies.iter().for_each(|body| hash.body(body));
    hash.whole(anchors.len() as u64);
    anchors.iter().for_each(|anchor| hash.anchor(anchor));
    hash.tag(u8::from(ground.is_some()));
    if let Some(Ground { normal, height, restitution, friction }) = ground {
        hash.vector(*normal);
        hash.numbers(&[*height, *restitution, *friction]);
    }
    // when checkpoints are made changes nothing in the result, and is left out where a scene from before could not say it
    let Output {
        frame_every,
        checkpoint_every,
        checkpoint_steps,
        checkpoint_minutes,
        keep,
        on_write_error,
        export,
        particles,
        picture,
    } = output;
    hash.numbers(&[*frame_every, *checkpoint_every]);
    hash.whole(u64::from(*keep));
    hash.picture(picture);
    // what scenes before did not have is left out where they would not have it, so that they keep their hash
    if !colliders.is_empty() {
        hash.text("colliders");
        hash.whole(colliders.len() as u64);
        colliders.iter().for_each(|collider| hash.collider(collider));
    }
    if *contact != Contact::default() {
        let Contact { particles, friction, restitution, stiffness } = contact;
        hash.text("contact");
        hash.tag(u8::from(*particles));
        hash.numbers(&[*friction, *restitution, *stiffness]);
    }
    // at the end, and nothing for the default: scenes from before there were integrators or references keep their hash
    match *integrator {
        Integrator::SymplecticEuler => {}
        Integrator::VelocityVerlet => hash.tag(1),
        Integrator::Relax(Relax { residual, iterations }) => {
            hash.tag(2);
            hash.number(residual);
            hash.whole(iterations);
        }
    }
    compares.iter().for_each(|compare| hash.compare(compare));
    if let Some(steps) = checkpoint_steps {
        hash.text("checkpoint_steps");
        hash.whole(*steps);
    }
    if let Some(minutes) = checkpoint_minutes {
        hash.text("checkpoint_minutes");
        hash.number(*minutes);
    }
    if *on_write_error == OnFailure::GoOn {
        hash.text("go_on");
    }
    export.iter().for_each(|format| hash.text(format.name()));
    if !particles {
        hash.text("no particles");
    }
    hash.0.digest()
}

struct Digest(Xxh3);

impl Digest {
    fn tag(&mut self, tag: u8) {
        self.0.update(&[tag]);
    }

    fn whole(&mut self, n: u64) {
        self.0.update(&n.to_le_bytes());
    }

    fn number(&mut self, x: f64) {
        self.whole((x + 0.0).to_bits()); // -0 + 0 is 0
    }

    fn numbers(&mut self, x: &[f64]) {
        x.iter().for_each(|x| self.number(*x));
    }

    fn vector(&mut self, x: DVec3) {
        self.numbers(&x.to_array());
    }

    fn text(&mut self, text: &str) {
        self.whole(text.len() as u64);
        self.0.update(text.as_bytes());
    }

    fn optional(&mut self, x: Option<f64>) {
        self.tag(u8::from(x.is_some()));
        self.numbers(x.as_slice());
    }

    fn optional_vector(&mut self, x: Option<[f64; 3]>) {
        self.tag(u8::from(x.is_some()));
        self.numbers(x.as_ref().map_or(&[], |x| x.as_slice()));
    }

    fn stance(&mut self, stance: &Stance) {
        let Stance { position, axis, degrees } = stance;
        self.vector(*position);
        self.number(*degrees);
        self.vector(if *degrees == 0.0 { DVec3::ZERO } else { *axis });
    }

    fn collider(&mut self, collider: &Collider) {
        let Collider { name, shape, start, motion, friction, restitution } = collider;
        self.text(name);
        match shape {
            ColliderShape::Plane { normal } => {
                self.tag(0);
                self.vector(*normal);
            }
            ColliderShape::Ball { radius } => {
                self.tag(1);
                self.number(*radius);
            }
            ColliderShape::Box { size } => {
                self.tag(2);
                self.vector(*size);
            }
            ColliderShape::Capsule { radius, height } => {
                self.tag(3);
                self.numbers(&[*radius, *height]);
            }
            ColliderShape::Cylinder { radius, height } => {
                self.tag(4);
                self.numbers(&[*radius, *height]);
            }
            ColliderShape::Mesh { path: _, written, scale, hull } => {
                self.tag(5 + u8::from(*hull));
                self.text(written);
                self.number(*scale);
            }
        }
        self.stance(start);
        match motion {
            ColliderMotion::Fixed => self.tag(0),
            ColliderMotion::Keyframes(frames) => {
                self.tag(1);
                self.whole(frames.len() as u64);
                for (time, stance) in frames {
                    self.number(*time);
                    self.stance(stance);
                }
            }
            ColliderMotion::Free { weight, inertia, velocity, spin } => {
                self.tag(2);
                let (tag, value) = match *weight {
                    Weight::Mass(mass) => (0, mass),
                    Weight::Density(density) => (1, density),
                };
                self.tag(tag);
                self.number(value);
                self.optional_vector(inertia.map(|i| i.to_array()));
                self.vector(*velocity);
                self.vector(*spin);
            }
        }
        self.numbers(&[*friction, *restitution]);
    }

    fn lattice(&mut self, lattice: &Lattice) {
        // scenes before had none
        if *lattice == Lattice::default() {
            return;
        }
        let Lattice { fineness, faces, memory } = *lattice;
        self.text("lattice");
        match fineness {
            Fineness::Cells(cells) => {
                self.tag(0);
                self.whole(cells);
            }
            Fineness::Size(size) => {
                self.tag(1);
                self.number(size);
            }
        }
        match faces {
            CrackFaces::Raw => self.tag(0),
            CrackFaces::Fitted => self.tag(1),
            CrackFaces::Noisy(Noise { amplitude, scale, seed }) => {
                self.tag(2);
                self.numbers(&[amplitude, scale]);
                self.whole(seed);
            }
        }
        self.whole(memory);
    }

    fn body(&mut self, body: &Body) {
        let Body {
            name,
            source,
            resolution,
            lattice,
            shell,
            placement,
            density,
            velocity,
            spin,
            horizon,
            surface,
            law,
            criterion,
            parts,
            interface,
            cuts,
        } = body;
        self.text(name);
        match source {
            Source::Mesh { path: _, written } => {
                self.tag(0);
                self.text(written);
            }
            Source::Shape(shape) => {
                self.tag(1);
                self.shape(shape);
            }
        }
        match *resolution {
            Resolution::Size(size) => {
                self.tag(0);
                self.number(size);
            }
            Resolution::Tets(tets) => {
                self.tag(1);
                self.whole(tets);
            }
        }
        self.lattice(lattice);
        self.optional(*shell);
        let Placement { scale, axis, degrees, translate } = placement;
        self.numbers(&[*scale, *degrees]);
        self.vector(if *degrees == 0.0 { DVec3::ZERO } else { *axis });
        self.vector(*translate);
        self.number(*density);
        self.vector(*velocity);
        self.vector(*spin);
        let (tag, radius) = match *horizon {
            Horizon::Length(length) => (0, length),
            Horizon::Factor(factor) => (1, factor),
        };
        self.tag(tag);
        self.number(radius);
        self.tag(*surface as u8);
        self.chosen(law);
        self.chosen(criterion);
        self.parts(parts, interface);
        self.whole(cuts.len() as u64);
        for cut in cuts {
            let (tag, points) = match *cut {
                Cut::Triangle(corners) => (0, corners),
                Cut::Rectangle { corner, u, v } => (1, [corner, u, v]),
            };
            self.tag(tag);
            points.iter().for_each(|x| self.vector(*x));
        }
    }

    /// Nothing for a body without, so that its scene keeps the hash that older runs have.
    fn parts(&mut self, parts: &[Part], interface: &Interface) {
        for Part { name, place, density, law, criterion } in parts {
            self.text("region");
            self.text(name);
            match place {
                Where::Space(space) => self.space(space),
                Where::Label(label) => {
                    self.tag(3);
                    self.whole(label.cast_unsigned());
                }
                Where::Nearest { to: _, than: _, written } => {
                    self.tag(4);
                    written.iter().for_each(|path| self.text(path));
                }
            }
            self.number(*density);
            self.chosen(law);
            self.chosen(criterion);
        }
        if !parts.is_empty() {
            let Interface { strength, pairs } = interface;
            self.text("interface");
            self.number(*strength);
            self.whole(pairs.len() as u64);
            for (a, b, strength) in pairs {
                self.whole(*a as u64);
                self.whole(*b as u64);
                self.number(*strength);
            }
        }
    }

    fn space(&mut self, space: &Region) {
        match *space {
            Region::Box { min, max } => {
                self.tag(0);
                self.vector(min);
                self.vector(max);
            }
            Region::Ball { centre, radius } => {
                self.tag(1);
                self.vector(centre);
                self.number(radius);
            }
            Region::All => self.tag(2),
        }
    }

    fn shape(&mut self, shape: &Shape) {
        let (tag, lengths) = match *shape {
            Shape::Box { size } => (0, size.to_array().to_vec()),
            Shape::Beam { length, width } => (1, vec![length, width]),
            Shape::Wall { width, height, thickness } => (2, vec![width, height, thickness]),
            Shape::Sheet { width, height, thickness } => (3, vec![width, height, thickness]),
            Shape::Ball { radius } => (4, vec![radius]),
            Shape::Cylinder { radius, height } => (5, vec![radius, height]),
            Shape::Revolution { ref profile, segments } => {
                (6, profile.iter().flatten().copied().chain([f64::from(segments)]).collect())
            }
            Shape::Vase { height, wall } => (7, vec![height, wall]),
        };
        self.tag(tag);
        self.whole(lengths.len() as u64);
        self.numbers(&lengths);
    }

    /// Keys in alphabetical order: their order in the file means nothing.
    fn chosen(&mut self, chosen: &Chosen) {
        let Chosen { name, given } = chosen;
        self.text(name);
        self.whole(given.len() as u64);
        let mut given: Vec<&Given> = given.iter().collect();
        given.sort_by(|a, b| a.key.cmp(&b.key));
        for Given { key, value, place: _ } in given {
            self.text(key);
            match value {
                Value::Number(x) => {
                    self.tag(0);
                    self.number(*x);
                }
                Value::Word(word) => {
                    self.tag(1);
                    self.text(word);
                }
                Value::List(list) => {
                    self.tag(2);
                    self.whole(list.len() as u64);
                    self.numbers(list);
                }
            }
        }
    }

    fn anchor(&mut self, anchor: &Anchor) {
        let Anchor { name, body, region, velocity, spin, centre, from, until } = anchor;
        self.text(name);
        self.whole(*body as u64);
        self.space(region);
        self.vector(*velocity);
        self.vector(*spin);
        self.vector(*centre);
        self.numbers(&[*from, *until]);
    }

    fn compare(&mut self, compare: &Compare) {
        let Compare { label, reference } = compare;
        self.text(label);
        match reference {
            Reference::Field { body, table: Table { path: _, written }, translate, at } => {
                self.tag(3);
                self.whole(*body as u64);
                self.text(written);
                self.vector(*translate);
                self.number(*at);
            }
            Reference::Track { body, table: Table { path: _, written }, point } => {
                self.tag(4);
                self.whole(*body as u64);
                self.text(written);
                self.vector(*point);
            }
            Reference::Number { of, along, value, at } => {
                let (tag, index, point) = match *of {
                    Quantity::Displacement { body, point } => (5, body, point),
                    Quantity::Force(anchor) => (6, anchor, DVec3::ZERO),
                    Quantity::Torque(anchor) => (7, anchor, DVec3::ZERO),
                };
                self.tag(tag);
                self.whole(index as u64);
                self.vector(point);
                self.vector(*along);
                self.numbers(&[*value, *at]);
            }
        }
    }

    fn picture(&mut self, picture: &Picture) {
        let Picture { width, height, camera, target, colouring, outside, inside } = picture;
        self.whole(u64::from(*width));
        self.whole(u64::from(*height));
        self.optional_vector(camera.map(|x| x.to_array()));
        self.optional_vector(target.map(|x| x.to_array()));
        self.tag(*colouring as u8);
        self.optional_vector(*outside);
        self.optional_vector(*inside);
    }
}
