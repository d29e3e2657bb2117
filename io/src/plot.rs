//! Plots of curves over axes: `plotters` lays them out. Pictures are drawn on pixels of ours with a font that is compiled in, so
//! they need nothing of the system and are the same everywhere; the same plot as SVG stays sharp at any size.

mod canvas;

use plotters::coord::Shift;
use plotters::coord::types::RangedCoordf64;
use plotters::prelude::*;

use crate::picture::Image;
use canvas::Canvas;

/// Panels, at most three in a row.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Figure {
    /// Headline.
    pub title: String,
    /// From left to right, then down; one or more.
    pub panels: Vec<Panel>,
}

/// Curves over two axes.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Panel {
    /// What is shown.
    pub title: String,
    /// Name and unit of the horizontal axis.
    pub x: String,
    /// Name and unit of the vertical axis.
    pub y: String,
    /// Whether lengths are as long along both axes.
    pub equal: bool,
    /// The curves, later ones over earlier ones.
    pub curves: Vec<Curve>,
}

/// Points with a colour.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Curve {
    /// For the legend; empty for none.
    pub name: String,
    /// Which colour of [`COLOURS`], counted around.
    pub colour: usize,
    /// Whether the points are dots, rather than joined by a line.
    pub dots: bool,
    /// Horizontal and vertical place of each point; what is not finite is left out.
    pub points: Vec<[f64; 2]>,
}

/// Black for references, then colours that people with colour blindness tell apart (Okabe and Ito 2008).
pub const COLOURS: [RGBColor; 7] = [
    RGBColor(40, 40, 40),
    RGBColor(213, 94, 0),
    RGBColor(0, 114, 178),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(230, 159, 0),
    RGBColor(86, 180, 233),
];

/// Size of a panel, and height of the headline (pixels).
const PANEL: (u32, u32) = (760, 480);
const HEADLINE: u32 = 44;

type Fault<B> = DrawingAreaErrorKind<<B as DrawingBackend>::ErrorType>;
type Area<B> = DrawingArea<B, Shift>;

impl Figure {
    /// Draws the figure.
    pub fn draw(&self) -> Image {
        let (cells, width, height) = self.layout();
        let mut pixels = vec![255; canvas::bytes(width, height)];
        let drawn = self.draw_on(&Canvas::new(&mut pixels, width, height).into_drawing_area(), cells);
        drawn.expect("the canvas takes whatever is drawn");
        canvas::develop(&pixels, width, height)
    }

    /// The figure as the text of an SVG file.
    pub fn svg(&self) -> String {
        let (cells, width, height) = self.layout();
        let (fine_width, fine_height) = (canvas::pixels(width), canvas::pixels(height));
        let mut text = String::new();
        {
            let area = SVGBackend::with_string(&mut text, (fine_width, fine_height)).into_drawing_area();
            let drawn = area.fill(&WHITE).and_then(|()| self.draw_on(&area, cells));
            drawn.expect("a text takes whatever is drawn");
        }
        // laid out twice as large as the picture is to be shown, as the pixels are
        let fine = format!("width=\"{fine_width}\" height=\"{fine_height}\"");
        text.replacen(&fine, &format!("width=\"{width}\" height=\"{height}\""), 1)
    }

    /// Rows and columns of panels, and the size of the whole.
    fn layout(&self) -> ((usize, usize), u32, u32) {
        let columns = match self.panels.len() {
            0 | 1 => 1,
            2 | 4 => 2,
            _ => 3,
        };
        let rows = self.panels.len().div_ceil(columns).max(1);
        ((rows, columns), PANEL.0 * columns as u32, PANEL.1 * rows as u32 + HEADLINE)
    }

    fn draw_on<B: DrawingBackend>(&self, area: &Area<B>, cells: (usize, usize)) -> Result<(), Fault<B>> {
        let (head, body) = area.split_vertically(canvas::pixels(HEADLINE));
        let style = font(true).pos(centred());
        let (width, height) = head.dim_in_pixel();
        head.draw_text(&self.title, &style, (width as i32 / 2, height as i32 / 2))?;
        for (panel, area) in self.panels.iter().zip(body.split_evenly(cells)) {
            panel.draw_on(&area)?;
        }
        area.present()
    }
}

impl Panel {
    fn draw_on<B: DrawingBackend>(&self, area: &Area<B>) -> Result<(), Fault<B>> {
        let px = canvas::pixels;
        let (left, bottom, margin) = (px(84), px(52), px(14));
        let inner = (PANEL.0 - 84 - 28, PANEL.1 - 52 - 28 - 34);
        let [x, y] = self.ranges(f64::from(inner.0) / f64::from(inner.1));
        let mut chart = ChartBuilder::on(area)
            .margin(margin)
            .caption(&self.title, font(true))
            .x_label_area_size(bottom)
            .y_label_area_size(left)
            .build_cartesian_2d(x[0]..x[1], y[0]..y[1])?;
        chart
            .configure_mesh()
            .x_desc(&self.x)
            .y_desc(&self.y)
            .x_labels(8)
            .y_labels(7)
            .x_label_formatter(&|at| tick(*at, x))
            .y_label_formatter(&|at| tick(*at, y))
            .label_style(font(false))
            .axis_desc_style(font(true))
            .axis_style(BLACK.stroke_width(px(1)))
            .bold_line_style(RGBColor(222, 222, 222).stroke_width(px(1)))
            .light_line_style(TRANSPARENT)
            .draw()?;
        self.curves.iter().try_for_each(|curve| curve.draw_on(&mut chart))?;
        self.legend(&chart.plotting_area().strip_coord_spec(), self.emptiest_corner([x, y]))
    }

