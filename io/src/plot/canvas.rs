//! Pixels for plots, twice as fine as the picture, so that lines are smooth when it is made smaller.

use std::convert::Infallible;

use embedded_graphics::mono_font::iso_8859_1::{FONT_9X18, FONT_10X20};
use embedded_graphics::mono_font::{MonoFont, MonoTextStyle};
use embedded_graphics::pixelcolor::BinaryColor;
use embedded_graphics::prelude::{DrawTarget, Drawable, OriginDimensions, Pixel, Point, Size};
use embedded_graphics::text::{Baseline, Text};
use plotters::style::text_anchor::{HPos, VPos};
use plotters_backend::{
    BackendColor, BackendCoord, BackendStyle, BackendTextStyle, DrawingBackend, DrawingErrorKind, FontTransform,
};

use crate::picture::Image;

/// Pixels of the canvas for one of the picture, along each side.
const FINE: u32 = 2;

/// Heights of the fonts (pixels of the canvas).
pub(super) const LARGE: f64 = (20 * FINE) as f64;
pub(super) const SMALL: f64 = (18 * FINE) as f64;

/// `n` pixels of the picture in pixels of the canvas.
pub(super) fn pixels(n: u32) -> u32 {
    n * FINE
}

/// Bytes of a canvas for a picture.
pub(super) fn bytes(width: u32, height: u32) -> usize {
    3 * pixels(width) as usize * pixels(height) as usize
}

/// Red, green, blue of each pixel, row by row.
pub(super) struct Canvas<'a> {
    pixels: &'a mut [u8],
    width: u32,
    height: u32,
}

impl<'a> Canvas<'a> {
    /// A canvas for a picture of `width` by `height` pixels on [`bytes`] bytes.
    pub(super) fn new(bytes: &'a mut [u8], width: u32, height: u32) -> Self {
        Self { pixels: bytes, width: pixels(width), height: pixels(height) }
    }
}

/// The picture, each pixel the mean of those of the canvas.
pub(super) fn develop(fine: &[u8], width: u32, height: u32) -> Image {
    let row = 3 * pixels(width) as usize;
    let channel = |k: usize| {
        let (y, x, c) = (k / (3 * width as usize), k / 3 % width as usize, k % 3);
        let corner = y * FINE as usize * row + 3 * x * FINE as usize + c;
        let around = (0..FINE as usize).flat_map(|dy| (0..FINE as usize).map(move |dx| corner + dy * row + 3 * dx));
        (around.map(|at| u32::from(fine[at])).sum::<u32>() / (FINE * FINE)) as u8
    };
    Image { width, height, pixels: (0..3 * (width * height) as usize).map(channel).collect() }
}

impl DrawingBackend for Canvas<'_> {
    type ErrorType = Infallible;

    fn get_size(&self) -> (u32, u32) {
        (self.width, self.height)
    }

    fn ensure_prepared(&mut self) -> Result<(), DrawingErrorKind<Infallible>> {
        Ok(())
    }

    fn present(&mut self) -> Result<(), DrawingErrorKind<Infallible>> {
        Ok(())
    }

    fn draw_pixel(&mut self, (x, y): BackendCoord, colour: BackendColor) -> Result<(), DrawingErrorKind<Infallible>> {
        if (0..self.width as i32).contains(&x) && (0..self.height as i32).contains(&y) {
            let at = 3 * (y as usize * self.width as usize + x as usize);
            let (r, g, b) = colour.rgb;
            for (old, new) in self.pixels[at..at + 3].iter_mut().zip([r, g, b]) {
                *old = (f64::from(*old) * (1.0 - colour.alpha) + f64::from(new) * colour.alpha).round() as u8;
            }
        }
        Ok(())
    }

    fn estimate_text_size<S: BackendTextStyle>(
        &self,
        text: &str,
        style: &S,
    ) -> Result<(u32, u32), DrawingErrorKind<Infallible>> {
        let letter = font(style).character_size;
        Ok((pixels(letter.width * text.chars().count() as u32), pixels(letter.height)))
    }

    fn draw_text<S: BackendTextStyle>(
        &mut self,
        text: &str,
        style: &S,
        at: BackendCoord,
    ) -> Result<(), DrawingErrorKind<Infallible>> {
        let (width, height) = self.estimate_text_size(text, style)?;
        let (width, height) = (width as i32, height as i32);
        let dx = match style.anchor().h_pos {
            HPos::Left => 0,
            HPos::Center => -width / 2,
            HPos::Right => -width,
        };
        let dy = match style.anchor().v_pos {
            VPos::Top => 0,
            VPos::Center => -height / 2,
            VPos::Bottom => -height,
        };
        let mut ink = Ink(Vec::new());
        let letters = MonoTextStyle::new(font(style), BinaryColor::On);
        let Ok(_) = Text::with_baseline(text, Point::zero(), letters, Baseline::Top).draw(&mut ink);
        let turned = |x: i32, y: i32| match style.transform() {
            FontTransform::None => (x, y),
            FontTransform::Rotate90 => (-y, x),
            FontTransform::Rotate180 => (-x, -y),
            FontTransform::Rotate270 => (y, -x),
        };
        let fine = FINE as i32;
        for Point { x, y } in ink.0 {
            for k in 0..fine * fine {
                let (x, y) = turned(x * fine + k % fine + dx, y * fine + k / fine + dy);
                self.draw_pixel((at.0 + x, at.1 + y), style.color())?;
            }
        }
        Ok(())
    }

    fn draw_path<S: BackendStyle, I: IntoIterator<Item = BackendCoord>>(
        &mut self,
        path: I,
        style: &S,
    ) -> Result<(), DrawingErrorKind<Infallible>> {
        // a nib that is moved along: corners are round, and steep curves as thick as flat ones
        let (mut last, nib) = (None, style.stroke_width() as i32);
        for (x, y) in path {
            let (from_x, from_y) = last.unwrap_or((x, y));
            let steps = (x - from_x).abs().max((y - from_y).abs()).max(1);
            for step in 0..=steps {
                let along = |a: i32, b: i32| a + ((b - a) as f64 * f64::from(step) / f64::from(steps)).round() as i32;
                let (x, y) = (along(from_x, x) - nib / 2, along(from_y, y) - nib / 2);
                (0..nib * nib).try_for_each(|k| self.draw_pixel((x + k % nib, y + k / nib), style.color()))?;
            }
            last = Some((x, y));
        }
        Ok(())
    }
}

fn font<S: BackendTextStyle>(style: &S) -> &'static MonoFont<'static> {
    if style.size() < LARGE { &FONT_9X18 } else { &FONT_10X20 }
}

/// Where letters have ink.
struct Ink(Vec<Point>);

impl DrawTarget for Ink {
    type Color = BinaryColor;
    type Error = Infallible;

    fn draw_iter<I: IntoIterator<Item = Pixel<BinaryColor>>>(&mut self, pixels: I) -> Result<(), Infallible> {
        self.0.extend(pixels.into_iter().filter(|p| p.1 == BinaryColor::On).map(|p| p.0));
        Ok(())
    }
}

impl OriginDimensions for Ink {
    fn size(&self) -> Size {
        Size::new(u32::MAX, u32::MAX)
    }
}
