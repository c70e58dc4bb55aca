//! Grains as shaded spheres seen from far away: a depth-tested raster for bitmaps, gradient-filled circles of the
//! visible ones for SVG.

use super::colour::{Colour, WHITE, mix};
use std::fmt::Write as _;

/// Largest number of circles in an SVG; beyond this number the grains with the least visible area
/// are left out.
const MOST_CIRCLES: usize = 9000;
/// Direction to the light: from the upper left, towards the reader (page axes, y downwards).
const LIGHT: [f64; 3] = [-0.44, -0.58, 0.686];
/// Half-width, page units, of the window over which depths are averaged; pixels deeper than this
/// mean are darkened.
const HOLLOW: f64 = 11.0;
const NONE: u32 = u32::MAX;

/// One grain on the page, in page units; `depth` grows towards the reader.
#[derive(Clone, Copy, Debug)]
pub struct Ball {
    pub x: f64,
    pub y: f64,
    pub depth: f64,
    pub r: f64,
    /// Index into the palette.
    pub colour: usize,
}

/// Grains drawn together, hiding each other.
#[derive(Clone, Debug, Default)]
pub struct Balls {
    pub items: Vec<Ball>,
    pub palette: Vec<Colour>,
}

/// Depth of each pixel of a window, and the index of the grain that is seen there.
struct Buffer {
    left: i64,
    top: i64,
    w: usize,
    h: usize,
    depth: Vec<f32>,
    owner: Vec<u32>,
}

impl Balls {
    fn buffer(&self, zoom: f64) -> Buffer {
        let mut b = [f64::INFINITY, f64::INFINITY, f64::NEG_INFINITY, f64::NEG_INFINITY];
        for s in self.items.iter().filter(|s| drawable(s)) {
            b[0] = b[0].min(s.x - s.r);
            b[1] = b[1].min(s.y - s.r);
            b[2] = b[2].max(s.x + s.r);
            b[3] = b[3].max(s.y + s.r);
        }
        let (left, top) = ((b[0] * zoom).floor() as i64, (b[1] * zoom).floor() as i64);
        let side = |lo: f64, hi: f64| {
            if hi > lo { ((hi - lo) * zoom).ceil().min(20_000.0) as usize + 2 } else { 0 }
        };
        let (w, h) = (side(b[0], b[2]), side(b[1], b[3]));
        let mut out = Buffer { left, top, w, h, depth: vec![f32::NEG_INFINITY; w * h], owner: vec![NONE; w * h] };
        for (i, s) in self.items.iter().enumerate().filter(|(_, s)| drawable(s)) {
            out.add(s, i as u32, zoom);
        }
        out
    }

    /// Number of visible pixels of each grain.
    fn visible(&self) -> Vec<u32> {
        let mut out = vec![0; self.items.len()];
        for owner in self.buffer(1.5).owner {
            if owner != NONE {
                out[owner as usize] += 1;
            }
        }
        out
    }

    /// Indices of the visible grains, far to near; at most [`MOST_CIRCLES`], those with the largest
    /// visible area.
    pub fn visible_order(&self) -> Vec<usize> {
        let seen = self.visible();
        let mut order: Vec<usize> = (0..seen.len()).filter(|i| seen[*i] > 0).collect();
        order.sort_by_key(|i| std::cmp::Reverse(seen[*i]));
        order.truncate(MOST_CIRCLES);
        order.sort_by(|a, b| self.items[*a].depth.total_cmp(&self.items[*b].depth));
        order
    }

    fn colour(&self, ball: &Ball) -> Colour {
        let last = self.palette.last().copied().unwrap_or(WHITE);
        self.palette.get(ball.colour).copied().unwrap_or(last)
    }

