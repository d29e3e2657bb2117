//! Stretched, bent and twisted bars against finite elements (`reference/README.md`), by reactions: positions hide what is
//! wrong with stiffness. `cargo test --release --test fem_statics -- --include-ignored --nocapture` prints the table.

use fissure_tests::bar::{Bar, displacement, relax, row, twist};
use fissure_tests::given::table;
use glam::DVec3;

const DEFAULT: &str = "default";
const AS_WRITTEN: &str = "as_written";

/// Force [N] that stretches a bar of 1 × 0.2 × 0.2 m with κ = 2 MPa by 1 %, for three Poisson ratios.
const STRETCH: [(f64, f64); 3] = [(0.1, 1922.8), (0.3, 974.5), (0.45, 250.6)];

fn stretch(across: usize, formulation: &str) -> f64 {
    let error = |(nu, reference): (f64, f64)| {
        let kappa = 2e6;
        let mu = 3.0 * kappa * (1.0 - 2.0 * nu) / (2.0 * (1.0 + nu));
        let bar = Bar { length: 1.0, width: 0.2, across, both_ends: true, moduli: (kappa, mu), formulation };
        let mut world = bar.world();
        world.anchors[1].velocity = DVec3::X * 0.01;
        relax(&mut world, 1);
        row(&format!("stretch, force, nu {nu}"), &bar, world.reactions()[1].force.x, reference).abs()
    };
    STRETCH.map(error).into_iter().fold(0.0, f64::max)
}

fn bend(across: usize, formulation: &str) -> f64 {
    let bar = Bar { length: 4.0, width: 0.5, across, both_ends: false, moduli: (6.3e6, 3.8e6), formulation };
    let mut world = bar.world();
    world.gravity = DVec3::NEG_Z * 9.81;
    relax(&mut world, 1);
    // the law that is linear in |y| − |x|, on 24 × 3 × 3 elements of 20 nodes
    row("bend, tip", &bar, displacement(&world, DVec3::X * 4.0).z, -1.4365).abs()
}

/// Errors of the torque and, over the diagonal, of the farthest position.
fn twisted(across: usize, formulation: &str, degrees: f64, torque: f64, field: &str) -> [f64; 2] {
    let bar = Bar { length: 1.0, width: 0.2, across, both_ends: true, moduli: (1e6, 6e5), formulation };
    let mut world = bar.world();
    twist(&mut world, degrees);
    relax(&mut world, (degrees / 15.0) as u32);
    let right = &world.reactions()[1];
    let error = row(&format!("twist {degrees}, torque"), &bar, right.torque_about(DVec3::ZERO).x, torque).abs();
    let diagonal = DVec3::new(1.0, 0.2, 0.2).length();
    let apart = |r: &Vec<f64>| {
        displacement(&world, DVec3::new(r[0], r[1], r[2])).distance(DVec3::new(r[3], r[4], r[5])) / diagonal
    };
    let farthest = table(field).iter().map(apart).fold(0.0, f64::max);
    println!("  positions within {:.2} % of the diagonal", 100.0 * farthest);
    [error, farthest]
}

fn twist_90(across: usize, formulation: &str) -> [f64; 2] {
    twisted(across, formulation, 90.0, 214.4, include_str!("../reference/fem_twist_90.csv"))
}

fn twist_180(across: usize, formulation: &str) -> [f64; 2] {
    twisted(across, formulation, 180.0, 431.3, include_str!("../reference/fem_twist_180.csv"))
}

#[test]
fn a_stretched_bar_pulls_as_finite_elements_do() {
    let worst = stretch(4, DEFAULT);
    assert!(worst < 0.05, "{worst}"); // measured +.7, +1.0 and +2.9 %
}

#[test]
fn a_bent_beam_hangs_as_finite_elements_do() {
    let error = bend(4, DEFAULT);
    assert!(error < 0.12, "{error}"); // measured +4.4 %
}

#[test]
fn a_twisted_bar_resists_as_finite_elements_do() {
    for [torque, position] in [twist_90(4, DEFAULT), twist_180(4, DEFAULT)] {
        // measured -5.5 and -6.6 %; positions .6 and 1.2 %, which alone would hide that
        assert!(torque < 0.12 && position < 0.1, "{torque} {position}");
    }
}

#[test]
#[ignore = "8 elements across, minutes"]
fn errors_fall_under_refinement() {
    // measured: stretch 2.9 to .8 %, bend 4.4 to 1.2 %, torque at 90° 5.5 to 1.1 %
    let (stretch_4, stretch_8) = (stretch(4, DEFAULT), stretch(8, DEFAULT));
    assert!(stretch_8 < 0.05 && stretch_8 < stretch_4, "{stretch_4} {stretch_8}");
    let (bend_4, bend_8) = (bend(4, DEFAULT), bend(8, DEFAULT));
    assert!(bend_8 < 0.06 && bend_8 < bend_4, "{bend_4} {bend_8}");
    for turn in [twist_90, twist_180] {
        let ([torque_4, _], [torque_8, position]) = (turn(4, DEFAULT), turn(8, DEFAULT));
        assert!(torque_8 < 0.06 && torque_8 < torque_4 && position < 0.1, "{torque_4} {torque_8} {position}");
    }
}

#[test]
#[ignore = "the paper as written at 4 and 8 elements across, minutes"]
fn the_paper_as_written_is_soft_and_less_so_under_refinement() {
    // measured at 4 across: stretch -19 to -23 %, bend +38 %, torque -32 and -33 %; at 8 stretch -11 to -14 %
    type Case = fn(usize, &str) -> f64;
    let cases: [Case; 4] = [stretch, bend, |n, f| twist_90(n, f)[0], |n, f| twist_180(n, f)[0]];
    for case in cases {
        let (coarse, fine) = (case(4, AS_WRITTEN), case(8, AS_WRITTEN));
        assert!(fine < coarse && fine < 0.5, "{coarse} {fine}");
    }
}
