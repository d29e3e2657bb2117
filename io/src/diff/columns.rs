//! Two columns, number by number.

use bytemuck::Pod;
use fissure_engine::column::{DType, Of};
use xxhash_rust::xxh3::Xxh3;

use super::order::Matching;
use super::side::{CHUNK, Side};
use super::{ColumnDiff, DiffError, FileDiff, Numbers, Options, Verdict};
use crate::checkpoint::{Section, type_name};

/// Bytes compared at a time; a multiple of every number's size.
const PIECE: usize = 1 << 20;

/// Compares two checkpoints.
///
/// # Errors
/// A damaged file, a live one against a frozen one, or no column with the name that the options ask for.
pub fn checkpoints(a: &Side, b: &Side, options: &Options) -> Result<FileDiff, DiffError> {
    b.file.expect_life(a.file.life())?;
    a.verify_frozen()?;
    b.verify_frozen()?;
    let matching = Matching::new(a, b);
    let mut columns = Vec::new();
    let wanted = |s: &&Section| s.label().contains(&options.columns);
    for section in a.file.sections().iter().filter(wanted) {
        let verdict = match find(b, section) {
            None => Verdict::Only(0),
            Some(other) => compare([a, b], [section, other], matching.as_ref(), options.tolerance)?,
        };
        columns.push(ColumnDiff { label: section.label(), unit: section.unit.clone(), verdict });
    }
    for section in b.file.sections().iter().filter(wanted).filter(|s| find(a, s).is_none()) {
        columns.push(ColumnDiff { label: section.label(), unit: section.unit.clone(), verdict: Verdict::Only(1) });
    }
    if columns.is_empty() && !options.columns.is_empty() {
        let known = a.file.sections().iter().map(Section::label).collect();
        return Err(DiffError::NoColumn { part: options.columns.clone(), known });
    }
    Ok(FileDiff { step: [a, b].map(|s| s.file.about().step), matched: matching.is_some(), columns })
}

/// The column of the same name.
fn find<'a>(side: &'a Side, section: &Section) -> Option<&'a Section> {
    side.file.find(&section.scope, &section.name).ok().map(|k| &side.file.sections()[k])
}

fn compare(
    sides: [&Side; 2],
    sections: [&Section; 2],
    matching: Option<&Matching>,
    tolerance: f64,
) -> Result<Verdict, DiffError> {
    let shape = |s: &Section| format!("{} {}", s.count, type_name(s.dtype, s.width, &s.unit));
    let shapes = sections.map(shape);
    if shapes[0] != shapes[1] {
        return Ok(Verdict::Shape(shapes));
    }
    let (mut differing, mut largest, mut at, mut squares) = (0u64, 0.0f64, 0, 0.0);
    let known = walk(sides, sections, matching, &mut |element, d| {
        squares += d * d;
        if tolerance == 0.0 || d > tolerance {
            if differing == 0 || d > largest {
                (largest, at) = (d, element);
            }
            differing += 1;
        }
    })?;
    let of = (sections[0].count * sections[0].width) as u64;
    Ok(match differing {
        _ if !known => Verdict::Order,
        0 => Verdict::Same,
        _ => {
            let rms = (squares / of as f64).sqrt();
            Verdict::Numbers(Numbers { of, differing, largest, rms, place: sides[0].place(sections[0], at) })
        }
    })
}

/// Tells `see` every number whose bits differ: the element of the first column, and how far apart they are. Says whether
/// the elements of both could be matched.
pub(super) fn walk(
    sides: [&Side; 2],
    sections: [&Section; 2],
    matching: Option<&Matching>,
    see: &mut dyn FnMut(u64, f64),
) -> Result<bool, DiffError> {
    let Some(matching) = matching else {
        in_step(sides, sections, see)?;
        return Ok(true);
    };
    let section = sections[0];
    if section.of == Of::Thing && !INDICES.contains(&section.name.as_str()) {
        in_step(sides, sections, see)?;
        return Ok(true);
    }
    for side in sides {
        side.file.verify_once()?;
    }
    let bodies = sides.map(|s| s.body_of(&section.scope));
    let bytes = [0, 1].map(|k| sides[k].file.bytes_of(sections[k]));
    let size = section.dtype.size() * section.width;
    let element = |k: usize, at: u64| bytes[k].get(at as usize * size..)?.get(..size);
    let mut inside = true; // a forged table of bodies may lead outside the column
    let mut pair = |[i, j]: [u64; 2]| match (element(0, i), element(1, j)) {
        (Some(a), Some(b)) => numbers(section, a, b, &mut |_, d| see(i, d)),
        _ => inside = false,
    };
    let matched = match (section.of, bodies) {
        _ if INDICES.contains(&section.name.as_str()) => None,
        (Of::Particle, bodies) => {
            let ranges = if let [Some((_, a)), Some((_, b))] = bodies { Some([a, b]) } else { None };
            (matching.particles(ranges, &mut pair) == section.count).then_some(())
        }
        (Of::Bond, [Some((name, a)), Some((_, b))]) => matching.bonds(sides, name, [a, b], &mut pair),
        (Of::Chunk, [Some((name, a)), Some((_, b))]) if size == 1 => {
            let bit = |k: usize, slot: u64| Some(bytes[k].get(slot as usize / CHUNK)? >> (slot as usize % CHUNK) & 1);
            matching.bonds(sides, name, [a, b], &mut |[i, j]| {
                if bit(0, i) != bit(1, j) {
                    see(i / CHUNK as u64, 1.0);
                }
            })
        }
        _ => None,
    };
    Ok(matched.is_some() && inside)
}

