//! The invariants of the cracked mesh, at every stage of random and of planned cuts.

use std::collections::BTreeMap;

use proptest::prelude::*;

use super::*;
use crate::TriMesh;
use crate::family::tests::meshes::{ball, kuhn, random, tetgen};
use crate::family::{Clip, families};
use crate::tetmesh::FACES;

/// Pairs of face neighbours, each once.
fn links(crack: &CrackMesh) -> Vec<(u32, u32)> {
    let pairs =
        |s: usize| crack.neighbours()[s].map(|t| (s as u32, t)).into_iter().filter(|(s, t)| *t != NONE && s < t);
    (0..crack.tets().len()).flat_map(pairs).collect()
}

/// Every directed edge is matched by its reverse.
fn is_closed(triangles: impl Iterator<Item = [u32; 3]>) -> bool {
    let mut open = BTreeMap::new();
    for [a, b, c] in triangles {
        for (u, v) in [(a, b), (b, c), (c, a)] {
            *open.entry((u.min(v), u.max(v))).or_insert(0i32) += if u < v { 1 } else { -1 };
        }
    }
    open.values().all(|&n| n == 0)
}

/// Checks everything that must hold at every moment; returns the number of fragments.
fn check(crack: &CrackMesh) -> usize {
    let surface = crack.surface();
    let mesh_triangles = || (0..surface.triangles.len()).map(|t| surface.mesh_triangle(t));
    assert!(is_closed(mesh_triangles()), "closed over current vertices");
    assert!(is_closed(mesh_triangles().map(|tri| tri.map(|v| crack.origin()[v as usize]))), "and over original ones");

    let (fragment, count) = crack.fragments();
    let (mut volume, mut enclosed) = (vec![0.0; count], vec![0.0; count]);
    for t in 0..fragment.len() {
        volume[fragment[t] as usize] += crack.rest_volume(t);
    }
    for (t, tri) in mesh_triangles().enumerate() {
        let [a, b, c] = tri.map(|v| crack.rest_position(v));
        enclosed[fragment[surface.tets[t] as usize] as usize] += a.dot(b.cross(c)) / 6.0;
        for &v in &surface.triangles[t] {
            assert_eq!(surface.inside[v as usize], surface.triangle_inside(t));
        }
    }
    for f in 0..count {
        assert!((volume[f] - enclosed[f]).abs() < 1e-9, "fragment {f}: {} and {}", volume[f], enclosed[f]);
    }

    let mut owner = vec![NONE; crack.origin().len()];
    for (t, tet) in crack.tets().iter().enumerate() {
        for (k, &v) in tet.iter().enumerate() {
            let owner = &mut owner[v as usize];
            assert!(*owner == NONE || *owner == fragment[t], "fragments share no vertex");
            *owner = fragment[t];
            assert_eq!(crack.origin()[v as usize], crack.rest_tets[t][k]);
        }
        for (k, &n) in crack.neighbours()[t].iter().enumerate().filter(|(_, n)| **n != NONE) {
            let there = crack.tets()[n as usize];
            let same = FACES[k].iter().all(|&v| there.contains(&tet[v]));
            assert_eq!(same, crack.status(t, k) != SEPARATED, "separated exactly if a vertex differs");
            let back = crack.neighbours()[n as usize].iter().position(|&m| m as usize == t).unwrap();
            assert_eq!(crack.status(t, k), crack.status(n as usize, back));
        }
    }
    count
}

