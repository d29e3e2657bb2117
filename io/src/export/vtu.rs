//! VTK's unstructured grids: surface, particles, tetrahedra and rigid things, each a folder of `.vtu` and a `.pvd` with the
//! times. Appended raw, compressed by zlib.

use std::borrow::Cow;
use std::io::Write;
use std::path::{Path, PathBuf};

use bytemuck::NoUninit;
use flate2::Compression;
use flate2::write::ZlibEncoder;

use super::{ExportError, Shot, Stream, make, name, write};
use crate::frames::Frame;

/// What is written, by the name of its folder.
const PARTS: [&str; 4] = ["surface", "particles", "tets", "colliders"];

pub(super) struct Vtu {
    dir: PathBuf,
    /// Frames of each part, with their times.
    listed: [Vec<(u32, f64)>; 4],
}

impl Vtu {
    pub fn open(dir: PathBuf, from: u32) -> Result<Self, ExportError> {
        let mut listed = [const { Vec::new() }; 4];
        if from > 0 {
            for (part, list) in PARTS.iter().zip(&mut listed) {
                *list = earlier(&dir.join(part).with_extension("pvd"), from)?;
            }
        }
        Ok(Self { dir, listed })
    }

    fn put(&mut self, part: usize, number: u32, time: f64, grid: &Grid<'_>) -> Result<(), ExportError> {
        let folder = self.dir.join(PARTS[part]);
        make(&folder)?;
        grid.write(&folder.join(name(number, "vtu")))?;
        self.listed[part].push((number, time));
        Ok(())
    }
}

impl Stream for Vtu {
    fn frame(&mut self, shot: &Shot<'_>) -> Result<(), ExportError> {
        let (number, time) = (shot.surface.number, shot.surface.time);
        self.put(0, number, time, &surface(shot.surface))?;
        if let Some(p) = shot.particles {
            let width: Vec<f32> = (0..p.positions.len()).map(|k| p.width(k)).collect();
            let mut grid = Grid::new(&p.positions, 1, Cow::Owned((0..p.positions.len() as u32).collect()));
            grid.points = vec![
                Array::of("velocity", 3, &p.velocity),
                Array::of("damage", 1, &p.damage),
                Array::of("id", 1, &p.id),
                Array::of("piece", 1, &p.piece),
                Array::of("body", 1, &p.body),
                Array::of("mass", 1, &p.mass),
                Array::of("volume", 1, &p.volume),
                Array::of("width", 1, &width),
            ];
            self.put(1, number, time, &grid)?;
        }
        if let Some(t) = shot.tets {
            let mut grid = Grid::new(&t.positions, 4, bytemuck::cast_slice(&t.tets).into());
            grid.points = vec![Array::of("velocity", 3, &t.velocity)];
            grid.cells = vec![
                Array::of("damage", 1, &t.damage),
                Array::of("id", 1, &t.id),
                Array::of("piece", 1, &t.piece),
                Array::of("body", 1, &t.body),
            ];
            self.put(2, number, time, &grid)?;
        }
        match shot.colliders {
            Some(colliders) => self.put(3, number, time, &surface(colliders)),
            None => Ok(()),
        }
    }

    fn index(&mut self) -> Result<(), ExportError> {
        for (part, list) in PARTS.iter().zip(&self.listed).filter(|(_, list)| !list.is_empty()) {
            write(&self.dir.join(part).with_extension("pvd"), |out| {
                out.write_all(
                    b"<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"1.0\" byte_order=\"LittleEndian\">\n\
                      <Collection>\n",
                )?;
                for &(number, time) in list {
                    let file = name(number, "vtu");
                    writeln!(out, "<DataSet timestep=\"{time:?}\" part=\"0\" file=\"{part}/{file}\"/>")?;
                }
                out.write_all(b"</Collection>\n</VTKFile>\n")
            })?;
        }
        Ok(())
    }
}

/// The frames before `from` that the PVD at `path` lists; none if it is not there or not ours.
fn earlier(path: &Path, from: u32) -> Result<Vec<(u32, f64)>, ExportError> {
    let text = match std::fs::read_to_string(path) {
        Ok(text) => text,
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(Vec::new()),
        Err(error) => return Err(ExportError::io("read", path)(error)),
    };
    let listed = |document: roxmltree::Document<'_>| {
        let sets = document.descendants().filter(|n| n.has_tag_name("DataSet"));
        sets.filter_map(|n| {
            let file = n.attribute("file")?;
            let number = file.rsplit_once("frame_")?.1.strip_suffix(".vtu")?.parse().ok()?;
            Some((number, n.attribute("timestep")?.parse().ok()?))
        })
        .filter(|&(number, _)| number < from)
        .collect()
    };
    Ok(roxmltree::Document::parse(&text).map(listed).unwrap_or_default())
}