    /// Names beside a sample of their curves, in a corner: at the right or left, at the top or bottom. That of `plotters`
    /// measures its text without asking the canvas.
    fn legend<B: DrawingBackend>(&self, area: &Area<B>, (right, top): (bool, bool)) -> Result<(), Fault<B>> {
        let named: Vec<&Curve> = self.curves.iter().filter(|c| !c.name.is_empty()).collect();
        let px = |n: u32| canvas::pixels(n) as i32;
        let mut width = 0;
        for curve in &named {
            width = width.max(area.estimate_text_size(&curve.name, &font(false))?.0 as i32 + px(54));
        }
        let (row, height) = (px(22), px(22) * named.len() as i32 + px(8));
        let (all_width, all_height) = area.dim_in_pixel();
        let x = if right { all_width as i32 - width - px(8) } else { px(8) };
        let y = if top { px(8) } else { all_height as i32 - height - px(8) };
        if !named.is_empty() {
            let frame = [(x, y), (x + width, y + height)];
            area.draw(&Rectangle::new(frame, WHITE.mix(0.85).filled()))?;
            area.draw(&Rectangle::new(frame, RGBColor(160, 160, 160).stroke_width(px(1) as u32)))?;
        }
        for (k, curve) in named.iter().enumerate() {
            let (middle, colour) = (y + px(4) + row / 2 + row * k as i32, curve.rgb());
            if curve.dots {
                area.draw(&Circle::new((x + px(22), middle), px(3), colour.filled()))?;
            } else {
                let ends = vec![(x + px(8), middle), (x + px(36), middle)];
                area.draw(&PathElement::new(ends, colour.stroke_width(px(2) as u32)))?;
            }
            area.draw_text(&curve.name, &font(false), (x + px(44), middle - px(9)))?;
        }
        Ok(())
    }

    fn points(&self) -> impl Iterator<Item = [f64; 2]> {
        self.curves.iter().flat_map(|c| &c.points).copied().filter(|p| p[0].is_finite() && p[1].is_finite())
    }

    /// What the axes show: all points and a twentieth more, with lengths as long along both axes where that is wanted.
    fn ranges(&self, aspect: f64) -> [[f64; 2]; 2] {
        let mut ranges = [0, 1].map(|axis| {
            let all = |c: fn(f64, f64) -> f64, start| self.points().map(|p| p[axis]).fold(start, c);
            let [low, high] = [all(f64::min, f64::INFINITY), all(f64::max, f64::NEG_INFINITY)];
            if low > high {
                return [0.0, 1.0];
            }
            // a constant has a range, too, and one that its own rounding does not fill
            let pad = (0.05 * (high - low)).max(1e-6 * low.abs().max(high.abs())).max(1e-12);
            [low - pad, high + pad]
        });
        if self.equal {
            let [width, height] = ranges.map(|r| r[1] - r[0]);
            let grow = |r: &mut [f64; 2], by: f64| *r = [r[0] - by / 2.0, r[1] + by / 2.0];
            grow(&mut ranges[0], (height * aspect - width).max(0.0));
            grow(&mut ranges[1], (width / aspect - height).max(0.0));
        }
        ranges
    }

    /// The corner with the fewest points in it: whether it is at the right, and at the top.
    fn emptiest_corner(&self, ranges: [[f64; 2]; 2]) -> (bool, bool) {
        let share = |p: [f64; 2], axis: usize| (p[axis] - ranges[axis][0]) / (ranges[axis][1] - ranges[axis][0]);
        let near = |right: bool, top: bool| {
            let inside = |p: &[f64; 2]| {
                let (x, y) = (share(*p, 0), share(*p, 1));
                (if right { 1.0 - x } else { x }) < 0.35 && (if top { 1.0 - y } else { y }) < 0.35
            };
            self.points().filter(inside).count()
        };
        let corners = [(true, true), (false, true), (true, false), (false, false)];
        corners.into_iter().min_by_key(|&(right, top)| near(right, top)).unwrap_or((true, true))
    }
}

impl Curve {
    fn draw_on<B: DrawingBackend>(
        &self,
        chart: &mut ChartContext<'_, B, Cartesian2d<RangedCoordf64, RangedCoordf64>>,
    ) -> Result<(), Fault<B>> {
        let px = canvas::pixels;
        let points = self.points.iter().filter(|p| p[0].is_finite() && p[1].is_finite()).map(|p| (p[0], p[1]));
        if self.dots {
            chart.draw_series(points.map(|p| Circle::new(p, px(3), self.rgb().filled())))?;
        } else {
            chart.draw_series(LineSeries::new(points, self.rgb().stroke_width(px(2))))?;
        }
        Ok(())
    }

    fn rgb(&self) -> RGBColor {
        COLOURS[self.colour % COLOURS.len()]
    }
}

/// A number beside an axis that shows `range`.
fn tick(x: f64, range: [f64; 2]) -> String {
    let largest = range[0].abs().max(range[1].abs());
    if x.abs() < 1e-6 * largest {
        return "0".into();
    }
    if !(1e-3..1e5).contains(&largest) {
        return format!("{x:.1e}");
    }
    let digits = format!("{x:.6}");
    digits.trim_end_matches('0').trim_end_matches('.').into()
}

/// The large or the small font; the family is the canvas' own.
fn font(large: bool) -> TextStyle<'static> {
    ("sans-serif", if large { canvas::LARGE } else { canvas::SMALL }).into_text_style(&(1, 1)).color(&COLOURS[0])
}

fn centred() -> plotters::style::text_anchor::Pos {
    use plotters::style::text_anchor::{HPos, Pos, VPos};
    Pos::new(HPos::Center, VPos::Center)
}

#[cfg(test)]
mod tests;
