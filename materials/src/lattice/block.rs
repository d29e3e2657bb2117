//! A block of a uniform lattice, and the running sums over it ([`uniform`](super::uniform) says which).

use std::ops::Range;

use glam::{DMat3, DVec3, Vec3};

use super::cells::{Finest, NONE};
use super::matching::{EMPTY, Found, Rows, STRAIGHT, Turn, Wanted, add, general, goal, lever, moment, rigid, subtract};
use super::uniform::{Columns, Step};

/// A box of cells of its own, with what lies around it.
#[derive(Debug, Default)]
pub struct Block {
    /// w of the regions.
    half_width: usize,
    /// Cells along x of the body's box.
    nx: usize,
    /// Rows along y in the plane of this block, and which of them are its own.
    ny: usize,
    own_rows: Range<usize>,
    /// First of the cells of each plane, and one more; which planes are its own.
    planes: Vec<u32>,
    own_planes: Range<usize>,
    /// Cells plane after plane and row after row, and their place in the plane.
    pub cells: Vec<u32>,
    at: Vec<u32>,
    /// Number among its own of each, else [`NONE`].
    pub own: Vec<u32>,
    /// For each of its own: the sum of the goals of its cubes; the rotation of the cube around it, and its stretch where rest
    /// shapes flow; sums over that cube, when it is settled.
    pub goals: Vec<DVec3>,
    pub means: Vec<Rows>,
    pub turns: Vec<Turn>,
    pub stretch: Vec<DMat3>,
    scratch: Scratch,
}

/// Sums of a block.
#[derive(Debug, Default)]
struct Scratch {
    /// Σ over planes of moments, and of goals.
    moments: Vec<Rows>,
    goals: Vec<Rows>,
    /// Goals of the last 2w + 1 planes.
    ring: Vec<Rows>,
    /// Sums along x of the last 2w + 1 rows, and their sum.
    lines: Vec<Rows>,
    sum: Vec<Rows>,
}

