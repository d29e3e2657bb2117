//! Tests of plots: what is drawn is where the axes say.

use super::*;

fn figure(points: Vec<[f64; 2]>) -> Figure {
    let curve =
        |dots| Curve { name: format!("dots {dots}"), colour: 1 + usize::from(dots), dots, points: points.clone() };
    let panel = Panel {
        title: "a parabola".into(),
        x: "t [s]".into(),
        y: "u [m/s²]".into(),
        curves: vec![curve(false), curve(true)],
        ..Panel::default()
    };
    Figure { title: "A test".into(), panels: vec![panel] }
}

/// Mean place of the pixels of exactly this colour.
fn centre(image: &Image, RGBColor(r, g, b): RGBColor) -> Option<[f64; 2]> {
    let here = |k: &usize| image.pixels[3 * k..3 * k + 3] == [r, g, b];
    let found: Vec<usize> = (0..image.pixels.len() / 3).filter(here).collect();
    let mean = |f: &dyn Fn(usize) -> usize| found.iter().map(|k| f(*k) as f64).sum::<f64>() / found.len() as f64;
    let width = image.width as usize;
    (!found.is_empty()).then(|| [mean(&|k| k % width), mean(&|k| k / width)])
}

#[test]
fn dots_and_lines_are_drawn_where_they_belong() {
    let dots = |points: &[[f64; 2]]| {
        let mut figure = figure(points.to_vec());
        figure.panels[0].curves.remove(0);
        figure.panels[0].curves[0].name.clear();
        // corners of the axes, in another colour
        let corners = Curve { dots: true, points: vec![[0.0, 0.0], [1.0, 2.0]], ..Curve::default() };
        figure.panels[0].curves.push(corners);
        centre(&figure.draw(), COLOURS[2]).expect("a dot")
    };
    let (middle, right, above) = (dots(&[[0.5, 1.0]]), dots(&[[0.75, 1.0]]), dots(&[[0.5, 1.5]]));
    assert!((right[1] - middle[1]).abs() < 1.0 && (above[0] - middle[0]).abs() < 1.0, "{middle:?} {right:?} {above:?}");
    // a quarter of 90 % of the inner panel: about 640 by 360 pixels
    assert!((120.0..180.0).contains(&(right[0] - middle[0])), "{middle:?} {right:?}");
    assert!((60.0..110.0).contains(&(middle[1] - above[1])), "{middle:?} {above:?}");
}

#[test]
fn a_plot_is_the_same_each_time_and_has_text() {
    let points: Vec<[f64; 2]> = (0..50).map(|k| f64::from(k) / 49.0).map(|t| [t, t * t]).collect();
    let image = figure(points.clone()).draw();
    assert_eq!(image, figure(points).draw());
    assert_eq!((image.width, image.height), (PANEL.0, PANEL.1 + HEADLINE));
    let ink = |rows: std::ops::Range<u32>| {
        rows.flat_map(|y| (0..image.width).map(move |x| (x, y)))
            .filter(|&(x, y)| image.at(x, y).unwrap()[0] < 100)
            .count()
    };
    assert!(ink(0..HEADLINE) > 100, "a headline");
    assert!(ink(image.height - 40..image.height) > 50, "a name of the axis");
}

#[test]
fn nothing_constant_or_not_finite_spoils_a_plot() {
    for points in
        [vec![], vec![[1.0, 3.0]], vec![[0.0, f64::NAN], [f64::INFINITY, 1.0]], vec![[0.0, 1e300], [1.0, -1e300]]]
    {
        let image = figure(points.clone()).draw();
        assert!(image.pixels.iter().any(|&p| p < 100), "{points:?}");
    }
}

#[test]
fn equal_axes_have_equal_lengths() {
    let mut figure = figure(vec![[0.0, 0.0], [1.0, 0.1]]);
    figure.panels[0].equal = true;
    let [x, y] = figure.panels[0].ranges(2.0);
    assert!(((x[1] - x[0]) / (y[1] - y[0]) - 2.0).abs() < 1e-12, "{x:?} {y:?}");
    assert!(x[0] < 0.0 && x[1] > 1.0 && y[0] < 0.0 && y[1] > 0.1);
}

#[test]
fn numbers_beside_axes_are_short() {
    let told = |x, range| tick(x, range);
    assert_eq!(told(0.30000000000000004, [0.0, 1.0]), "0.3");
    assert_eq!(told(-1e-17, [-1.0, 1.0]), "0");
    assert_eq!(told(1500.0, [0.0, 2000.0]), "1500");
    assert_eq!(told(2.5e-7, [0.0, 1e-6]), "2.5e-7");
}
