use glam::Vec3;

use super::*;

mod parts;

const SIZE: (u32, u32) = (160, 90);

fn small() -> View {
    View { width: SIZE.0, height: SIZE.1, ..View::default() }
}

/// A camera on +z, one metre up, that looks level at the middle of a body at `x`.
fn level() -> View {
    View { camera: Some(Camera { eye: [0.0, 1.0, 6.0], target: [0.0, 0.5, 0.0], opening: 40.0 }), ..small() }
}

/// Adds a rectangle with its own four vertices and the normal of its winding.
fn rectangle(frame: &mut Frame, corners: [[f32; 3]; 4], inside: u8) {
    let [a, b, c, _] = corners.map(Vec3::from);
    let normal = (b - a).cross(c - a).normalize().to_array();
    let base = frame.positions.len() as u32;
    for p in corners {
        frame.id.push(frame.positions.len() as u32);
        frame.positions.push(p);
        frame.normals.push(normal);
        frame.velocity.push([0.0; 3]);
        frame.damage.push(f32::from(inside));
        frame.stretch.push(0.5 * f32::from(inside));
        frame.inside.push(inside);
        frame.piece.push(0);
    }
    frame.triangles.extend([[base, base + 1, base + 2], [base, base + 2, base + 3]]);
}

/// A box that stands on the ground, `half` wide to each side and `high`; its front is a crack face if `inside` is 1.
fn block(x: f32, half: f32, high: f32, inside: u8) -> Frame {
    let (l, r, n, f) = (x - half, x + half, half, -half);
    let mut frame = Frame::default();
    rectangle(&mut frame, [[l, 0.0, n], [r, 0.0, n], [r, high, n], [l, high, n]], inside);
    rectangle(&mut frame, [[r, 0.0, f], [l, 0.0, f], [l, high, f], [r, high, f]], 0);
    rectangle(&mut frame, [[l, 0.0, f], [l, 0.0, n], [l, high, n], [l, high, f]], 0);
    rectangle(&mut frame, [[r, 0.0, n], [r, 0.0, f], [r, high, f], [r, high, n]], 0);
    rectangle(&mut frame, [[l, high, n], [r, high, n], [r, high, f], [l, high, f]], 0);
    frame
}

fn brightness(rgb: [u8; 3]) -> f64 {
    rgb.iter().map(|&c| f64::from(c)).sum::<f64>() / 3.0
}

/// Mean brightness of 5 × 5 pixels.
fn patch(picture: &Image, x: u32, y: u32) -> f64 {
    let around = (0..25).map(|k| picture.at(x + k % 5 - 2, y + k / 5 - 2).unwrap());
    around.map(brightness).sum::<f64>() / 25.0
}

#[test]
fn the_png_decodes_to_the_same_pixels() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("block.png");
    let picture = render(&[&block(0.0, 0.5, 1.0, 0)], &small()).unwrap();
    picture.write_png(&path).unwrap();
    let file = std::io::BufReader::new(std::fs::File::open(&path).unwrap());
    let mut reader = png::Decoder::new(file).read_info().unwrap();
    let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
    let info = reader.next_frame(&mut bytes).unwrap();
    assert_eq!((info.width, info.height, info.color_type), (SIZE.0, SIZE.1, png::ColorType::Rgb));
    assert_eq!(bytes, picture.pixels);
}

#[test]
fn body_ground_and_sky_are_where_they_should_be() {
    let picture = render(&[&block(0.0, 0.5, 1.0, 0)], &level()).unwrap();
    let (body, ground, sky) = (patch(&picture, 78, 45), patch(&picture, 20, 80), patch(&picture, 80, 4));
    // Measured: 200, 157, 39.
    assert!(body > ground + 30.0 && ground > sky + 60.0, "{body} {ground} {sky}");
    let without = render(&[&block(0.0, 0.5, 1.0, 0)], &View { ground: None, ..level() }).unwrap();
    assert!(patch(&without, 20, 80) < ground - 40.0, "without a ground there is background below the horizon");
}

#[test]
fn the_shadow_is_darker_than_the_lit_ground() {
    // From straight above, 20.6 pixels to the metre. The key comes from the left and the viewer's side, 45 degrees
    // high, so the shadow of the top ends near x = 1.5, z = -0.3.
    let camera = Camera { eye: [0.0, 6.0, 0.0], target: [0.0; 3], opening: 40.0 };
    let picture = render(&[&block(0.0, 0.5, 1.0, 0)], &View { camera: Some(camera), ..small() }).unwrap();
    let (shadow, lit) = (patch(&picture, 95, 42), patch(&picture, 65, 42));
    // Measured: 81 and 164.
    assert!(shadow < 0.7 * lit, "{shadow} {lit}");
}

#[test]
fn crack_faces_have_a_colour_of_their_own() {
    let skin = render(&[&block(0.0, 0.5, 1.0, 0)], &level()).unwrap().at(78, 45).unwrap();
    let crack = render(&[&block(0.0, 0.5, 1.0, 1)], &level()).unwrap().at(78, 45).unwrap();
    let warmth = |c: [u8; 3]| f64::from(c[0]) / f64::from(c[2]).max(1.0);
    // Measured: 1.05 and 2.7.
    assert!(warmth(crack) > 1.4 * warmth(skin), "{crack:?} {skin:?}");
}