impl Block {
    /// The box of `rows` and `planes` of a body of `size`, whose cells lie at `place`, those of each plane in `plane`.
    pub fn new<'a>(
        size: [usize; 3],
        rows: Range<usize>,
        planes: Range<usize>,
        w: usize,
        place: impl Fn(u32) -> [usize; 3],
        plane: impl Fn(usize) -> &'a [u32],
    ) -> Self {
        let around = |own: &Range<usize>, all: usize| own.start.saturating_sub(2 * w)..(own.end + 2 * w).min(all);
        let (all_rows, all_planes) = (around(&rows, size[1]), around(&planes, size[2]));
        let (nx, ny) = (size[0], all_rows.len());
        let mut b = Self {
            half_width: w,
            nx,
            ny,
            own_rows: rows.start - all_rows.start..rows.end - all_rows.start,
            planes: vec![0],
            own_planes: planes.start - all_planes.start..planes.end - all_planes.start,
            ..Self::default()
        };
        let mut count = 0;
        for z in all_planes {
            for &c in plane(z).iter().filter(|&&c| all_rows.contains(&place(c)[1])) {
                let [x, y, _] = place(c);
                b.cells.push(c);
                b.at.push(((y - all_rows.start) * nx + x) as u32);
                let own = rows.contains(&y) && planes.contains(&z);
                b.own.push(if own { count } else { NONE });
                count += u32::from(own);
            }
            b.planes.push(b.cells.len() as u32);
        }
        let own = count as usize;
        (b.goals, b.means) = (vec![DVec3::ZERO; own], vec![EMPTY; own]);
        (b.turns, b.stretch) = (vec![STRAIGHT; own], vec![DMat3::IDENTITY; own]);
        let room = |planes: usize| vec![EMPTY; planes * nx * ny];
        let line = |rows: usize| vec![EMPTY; rows * nx];
        b.scratch =
            Scratch { moments: room(1), goals: room(1), ring: room(2 * w + 1), lines: line(2 * w + 1), sum: line(1) };
        b
    }

    /// Entries of plane `z`, which may lie outside.
    #[inline(always)]
    fn plane(&self, z: isize) -> Range<usize> {
        match usize::try_from(z) {
            Ok(z) if z + 1 < self.planes.len() => self.planes[z] as usize..self.planes[z + 1] as usize,
            _ => 0..0,
        }
    }

    /// The sums over the cube around each cell, with nodes at `x`; `each` gets the number among the own and the sums.
    pub fn cubes(
        &mut self,
        finest: &Finest,
        columns: &Columns,
        x: impl Fn(usize) -> DVec3,
        mut each: impl FnMut(u32, &Rows),
    ) {
        let mut s = std::mem::take(&mut self.scratch);
        s.moments.fill(EMPTY);
        let w = self.half_width as isize;
        for z in self.own_planes.start as isize - 2 * w..self.own_planes.end as isize + w {
            self.turn_over(z, &finest.rest, columns, &x, &mut s.moments);
            self.regions(z - w, &mut s, |entry, rows| each(self.own[entry], rows));
        }
        self.scratch = s;
    }

    /// Lets plane `z` enter the sum over 2w + 1 planes, and the last one leave.
    #[inline(always)]
    fn turn_over(&self, z: isize, rest: &[Vec3], columns: &Columns, x: &impl Fn(usize) -> DVec3, sum: &mut [Rows]) {
        let w = self.half_width as isize;
        let of = |k: usize| {
            let c = self.cells[k] as usize;
            moment(columns.weight[c], x(c), lever(rest[c].as_dvec3()))
        };
        self.plane(z).for_each(|k| add(&mut sum[self.at[k] as usize], &of(k)));
        self.plane(z - 2 * w - 1).for_each(|k| subtract(&mut sum[self.at[k] as usize], &of(k)));
    }

    /// Gives the sums over the cube around each entry of plane `z` that a cell of this block may need.
    #[inline(always)]
    fn regions(&self, z: isize, s: &mut Scratch, mut each: impl FnMut(usize, &Rows)) {
        let w = self.half_width;
        let rows = self.own_rows.start.saturating_sub(w)..(self.own_rows.end + w).min(self.ny);
        let Scratch { moments, lines, sum, .. } = s;
        self.cubes_of(z, moments, rows, lines, sum, &mut each);
    }

    /// Sums over 2w + 1 along x and along y of `sums`, which are those of a plane: `each` gets those around the entries of plane `z`
    /// in the rows `wanted`.
    #[inline(always)]
    fn cubes_of(
        &self,
        z: isize,
        sums: &[Rows],
        wanted: Range<usize>,
        lines: &mut [Rows],
        sum: &mut [Rows],
        mut each: impl FnMut(usize, &Rows),
    ) {
        let mut entries = self.plane(z).peekable();
        if entries.peek().is_none() {
            return;
        }
        along(sums, [self.nx, self.ny], self.half_width, wanted, lines, sum, |y, sums| {
            let (start, end) = ((y * self.nx) as u32, ((y + 1) * self.nx) as u32);
            while entries.next_if(|&k| self.at[k] < start).is_some() {}
            while let Some(k) = entries.next_if(|&k| self.at[k] < end) {
                each(k, &sums[(self.at[k] - start) as usize]);
            }
        });
    }

    /// The sum of the goals of the cubes over each of its own cells, and their rotations.
    pub fn gather(&mut self, columns: &Columns, step: &Step<'_>) {
        let mut s = std::mem::take(&mut self.scratch);
        let mut goals = std::mem::take(&mut self.goals);
        let (mut turns, mut stretch) = (std::mem::take(&mut self.turns), std::mem::take(&mut self.stretch));
        s.moments.fill(EMPTY);
        s.goals.fill(EMPTY);
        let (plane, i) = (self.nx * self.ny, self.half_width as isize);
        let (x, rest) = (|c: usize| step.x[c] - step.origin, &step.finest.rest[..]);
        let first = self.own_planes.start as isize - i;
        for z in self.own_planes.start as isize - 2 * i..self.own_planes.end as isize + 2 * i {
            self.turn_over(z, rest, columns, &x, &mut s.moments);
            let middle = z - i;
            if middle < first {
                continue;
            }
            let slot = (middle.rem_euclid(2 * i + 1)) as usize * plane;
            let mut ring = std::mem::take(&mut s.ring);
            let mut sum = std::mem::take(&mut s.goals);
            let kept = &mut ring[slot..slot + plane];
            if middle > first + 2 * i {
                for k in self.plane(middle - 2 * i - 1) {
                    subtract(&mut sum[self.at[k] as usize], &kept[self.at[k] as usize]);
                }
            }
            self.plane(middle).for_each(|k| kept[self.at[k] as usize] = EMPTY);
            self.match_plane(middle, columns, step, &mut s, kept, (&mut turns, &mut stretch));
            self.plane(middle).for_each(|k| add(&mut sum[self.at[k] as usize], &kept[self.at[k] as usize]));
            (s.ring, s.goals) = (ring, sum);
            let out = middle - i;
            if out >= self.own_planes.start as isize {
                let Scratch { goals: sum, lines, sum: line, .. } = &mut s;
                self.cubes_of(out, sum, self.own_rows.clone(), lines, line, |k, rows| {
                    goals[self.own[k] as usize] = goal(rows, lever(rest[self.cells[k] as usize].as_dvec3()));
                });
            }
        }
        (self.goals, self.turns, self.stretch, self.scratch) = (goals, turns, stretch, s);
    }

    /// Matches the cubes around the cells of plane `z`, four at a time, and keeps their goals.
    #[inline(always)]
    fn match_plane(
        &self,
        z: isize,
        columns: &Columns,
        step: &Step<'_>,
        s: &mut Scratch,
        kept: &mut [Rows],
        (turned, stretched): (&mut [Turn], &mut [DMat3]),
    ) {
        let (mut entry, mut sums, mut waiting) = ([0; 4], [EMPTY; 4], 0);
        let mut solve = |entry: &[usize; 4], sums: &[Rows; 4], count: usize| {
            let cell = entry.map(|k| self.cells[k] as usize);
            let turns = cell.map(|c| step.turns[c]);
            let own = entry.map(|k| self.own[k]);
            let goals = if columns.still.is_empty() {
                let (goals, turns) = rigid(*sums, cell.map(|c| columns.light[c]), turns);
                let mine = own.iter().zip(turns).take(count).filter(|(own, _)| **own != NONE);
                mine.for_each(|(&own, turn)| turned[own as usize] = turn);
                goals
            } else {
                let (still, shapes) = (cell.map(|c| &columns.still[c]), cell.map(|c| step.shapes.get(c)));
                let (mut goals, mut found) = ([EMPTY; 4], [Found::default(); 4]);
                let wanted = Wanted { settings: step.settings, all: false };
                general(*sums, still, turns, shapes, wanted, &mut goals, &mut found);
                for (&own, found) in own.iter().zip(found).take(count).filter(|(own, _)| **own != NONE) {
                    (turned[own as usize], stretched[own as usize]) = (found.turn, found.stretch);
                }
                goals
            };
            (0..count).for_each(|l| kept[self.at[entry[l]] as usize] = goals[l]);
        };
        self.regions(z, s, |k, rows| {
            if !columns.whole[self.cells[k] as usize] {
                return;
            }
            (entry[waiting], sums[waiting]) = (k, *rows);
            waiting += 1;
            if waiting == 4 {
                solve(&entry, &sums, 4);
                waiting = 0;
            }
        });
        if waiting > 0 {
            for l in waiting..4 {
                (entry[l], sums[l]) = (entry[0], sums[0]);
            }
            solve(&entry, &sums, waiting);
        }
    }
}

