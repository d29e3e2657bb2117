//! The light: a large key light, the sky, its mirror image in the glaze, and the ground's fade into the background.

use glam::Vec3A;

use super::{
    View,
    camera::Lens,
    colour,
    filter::Pixel,
    sample::{Sampler, cone, cosine, tent},
    scene::{Face, Hit, Scene},
};

/// Tangent of the half angle under which the key light is seen; sets how soft its shadow is.
const KEY_SPREAD: f32 = 0.11;
/// Light of the key on a face turned towards it.
const KEY: Vec3A = Vec3A::new(1.86, 1.74, 1.56);
/// Light of the open sky from straight above and of the ground from below.
const SKY: Vec3A = Vec3A::new(0.62, 0.66, 0.74);
const BOUNCE: Vec3A = Vec3A::new(0.34, 0.31, 0.28);
/// How far bodies dim the sky, in units of their size.
const REACH: f32 = 1.6;
/// What an occluded sky ray still brings: light from the thing that it met.
const OCCLUDED: f32 = 0.30;
/// Sky rays for each camera ray.
const SKY_RAYS: u32 = 2;
/// How far off its surface a secondary ray starts, in units of the bodies' size.
const LIFT: f32 = 2e-4;

/// Light sources and what they fall on.
pub(super) struct Shader<'a> {
    scene: &'a Scene,
    key: Vec3A,
    ground: Vec3A,
    horizon: Vec3A,
    zenith: Vec3A,
    gloss: f32,
    /// Distance from the middle over which the ground fades out.
    fade: [f32; 2],
}

/// What one camera ray brings.
struct Light {
    /// Scaled by the visibility of the key light.
    key: Vec3A,
    /// Scaled by the openness of the sky.
    sky: Vec3A,
    /// Scaled by nothing.
    rest: Vec3A,
    lit: f32,
    open: f32,
    normal: Vec3A,
    depth: f32,
}

impl<'a> Shader<'a> {
    pub fn new(scene: &'a Scene, view: &View, lens: &Lens) -> Self {
        // The key stands to the left and a little behind the camera, wherever that is: form shows in side light.
        let back = -Vec3A::new(lens.forward.x, 0.0, lens.forward.z).try_normalize().unwrap_or(Vec3A::Z);
        let key = (0.30 * back - 0.85 * lens.right + 0.90 * Vec3A::Y).normalize();
        let far = lens.eye.length().max(3.0);
        let p = &view.palette;
        Self {
            scene,
            key,
            ground: colour::linear(p.ground),
            horizon: colour::linear(p.horizon),
            zenith: colour::linear(p.zenith),
            gloss: if p.gloss.is_finite() { p.gloss.clamp(0.0, 1.0) } else { 0.0 },
            fade: [0.5 * far, 3.0 * far],
        }
    }

    /// One pixel: the mean over its samples.
    pub fn pixel(&self, lens: &Lens, at: [u32; 2], [width, height]: [u32; 2], samples: u32) -> Pixel {
        let mut sampler = Sampler::new(at, samples);
        let mut sum = Pixel::default();
        for index in 0..samples {
            sampler.start(index);
            let [u, v] = sampler.place();
            let x = (at[0] as f32 + 0.5 + tent(u)) / width as f32;
            let y = (at[1] as f32 + 0.5 + tent(v)) / height as f32;
            let light = self.ray(lens.eye, lens.direction(x, y), &sampler);
            sum.add(light.key, light.sky, light.rest, [light.lit, light.open], light.normal, light.depth);
        }
        sum.mean()
    }

    fn ray(&self, origin: Vec3A, direction: Vec3A, sampler: &Sampler) -> Light {
        match self.scene.trace(origin, direction) {
            Hit::Sky => Light {
                key: Vec3A::ZERO,
                sky: Vec3A::ZERO,
                rest: self.background(direction),
                lit: 1.0,
                open: 1.0,
                normal: Vec3A::ZERO,
                depth: 1e6,
            },
            Hit::Ground(t) => self.on_ground(origin + direction * t, direction, t, sampler),
            Hit::Body(face, weights, t) => self.on_body(face, weights, direction, t, sampler),
        }
    }

    /// The background along a direction: a soft gradient upwards.
    fn background(&self, direction: Vec3A) -> Vec3A {
        let t = (direction.y * 2.2).clamp(0.0, 1.0);
        self.horizon.lerp(self.zenith, t * (2.0 - t))
    }