#[test]
fn every_mode_colours_by_its_own_column() {
    let (mut a, mut b) = (block(0.0, 0.5, 1.0, 0), block(0.0, 0.5, 1.0, 0));
    a.damage.fill(0.0);
    b.damage.fill(1.0);
    b.stretch.fill(0.5);
    b.velocity.fill([0.0, -3.0, 0.0]);
    b.piece.fill(1);
    for mode in [ColourMode::Damage, ColourMode::Speed, ColourMode::Stretch, ColourMode::Piece] {
        let view = View { mode, speed_range: Some(3.0), ..level() };
        let [a, b] = [&a, &b].map(|f| render(&[f], &view).unwrap().at(78, 45).unwrap());
        let apart: i32 = (0..3).map(|k| (i32::from(a[k]) - i32::from(b[k])).abs()).sum();
        assert!(apart > 60, "{mode:?}: {a:?} {b:?}");
    }
}

#[test]
fn the_automatic_camera_holds_the_bodies_in_the_middle() {
    // Far from the origin, small, and off the ground: the picture must be about the same.
    for (x, scale) in [(0.0, 1.0), (40.0, 1.0), (0.0, 1e-3), (3000.0, 50.0)] {
        let mut frame = block(x, 0.5, 1.0, 1);
        frame.positions.iter_mut().for_each(|p| p.iter_mut().for_each(|c| *c *= scale));
        let picture = render(&[&frame], &small()).unwrap();
        let at = |x, y| brightness(picture.at(x, y).unwrap());
        let (middle, left, right) = (at(80, 45), at(8, 45), at(151, 45));
        assert!((middle - left).abs() > 8.0 && (left - right).abs() < 25.0, "{x} {scale}: {left} {middle} {right}");
        let view = small();
        let camera = Camera::framing(&[&frame], &view, 16.0 / 9.0);
        assert!(camera.checked().is_ok());
    }
}

#[test]
fn an_empty_frame_is_a_picture_of_the_ground() {
    for frames in [&[][..], &[&Frame::default()][..]] {
        let picture = render(frames, &small()).unwrap();
        let (top, bottom) = (patch(&picture, 80, 3), patch(&picture, 80, 80));
        assert!(bottom > top + 40.0, "{top} {bottom}");
    }
}

#[test]
fn broken_numbers_leave_triangles_out_and_nothing_else() {
    let whole = render(&[&block(0.0, 0.5, 1.0, 0)], &level()).unwrap();
    let mut frame = block(0.0, 0.5, 1.0, 0);
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        let v = frame.positions.len() as u32;
        frame.positions.push([0.0, bad, 0.0]);
        frame.normals.push([bad; 3]);
        frame.triangles.extend([[0, 1, v], [v, v, v], [0, 0, 0], [0, 1, u32::MAX]]);
    }
    assert_eq!(render(&[&frame], &level()).unwrap(), whole);
    frame.velocity.fill([f32::NAN; 3]);
    frame.damage.fill(f32::NAN);
    frame.stretch.fill(f32::NAN);
    for mode in [ColourMode::Damage, ColourMode::Speed, ColourMode::Stretch, ColourMode::Piece] {
        render(&[&frame], &View { mode, ..small() }).unwrap();
    }
    frame.positions.iter_mut().step_by(2).for_each(|p| *p = [1e38, -1e38, 1e30]);
    render(&[&frame], &small()).unwrap();
    frame.positions.fill([f32::NAN; 3]);
    render(&[&frame], &small()).unwrap();
    frame.positions.fill([0.3; 3]);
    render(&[&frame], &small()).unwrap();
}

#[test]
fn a_camera_or_size_that_cannot_see_is_an_error() {
    let frame = block(0.0, 0.5, 1.0, 0);
    let size = render(&[&frame], &View { width: 0, ..small() }).unwrap_err().to_string();
    assert!(size.contains("0 x 90"), "{size}");
    let blind = Camera { eye: [1.0; 3], target: [1.0; 3], opening: 30.0 };
    let error = render(&[&frame], &View { camera: Some(blind), ..small() }).unwrap_err().to_string();
    assert!(error.contains("cannot see"), "{error}");
    for camera in [
        Camera { eye: [f64::NAN; 3], target: [0.0; 3], opening: 30.0 },
        Camera { eye: [1.0; 3], target: [0.0; 3], opening: 180.0 },
        Camera { eye: [1e200; 3], target: [0.0; 3], opening: 30.0 },
    ] {
        assert!(render(&[&frame], &View { camera: Some(camera), ..small() }).is_err());
    }
    // Straight down and straight up have no horizon, but are places to look.
    for y in [5.0, -5.0] {
        let camera = Camera { eye: [0.0, y, 0.0], target: [0.0; 3], opening: 30.0 };
        render(&[&frame], &View { camera: Some(camera), ..small() }).unwrap();
    }
    let short = Image { width: 4, height: 4, pixels: vec![0; 5] };
    assert!(short.to_png().unwrap_err().to_string().contains("5 bytes"));
}

#[test]
fn one_and_two_threads_give_the_same_bits() {
    let frame = block(0.0, 0.5, 1.0, 1);
    let [one, two] = [1, 2].map(|threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| render(&[&frame], &small()).unwrap())
    });
    assert_eq!(one, two);
}

#[test]
fn a_single_triangle_is_seen() {
    let mut frame = Frame::default();
    rectangle(&mut frame, [[-1.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]], 0);
    frame.triangles.truncate(1);
    let picture = render(&[&frame], &level()).unwrap();
    assert!(patch(&picture, 88, 50) > patch(&picture, 60, 30) + 30.0);
}
