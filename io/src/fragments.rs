//! The fragments of a run at each frame, as rigid bodies: mass, volume, centre of mass, inertia, velocity and spin, from the
//! particles of the frames.

use std::collections::{BTreeMap, HashMap};
use std::io::{self, Write};

use glam::{DMat3, DVec3};

use crate::frames::ParticleFrame;

/// What holds together at one frame, as a rigid body.
#[derive(Clone, Debug, PartialEq)]
pub struct Fragment {
    /// Its id: the same in every frame.
    pub id: u32,
    /// The fragment that it broke off; none for a whole body.
    pub parent: Option<u32>,
    /// When it was first seen [s].
    pub born: f64,
    /// Number of its body in the scene.
    pub body: u32,
    /// How many particles it has.
    pub particles: usize,
    /// Mass [kg].
    pub mass: f64,
    /// Rest volume [m³].
    pub volume: f64,
    /// Centre of mass [m].
    pub centre: DVec3,
    /// Inertia about the centre of mass, along the axes of the world [kg m²]. A particle counts as a cube of its volume.
    pub inertia: DMat3,
    /// Velocity of the centre of mass [m/s].
    pub velocity: DVec3,
    /// Angular velocity of a rigid body with this angular momentum [rad/s].
    pub spin: DVec3,
}

/// Tells from frame to frame who broke off whom.
#[derive(Clone, Debug, Default)]
pub struct Lineage {
    /// The piece of each particle at the last frame, by body and id.
    last: HashMap<(u32, u32), u32>,
    /// Parent and birth of each piece seen.
    known: BTreeMap<u32, (Option<u32>, f64)>,
}

impl Lineage {
    /// The fragments of the next frame, by id. Frames come in the order of time.
    pub fn frame(&mut self, frame: &ParticleFrame) -> Vec<Fragment> {
        let mut members: BTreeMap<u32, Vec<usize>> = BTreeMap::new();
        frame.piece.iter().enumerate().for_each(|(k, &piece)| members.entry(piece).or_default().push(k));
        let all = members
            .iter()
            .map(|(&id, members)| {
                // a piece of a lattice may have nodes that are new, but not only such
                let before = members.iter().find_map(|&k| self.last.get(&(frame.body[k], frame.id[k])));
                let before = before.copied().filter(|&before| before != id);
                let &mut (parent, born) = self.known.entry(id).or_insert((before, frame.time));
                Fragment { parent, born, ..rigid(frame, id, members) }
            })
            .collect();
        self.last.clear();
        self.last.extend((0..frame.id.len()).map(|k| ((frame.body[k], frame.id[k]), frame.piece[k])));
        all
    }
}

fn rigid(frame: &ParticleFrame, id: u32, members: &[usize]) -> Fragment {
    let place = |k: usize| DVec3::from(frame.positions[k].map(f64::from));
    let speed = |k: usize| DVec3::from(frame.velocity[k].map(f64::from));
    let mass_of = |k: usize| f64::from(frame.mass[k]);
    let mass: f64 = members.iter().map(|&k| mass_of(k)).sum();
    let mean = |of: &dyn Fn(usize) -> DVec3| members.iter().map(|&k| mass_of(k) * of(k)).sum::<DVec3>() / mass;
    let (centre, velocity) = (mean(&place), mean(&speed));
    let (mut inertia, mut own, mut momentum) = (DMat3::ZERO, 0.0, DVec3::ZERO);
    for &k in members {
        let (m, arm) = (mass_of(k), place(k) - centre);
        inertia += m * (DMat3::from_diagonal(DVec3::splat(arm.length_squared())) - outer(arm, arm));
        momentum += m * arm.cross(speed(k) - velocity);
        own += m * f64::from(frame.width(k)).powi(2) / 6.0;
    }
    // one or two particles have axes about which their points have no inertia, and no momentum
    let slight = 1e-9 * (inertia.x_axis.x + inertia.y_axis.y + inertia.z_axis.z + own);
    let spin = (inertia + DMat3::from_diagonal(DVec3::splat(slight))).inverse() * momentum;
    Fragment {
        id,
        parent: None,
        born: frame.time,
        body: frame.body[members[0]],
        particles: members.len(),
        mass,
        volume: members.iter().map(|&k| f64::from(frame.volume[k])).sum(),
        centre,
        inertia: inertia + DMat3::from_diagonal(DVec3::splat(own)),
        velocity,
        spin: if spin.is_finite() { spin } else { DVec3::ZERO },
    }
}