    /// Shades the grains into an RGB image of `zoom` pixels a page unit.
    pub fn raster(&self, image: &mut [u8], w: usize, h: usize, zoom: f64) {
        let buffer = self.buffer(zoom);
        let mean = buffer.mean_depth((HOLLOW * zoom) as usize);
        for row in 0..buffer.h {
            for col in 0..buffer.w {
                let at = row * buffer.w + col;
                let (px, py) = (buffer.left + col as i64, buffer.top + row as i64);
                if buffer.owner[at] == NONE || px < 0 || py < 0 {
                    continue;
                }
                let (px, py) = (px as usize, py as usize);
                if px >= w || py >= h {
                    continue;
                }
                let ball = &self.items[buffer.owner[at] as usize];
                let x = ((px as f64 + 0.5) / zoom - ball.x) / ball.r;
                let y = ((py as f64 + 0.5) / zoom - ball.y) / ball.r;
                let below = f64::from(mean[at] - buffer.depth[at]) / (HOLLOW * 1.6);
                let shade = 1.0 - 0.6 * below.clamp(0.0, 1.0);
                let lit = shaded(self.colour(ball), x, y, shade);
                let to = 3 * (py * w + px);
                image[to..to + 3].copy_from_slice(&[lit.0, lit.1, lit.2]);
            }
        }
    }

    /// The visible grains as SVG circles with a radial gradient for each colour; `tag` makes the
    /// ids of the gradients unique in the file.
    pub fn svg(&self, tag: usize) -> String {
        let mut out = String::from("<defs>\n");
        for (i, c) in self.palette.iter().enumerate() {
            let dark = |t| hex(mix(*c, Colour(0, 0, 0), t));
            let _ = writeln!(
                out,
                "<radialGradient id=\"b{tag}-{i}\" cx=\"0.5\" cy=\"0.5\" r=\"0.5\" fx=\"0.33\" fy=\"0.28\">\
                 <stop offset=\"0\" stop-color=\"{}\"/><stop offset=\"0.45\" stop-color=\"{}\"/>\
                 <stop offset=\"0.85\" stop-color=\"{}\"/><stop offset=\"1\" stop-color=\"{}\"/></radialGradient>",
                hex(mix(*c, WHITE, 0.45)),
                hex(*c),
                dark(0.32),
                dark(0.5)
            );
        }
        out += "</defs>\n<g stroke=\"#222222\" stroke-opacity=\"0.45\" stroke-width=\"0.8\">\n";
        for i in self.visible_order() {
            let b = &self.items[i];
            let c = b.colour.min(self.palette.len().saturating_sub(1));
            let _ = writeln!(out, "<circle cx=\"{:.1}\" cy=\"{:.1}\" r=\"{:.1}\" fill=\"url(#b{tag}-{c})\"/>", b.x, b.y, b.r);
        }
        out + "</g>\n"
    }
}

impl Buffer {
    fn add(&mut self, s: &Ball, owner: u32, zoom: f64) {
        let (cx, cy, r) = (s.x * zoom - self.left as f64, s.y * zoom - self.top as f64, s.r * zoom);
        let span = |c: f64, n: usize| {
            let lo = (c - r).floor().max(0.0) as usize;
            lo..((c + r).ceil().max(0.0) as usize + 1).min(n)
        };
        for row in span(cy, self.h) {
            let dy = row as f64 + 0.5 - cy;
            for col in span(cx, self.w) {
                let dx = col as f64 + 0.5 - cx;
                let inside = r * r - dx * dx - dy * dy;
                if inside <= 0.0 {
                    continue;
                }
                let depth = (s.depth + inside.sqrt() / zoom) as f32;
                let at = row * self.w + col;
                if depth > self.depth[at] {
                    self.depth[at] = depth;
                    self.owner[at] = owner;
                }
            }
        }
    }

