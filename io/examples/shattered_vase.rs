//! Draws a made-up shattered vase: `shattered_vase OUT.png [material|damage|speed|piece] [samples] [FRAME.ply]`.
//!
//! No physics: the wall of a surface of revolution is cut along the Voronoi cells of points on it, and the shards of the
//! upper part are laid on the ground around the rest. It is there to judge the look and the speed of pictures.

use std::f64::consts::{PI, TAU};
use std::path::Path;
use std::time::Instant;

use fissure_io::frames::{self, Frame};
use fissure_io::picture::{ColourMode, View, render};
use glam::{DQuat, DVec2, DVec3, dvec2, dvec3};

/// Radius and height of the outside, from the middle of the foot to the lip [m].
const PROFILE: [[f64; 2]; 12] = [
    [0.000, 0.000],
    [0.040, 0.000],
    [0.056, 0.002],
    [0.060, 0.012],
    [0.072, 0.045],
    [0.092, 0.095],
    [0.104, 0.150],
    [0.098, 0.200],
    [0.070, 0.245],
    [0.046, 0.280],
    [0.044, 0.310],
    [0.060, 0.335],
];
const WALL: f64 = 0.006;
const AROUND: usize = 160;
const ALONG: usize = 110;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let out = arguments.first().ok_or("give the name of the picture, such as vase.png")?;
    let mode = match arguments.get(1).map_or("material", String::as_str) {
        "damage" => ColourMode::Damage,
        "speed" => ColourMode::Speed,
        "piece" => ColourMode::Piece,
        _ => ColourMode::Material,
    };
    let samples = arguments.get(2).map_or(Ok(4), |s| s.parse())?;
    let vase = shattered_vase();
    if let Some(path) = arguments.get(3) {
        frames::write(&vase, Path::new(path))?;
    }
    let start = Instant::now();
    let picture = render(&[&vase], &View { mode, samples, ..View::default() })?;
    println!("{} triangles, {:.2} s", vase.triangles.len(), start.elapsed().as_secs_f64());
    picture.write_png(Path::new(out))?;
    Ok(())
}