fn surface(frame: &Frame) -> Grid<'_> {
    let mut grid = Grid::new(&frame.positions, 3, bytemuck::cast_slice(&frame.triangles).into());
    grid.points = vec![
        Array::of("Normals", 3, &frame.normals),
        Array::of("velocity", 3, &frame.velocity),
        Array::of("damage", 1, &frame.damage),
        Array::of("stretch", 1, &frame.stretch),
        Array::of("id", 1, &frame.id),
        Array::of("inside", 1, &frame.inside),
        Array::of("piece", 1, &frame.piece),
    ];
    grid
}

/// A column of numbers.
struct Array<'a> {
    name: &'static str,
    kind: &'static str,
    width: usize,
    bytes: &'a [u8],
}

/// A number that VTK has a name for.
trait Scalar: NoUninit {
    const NAME: &'static str;
}

impl Scalar for u8 {
    const NAME: &'static str = "UInt8";
}
impl Scalar for u32 {
    const NAME: &'static str = "UInt32";
}
impl Scalar for f32 {
    const NAME: &'static str = "Float32";
}
impl Scalar for i64 {
    const NAME: &'static str = "Int64";
}
impl Scalar for [f32; 3] {
    const NAME: &'static str = "Float32";
}

impl<'a> Array<'a> {
    fn of<T: Scalar>(name: &'static str, width: usize, values: &'a [T]) -> Self {
        Self { name, kind: T::NAME, width, bytes: bytemuck::cast_slice(values) }
    }
}

/// Points, and cells with `corners` points each: 1, 3 or 4.
struct Grid<'a> {
    at: &'a [[f32; 3]],
    corners: usize,
    connectivity: Cow<'a, [u32]>,
    points: Vec<Array<'a>>,
    cells: Vec<Array<'a>>,
}

impl<'a> Grid<'a> {
    fn new(at: &'a [[f32; 3]], corners: usize, connectivity: Cow<'a, [u32]>) -> Self {
        Self { at, corners, connectivity, points: Vec::new(), cells: Vec::new() }
    }

    fn write(&self, path: &Path) -> Result<(), ExportError> {
        let n = self.connectivity.len() / self.corners;
        let kind = [0_u8, 1, 0, 5, 10][self.corners]; // VTK_VERTEX, VTK_TRIANGLE, VTK_TETRA
        // 64 bits, as VTK keeps them: meshio takes no others for offsets
        let connectivity: Vec<i64> = self.connectivity.iter().map(|&v| v.into()).collect();
        let ends: Vec<i64> = (1..=n).map(|k| (k * self.corners) as i64).collect();
        let kinds = vec![kind; n];
        let mut data = Vec::new();
        let mut line = |a: &Array<'_>| {
            let (kind, name, width, offset) = (a.kind, a.name, a.width, data.len());
            pack(a.bytes, &mut data);
            format!(
                "<DataArray type=\"{kind}\" Name=\"{name}\" NumberOfComponents=\"{width}\" format=\"appended\" \
                 offset=\"{offset}\"/>\n"
            )
        };
        let mut xml = format!(
            "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" \
             header_type=\"UInt64\" compressor=\"vtkZLibDataCompressor\">\n<UnstructuredGrid>\n\
             <Piece NumberOfPoints=\"{}\" NumberOfCells=\"{n}\">\n",
            self.at.len()
        );
        let mut section = |tag: &str, arrays: &[Array<'_>]| {
            xml += &format!("<{tag}>\n");
            arrays.iter().for_each(|a| xml += &line(a));
            xml += &format!("</{tag}>\n");
        };
        section("PointData", &self.points);
        section("CellData", &self.cells);
        section("Points", &[Array::of("Points", 3, self.at)]);
        let cells = [("connectivity", &connectivity), ("offsets", &ends)].map(|(name, v)| Array::of(name, 1, v));
        let [connectivity, ends] = cells;
        section("Cells", &[connectivity, ends, Array::of("types", 1, &kinds)]);
        xml += "</Piece>\n</UnstructuredGrid>\n<AppendedData encoding=\"raw\">\n_";
        write(path, |out| {
            out.write_all(xml.as_bytes())?;
            out.write_all(&data)?;
            out.write_all(b"\n</AppendedData>\n</VTKFile>\n")
        })
    }
}

/// Appends `bytes` in compressed blocks: number of blocks, bytes of one, bytes of a shorter last one or 0, packed bytes of
/// each, blocks.
fn pack(bytes: &[u8], data: &mut Vec<u8>) {
    const BLOCK: usize = 1 << 16;
    let blocks: Vec<Vec<u8>> = bytes.chunks(BLOCK).map(zlib).collect();
    let lengths = blocks.iter().map(Vec::len);
    for word in [blocks.len(), BLOCK, bytes.len() % BLOCK].into_iter().chain(lengths) {
        data.extend_from_slice(&(word as u64).to_le_bytes());
    }
    blocks.iter().for_each(|block| data.extend_from_slice(block));
}

fn zlib(block: &[u8]) -> Vec<u8> {
    // the fastest level: frames are written while a run waits
    let mut encoder = ZlibEncoder::new(Vec::new(), Compression::fast());
    encoder.write_all(block).and_then(|()| encoder.finish()).expect("a vector takes what it is given")
}
