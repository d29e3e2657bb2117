//! Pictures one after the other in one file: GIF, which opens everywhere and has 256 colours a picture, or APNG, which has all.

use super::{Image, PictureError};

/// The format of a film.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FilmFormat {
    /// Animated GIF.
    Gif,
    /// Animated PNG.
    Apng,
}

/// A film in the making; it repeats for ever.
pub struct Film {
    size: (u32, u32),
    made: Made,
}

enum Made {
    Gif { encoder: Box<gif::Encoder<Vec<u8>>>, delay: u16 },
    Apng { images: Vec<Vec<u8>>, delay: (u16, u16) },
}

/// GIF counts in hundredths of a second, and programs show what is faster than two of them slowly.
const LEAST_DELAY: u16 = 2;
/// How thoroughly the colours of a GIF are chosen, 1 (best) to 30.
const SPEED: i32 = 10;

impl Film {
    /// An empty film of pictures of `width` and `height` pixels, `fps` a second: above 0, for GIF at most 50.
    ///
    /// # Errors
    /// [`PictureError::Size`] for sides that are 0 or, for GIF, above 65 535.
    pub fn new(format: FilmFormat, (width, height): (u32, u32), fps: f64) -> Result<Self, PictureError> {
        let fault = PictureError::Size { width, height };
        if width == 0 || height == 0 {
            return Err(fault);
        }
        let made = match format {
            FilmFormat::Gif => {
                let (Ok(w), Ok(h)) = (u16::try_from(width), u16::try_from(height)) else { return Err(fault) };
                let mut encoder = gif::Encoder::new(Vec::new(), w, h, &[]).map_err(|_| fault)?;
                encoder.set_repeat(gif::Repeat::Infinite).map_err(|_| PictureError::Size { width, height })?;
                let delay = (100.0 / fps).round().clamp(f64::from(LEAST_DELAY), f64::from(u16::MAX)) as u16;
                Made::Gif { encoder: Box::new(encoder), delay }
            }
            FilmFormat::Apng => {
                let thousandths = (1000.0 / fps).round().clamp(1.0, f64::from(u16::MAX)) as u16;
                Made::Apng { images: Vec::new(), delay: (thousandths, 1000) }
            }
        };
        Ok(Self { size: (width, height), made })
    }

    /// Adds a picture.
    ///
    /// # Errors
    /// [`PictureError::Size`] or [`PictureError::Pixels`] if it is of another size than the film.
    pub fn add(&mut self, image: &Image) -> Result<(), PictureError> {
        let (width, height) = self.size;
        let got = image.pixels.len();
        if (image.width, image.height) != self.size {
            return Err(PictureError::Size { width: image.width, height: image.height });
        }
        if got != 3 * width as usize * height as usize {
            return Err(PictureError::Pixels { got, width, height });
        }
        match &mut self.made {
            Made::Gif { encoder, delay } => {
                let mut frame = gif::Frame::from_rgb_speed(width as u16, height as u16, &image.pixels, SPEED);
                frame.delay = *delay;
                encoder.write_frame(&frame).map_err(|_| PictureError::Pixels { got, width, height })
            }
            Made::Apng { images, .. } => {
                images.push(image.pixels.clone());
                Ok(())
            }
        }
    }

    /// The bytes of the file.
    ///
    /// # Errors
    /// [`PictureError::Size`] for a film without pictures.
    pub fn finish(self) -> Result<Vec<u8>, PictureError> {
        let (width, height) = self.size;
        let fault = |_| PictureError::Size { width, height };
        match self.made {
            Made::Gif { encoder, .. } => encoder.into_inner().map_err(|_| PictureError::Size { width, height }),
            Made::Apng { images, delay } => {
                let mut bytes = Vec::new();
                let mut encoder = png::Encoder::new(&mut bytes, width, height);
                encoder.set_color(png::ColorType::Rgb);
                encoder.set_depth(png::BitDepth::Eight);
                encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
                encoder.set_animated(images.len() as u32, 0).map_err(fault)?;
                encoder.set_frame_delay(delay.0, delay.1).map_err(fault)?;
                let mut writer = encoder.write_header().map_err(fault)?;
                images.iter().try_for_each(|pixels| writer.write_image_data(pixels)).map_err(fault)?;
                writer.finish().map_err(fault)?;
                Ok(bytes)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pictures() -> Vec<Image> {
        let plain = |k: u8| Image { width: 6, height: 4, pixels: [40 * k, 200 - 40 * k, 7].repeat(24) };
        (0..4).map(plain).collect()
    }

    fn film(format: FilmFormat) -> Vec<u8> {
        let mut film = Film::new(format, (6, 4), 25.0).unwrap();
        pictures().iter().for_each(|image| film.add(image).unwrap());
        film.finish().unwrap()
    }

    #[test]
    fn a_gif_has_the_pictures_and_their_delay() {
        let bytes = film(FilmFormat::Gif);
        let mut options = gif::DecodeOptions::new();
        options.set_color_output(gif::ColorOutput::RGBA);
        let mut reader = options.read_info(&bytes[..]).unwrap();
        for want in pictures() {
            let frame = reader.read_next_frame().unwrap().unwrap();
            assert_eq!((frame.width, frame.height, frame.delay), (6, 4, 4));
            for (got, want) in frame.buffer.chunks(4).zip(want.pixels.chunks(3)) {
                assert!(got.iter().zip(want).all(|(a, b)| a.abs_diff(*b) <= 2), "{got:?} {want:?}"); // one colour: exact but for the table
            }
        }
        assert!(reader.read_next_frame().unwrap().is_none());
    }

    #[test]
    fn an_apng_has_the_pictures_to_the_bit() {
        let bytes = film(FilmFormat::Apng);
        let mut reader = png::Decoder::new(std::io::Cursor::new(&bytes)).read_info().unwrap();
        assert_eq!(reader.info().animation_control().unwrap().num_frames, 4);
        for want in pictures() {
            let mut pixels = vec![0; 72];
            reader.next_frame(&mut pixels).unwrap();
            assert_eq!(pixels, want.pixels);
            let control = reader.info().frame_control().unwrap();
            assert_eq!((control.delay_num, control.delay_den), (40, 1000));
        }
    }

    #[test]
    fn pictures_of_another_size_and_empty_films_are_refused() {
        let mut film = Film::new(FilmFormat::Apng, (6, 5), 25.0).unwrap();
        assert!(matches!(film.add(&pictures()[0]), Err(PictureError::Size { .. })));
        assert!(film.finish().is_err());
        assert!(Film::new(FilmFormat::Gif, (70_000, 5), 25.0).is_err());
    }
}