    fn on_ground(&self, p: Vec3A, direction: Vec3A, t: f32, sampler: &Sampler) -> Light {
        let [near, far] = self.fade;
        let flat = Vec3A::new(p.x, 0.0, p.z).length();
        let x = ((flat - near) / (far - near)).clamp(0.0, 1.0);
        let fog = x * x * (3.0 - 2.0 * x);
        let p = p + Vec3A::Y * LIFT;
        let keep = 1.0 - fog;
        // A lamp lights the middle best.
        let pool = 1.0 / (1.0 + (flat / far * 1.8).powi(2));
        let (lit, open) = if fog < 1.0 { self.seen(p, Vec3A::Y, sampler) } else { (1.0, 1.0) };
        Light {
            key: self.ground * KEY * (self.key.y * keep * pool),
            sky: self.ground * SKY * (keep * pool),
            rest: self.background(Vec3A::new(direction.x, 0.0, direction.z)) * fog,
            lit,
            open,
            normal: Vec3A::Y,
            depth: t,
        }
    }

    fn on_body(&self, face: &Face, w: [f32; 3], direction: Vec3A, t: f32, sampler: &Sampler) -> Light {
        let mix = |v: [Vec3A; 3]| v[0] * w[0] + v[1] * w[1] + v[2] * w[2];
        let side = if face.plane.dot(direction) > 0.0 { -1.0 } else { 1.0 };
        let plane = face.plane * side;
        let n = (mix(face.normals) * side).try_normalize().unwrap_or(plane);
        let flat = mix(face.corners);
        // Secondary rays start on the smooth surface that the normals describe, or coarse meshes throw jagged shadows
        // on themselves (Hanika, Hacking the shadow terminator, Ray Tracing Gems II, 2021).
        let above = |k: usize| {
            let (corner, normal) = (face.corners[k], face.normals[k] * side);
            flat - normal * (flat - corner).dot(normal).min(0.0)
        };
        let p = mix([above(0), above(1), above(2)]) + plane * LIFT;
        let albedo = mix(face.colours);
        let facing = n.dot(self.key);
        let key = if facing > 0.0 { KEY * facing } else { Vec3A::ZERO };
        let up = 0.5 + 0.5 * n.y;
        let (lit, open) = self.seen(p, n, sampler);
        let mut light = Light {
            key: albedo * key,
            sky: albedo * BOUNCE.lerp(SKY, up),
            rest: Vec3A::ZERO,
            lit: if facing > 0.0 { lit } else { 0.0 },
            open,
            normal: n,
            depth: t,
        };
        if !face.crack && self.gloss > 0.0 {
            let mirrored = (direction - n * (2.0 * direction.dot(n))).normalize();
            let grazing = (1.0 + direction.dot(n)).clamp(0.0, 1.0);
            let fresnel = self.gloss * (0.05 + 0.95 * grazing.powi(5)).min(0.5);
            light.key *= 1.0 - fresnel;
            light.sky *= 1.0 - fresnel;
            let mirrored = if mirrored.dot(plane) > 0.0 { mirrored } else { plane };
            let glint = cone(mirrored, 0.02, sampler.pair(9));
            light.rest = self.mirror(p, glint) * fresnel;
        }
        light
    }

    /// What the glaze mirrors: a wide soft box where the key is, a strip opposite, the sky, the ground, other bodies.
    fn mirror(&self, p: Vec3A, direction: Vec3A) -> Vec3A {
        if !self.scene.open(p, direction, 1e3) {
            return Vec3A::splat(0.22);
        }
        let smooth = |a: f32, b: f32, x: f32| {
            let t = ((x - a) / (b - a)).clamp(0.0, 1.0);
            t * t * (3.0 - 2.0 * t)
        };
        let soft_box = smooth(0.945, 0.957, direction.dot(self.key));
        let behind = Vec3A::new(-self.key.x, 0.25, -self.key.z).normalize();
        let strip = smooth(0.90, 0.97, direction.dot(behind)) * 0.9;
        let base = if direction.y < 0.0 && self.scene.ground.is_some() {
            self.ground * 0.9
        } else {
            SKY * (0.5 + 0.7 * direction.y.max(0.0))
        };
        base + KEY * (15.0 * soft_box) + SKY * strip
    }

    /// Visibility of the key (0 or 1) and openness of the sky from a point.
    fn seen(&self, p: Vec3A, n: Vec3A, sampler: &Sampler) -> (f32, f32) {
        let towards = cone(self.key, KEY_SPREAD, sampler.pair(1));
        let lit = if n.dot(self.key) > 0.0 && self.scene.open(p, towards, 1e3) { 1.0 } else { 0.0 };
        let mut open = 0.0;
        for k in 0..SKY_RAYS {
            let free = self.scene.open(p, cosine(n, sampler.pair(2 + k)), REACH);
            open += if free { 1.0 } else { OCCLUDED };
        }
        (lit, open / SKY_RAYS as f32)
    }
}
