//! POV-Ray: a scene for each frame, with a `mesh2` that has one texture outside and one inside. `look.inc` has camera, light,
//! ground and textures, is written once, and is there to be changed.
//!
//! `inside` alone is a word of POV-Ray's own. It turns by the left hand; a camera whose `right` points left shows the world as it is.

use std::io::{self, Write};
use std::path::PathBuf;

use super::{About, ExportError, Shot, Stream, colours, inside, name, write};
use crate::frames::Frame;
use crate::picture::Camera;

pub(super) struct Pov {
    pub dir: PathBuf,
    pub about: About,
}

impl Stream for Pov {
    fn frame(&mut self, shot: &Shot<'_>) -> Result<(), ExportError> {
        let look = self.dir.join("look.inc");
        if !look.exists() {
            let text = self.look(shot.surface);
            write(&look, |out| out.write_all(text.as_bytes()))?;
        }
        let frame = shot.surface;
        write(&self.dir.join(name(frame.number, "pov")), |out| {
            writeln!(out, "// frame {} at {:?} s\n#version 3.7;\n#include \"look.inc\"", frame.number, frame.time)?;
            mesh(out, frame, &["outside_texture", "inside_texture"], |t| usize::from(inside(frame, t)))?;
            shot.colliders.map_or(Ok(()), |frame| mesh(out, frame, &["collider_texture"], |_| 0))
        })
    }
}

impl Pov {
    /// The camera of the scene's picture, or one that frames `first`.
    fn look(&self, first: &Frame) -> String {
        let view = &self.about.view;
        let (width, height) = (f64::from(view.width.max(1)), f64::from(view.height.max(1)));
        let Camera { eye, target, opening } =
            view.camera.unwrap_or_else(|| Camera::framing(&[first], view, width / height));
        // POV-Ray's angle is the horizontal one
        let wide = 2.0 * ((opening.to_radians() / 2.0).tan() * width / height).atan().to_degrees();
        let away = (0..3).map(|k| (eye[k] - target[k]).powi(2)).sum::<f64>().sqrt();
        let list = |v: [f64; 3]| format!("<{:?}, {:?}, {:?}>", v[0], v[1], v[2]);
        let light = list([target[0] - 1.6 * away, target[1] + 2.4 * away, target[2] + 1.2 * away]);
        let mut text = format!(
            "// camera, light and textures of all frames; change what you like, this file is not written again\n\
             #version 3.7;\nglobal_settings {{ assumed_gamma 1.0 }}\nbackground {{ srgb <0.40, 0.41, 0.425> }}\n\
             camera {{\n  location {}\n  right -x*{width}/{height}\n  up y\n  angle {wide:?}\n  look_at {}\n}}\n\
             light_source {{ {light} rgb 1.1 area_light x*{size:?}, z*{size:?}, 5, 5 adaptive 1 jitter circular orient }}\n\
             light_source {{ {eye} rgb 0.35 shadowless }}\n",
            list(eye),
            list(target),
            size = away / 2.0,
            eye = list(eye),
        );
        for (name, [r, g, b], finish) in [
            ("outside_texture", colours(&self.about)[0], "diffuse 0.75 ambient 0.12 specular 0.3 roughness 0.02"),
            ("inside_texture", colours(&self.about)[1], "diffuse 0.8 ambient 0.12"),
            ("collider_texture", colours(&self.about)[2], "diffuse 0.7 ambient 0.12 specular 0.2 roughness 0.05"),
        ] {
            text +=
                &format!("#declare {name} = texture {{ pigment {{ srgb <{r}, {g}, {b}> }} finish {{ {finish} }} }};\n");
        }
        if let Some(height) = view.ground {
            text += &format!(
                "plane {{ y, {height:?} texture {{ pigment {{ srgb <0.50, 0.495, 0.49> }} finish {{ diffuse 0.8 ambient 0.1 }} }} }}\n"
            );
        }
        text
    }
}

fn mesh(out: &mut dyn Write, frame: &Frame, textures: &[&str], texture: impl Fn(&[u32; 3]) -> usize) -> io::Result<()> {
    if frame.triangles.is_empty() {
        return Ok(()); // an empty mesh2 is an error
    }
    let vectors = |out: &mut dyn Write, what: &str, values: &[[f32; 3]]| {
        write!(out, "  {what} {{\n    {}", values.len())?;
        for [x, y, z] in values {
            write!(out, ",\n    <{x:?},{y:?},{z:?}>")?;
        }
        writeln!(out, "\n  }}")
    };
    writeln!(out, "mesh2 {{")?;
    vectors(out, "vertex_vectors", &frame.positions)?;
    vectors(out, "normal_vectors", &frame.normals)?;
    write!(out, "  texture_list {{ {}", textures.len())?;
    for name in textures {
        write!(out, ", texture {{ {name} }}")?;
    }
    write!(out, " }}\n  face_indices {{\n    {}", frame.triangles.len())?;
    for t in &frame.triangles {
        write!(out, ",\n    <{},{},{}>,{}", t[0], t[1], t[2], texture(t))?;
    }
    writeln!(out, "\n  }}\n}}")
}
