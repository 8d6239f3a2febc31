//! Marks of a figure as pixels.
use super::{Color, Mark};
use tiny_skia::{FillRule, LineJoin, Paint, Path, PathBuilder, Pixmap, Stroke, StrokeDash, Transform};

/// Draws a mark that is no image; `scale` leads from millimeters to pixels.
pub fn draw(pixmap: &mut Pixmap, mark: &Mark, scale: Transform) {
    match mark {
        Mark::Line { points, color, width, dashes } => {
            let Some(path) = through(points, false) else { return };
            let dash = StrokeDash::new(dashes.iter().map(|d| *d as f32).collect(), 0.0);
            let stroke =
                Stroke { width: *width as f32, line_join: LineJoin::Round, dash, ..Stroke::default() };
            pixmap.stroke_path(&path, &paint(*color), &stroke, scale, None);
        }
        Mark::Area { points, color } => fill(pixmap, through(points, true), *color, scale),
        Mark::Disc { center: [x, y], radius, color } => {
            fill(pixmap, PathBuilder::from_circle(*x as f32, *y as f32, *radius as f32), *color, scale);
        }
        Mark::Text { at, text, font } => fill(pixmap, font.outlines(text, *at), font.color, scale),
        Mark::Image { .. } => {}
    }
}

fn fill(pixmap: &mut Pixmap, path: Option<Path>, color: Color, scale: Transform) {
    if let Some(path) = path {
        pixmap.fill_path(&path, &paint(color), FillRule::Winding, scale, None);
    }
}

fn paint(color: Color) -> Paint<'static> {
    let mut paint = Paint::default();
    paint.set_color_rgba8(color[0], color[1], color[2], 255);
    paint
}

/// A path through points.
fn through(points: &[[f64; 2]], closed: bool) -> Option<Path> {
    let mut path = PathBuilder::new();
    for (n, [x, y]) in points.iter().enumerate() {
        let (x, y) = (*x as f32, *y as f32);
        if n == 0 { path.move_to(x, y) } else { path.line_to(x, y) }
    }
    if closed {
        path.close();
    }
    path.finish()
}
