//! Legacy VTK files (`.vtk`) with an unstructured grid: text, or big-endian binary.
//!
//! `CELLS` come as lists with their lengths (up to version 4) or as offsets and connectivity (5.1). Only reading:
//! whoever reads these reads `.vtu` too.

use super::LabelledTets;
use super::build::TetBuilder;
use super::cursor::{Cursor, number};
use super::error::{MeshError, Place, Problem};
use super::scalar::{Endian, Scalar};
use std::path::Path;

/// VTK's numbers for the linear and the quadratic tetrahedron.
const TETRA: i64 = 10;
const QUADRATIC_TETRA: i64 = 24;

/// Names under which programs store the region of a cell.
const LABELS: [&str; 13] = [
    "label",
    "labels",
    "region",
    "regions",
    "regionid",
    "material",
    "materialid",
    "materialids",
    "cellentityids",
    "gmsh:physical",
    "gmsh:geometrical",
    "medit:ref",
    "cell_tags",
];

pub(super) fn is_label(name: &str) -> bool {
    LABELS.contains(&name.to_ascii_lowercase().as_str())
}

/// Cells of one piece: cell `c` has the type `types[c]` and the points `connectivity[offsets[c]..offsets[c + 1]]`.
pub(super) struct Cells {
    pub(super) offsets: Vec<i64>,
    pub(super) connectivity: Vec<i64>,
    pub(super) types: Vec<i64>,
}

impl Cells {
    /// Adds the tetrahedra to `out` and their labels, where there are any, to `kept`. The piece has `points` points, of
    /// which the first is vertex `base`; `name` names a cell.
    pub(super) fn add(
        &self,
        at: &Cursor,
        out: &mut TetBuilder,
        [base, points]: [i64; 2],
        labels: &[i64],
        kept: &mut Vec<i64>,
        name: impl Fn(usize) -> String,
    ) -> Result<(), MeshError> {
        for (c, &kind) in self.types.iter().enumerate() {
            if kind != TETRA && kind != QUADRATIC_TETRA {
                continue;
            }
            let need = if kind == TETRA { 4 } else { 10 };
            let [from, to] = [self.offsets[c], self.offsets[c + 1]];
            let range = usize::try_from(from).ok().zip(usize::try_from(to).ok());
            let nodes = range.and_then(|(from, to)| self.connectivity.get(from..to)).unwrap_or_default();
            if nodes.len() != need {
                let what = format!("the connectivity of {}", name(c));
                return Err(at.fail(Problem::Length { what, expected: need as u64, found: nodes.len() as u64 }));
            }
            let mut tet = [0; 4];
            for (corner, &node) in tet.iter_mut().zip(nodes) {
                if !(0..points).contains(&node) {
                    return Err(at.fail(Problem::NoSuchVertex { element: name(c), vertex: node }));
                }
                *corner = base + node;
            }
            out.tet(at, tet, || name(c))?;
            kept.push(labels.get(c).copied().unwrap_or(0));
        }
        Ok(())
    }
}

pub(super) fn read(path: &Path, bytes: &[u8]) -> Result<LabelledTets, MeshError> {
    let mut at = Cursor::new(path, bytes);
    let first = at.line().unwrap_or_default();
    if !first.starts_with(b"# vtk DataFile Version") {
        return Err(at.unexpected("'# vtk DataFile Version' as the first line", first));
    }
    let version: f64 = first.rsplit(|&c| c == b' ').next().and_then(number).unwrap_or(3.0);
    at.line();
    let encoding = match at.word("the encoding")?.to_ascii_uppercase().as_slice() {
        b"ASCII" => None,
        b"BINARY" => Some(Endian::Big),
        other => return Err(at.unexpected("ASCII or BINARY", other)),
    };
    let mut file = File { at, encoding };
    file.keyword(b"DATASET")?;
    let dataset = file.at.word("the data set")?;
    if !dataset.eq_ignore_ascii_case(b"UNSTRUCTURED_GRID") {
        return Err(file.at.unexpected("UNSTRUCTURED_GRID", dataset));
    }
    file.grid(version)
}

/// What came of looking at one section of data.
enum Search {
    On,
    Found(Vec<i64>),
    End,
}

