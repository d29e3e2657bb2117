//! A picture of a frame without a GPU, a display or another program: a small ray tracer.
//!
//! Bodies stand on a matte ground that fades into the background. A large key light from the upper left throws a soft
//! shadow; sky light is dimmed by ambient occlusion; the outside of bodies is glazed, crack faces are matte and of
//! another colour, so that shards read as shards. Everything is measured in units of the bodies' size, so a 3 cm cup
//! and a 30 m wall get the same light.
//!
//! The way of a pixel: `camera` sends 4 rays or more (`sample` places them), `scene` finds what they hit,
//! `shade` splits the light into a part that key shadows scale, a part that occlusion scales and a part that nothing
//! scales. `filter` smooths the two scale factors, which are all the noise there is, along surfaces, and `colour`
//! makes 8-bit sRGB of the sum. Pixels never share an accumulator: the same bits on any number of threads.
//!
//! Tried and left: path tracing (30 times the rays for a picture that says no more about the cracks), and filtering
//! the finished colours (it blurs the crack edges one wants to see).

mod camera;
mod colour;
mod film;
mod filter;
mod image;
mod sample;
mod scene;
mod shade;
#[cfg(test)]
mod tests;
mod view;

use rayon::prelude::*;

pub use camera::Camera;
pub use film::{Film, FilmFormat};
pub use image::{Image, PictureError};
pub use view::{ColourMode, Palette, View};

use crate::frames::Frame;
use filter::Pixel;
use scene::Scene;
use shade::Shader;

/// Largest width and height (pixels). A pixel takes 96 bytes while it is drawn.
pub const MAX_SIDE: u32 = 8192;

/// Draws `frames` (usually one; several are drawn together, as bodies of one scene) as `view` asks.
///
/// Triangles with a non-finite corner or a vertex number out of range are left out. Without any triangle the ground
/// is drawn. A [`View::samples`] of 0 counts as 1.
///
/// # Errors
/// [`PictureError::Size`] if width or height is 0 or above [`MAX_SIDE`]; [`PictureError::Camera`] if the given camera
/// cannot see: a non-finite number, eye and target in one place, 1e15 body
/// sizes away, an opening angle outside 0 to 180 degrees.
pub fn render(frames: &[&Frame], view: &View) -> Result<Image, PictureError> {
    let (width, height) = (view.width, view.height);
    if width == 0 || height == 0 || width > MAX_SIDE || height > MAX_SIDE {
        return Err(PictureError::Size { width, height });
    }
    let aspect = f64::from(width) / f64::from(height);
    let camera = match view.camera {
        Some(camera) => camera.checked()?,
        None => Camera::framing(frames, view, aspect),
    };
    let scene = Scene::new(frames, view, &camera);
    let lens = camera.lens(&scene.place, aspect).ok_or(PictureError::Camera(camera))?;
    let shader = Shader::new(&scene, view, &lens);
    let samples = view.samples.max(1);
    let mut pixels = vec![Pixel::default(); width as usize * height as usize];
    pixels.par_chunks_mut(width as usize).enumerate().for_each(|(y, row)| {
        for (x, pixel) in row.iter_mut().enumerate() {
            *pixel = shader.pixel(&lens, [x as u32, y as u32], [width, height], samples);
        }
    });
    filter::smooth(&mut pixels, width as usize, samples);
    Ok(Image::develop(&pixels, width, height))
}
