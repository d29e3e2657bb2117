//! A checkpoint for other programs: every column as `.npy`, or the particles as a table (`.csv`) or as points for ParaView
//! (`.vtu`).

use std::fmt::Write as _;
use std::fs;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use fissure_engine::column::{DType, Life, Of};

use super::{CheckpointError, FROZEN, Opened, Section};
use crate::atomic::write_atomically_with;

/// What a checkpoint can be exported to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ExportFormat {
    /// A row per particle with body and every number of every column of particles.
    Csv,
    /// A folder with a NumPy file for every column: `particles.position.npy`, `bodies.vase.bonds.intact.npy`.
    Npy,
    /// Points with every column of particles: opens in ParaView, pyvista, meshio.
    Vtu,
}

impl ExportFormat {
    /// All formats with their names.
    pub const ALL: [(Self, &'static str); 3] = [(Self::Csv, "csv"), (Self::Npy, "npy"), (Self::Vtu, "vtu")];
}

/// Writes the checkpoint `path` to `to`: a file, or a folder for [`ExportFormat::Npy`]. The columns that do not change are
/// taken from `frozen.fis` beside it, where that belongs to it. Every column is checked first. Returns the files.
///
/// # Errors
/// A file that is no checkpoint or is damaged, one without positions, or what the system says.
pub fn export(path: &Path, format: ExportFormat, to: &Path) -> Result<Vec<PathBuf>, CheckpointError> {
    let file = Opened::open(path)?;
    file.verify()?;
    let beside = path.with_file_name(FROZEN);
    let mut files = Vec::new();
    if file.life() == Life::Live && beside.is_file() {
        let frozen = Opened::open(beside)?;
        file.belongs_to(&frozen)?;
        frozen.verify()?;
        files.push(frozen);
    }
    files.push(file);
    match format {
        ExportFormat::Npy => {
            fs::create_dir_all(to).map_err(CheckpointError::io("create", to))?;
            let columns = files.iter().flat_map(|file| file.iter());
            let each = columns.map(|(section, bytes)| {
                let name = section.label().replace(|c: char| !c.is_alphanumeric() && c != '_' && c != '-', ".");
                let path = to.join(name + ".npy");
                write_atomically_with(&path, |out| npy(section, bytes, out))
                    .map_err(CheckpointError::io("write", &path))?;
                Ok(path)
            });
            each.collect()
        }
        ExportFormat::Csv | ExportFormat::Vtu => {
            let table = Table::of(&files)?;
            let written = match format {
                ExportFormat::Csv => write_atomically_with(to, |out| table.csv(out)),
                _ => write_atomically_with(to, |out| table.vtu(out)),
            };
            written.map_err(CheckpointError::io("write", to))?;
            Ok(vec![to.to_owned()])
        }
    }
}

/// Names of the types in NumPy and in VTK.
fn names(dtype: DType) -> [&'static str; 2] {
    match dtype {
        DType::U8 => ["|u1", "UInt8"],
        DType::U32 => ["<u4", "UInt32"],
        DType::U64 => ["<u8", "UInt64"],
        DType::F32 => ["<f4", "Float32"],
        DType::F64 => ["<f8", "Float64"],
    }
}

/// Version 1.0 of the format: magic, length of the header, a Python dictionary padded to 64 bytes, the numbers.
fn npy(section: &Section, bytes: &[u8], out: &mut dyn Write) -> io::Result<()> {
    let shape = match section.width {
        1 => format!("({},)", section.count),
        width => format!("({}, {width})", section.count),
    };
    let [descr, _] = names(section.dtype);
    let mut header = format!("{{'descr': '{descr}', 'fortran_order': False, 'shape': {shape}, }}");
    let padded = (10 + header.len() + 1).next_multiple_of(64);
    header.extend(std::iter::repeat_n(' ', padded - 10 - header.len() - 1));
    header.push('\n');
    out.write_all(b"\x93NUMPY\x01\x00")?;
    out.write_all(&(header.len() as u16).to_le_bytes())?;
    out.write_all(header.as_bytes())?;
    out.write_all(bytes)
}

/// The columns of particles, and the body of each.
struct Table<'a> {
    columns: Vec<(&'a Section, &'a [u8])>,
    /// Name, first particle and the one after the last of each body.
    bodies: Vec<(&'a str, [u64; 2])>,
    particles: usize,
}

impl<'a> Table<'a> {
    fn of(files: &'a [Opened]) -> Result<Self, CheckpointError> {
        let of_particles = |s: &Section| s.of == Of::Particle && s.scope == "particles";
        let columns: Vec<_> = files.iter().flat_map(Opened::iter).filter(|(s, _)| of_particles(s)).collect();
        let last = files.last().expect("the checkpoint itself");
        let Some(particles) = columns.iter().find(|(s, _)| s.name == "position").map(|(s, _)| s.count) else {
            return Err(CheckpointError::NoColumn {
                path: last.path().to_owned(),
                column: "particles/position".into(),
            });
        };
        if let Some((s, _)) = columns.iter().find(|(s, _)| s.count != particles) {
            let problem = format!("column `{}` has {} elements for {particles} particles", s.label(), s.count);
            return Err(CheckpointError::damaged(last.path(), problem));
        }
        let mut bodies = Vec::new();
        for file in files {
            for name in
                file.sections().iter().filter(|s| s.name == "range").filter_map(|s| s.scope.strip_prefix("bodies/"))
            {
                if let Ok(&[start, end]) = file.column::<u64>(&format!("bodies/{name}"), "range") {
                    bodies.push((name, [start, end]));
                }
            }
        }
        Ok(Self { columns, bodies, particles })
    }

    fn body(&self, particle: usize) -> Option<usize> {
        self.bodies.iter().position(|(_, [start, end])| (*start..*end).contains(&(particle as u64)))
    }

    fn csv(&self, out: &mut dyn Write) -> io::Result<()> {
        let mut writer = csv::Writer::from_writer(out);
        let mut head = vec!["body".to_owned()];
        for (s, _) in &self.columns {
            let unit = if s.unit == "1" { String::new() } else { format!(" [{}]", s.unit) };
            match s.width {
                1 => head.push(format!("{}{unit}", s.name)),
                3 => head.extend(["x", "y", "z"].map(|axis| format!("{} {axis}{unit}", s.name))),
                width => head.extend((0..width).map(|k| format!("{} {k}{unit}", s.name))),
            }
        }
        writer.write_record(&head).map_err(io::Error::other)?;
        let mut text = String::new();
        for i in 0..self.particles {
            writer.write_field(self.body(i).map_or("", |b| self.bodies[b].0)).map_err(io::Error::other)?;
            for (s, bytes) in &self.columns {
                let size = s.dtype.size();
                for number in bytes[i * s.width * size..(i + 1) * s.width * size].chunks_exact(size) {
                    text.clear();
                    number_text(s.dtype, number, &mut text);
                    writer.write_field(&text).map_err(io::Error::other)?;
                }
            }
            writer.write_record(None::<&[u8]>).map_err(io::Error::other)?;
        }
        writer.flush()
    }

    fn vtu(&self, out: &mut dyn Write) -> io::Result<()> {
        let n = self.particles;
        let body: Vec<u8> = (0..n).flat_map(|i| self.body(i).map_or(-1, |b| b as i32).to_le_bytes()).collect();
        let positions = self.columns.iter().find(|(s, _)| s.name == "position").expect("looked for").1;
        let vertices: Vec<u8> = (0..n as i64).flat_map(i64::to_le_bytes).collect();
        let ends: Vec<u8> = (1..=n as i64).flat_map(i64::to_le_bytes).collect();
        let types = vec![1; n]; // VTK_VERTEX
        let mut blocks: Vec<&[u8]> = Vec::new();
        let mut offset = 0;
        // one line per array, and its place behind those before it: each has 8 bytes of length first
        let mut array = |kind: &str, name: &str, width: usize, bytes| {
            let line = format!(
                "<DataArray type=\"{kind}\" Name=\"{name}\" NumberOfComponents=\"{width}\" format=\"appended\" \
                 offset=\"{offset}\"/>\n"
            );
            blocks.push(bytes);
            offset += 8 + bytes.len();
            line
        };
        let mut xml = format!(
            "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" \
             header_type=\"UInt64\">\n<UnstructuredGrid>\n<Piece NumberOfPoints=\"{n}\" NumberOfCells=\"{n}\">\n"
        );
        write!(xml, "<Points>\n{}</Points>\n", array("Float64", "Points", 3, positions)).expect("a string grows");
        let cells = array("Int64", "connectivity", 1, &vertices)
            + &array("Int64", "offsets", 1, &ends)
            + &array("UInt8", "types", 1, &types);
        write!(xml, "<Cells>\n{cells}</Cells>\n<PointData>\n{}", array("Int32", "body", 1, &body))
            .expect("a string grows");
        for (s, bytes) in self.columns.iter().filter(|(s, _)| s.name != "position") {
            xml += &array(names(s.dtype)[1], &s.name, s.width, *bytes);
        }
        xml += "</PointData>\n</Piece>\n</UnstructuredGrid>\n<AppendedData encoding=\"raw\">\n_";
        out.write_all(xml.as_bytes())?;
        for block in blocks {
            out.write_all(&(block.len() as u64).to_le_bytes())?;
            out.write_all(block)?;
        }
        out.write_all(b"\n</AppendedData>\n</VTKFile>\n")
    }
}

/// A number as the shortest text that reads back as the same.
fn number_text(dtype: DType, bytes: &[u8], text: &mut String) {
    let eight = || bytes.try_into().expect("eight bytes");
    let four = || bytes.try_into().expect("four bytes");
    match dtype {
        DType::U8 => write!(text, "{}", bytes[0]),
        DType::U32 => write!(text, "{}", u32::from_le_bytes(four())),
        DType::U64 => write!(text, "{}", u64::from_le_bytes(eight())),
        DType::F32 => write!(text, "{:?}", f32::from_le_bytes(four())),
        DType::F64 => write!(text, "{:?}", f64::from_le_bytes(eight())),
    }
    .expect("a string grows");
}
