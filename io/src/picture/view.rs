//! What a picture shows: its size, its camera, and which quantity gives the colour.

use super::Camera;

/// What gives a body its colour.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ColourMode {
    /// The palette's outside and crack colours.
    #[default]
    Material,
    /// Damage, 0 to 1, from pale to deep red.
    Damage,
    /// How much longer the surface is than at rest, from blue (shorter) over pale (as at rest) to red (longer); see
    /// [`View::stretch_range`].
    Stretch,
    /// Speed, from dark blue over green to yellow; see [`View::speed_range`].
    Speed,
    /// A colour of its own for each fragment.
    Piece,
}

/// Colours as sRGB values, 0 to 1, as a colour picker shows them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Palette {
    /// The outside of bodies.
    pub outside: [f32; 3],
    /// Crack faces.
    pub crack: [f32; 3],
    /// The ground in full light.
    pub ground: [f32; 3],
    /// The background at the horizon, into which the ground fades.
    pub horizon: [f32; 3],
    /// The background high above the horizon.
    pub zenith: [f32; 3],
    /// How much the outside mirrors: 0 matte, 1 glazed.
    pub gloss: f32,
}

impl Default for Palette {
    /// Glazed porcelain with terracotta breaks on a warm grey ground.
    fn default() -> Self {
        Self {
            outside: [0.94, 0.92, 0.88],
            crack: [0.66, 0.42, 0.33],
            ground: [0.50, 0.495, 0.49],
            horizon: [0.40, 0.41, 0.425],
            zenith: [0.13, 0.14, 0.16],
            gloss: 1.0,
        }
    }
}

/// How to draw a frame.
#[derive(Clone, Debug, PartialEq)]
pub struct View {
    /// Width (pixels), 1 to [`super::MAX_SIDE`].
    pub width: u32,
    /// Height (pixels), 1 to [`super::MAX_SIDE`].
    pub height: u32,
    /// Rays through each pixel; 4 is clean, 16 is for print.
    pub samples: u32,
    /// Where to look from; `None` frames the bodies from [`View::azimuth`] and [`View::elevation`].
    pub camera: Option<Camera>,
    /// Direction of an automatic camera around the vertical, 0 = from +z, 90 = from +x (degrees).
    pub azimuth: f64,
    /// Height of an automatic camera above the horizontal, −89 to 89 (degrees).
    pub elevation: f64,
    /// Height y of the ground plane (m); `None` for no ground.
    pub ground: Option<f64>,
    /// What gives the colour.
    pub mode: ColourMode,
    /// Speed drawn in the last colour of [`ColourMode::Speed`] (m/s); `None` takes the largest in the frames. Give it
    /// for a film, or the scale changes from frame to frame.
    pub speed_range: Option<f32>,
    /// Stretch drawn in the last colours of [`ColourMode::Stretch`]; `None` takes the largest in the frames, but for a
    /// hundredth of the vertices, where cracks tear at the surface.
    pub stretch_range: Option<f32>,
    /// Colours of the material mode, the ground and the background.
    pub palette: Palette,
}

impl Default for View {
    /// 1280 × 720 in material colours over the ground y = 0, three-quarter view slightly from above.
    fn default() -> Self {
        Self {
            width: 1280,
            height: 720,
            samples: 4,
            camera: None,
            azimuth: 32.0,
            elevation: 20.0,
            ground: Some(0.0),
            mode: ColourMode::Material,
            speed_range: None,
            stretch_range: None,
            palette: Palette::default(),
        }
    }
}
