//! Table 1 of Chen et al.: what must be seen of the glass walls (Figs. 1a, 1b, 7, 15), coarse and short.

use fissure_io::simulation::Simulation;
use fissure_tests::scene::{
    angles, around_30, assert_closed, build, crack_faces, cracks, displacements, fragments, run,
};
use glam::DVec3;

const COARSE: &str = "body.wall.tets=10000";
/// Where the ball of Fig. 1 hits [m].
const HIT: DVec3 = DVec3::new(0.0, 0.6, 0.0);

/// The farthest [m] that the largest crack reaches from `middle` in the plane of the wall.
fn reach(simulation: &Simulation, middle: DVec3) -> f64 {
    let places = displacements(simulation, 0);
    let crack = cracks(simulation, 0, 0.3).swap_remove(0);
    crack.iter().map(|&i| (places[i].0 - middle).truncate().length()).fold(0.0, f64::max)
}

/// Share of the particles with a damage of `least` and more, among those of the wall within and beyond `radius` [m] of
/// where the ball hits.
fn shattered(simulation: &Simulation, radius: f64, least: f32) -> [f64; 2] {
    let (mut broken, mut all) = ([0.0; 2], [0.0; 2]);
    for (place, damage) in displacements(simulation, 0).iter().zip(simulation.world.particles.damage.iter()) {
        let beyond = usize::from((place.0 - HIT).truncate().length() > radius);
        all[beyond] += 1.0;
        broken[beyond] += f64::from(u8::from(*damage >= least));
    }
    [broken[0] / all[0], broken[1] / all[1]]
}

#[test]
fn figure_1a_the_ball_shatters_what_it_hits_and_cracks_run_from_there() {
    let mut s = build("fig01a_glass", &[COARSE]);
    run(&mut s, 0.0012);
    let (fragments, reach) = (fragments(&s), reach(&s, HIT));
    let [within, beyond] = shattered(&s, 0.1, 0.9);
    // measured: 506 fragments, 0.44 m, 1.00 and 0.027
    println!("{} fragments, cracks to {reach:.2} m, dust {within:.2} {beyond:.4}", fragments.len());
    assert!(fragments.len() > 100 && within > 0.3 && beyond < 0.06, "dust where the ball is, and nowhere else");
    assert!(reach > 0.35, "cracks of {reach} m");
    assert!(s.world.colliders[1].velocity.z < -30.0, "stopped to {}", s.world.colliders[1].velocity);
    assert_closed(&s.frame(1), "shattered wall");
}

#[test]
fn figure_1b_cracks_lie_across_the_weak_direction() {
    let shares = ["fig01a_glass", "fig01b_glass"].map(|scene| {
        let mut s = build(scene, &[COARSE]);
        run(&mut s, 0.0006);
        let faces = crack_faces(&s, 0);
        angles(&faces, DVec3::X, DVec3::Y, 9)
    });
    println!("isotropic {:.3?}\nanisotropic {:.3?}", shares[0], shares[1]);
    let [isotropic, anisotropic] = shares.map(|s| around_30(&s));
    // measured: 1.2 and 3.9
    assert!(isotropic < 1.6 && anisotropic > 2.5, "{isotropic} {anisotropic}");
}

#[test]
fn figure_7_larger_alpha_makes_less_dust() {
    let dust = [0.0, 2.0, 8.0].map(|alpha| {
        let mut s = build("fig01a_glass", &[COARSE, &format!("body.wall.fracture.alpha={alpha}")]);
        run(&mut s, 0.0007);
        fragments(&s).iter().filter(|&&n| n <= 3).count() as f64
    });
    // measured: 372, 199, 14
    println!("fragments of up to 3 tetrahedra: {dust:?}");
    assert!(dust[0] > 50.0 && dust[1] < 0.7 * dust[0] && dust[2] < 0.7 * dust[1], "{dust:?}");
}

#[test]
fn figure_15_the_pressed_wall_is_cracked_and_one_piece() {
    let mut s = build("fig15_pressed", &[COARSE]);
    run(&mut s, 0.002);
    let (pieces, particles) = (fragments(&s), s.world.particles.len());
    let cracks = cracks(&s, 0, 0.3);
    let reach = reach(&s, DVec3::new(0.0, 0.5, 0.0));
    println!(
        "pieces {:?}, {} cracks, {:?} to {reach} m",
        &pieces[..pieces.len().min(5)],
        cracks.len(),
        cracks[0].len()
    );
    // measured 10200 of 10215 and up to 2
    // one piece, and splinters of a few tetrahedra that the cracks have chipped off
    assert!(pieces[0] as f64 > 0.985 * particles as f64 && pieces[1] <= 12, "{pieces:?}");
    assert!(reach > 0.22 && cracks[0].len() * 10 < 3 * particles, "{reach} m, {} of {particles}", cracks[0].len());
}

#[test]
#[ignore = "30 000 tetrahedra for 4 ms, a minute"]
fn figure_15_as_it_is_stays_one_piece_to_its_end() {
    let mut s = build("fig15_pressed", &[]);
    run(&mut s, 0.004);
    let (pieces, particles) = (fragments(&s), s.world.particles.len());
    println!("pieces {:?}", &pieces[..pieces.len().min(5)]);
    // measured 27881 of 28038; with a ball of 5 m/s instead of 4, 19320: the upper third parts in the last half millisecond
    assert!(pieces[0] as f64 > 0.985 * particles as f64 && pieces[1] <= 12, "{pieces:?}");
}