struct File<'a> {
    at: Cursor<'a>,
    encoding: Option<Endian>,
}

impl File<'_> {
    fn keyword(&mut self, wanted: &[u8]) -> Result<(), MeshError> {
        let word = self.at.word("the header")?;
        let expected = format!("'{}'", String::from_utf8_lossy(wanted));
        if word.eq_ignore_ascii_case(wanted) { Ok(()) } else { Err(self.at.unexpected(&expected, word)) }
    }

    fn scalar(&mut self) -> Result<Scalar, MeshError> {
        let word = self.at.word("a number type")?;
        std::str::from_utf8(word)
            .ok()
            .and_then(Scalar::named)
            .ok_or_else(|| self.at.unexpected("a number type like 'double' or 'vtktypeint64'", word))
    }

    /// Reads values from the next line on with `read`.
    fn values<T>(&mut self, read: impl FnOnce(&mut Cursor) -> Result<T, MeshError>) -> Result<T, MeshError> {
        self.at.line();
        self.at.endian = self.encoding;
        let out = read(&mut self.at);
        if out.is_ok() {
            self.at.endian = None;
        }
        out
    }

    fn ints(&mut self, scalar: Scalar, n: usize, what: &str) -> Result<Vec<i64>, MeshError> {
        self.values(|at| at.ints(scalar, n, what))
    }

    fn count(&mut self, what: &str) -> Result<usize, MeshError> {
        let n = self.at.parse(what)?;
        self.at.count(n, 1, what)
    }

    fn grid(mut self, version: f64) -> Result<LabelledTets, MeshError> {
        let mut out = TetBuilder::default();
        let (mut offsets, mut connectivity, mut types) = (Vec::new(), Vec::new(), None);
        while types.is_none() {
            let word = self.at.word("the grid")?;
            match word.to_ascii_uppercase().as_slice() {
                b"POINTS" => {
                    let n = self.count("points")?;
                    let scalar = self.scalar()?;
                    self.values(|at| {
                        for i in 0..n {
                            let [x, y, z] = [(); 3].map(|()| at.real(scalar, "the points"));
                            out.vertex(at, i as i64, [x?, y?, z?])?;
                        }
                        Ok(())
                    })?;
                }
                b"CELLS" => (offsets, connectivity) = self.cells(version)?,
                b"CELL_TYPES" => {
                    let n = self.count("cell types")?;
                    types = Some(self.ints(Scalar::I32, n, "the cell types")?);
                }
                b"METADATA" => self.metadata(),
                b"FIELD" => drop(self.field(false)?),
                _ => return Err(self.at.unexpected("POINTS, CELLS or CELL_TYPES", word)),
            }
        }
        let types = types.unwrap_or_default();
        if offsets.len() != types.len() + 1 {
            let [expected, found] = [types.len() as u64, (offsets.len() as u64).saturating_sub(1)];
            return Err(self.at.fail(Problem::Length { what: "CELLS".into(), expected, found }));
        }
        let points = out.vertices() as i64;
        let cells = Cells { offsets, connectivity, types };
        // The cell's number tells more than the end of the grid, where the reader stands.
        let whole = Cursor::decoded(self.at.path(), &[], None, Place::Whole);
        let labels = self.labels(cells.types.len())?;
        let mut kept = Vec::new();
        cells.add(&whole, &mut out, [0, points], &labels, &mut kept, |c| format!("cell {c}"))?;
        out.finish(&whole, kept)
    }

    /// Offsets and connectivity of either layout.
    fn cells(&mut self, version: f64) -> Result<(Vec<i64>, Vec<i64>), MeshError> {
        let n = self.count("cells")?;
        let size = self.count("cell entries")?;
        if version >= 5.0 {
            self.keyword(b"OFFSETS")?;
            let scalar = self.scalar()?;
            let offsets = self.ints(scalar, n, "the offsets")?;
            self.keyword(b"CONNECTIVITY")?;
            let scalar = self.scalar()?;
            return Ok((offsets, self.ints(scalar, size, "the connectivity")?));
        }
        let flat = self.ints(Scalar::I32, size, "the cells")?;
        let (mut offsets, mut connectivity) = (vec![0], Vec::with_capacity(flat.len()));
        let mut rest = &flat[..];
        while let Some((&corners, later)) = rest.split_first() {
            let Some((cell, later)) = usize::try_from(corners).ok().and_then(|c| later.split_at_checked(c)) else {
                return Err(self.at.unexpected("the number of corners of a cell", corners.to_string().as_bytes()));
            };
            connectivity.extend_from_slice(cell);
            offsets.push(connectivity.len() as i64);
            rest = later;
        }
        Ok((offsets, connectivity))
    }

    /// `METADATA` goes up to the next blank line.
    fn metadata(&mut self) {
        self.at.line();
        while self.at.line().is_some_and(|line| !line.trim_ascii().is_empty()) {}
    }

    /// The label of each of `cells` cells, if there are any; what this reader can't step over ends the search, but a
    /// file that ends inside the labels is an error.
    fn labels(&mut self, cells: usize) -> Result<Vec<i64>, MeshError> {
        let mut found = None;
        let mut of_cells = false;
        while found.is_none() && !self.at.left().trim_ascii_start().is_empty() {
            match self.next_data(cells, &mut of_cells) {
                Ok(Search::On) => {}
                Ok(Search::Found(labels)) => found = Some(labels),
                Ok(Search::End) => break,
                Err(e @ MeshError::Content { problem: Problem::Truncated { .. } | Problem::TooMany { .. }, .. }) => {
                    return Err(e);
                }
                Err(_) => break,
            }
        }
        Ok(found.filter(|labels| labels.len() == cells).unwrap_or_default())
    }

    fn next_data(&mut self, cells: usize, of_cells: &mut bool) -> Result<Search, MeshError> {
        let word = self.at.word("the data")?.to_ascii_uppercase();
        match word.as_slice() {
            b"CELL_DATA" => {
                *of_cells = true;
                self.count("cells")?;
            }
            // Its kinds are many, so the next line 'CELL_DATA' is searched for.
            b"POINT_DATA" if !self.at.skip_to(b"\nCELL_DATA ") => return Ok(Search::End),
            b"POINT_DATA" => {}
            b"METADATA" => self.metadata(),
            b"FIELD" => {
                if let Some(labels) = self.field(*of_cells)? {
                    return Ok(Search::Found(labels));
                }
            }
            b"SCALARS" if *of_cells => {
                let name = self.at.word("a name")?;
                let wanted = std::str::from_utf8(name).is_ok_and(is_label);
                let scalar = self.scalar()?;
                let components = self.at.line().unwrap_or_default().trim_ascii();
                let components: usize = if components.is_empty() { 1 } else { number(components).unwrap_or(0) };
                self.keyword(b"LOOKUP_TABLE")?;
                self.at.word("a table")?;
                let values = self.ints_or_reals(scalar, cells.saturating_mul(components))?;
                if wanted && components == 1 {
                    return Ok(Search::Found(values));
                }
            }
            _ => return Ok(Search::End),
        }
        Ok(Search::On)
    }

    fn ints_or_reals(&mut self, scalar: Scalar, n: usize) -> Result<Vec<i64>, MeshError> {
        if scalar.is_float() {
            return Ok(self.values(|at| at.reals(scalar, n, "the data"))?.into_iter().map(|v| v as i64).collect());
        }
        self.ints(scalar, n, "the data")
    }

    /// Steps over the arrays of a `FIELD`; returns the label array if `wanted` and among them.
    fn field(&mut self, wanted: bool) -> Result<Option<Vec<i64>>, MeshError> {
        self.at.word("the name of a field")?;
        let mut found = None;
        for _ in 0..self.count("arrays")? {
            let mut name = self.at.word("the name of an array")?;
            while name.eq_ignore_ascii_case(b"METADATA") {
                self.metadata();
                name = self.at.word("the name of an array")?;
            }
            let [components, tuples] = [self.count("components")?, self.count("tuples")?];
            let scalar = self.scalar()?;
            let values = self.ints_or_reals(scalar, components.saturating_mul(tuples))?;
            if wanted && components == 1 && std::str::from_utf8(name).is_ok_and(is_label) {
                found = Some(values);
            }
        }
        Ok(found)
    }
}