/// Columns that hold places of particles and not what particles are.
const INDICES: [&str; 2] = ["neighbours", "offsets"];

/// Columns in the same order, read side by side; checks their sums on the way.
fn in_step(sides: [&Side; 2], sections: [&Section; 2], see: &mut dyn FnMut(u64, f64)) -> Result<(), DiffError> {
    let mut buffers = [0, 1].map(|_| vec![0u64; PIECE / 8]); // u64 for the alignment of any number
    let mut hashes = [Xxh3::new(), Xxh3::new()];
    let per_element = (sections[0].dtype.size() * sections[0].width) as u64;
    let mut done = 0;
    while done < sections[0].len() {
        let length = PIECE.min(sections[0].len() - done);
        for k in 0..2 {
            let piece = &mut bytemuck::cast_slice_mut::<u64, u8>(&mut buffers[k])[..length];
            sides[k].file.piece(sections[k], done, piece)?;
            hashes[k].update(piece);
        }
        let [a, b] = buffers.each_ref().map(|buffer| &bytemuck::cast_slice::<u64, u8>(buffer)[..length]);
        if a != b {
            let size = sections[0].dtype.size() as u64;
            numbers(sections[0], a, b, &mut |k, d| see((done as u64 + k * size) / per_element, d));
        }
        done += length;
    }
    for k in 0..2 {
        sides[k].file.check_sum(sections[k], hashes[k].digest())?;
    }
    Ok(())
}

/// Every number of two pieces whose bits differ: its place in the piece, and how far apart they are.
fn numbers(section: &Section, a: &[u8], b: &[u8], see: &mut dyn FnMut(u64, f64)) {
    fn each<T: Pod>(a: &[u8], b: &[u8], apart: impl Fn(T, T) -> Option<f64>, see: &mut dyn FnMut(u64, f64)) {
        let (a, b) = (a.chunks_exact(size_of::<T>()), b.chunks_exact(size_of::<T>()));
        for (k, (a, b)) in a.zip(b).enumerate() {
            if let Some(d) = apart(bytemuck::pod_read_unaligned(a), bytemuck::pod_read_unaligned(b)) {
                see(k as u64, d);
            }
        }
    }
    let float = |a: f64, b: f64| match (a.is_nan(), b.is_nan()) {
        (true, true) => 0.0,
        (false, false) if a == b => 0.0, // also of infinities
        (false, false) => (a - b).abs(),
        _ => f64::INFINITY,
    };
    match section.dtype {
        DType::U8 if section.of == Of::Chunk => {
            each::<u8>(a, b, |a, b| (a != b).then(|| f64::from((a ^ b).count_ones())), see);
        }
        DType::U8 => each::<u8>(a, b, |a, b| (a != b).then(|| a.abs_diff(b).into()), see),
        DType::U32 => each::<u32>(a, b, |a, b| (a != b).then(|| a.abs_diff(b).into()), see),
        DType::U64 => each::<u64>(a, b, |a, b| (a != b).then(|| a.abs_diff(b) as f64), see),
        DType::F32 => {
            each::<f32>(a, b, |a, b| (a.to_bits() != b.to_bits()).then(|| float(a.into(), b.into())), see);
        }
        DType::F64 => each::<f64>(a, b, |a, b| (a.to_bits() != b.to_bits()).then(|| float(a, b)), see),
    }
}