/// A number in 0..1 that depends on `k` only.
fn random(k: u64) -> f64 {
    let mut x = k.wrapping_add(1).wrapping_mul(0x9E37_79B9_7F4A_7C15);
    x = (x ^ (x >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    x = (x ^ (x >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    ((x ^ (x >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
}

/// Radius and height at `t` in 0..1 along the profile (Catmull-Rom).
fn profile(t: f64) -> DVec2 {
    let n = PROFILE.len() as isize;
    let s = t.clamp(0.0, 1.0) * (n - 1) as f64;
    let k = (s as isize).min(n - 2);
    let f = s - k as f64;
    let at = |i: isize| DVec2::from(PROFILE[i.clamp(0, n - 1) as usize]);
    let (a, b, c, d) = (at(k - 1), at(k), at(k + 1), at(k + 2));
    let p = b + 0.5 * f * ((c - a) + f * ((2.0 * a - 5.0 * b + 4.0 * c - d) + f * (3.0 * (b - c) + d - a)));
    dvec2(p.x.max(0.0), p.y.max(0.0))
}

/// Position and outward normal at angle `a` and profile place `t`, `depth` below the outside.
fn surface(a: f64, t: f64, depth: f64) -> (DVec3, DVec3) {
    let e = 1e-4;
    let along = profile(t + e) - profile(t - e);
    let out = dvec2(along.y, -along.x).normalize();
    let p = profile(t) - depth * out;
    let round = |v: DVec2| dvec3(v.x * a.cos(), v.y, v.x * a.sin());
    (round(p), round(out))
}

/// Bends the straight Voronoi edges a little.
fn bend(p: DVec2) -> DVec2 {
    let wave = |x: f64, y: f64| (x + 1.3 * (y * 1.7).sin()).sin();
    p + 0.035 * dvec2(wave(p.x * 7.0, p.y * 9.0), wave(p.y * 8.0, p.x * 6.0))
        + 0.012 * dvec2(wave(p.x * 19.0, p.y * 27.0), wave(p.y * 31.0, p.x * 17.0))
}

fn shattered_vase() -> Frame {
    // Plane coordinates: angle, and 5 t, so that both are of like length on the belly.
    let seeds: Vec<DVec2> = (0..60).map(|k| dvec2(TAU * random(2 * k), 1.4 + 3.6 * random(2 * k + 1))).collect();
    let mut vase = Frame::default();
    let mut laid = Vec::new();
    for (piece, &seed) in seeds.iter().enumerate() {
        let first = vase.positions.len();
        cut_piece(&mut vase, &seeds, piece);
        lay_down(&mut vase, &mut laid, first, seed, piece as u64);
    }
    vase.id = (0..vase.positions.len() as u32).collect();
    vase
}

/// Adds the wall around seed `piece`: each cell of a grid, clipped to the side of the seed of every bisector.
fn cut_piece(vase: &mut Frame, seeds: &[DVec2], piece: usize) {
    let seed = seeds[piece];
    let (da, dt) = (TAU / AROUND as f64, 1.0 / ALONG as f64);
    let rivals: Vec<DVec2> = seeds
        .iter()
        .flat_map(|s| [-TAU, 0.0, TAU].map(|turn| *s + dvec2(turn, 0.0)))
        .filter(|s| *s != seed && s.distance(seed) < 4.0)
        .collect();
    for j in 0..ALONG {
        for i in 0..AROUND {
            let a0 = seed.x - PI + i as f64 * da;
            let t0 = j as f64 * dt;
            let corners = [[a0, t0], [a0, t0 + dt], [a0 + da, t0 + dt], [a0 + da, t0]];
            let mut polygon: Vec<(DVec2, bool)> = corners.iter().map(|&[a, t]| (dvec2(a, 5.0 * t), false)).collect();
            for &rival in &rivals {
                polygon = clip(&polygon, |p| {
                    let p = bend(p);
                    p.distance_squared(rival) - p.distance_squared(seed)
                });
            }
            let rim: Vec<bool> = (0..polygon.len())
                .map(|k| polygon[k].0.y > 5.0 - 1e-9 && polygon[(k + 1) % polygon.len()].0.y > 5.0 - 1e-9)
                .collect();
            add_wall(vase, &polygon, &rim, piece as u32);
        }
    }
}

/// The part of a polygon where `side` is positive; edges that the cut made are marked.
fn clip(polygon: &[(DVec2, bool)], side: impl Fn(DVec2) -> f64) -> Vec<(DVec2, bool)> {
    let mut out = Vec::new();
    for k in 0..polygon.len() {
        let ((p, cut), (q, _)) = (polygon[k], polygon[(k + 1) % polygon.len()]);
        let (sp, sq) = (side(p), side(q));
        if sp > 0.0 {
            out.push((p, cut));
        }
        if (sp > 0.0) != (sq > 0.0) {
            // The edge that starts where the outline leaves runs along the cut.
            out.push((p.lerp(q, sp / (sp - sq)), if sp > 0.0 { true } else { cut }));
        }
    }
    out
}

/// Outside, inside, and side faces of one clipped cell.
fn add_wall(vase: &mut Frame, polygon: &[(DVec2, bool)], rim: &[bool], piece: u32) {
    if polygon.len() < 3 {
        return;
    }
    let at = |p: DVec2, depth: f64| surface(p.x, p.y / 5.0, depth);
    for (depth, sign) in [(0.0, 1.0), (WALL, -1.0)] {
        let base = vase.positions.len() as u32;
        for &(p, _) in polygon {
            let (x, n) = at(p, depth);
            push(vase, x, sign * n, false, piece);
        }
        for k in 1..polygon.len() as u32 - 1 {
            let (b, c) = if sign > 0.0 { (k, k + 1) } else { (k + 1, k) };
            vase.triangles.push([base, base + b, base + c]);
        }
    }
    for k in 0..polygon.len() {
        let (p, cut) = polygon[k];
        let (q, _) = polygon[(k + 1) % polygon.len()];
        if !cut && !rim[k] {
            continue;
        }
        let corners = [at(p, 0.0).0, at(p, WALL).0, at(q, WALL).0, at(q, 0.0).0];
        let normal = (corners[1] - corners[0]).cross(corners[3] - corners[0]).normalize_or_zero();
        let base = vase.positions.len() as u32;
        for corner in corners {
            push(vase, corner, normal, cut, piece);
        }
        vase.triangles.extend([[base, base + 1, base + 2], [base, base + 2, base + 3]]);
    }
}

fn push(vase: &mut Frame, x: DVec3, n: DVec3, crack: bool, piece: u32) {
    vase.positions.push(x.as_vec3().to_array());
    vase.normals.push(n.as_vec3().to_array());
    vase.velocity.push([0.0; 3]);
    vase.damage.push(if crack { 1.0 } else { 0.15 * random(u64::from(piece)) as f32 });
    vase.stretch.push(0.0);
    vase.inside.push(u8::from(crack));
    vase.piece.push(piece);
}

/// Lays the shard whose vertices begin at `first` on the ground, unless it belongs to the part that stays.
fn lay_down(vase: &mut Frame, laid: &mut Vec<DVec3>, first: usize, seed: DVec2, key: u64) {
    let (middle, normal) = surface(seed.x, seed.y / 5.0, 0.0);
    let random = |k: u64| random(1000 * (key + 1) + k);
    if seed.y / 5.0 < 0.60 + 0.14 * (seed.x - 0.6).cos() {
        return;
    }
    // Most shards lie with the hollow side down or up, a little askew.
    let up = if random(1) < 0.65 { DVec3::Y } else { DVec3::NEG_Y };
    let askew = dvec3(random(2) - 0.5, 0.0, random(3) - 0.5) * 0.5;
    let turn = DQuat::from_rotation_y(TAU * random(4)) * DQuat::from_rotation_arc(normal, (up + askew).normalize());
    // The first of some random places that leaves room between this shard and those that lie already.
    let tries = (0..200).map(|k| {
        let away = seed.x + 2.2 * (random(20 + 2 * k) - 0.5);
        let far = 0.13 + (0.16 + 0.001 * k as f64) * random(21 + 2 * k);
        dvec3(far * away.cos(), 0.0, far * away.sin())
    });
    let lonely = |p: &DVec3| laid.iter().map(|q| q.distance(*p)).fold(f64::INFINITY, f64::min);
    let mut place = tries.clone().find(|p| lonely(p) > 0.062).or(tries.clone().next()).unwrap_or_default();
    laid.push(place);
    let moved: Vec<DVec3> =
        vase.positions[first..].iter().map(|&x| turn * (glam::Vec3::from(x).as_dvec3() - middle)).collect();
    place.y = -moved.iter().map(|x| x.y).fold(f64::INFINITY, f64::min);
    for (k, x) in moved.iter().enumerate() {
        vase.positions[first + k] = (*x + place).as_vec3().to_array();
        let n = turn * glam::Vec3::from(vase.normals[first + k]).as_dvec3();
        vase.normals[first + k] = n.as_vec3().to_array();
        vase.velocity[first + k] = (place * 6.0).as_vec3().to_array();
    }
}