/// Sums over 2w + 1 along x and along y of a plane of `nx` × `ny`: `each` gets those of the rows in `wanted`, one after the other.
#[inline(always)]
fn along(
    plane: &[Rows],
    [nx, ny]: [usize; 2],
    w: usize,
    wanted: Range<usize>,
    lines: &mut [Rows],
    sum: &mut [Rows],
    mut each: impl FnMut(usize, &[Rows]),
) {
    sum.fill(EMPTY);
    let first = wanted.start.saturating_sub(w);
    for y in first..wanted.end + w {
        let slot = y % (2 * w + 1) * nx;
        let line = &mut lines[slot..slot + nx];
        let leaves = y > first + 2 * w;
        if y < ny {
            let row = &plane[y * nx..(y + 1) * nx];
            let mut running = EMPTY;
            row[..w.min(nx)].iter().for_each(|r| add(&mut running, r));
            let put = |sum: &mut Rows, line: &mut Rows, running: &Rows| {
                if leaves {
                    subtract(sum, line);
                }
                add(sum, running);
                *line = *running;
            };
            let edge = |range: Range<usize>, running: &mut Rows, sum: &mut [Rows], line: &mut [Rows]| {
                for x in range {
                    if let Some(enters) = row.get(x + w) {
                        add(running, enters);
                    }
                    put(&mut sum[x], &mut line[x], running);
                    if x >= w {
                        subtract(running, &row[x - w]);
                    }
                }
            };
            let [start, end] = if nx > 2 * w { [w, nx - w] } else { [nx; 2] };
            edge(0..start, &mut running, sum, line);
            let middle = sum[start..end].iter_mut().zip(&mut line[start..end]);
            for ((sum, line), (enters, leaves)) in middle.zip(row[(2 * w).min(nx)..].iter().zip(row)) {
                add(&mut running, enters);
                put(sum, line, &running);
                subtract(&mut running, leaves);
            }
            edge(end..nx, &mut running, sum, line);
        } else {
            if leaves {
                sum.iter_mut().zip(&*line).for_each(|(sum, row)| subtract(sum, row));
            }
            line.fill(EMPTY);
        }
        if y >= wanted.start + w {
            each(y - w, sum);
        }
    }
}
