//! What a scene says of the cells of a lattice, and which keys are for bodies of cells or of bonds only.

use fissure_engine::registry::Wants;
use fissure_meshing::lattice::{CrackFaces, Noise, Options};

use super::Scene;
use super::error::SceneError;
use super::model::Body;
use super::reader::Reader;

/// How a lattice is made of a surface; says nothing for bodies of bonds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lattice {
    /// How fine it is.
    pub fineness: Fineness,
    /// What cracks look like.
    pub faces: CrackFaces,
    /// Memory that making it may take [MiB].
    pub memory: u64,
}

/// How fine the cells of a lattice are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Fineness {
    /// So many cells, about.
    Cells(u64),
    /// Cells of this edge [m].
    Size(f64),
}

impl Default for Lattice {
    /// As the table of keys has it.
    fn default() -> Self {
        let Options { faces, memory, .. } = Options::new(1.0);
        Self { fineness: Fineness::Cells(2000), faces, memory }
    }
}

/// Keys of a body that only bonds have a use for, and those that only a lattice has.
const OF_BONDS: [&str; 9] =
    ["size", "tets", "shell", "horizon", "horizon_factor", "surface", "region", "interface", "cut"];
const OF_CELLS: [&str; 4] = ["cells", "cell", "memory", "crack_faces"];

/// The keys of a lattice in the table of a body.
pub(super) fn lattice(body: &Reader<'_>) -> Result<Lattice, SceneError> {
    let fineness = match body.one_of(&["cells", "cell"])? {
        Some("cell") => Fineness::Size(body.get("cell")?),
        _ => Fineness::Cells(body.get("cells")?),
    };
    let mut faces = Lattice::default().faces;
    if let Some(table) = body.table_if("crack_faces")? {
        let noise = Noise { amplitude: table.get("noise")?, scale: table.get("scale")?, seed: table.get("seed")? };
        faces = match table.get::<String>("kind")?.as_str() {
            "raw" => CrackFaces::Raw,
            "fitted" => CrackFaces::Fitted,
            _ => CrackFaces::Noisy(noise),
        };
    }
    Ok(Lattice { fineness, faces, memory: body.get("memory")? })
}

impl Scene {
    /// Refuses keys of `body` that a material which wants `wants` has no use for.
    pub(super) fn check_fit(&self, body: &Body, wants: Wants) -> Result<(), SceneError> {
        let (useless, made) = match wants {
            Wants::Bonds => (&OF_CELLS[..], "a body of bonds, made of tetrahedra"),
            Wants::Cells => (&OF_BONDS[..], "a lattice, made of cells"),
        };
        match useless.iter().find(|key| self.gives(&body.name, "", key)) {
            None => Ok(()),
            Some(key) => {
                let (name, law) = (&body.name, &body.law.name);
                let message =
                    format!("`{key}` in [body.{name}] has no use: law = \"{law}\" makes {made}; leave `{key}` out");
                Err(self.error(name, "", key, message))
            }
        }
    }
}
