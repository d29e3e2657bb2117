//! The finished picture and its PNG file.

use std::path::{Path, PathBuf};

use super::{Camera, colour, filter::Pixel};
use crate::atomic::write_atomically;

/// An 8-bit sRGB picture.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Image {
    /// Width (pixels).
    pub width: u32,
    /// Height (pixels).
    pub height: u32,
    /// Red, green, blue of each pixel, row by row from the top left: 3 · width · height bytes.
    pub pixels: Vec<u8>,
}

/// Why there is no picture.
#[derive(Debug, thiserror::Error)]
pub enum PictureError {
    /// Nothing can be drawn in this size.
    #[error("a picture of {width} x {height} pixels cannot be drawn; choose sides from 1 to {}", super::MAX_SIDE)]
    Size {
        /// Width asked for.
        width: u32,
        /// Height asked for.
        height: u32,
    },
    /// The camera sees nothing.
    #[error(
        "the camera at {:?} looking at {:?} with an opening of {} degrees cannot see; \
         give two different finite places and an angle between 0 and 180",
        .0.eye, .0.target, .0.opening
    )]
    Camera(Camera),
    /// The pixels are not width · height · 3 bytes.
    #[error("the picture has {got} bytes where {width} x {height} pixels need three each; fill it row by row")]
    Pixels {
        /// How many bytes there are.
        got: usize,
        /// The width.
        width: u32,
        /// The height.
        height: u32,
    },
    /// The file could not be written.
    #[error("cannot write {}: {source}; check that the folder exists, is writable and has room", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
}

impl Image {
    /// Sums the light of each pixel and makes bytes of it.
    pub(super) fn develop(pixels: &[Pixel], width: u32, height: u32) -> Self {
        let bytes = pixels.iter().enumerate().flat_map(|(k, p)| colour::to_bytes(p.light(), k as u32)).collect();
        Self { width, height, pixels: bytes }
    }

    /// Red, green, blue at column `x` from the left and row `y` from the top; `None` outside.
    pub fn at(&self, x: u32, y: u32) -> Option<[u8; 3]> {
        if x >= self.width || y >= self.height {
            return None;
        }
        let k = 3 * (y as usize * self.width as usize + x as usize);
        Some([*self.pixels.get(k)?, *self.pixels.get(k + 1)?, *self.pixels.get(k + 2)?])
    }

    /// The picture as the bytes of a PNG file.
    ///
    /// # Errors
    /// [`PictureError::Size`] for an empty picture, [`PictureError::Pixels`] if the bytes do not fit the size.
    pub fn to_png(&self) -> Result<Vec<u8>, PictureError> {
        let (width, height) = (self.width, self.height);
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, width, height);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
        let size = |_| PictureError::Size { width, height };
        let got = self.pixels.len();
        let mut writer = encoder.write_header().map_err(size)?;
        writer.write_image_data(&self.pixels).map_err(|_| PictureError::Pixels { got, width, height })?;
        writer.finish().map_err(size)?;
        Ok(bytes)
    }

    /// Writes the picture as PNG, complete or not at all.
    ///
    /// # Errors
    /// As [`Image::to_png`], and [`PictureError::Io`].
    pub fn write_png(&self, path: &Path) -> Result<(), PictureError> {
        write_atomically(path, &self.to_png()?).map_err(|source| PictureError::Io { path: path.into(), source })
    }
}