/// Cuts `all` in a random order, `step` at a time, and checks after each step.
fn cut_at_random(mesh: &TetMesh, seed: u64, step: usize, until: f64) {
    let mut crack = CrackMesh::new(mesh).unwrap();
    let mut all = links(&crack);
    let key = |l: &(u32, u32)| (random(seed ^ (u64::from(l.0) << 32 | u64::from(l.1))) * 1e15) as u64;
    all.sort_by_key(key);
    all.truncate((all.len() as f64 * until) as usize);
    let mut last = check(&crack);
    for some in all.chunks(step) {
        let vertices = crack.origin().len();
        let new = crack.cut(some);
        assert_eq!(crack.origin().len(), vertices + new);
        assert_eq!(crack.splits().iter().map(|s| s.count as usize).sum::<usize>(), new);
        let count = check(&crack);
        assert!(count >= last);
        last = count;
    }
    if until >= 1.0 {
        assert_eq!((last, crack.origin().len()), (mesh.tets.len(), 4 * mesh.tets.len()));
        assert_eq!(crack.crack_set(), 0, "every face has led to a split");
        assert_eq!(crack.surface().triangles.len(), 4 * mesh.tets.len());
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 12, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn invariants_hold_at_every_stage(seed in any::<u64>(), step in 1usize..60, until in 0.1f64..1.2, round in any::<bool>()) {
        let mesh = if round { ball(1) } else { kuhn([3, 2, 2], 0.3, |c| c != [1, 0, 0]) };
        cut_at_random(&mesh, seed, step, until);
    }
}

#[test]
fn everything_cut_at_once_and_one_by_one() {
    cut_at_random(&kuhn([2, 2, 1], 0.2, |_| true), 1, 1, 1.0);
    cut_at_random(&ball(2), 2, 100_000, 1.0);
}

/// Links across the plane x = 2 of a box of 4 cells.
fn plane() -> (CrackMesh, Vec<(u32, u32)>) {
    let mesh = kuhn([4, 3, 3], 0.0, |_| true);
    let crack = CrackMesh::new(&mesh).unwrap();
    let left = |t: u32| mesh.barycentre(t as usize).x < 2.0;
    let across = links(&crack).into_iter().filter(|&(s, t)| left(s) != left(t)).collect();
    (crack, across)
}

#[test]
fn a_full_plane_makes_two_fragments_and_an_incomplete_one_none() {
    let (whole, across) = plane();
    assert_eq!(across.len(), 18);
    let mut crack = whole.clone();
    assert_eq!(crack.cut(&across), 16, "all vertices of the plane split in one step");
    assert_eq!((check(&crack), crack.crack_set()), (2, 0));

    for missing in 0..across.len() {
        let mut crack = whole.clone();
        let rest: Vec<_> = across.iter().copied().enumerate().filter(|(i, _)| *i != missing).map(|(_, l)| l).collect();
        let new = crack.cut(&rest);
        assert_eq!(check(&crack), 1, "without face {missing}");
        assert_eq!(new, 13, "all but the corners of the face that holds");
        assert_eq!(crack.cut(&across), 3);
        assert_eq!(check(&crack), 2);
    }
}

#[test]
fn a_crack_inside_stays_in_the_set_until_it_opens() {
    let (mut crack, across) = plane();
    let middle = across[8];
    assert_eq!((crack.cut(&[middle]), crack.crack_set()), (0, 1));
    assert_eq!(crack.surface(), plane().0.surface(), "a closed crack shows nowhere");
    crack.cut(&across[9..]);
    crack.cut(&across[..8]);
    assert_eq!((check(&crack), crack.crack_set()), (2, 0));
}

#[test]
fn a_pre_cut_starts_the_crack_mesh() {
    let mesh = kuhn([6, 3, 3], 0.4, |_| true);
    let plane = TriMesh {
        vertices: [(2.7, -1.0, -1.0), (2.7, 9.0, -1.0), (3.2, -1.0, 9.0)].map(|(x, y, z)| DVec3::new(x, y, z)).to_vec(),
        triangles: vec![[0, 1, 2]],
    };
    let clip = Clip::new(&mesh, Some(&plane)).unwrap();
    let mut crack = CrackMesh::new(&mesh).unwrap();
    assert!(crack.cut(clip.cut_links()) > 0);
    assert_eq!((check(&crack), crack.crack_set()), (2, 0));
    let (fragment, _) = crack.fragments();
    let points: Vec<DVec3> = (0..mesh.tets.len()).map(|t| mesh.barycentre(t)).collect();
    let families = families(&points, 1.5, Some(&clip)).unwrap();
    for i in 0..points.len() {
        assert!(families.row(i).iter().all(|&j| fragment[i] == fragment[j as usize]), "bonds join what faces join");
    }
}

#[test]
fn pinched_input_is_split_at_once() {
    // Boxes that touch in an edge of two cells: three vertices become two each.
    let mesh = kuhn([4, 4, 2], 0.0, |c| (c[0] < 2) == (c[1] < 2));
    let crack = CrackMesh::new(&mesh).unwrap();
    assert_eq!(crack.origin().len(), mesh.vertices.len() + 3);
    assert_eq!(check(&crack), 2);
    assert!(crack.splits().is_empty());
}

#[test]
fn links_of_no_face_change_nothing() {
    let (mut crack, across) = plane();
    let before = crack.status.to_vec();
    assert_eq!(crack.cut(&[(0, 0), (0, 200), (5000, 1), (NONE, NONE)]), 0);
    assert_eq!(crack.status.to_vec(), before);
    crack.cut(&across);
    let after = crack.tets.to_vec();
    assert_eq!(crack.cut(&across), 0, "cutting twice cuts once");
    assert!(crack.tets.to_vec() == after && crack.splits().is_empty());
}

#[test]
fn crack_faces_have_normals_of_their_own() {
    let (mut crack, across) = plane();
    crack.cut(&across);
    let surface = crack.surface_with(Smoothing { outside: std::f64::consts::PI, inside: 0.5 });
    let rest: Vec<DVec3> = (0..crack.origin().len() as u32).map(|v| crack.rest_position(v)).collect();
    let normals = surface.normals(&rest);
    let inside = || (0..surface.vertices.len()).filter(|&v| surface.inside[v] == 1);
    assert_eq!(inside().count(), 32, "a flat crack is smooth: one vertex per mesh vertex and side");
    assert!(inside().all(|v| normals[v].x.abs() == 1.0));
    let outside = surface.inside.iter().filter(|&&i| i == 0).count();
    assert_eq!(outside, 80 - 12 + 12, "the lattice without its inside, and the rim of the crack twice");
    assert_eq!((0..surface.triangles.len()).filter(|&t| surface.triangle_inside(t) == 1).count(), 36);

    // A box keeps its edges: each corner has three vertices, unless everything is smoothed.
    let sharp = CrackMesh::new(&kuhn([1, 1, 1], 0.0, |_| true)).unwrap();
    assert_eq!(sharp.surface().vertices.len(), 24);
    let round = sharp.surface_with(Smoothing { outside: std::f64::consts::PI, inside: 0.5 });
    assert_eq!(round.vertices.len(), 8);
}

#[test]
fn a_restart_from_the_columns_goes_on_the_same() {
    let mesh = ball(2);
    let mut crack = CrackMesh::new(&mesh).unwrap();
    let all = links(&crack);
    crack.cut(&all[..300]);
    let mut saved: Vec<Vec<u8>> = Vec::new();
    crack.visit("ball", &mut |_, _, b| saved.push(b.bytes().to_vec()));
    let mut again = CrackMesh::default();
    let mut next = saved.iter();
    again.visit("ball", &mut |_, _, b| assert!(b.set_bytes(next.next().unwrap())));
    assert_eq!(crack.cut(&all[300..500]), again.cut(&all[300..500]));
    assert_eq!((crack.tets(), crack.origin(), crack.surface()), (again.tets(), again.origin(), again.surface()));
    check(&again);
}

#[test]
fn bad_meshes_are_refused() {
    let mut mesh = kuhn([1, 1, 1], 0.0, |_| true);
    let tet = mesh.tets[0];
    mesh.tets.extend([tet, tet]);
    assert!(matches!(CrackMesh::new(&mesh), Err(CrackError::CrowdedFace(_))));
    mesh.tets[2][0] = 8;
    let error = CrackMesh::new(&mesh).unwrap_err();
    assert_eq!(error, CrackError::NoVertex { tet: 2, vertex: 8, vertices: 8 });
    assert!(error.to_string().contains("tetrahedron 2"));
    let empty = CrackMesh::new(&TetMesh::default()).unwrap();
    assert_eq!((empty.fragments().1, empty.surface().triangles.len()), (0, 0));
}

#[test]
fn meshes_of_other_people_crack_in_pieces() {
    for name in ["bunny_20k", "sheet_notched_20k"] {
        let Some(mesh) = tetgen(name) else { return };
        let mut crack = CrackMesh::new(&mesh).unwrap();
        assert_eq!(crack.origin().len(), mesh.vertices.len(), "{name} has no pinched vertex");
        // Cells of a random Voronoi diagram: the links between them are cut.
        let (low, high) = mesh.bounds().unwrap();
        let seed = |i: u64| low + (high - low) * DVec3::new(random(3 * i), random(3 * i + 1), random(3 * i + 2));
        let cell = |t: u32| {
            let x = mesh.barycentre(t as usize);
            (0..30).min_by(|&a, &b| seed(a).distance(x).total_cmp(&seed(b).distance(x))).unwrap()
        };
        let cells: Vec<u64> = (0..mesh.tets.len() as u32).map(cell).collect();
        let cuts: Vec<(u32, u32)> =
            links(&crack).into_iter().filter(|&(s, t)| cells[s as usize] != cells[t as usize]).collect();
        for some in cuts.chunks(cuts.len() / 5) {
            crack.cut(some);
            check(&crack);
        }
        let (_, count) = crack.fragments();
        println!("{name}: {} cuts, {count} fragments, {} in the set", cuts.len(), crack.crack_set());
        assert!((20..60).contains(&count));
    }
}