/// The matrix a bᵀ.
pub(crate) fn outer(a: DVec3, b: DVec3) -> DMat3 {
    DMat3::from_cols(a * b.x, a * b.y, a * b.z)
}

/// The names of the columns of [`Table`]: SI units, `spin` in radians a second, inertia about the centre of mass along the axes
/// of the world.
const COLUMNS: [&str; 24] = [
    "frame",
    "time",
    "id",
    "parent",
    "born",
    "body",
    "particles",
    "mass",
    "volume",
    "x",
    "y",
    "z",
    "velocity_x",
    "velocity_y",
    "velocity_z",
    "spin_x",
    "spin_y",
    "spin_z",
    "inertia_xx",
    "inertia_yy",
    "inertia_zz",
    "inertia_xy",
    "inertia_xz",
    "inertia_yz",
];

/// Writes fragments as CSV: a row for each fragment of each frame.
pub struct Table<W: Write> {
    writer: csv::Writer<W>,
    lineage: Lineage,
}

impl<W: Write> Table<W> {
    /// Begins a table.
    ///
    /// # Errors
    /// What the system says.
    pub fn begin(out: W) -> io::Result<Self> {
        let mut writer = csv::Writer::from_writer(out);
        writer.write_record(COLUMNS).map_err(io::Error::other)?;
        Ok(Self { writer, lineage: Lineage::default() })
    }

    /// Adds the rows of a frame, which comes after those before it in time; `bodies` are the names of the bodies. Returns how
    /// many there are.
    ///
    /// # Errors
    /// What the system says.
    pub fn add(&mut self, frame: &ParticleFrame, bodies: &[String]) -> io::Result<usize> {
        let fragments = self.lineage.frame(frame);
        for f in &fragments {
            let number = |x: f64| format!("{x:?}");
            let body = bodies.get(f.body as usize).cloned().unwrap_or_else(|| f.body.to_string());
            let mut row = vec![frame.number.to_string(), number(frame.time), f.id.to_string()];
            row.extend([f.parent.map_or_else(String::new, |p| p.to_string()), number(f.born), body]);
            row.extend([f.particles.to_string(), number(f.mass), number(f.volume)]);
            row.extend([f.centre, f.velocity, f.spin].into_iter().flat_map(|v| v.to_array()).map(number));
            let i = f.inertia;
            row.extend([i.x_axis.x, i.y_axis.y, i.z_axis.z, i.x_axis.y, i.x_axis.z, i.y_axis.z].map(number));
            self.writer.write_record(&row).map_err(io::Error::other)?;
        }
        Ok(fragments.len())
    }