    /// Mean depth of the covered pixels in a square window round each pixel.
    fn mean_depth(&self, half: usize) -> Vec<f32> {
        let (w, h) = (self.w, self.h);
        let stride = w + 1;
        let mut sums = vec![(0.0f64, 0u32); stride * (h + 1)];
        for row in 0..h {
            let mut line = (0.0, 0);
            for col in 0..w {
                let at = row * w + col;
                if self.owner[at] != NONE {
                    line = (line.0 + f64::from(self.depth[at]), line.1 + 1);
                }
                let above = sums[row * stride + col + 1];
                sums[(row + 1) * stride + col + 1] = (above.0 + line.0, above.1 + line.1);
            }
        }
        let mut out = vec![0.0; w * h];
        for row in 0..h {
            let (a, b) = (row.saturating_sub(half), (row + half + 1).min(h));
            for col in 0..w {
                let (l, r) = (col.saturating_sub(half), (col + half + 1).min(w));
                let get = |row: usize, col: usize| sums[row * stride + col];
                let (p, q, s, t) = (get(b, r), get(a, r), get(b, l), get(a, l));
                let n = p.1 + t.1 - q.1 - s.1;
                out[row * w + col] = ((p.0 + t.0 - q.0 - s.0) / f64::from(n.max(1))) as f32;
            }
        }
        out
    }
}

fn drawable(s: &Ball) -> bool {
    s.r > 0.0 && [s.x, s.y, s.depth, s.r].iter().all(|v| v.is_finite() && v.abs() < 1e6)
}

/// Lambert shading with a small highlight at a point of the unit disc.
fn shaded(base: Colour, x: f64, y: f64, shade: f64) -> Colour {
    let z = (1.0 - x * x - y * y).max(0.0).sqrt();
    let lambert = (x * LIGHT[0] + y * LIGHT[1] + z * LIGHT[2]).max(0.0);
    // Half-way direction between the light and the reader.
    let half = (x * LIGHT[0] + y * LIGHT[1] + z * (LIGHT[2] + 1.0)) / (2.0 * (1.0 + LIGHT[2])).sqrt();
    let glow = 0.30 * half.max(0.0).powi(22);
    let rim = if z < 0.28 { 0.55 + 0.45 * z / 0.28 } else { 1.0 };
    let light = (0.46 + 0.62 * lambert) * shade * rim;
    let channel = |v: u8| {
        let v = f64::from(v) * light;
        (v + (255.0 - v).max(0.0) * glow * shade).clamp(0.0, 255.0) as u8
    };
    Colour(channel(base.0), channel(base.1), channel(base.2))
}

fn hex(c: Colour) -> String {
    format!("#{:02X}{:02X}{:02X}", c.0, c.1, c.2)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ball(x: f64, depth: f64, r: f64, colour: usize) -> Ball {
        Ball { x, y: 20.0, depth, r, colour }
    }

    #[test]
    fn the_nearer_grain_hides_the_farther() {
        let items = vec![ball(20.0, 0.0, 5.0, 0), ball(20.0, 50.0, 10.0, 1), ball(60.0, 0.0, 4.0, 0)];
        let balls = Balls { items, palette: vec![Colour(255, 0, 0), Colour(0, 0, 255)] };
        assert_eq!(balls.visible_order(), [2, 1]);
        assert_eq!(balls.svg(3).matches("<circle").count(), 2);
        let mut image = vec![255; 80 * 40 * 3];
        balls.raster(&mut image, 80, 40, 1.0);
        let at = |x: usize, y: usize| [image[3 * (y * 80 + x)], image[3 * (y * 80 + x) + 2]];
        let middle = at(20, 20);
        assert!(middle[1] > middle[0], "blue is in front: {middle:?}");
        assert_eq!(at(40, 20), [255, 255]);
    }

    #[test]
    fn light_comes_from_the_upper_left() {
        let c = Colour(200, 200, 200);
        let (lit, dim) = (shaded(c, -0.4, -0.5, 1.0), shaded(c, 0.4, 0.5, 1.0));
        assert!(lit.0 > dim.0 + 40, "{lit:?} {dim:?}");
    }

    #[test]
    fn odd_grains_are_left_out() {
        let balls = Balls { items: vec![ball(f64::NAN, 0.0, 5.0, 0), ball(1.0, 0.0, -1.0, 0)], palette: Vec::new() };
        assert!(balls.visible_order().is_empty());
        balls.raster(&mut [0; 12], 2, 2, 1.0);
    }
}
