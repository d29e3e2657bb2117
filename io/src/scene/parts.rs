//! Regions of a body that are made of something else, and how strong the interfaces are.

use std::path::{Path, PathBuf};

use fissure_engine::Interface;
use fissure_engine::params::hint;

use super::error::SceneError;
use super::model::{Chosen, Region};
use super::read::{check_name, chosen, space};
use super::reader::Reader;

/// A region of a body, `[[body.NAME.region]]`. Where several hold a particle, the last one has it.
#[derive(Clone, Debug)]
pub struct Part {
    /// Name for messages and interfaces.
    pub name: String,
    /// Which particles.
    pub place: Where,
    /// Density [kg/m³].
    pub density: f64,
    /// Its law; that of the body if it says none.
    pub law: Chosen,
    /// Its criterion; that of the body if it says none.
    pub criterion: Chosen,
}

/// Which particles of a body are in a region.
#[derive(Clone, Debug, PartialEq)]
pub enum Where {
    /// Those in a part of space, where the body stands at the start.
    Space(Region),
    /// Those whose tetrahedron has this label in the mesh file.
    Label(i64),
    /// Those that lie nearer to the solid `to` than to the solid `than`, closed surfaces that stand as the body's mesh does.
    /// Inside counts as negative distance.
    Nearest {
        /// The path to open.
        to: PathBuf,
        /// The path to open.
        than: PathBuf,
        /// Both as the scene has them.
        written: [String; 2],
    },
}

/// The regions of a body whose own density, law and criterion are given.
pub(super) fn parts(
    body: &Reader<'_>,
    name: &str,
    folder: &Path,
    own: &(f64, Chosen, Chosen),
) -> Result<Vec<Part>, SceneError> {
    let mut parts: Vec<Part> = Vec::new();
    let tables = body.tables("region")?;
    if tables.len() > MOST {
        let message = format!("{} regions are too many; a body has at most {MOST}", tables.len());
        return Err(body.fail("region", message));
    }
    for (k, r) in tables.iter().enumerate() {
        let part = part(r, k, folder, own)?;
        if part.name == name || parts.iter().any(|other| other.name == part.name) {
            let message = format!("a second region is called `{}` (what is in none is called `{name}`)", part.name);
            return Err(r.fail("name", message));
        }
        parts.push(part);
    }
    Ok(parts)
}

/// Regions are numbered by a byte, and the body itself is one.
const MOST: usize = 255;

fn part(r: &Reader<'_>, k: usize, folder: &Path, own: &(f64, Chosen, Chosen)) -> Result<Part, SceneError> {
    let name = r.get_if("name")?.unwrap_or_else(|| format!("region {}", k + 1));
    check_name(&name, "a region").map_err(|message| r.fail("name", message))?;
    let place = match r.exactly_one_of(&["box", "ball", "label", "nearest"])? {
        "label" => Where::Label(r.get::<u64>("label")?.cast_signed()),
        "nearest" => {
            let written: [String; 2] = [r.get("nearest")?, r.get("than")?];
            let [to, than] = written.each_ref().map(|path| folder.join(path));
            Where::Nearest { to, than, written }
        }
        word => Where::Space(space(r, word)?),
    };
    if !matches!(place, Where::Nearest { .. }) && r.get_if::<String>("than")?.is_some() {
        return Err(r.fail("than", format!("`than` in {} goes with `nearest`; remove it", r.title)));
    }
    let of = |table: &str, word: &str, own: &Chosen| match r.table_if(table)? {
        Some(t) => chosen(&t, word),
        None => Ok(own.clone()),
    };
    Ok(Part {
        name,
        place,
        density: r.get_if("density")?.unwrap_or(own.0),
        law: of("material", "law", &own.1)?,
        criterion: of("fracture", "criterion", &own.2)?,
    })
}

/// The interface table of the body `name`; regions are numbered from 1, the rest of the body is 0.
pub(super) fn interface(body: &Reader<'_>, name: &str, parts: &[Part]) -> Result<Interface, SceneError> {
    let Some(r) = body.table_if("interface")? else { return Ok(Interface::default()) };
    if parts.is_empty() {
        let message =
            format!("{} has no [[body.{name}.region]], so there is no interface; add one or remove it", r.title);
        return Err(body.fail("interface", message));
    }
    let names: Vec<&str> = std::iter::once(name).chain(parts.iter().map(|p| p.name.as_str())).collect();
    let mut pairs = Vec::new();
    for pair in r.tables("pair")? {
        let number = |key: &str| {
            let word: String = pair.get(key)?;
            let unknown = || format!("no region is called `{word}` in {}{}", pair.title, hint(&word, &names));
            names.iter().position(|known| *known == word).ok_or_else(|| pair.fail(key, unknown()))
        };
        let (of, and) = (number("of")?, number("and")?);
        if of == and {
            return Err(pair.fail("and", format!("{} is about one region; name two different ones", pair.title)));
        }
        pairs.push((of, and, pair.get("strength")?));
    }
    Ok(Interface { strength: r.get("strength")?, pairs })
}