    /// Writes what is left.
    ///
    /// # Errors
    /// What the system says.
    pub fn end(mut self) -> io::Result<()> {
        self.writer.flush()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A box of particles that turns and flies, in two bodies with the same ids.
    fn turning(time: f64, split: bool) -> ParticleFrame {
        let (spin, velocity) = (DVec3::new(1.0, -2.0, 0.5), DVec3::new(3.0, 0.0, -1.0));
        let mut frame = ParticleFrame { time, ..ParticleFrame::default() };
        for k in 0..60_u32 {
            let x = DVec3::new(f64::from(k % 3), f64::from(k / 3 % 4), f64::from(k / 12)) * 0.1;
            let arm = x - DVec3::new(0.1, 0.15, 0.2);
            for body in 0..2 {
                frame.positions.push((x + f64::from(body) * DVec3::X).as_vec3().into());
                frame.velocity.push((velocity + spin.cross(arm)).as_vec3().into());
                frame.id.push(k);
                frame.body.push(body);
                frame.piece.push(if split && body == 1 && k > 40 { 2 } else { body });
                frame.mass.push(2.0);
                frame.volume.push(1e-3);
                frame.damage.push(0.0);
            }
        }
        frame
    }

    #[test]
    fn a_box_of_particles_is_a_rigid_box() {
        let mut lineage = Lineage::default();
        let whole = lineage.frame(&turning(0.0, false));
        assert_eq!(whole.len(), 2);
        let f = &whole[1];
        assert_eq!((f.id, f.parent, f.body, f.particles), (1, None, 1, 60));
        assert!((f.mass - 120.0).abs() < 1e-9 && (f.volume - 0.06).abs() < 1e-8);
        assert!(f.centre.distance(DVec3::new(1.1, 0.15, 0.2)) < 1e-7);
        assert!(f.velocity.distance(DVec3::new(3.0, 0.0, -1.0)) < 1e-6);
        assert!(f.spin.distance(DVec3::new(1.0, -2.0, 0.5)) < 1e-5, "{}", f.spin); // measured: f32
        // cubes fill a box of 0.3 × 0.4 × 0.5 m without gaps, so this is its inertia exactly
        let want = [0.16 + 0.25, 0.09 + 0.25, 0.09 + 0.16].map(|s| 120.0 / 12.0 * s);
        let [a, b, c] = [f.inertia.x_axis, f.inertia.y_axis, f.inertia.z_axis];
        for (got, want) in [a.x, b.y, c.z].iter().zip(want) {
            assert!((got / want - 1.0).abs() < 1e-5, "{got} {want}"); // measured: f32
        }
        assert!(a.y.abs() + a.z.abs() + b.z.abs() < 1e-5);

        let broken = lineage.frame(&turning(0.5, true));
        assert_eq!(
            broken.iter().map(|f| (f.id, f.parent, f.born)).collect::<Vec<_>>(),
            [(0, None, 0.0), (1, None, 0.0), (2, Some(1), 0.5)]
        );
        let later = lineage.frame(&turning(1.0, true));
        assert_eq!((later[2].parent, later[2].born, later[2].particles), (Some(1), 0.5, 19));
    }

    #[test]
    fn single_particles_do_not_spin() {
        let mut frame = turning(0.0, false);
        frame.piece = (0..120).collect();
        assert!(
            Lineage::default().frame(&frame).iter().all(|f| f.spin == DVec3::ZERO && f.inertia.determinant() > 0.0)
        );
        frame.volume.fill(0.0); // a point
        assert!(Lineage::default().frame(&frame).iter().all(|f| f.spin == DVec3::ZERO));
    }

    #[test]
    fn rows_add_up_to_the_particles() {
        let mut text = Vec::new();
        let mut table = Table::begin(&mut text).unwrap();
        assert_eq!(table.add(&turning(0.0, false), &["low".into()]).unwrap(), 2);
        let frame = turning(0.5, true);
        assert_eq!(table.add(&frame, &["low".into()]).unwrap(), 3);
        table.end().unwrap();
        let mut reader = csv::Reader::from_reader(&text[..]);
        assert_eq!(reader.headers().unwrap().len(), COLUMNS.len());
        let rows: Vec<csv::StringRecord> = reader.records().map(Result::unwrap).collect();
        assert_eq!((rows.len(), &rows[0][5], &rows[1][5], &rows[4][3]), (5, "low", "1", "1"));
        let get = |row: &csv::StringRecord, k: usize| row[k].parse::<f64>().unwrap();
        for axis in 0..3 {
            let momentum: f64 = rows[2..].iter().map(|r| get(r, 7) * get(r, 12 + axis)).sum();
            let want: f64 = (0..120).map(|k| f64::from(frame.mass[k]) * f64::from(frame.velocity[k][axis])).sum();
            assert!((momentum - want).abs() < 1e-9 * 240.0 * 3.0, "{momentum} {want}"); // measured: round-off
        }
    }
}
