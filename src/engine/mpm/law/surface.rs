//! The yield surface J + alpha I1 = kappa as a function of the accumulated plastic strain, in a table of polynomials of fifth degree that is made once for a law.
//! Without the table the sine, exponential and square root for every yielding point took 29 % of the time of a step in shear.

use super::{Cone, Evolution};

/// Differences between plastic strains below this, absolute and relative to 1 + the plastic strain, count as none.
const NARROW: f64 = 1e-9;

/// The yield surface J + alpha I1 = kappa at one plastic strain, with J = sqrt(J2) and tension positive.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct YieldParameters {
    /// Slope of the cone, -.
    pub alpha: f64,
    /// k c, Pa: factor of the cohesion times cohesion.
    pub kappa: f64,
}

impl YieldParameters {
    /// Axial less radial stress at failure in triaxial compression at the cell pressure `cell`, Pa, compression positive.
    pub fn q_compression(&self, cell: f64) -> f64 {
        let root = 3f64.sqrt();
        root * (3.0 * self.alpha * cell + self.kappa) / (1.0 - root * self.alpha)
    }

    /// Radial less axial stress at failure in triaxial extension at the cell pressure `cell`, Pa, compression positive.
    pub fn q_extension(&self, cell: f64) -> f64 {
        let root = 3f64.sqrt();
        root * (3.0 * self.alpha * cell + self.kappa) / (1.0 + root * self.alpha)
    }

    /// Deviatoric stress sqrt(3 J2) on the surface at the mean stress `p`, Pa, compression positive; 0 beyond the apex.
    pub fn q_at(&self, p: f64) -> f64 {
        3f64.sqrt() * (3.0 * self.alpha * p + self.kappa).max(0.0)
    }
}

/// The surface at one plastic strain, with its first and second derivatives with respect to the plastic strain.
#[derive(Clone, Copy, Debug, PartialEq)]
struct WithDerivatives {
    value: YieldParameters,
    slope: YieldParameters,
    curvature: YieldParameters,
}

/// What a surface is made from.
#[derive(Clone, Copy, Debug)]
pub struct SurfaceDefinition {
    /// Where the cone touches the Mohr-Coulomb pyramid.
    pub cone: Cone,
    /// Friction angle, rad.
    pub friction: Evolution,
    /// Cohesion, Pa.
    pub cohesion: Evolution,
}

impl SurfaceDefinition {
    /// The surface at a plastic strain without the table.
    fn at(&self, plastic: f64) -> WithDerivatives {
        let (angle, dangle, d2angle) = self.friction.at(plastic);
        let (c, dc, d2c) = self.cohesion.at(plastic);
        let cone = self.cone.at(angle);
        let (dk, d2k) = (cone.dk * dangle, cone.d2k * (dangle * dangle) + cone.dk * d2angle);
        WithDerivatives {
            value: YieldParameters { alpha: cone.alpha, kappa: cone.k * c },
            slope: YieldParameters { alpha: cone.dalpha * dangle, kappa: dk * c + cone.k * dc },
            curvature: YieldParameters {
                alpha: cone.d2alpha * (dangle * dangle) + cone.dalpha * d2angle,
                kappa: d2k * c + 2.0 * (dk * dc) + cone.k * d2c,
            },
        }
    }
}

/// The table: the surface at any plastic strain.
#[derive(Clone, Debug, PartialEq)]
pub struct Surface {
    /// Ranges of plastic strain without jumps and kinks, in ascending order. Where the surface jumps at plastic strain 0, the first piece is that point alone.
    pieces: Vec<Piece>,
    /// The surface from `settled` on.
    last: YieldParameters,
    /// Plastic strain from which on the surface is constant.
    settled: f64,
}

/// Plastic strains from `start` to `end`, the end included, in cells of equal width.
#[derive(Clone, Debug, PartialEq)]
struct Piece {
    start: f64,
    end: f64,
    /// Width of a cell; 0 for a piece that is one point.
    width: f64,
    /// 1/width.
    per_width: f64,
    cells: Vec<Cell>,
}

/// Coefficients of the polynomials in the coordinate 0..1 within the cell, the constant term first.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Cell([YieldParameters; 6]);

/// A point of the table: one plastic strain, with the cell that it lies in.
#[derive(Clone, Copy)]
pub struct SurfacePoint<'a> {
    piece: &'a Piece,
    cell: &'a Cell,
    plastic: f64,
    /// Coordinate within the cell, 0..1.
    x: f64,
}

impl Surface {
    pub fn new(definition: &SurfaceDefinition) -> Surface {
        let SurfaceDefinition { cone, friction, cohesion } = definition;
        let mut ends: Vec<f64> = friction.ends().chain(cohesion.ends()).collect();
        ends.sort_by(f64::total_cmp);
        ends.dedup();
        let mut pieces = Vec::with_capacity(ends.len() + 1);
        let mut start = 0.0;
        for end in ends {
            // what is narrower takes the value with which the next piece starts
            if end - start > NARROW * (1.0 + end) {
                pieces.push(Piece::new(definition, start, end));
            }
            start = end;
        }
        let of_last = cone.at(friction.last());
        let last = YieldParameters { alpha: of_last.alpha, kappa: of_last.k * cohesion.last() };
        let initial = definition.at(0.0);
        if initial.value != pieces.first().map_or(last, |first| first.at(0.0).value()) {
            pieces.insert(0, Piece::of_start(initial));
        }
        Surface { pieces, last, settled: start }
    }

    /// Plastic strain from which on the surface is constant.
    #[inline]
    pub fn settled(&self) -> f64 {
        self.settled
    }

    /// The final surface.
    #[inline]
    pub fn last(&self) -> YieldParameters {
        self.last
    }

    /// The point of the table at a plastic strain; `None` where the surface is constant.
    #[inline]
    pub fn point(&self, plastic: f64) -> Option<SurfacePoint<'_>> {
        if plastic >= self.settled {
            return None;
        }
        self.pieces.iter().find(|piece| plastic <= piece.end).map(|piece| piece.at(plastic))
    }

    /// The surface at a plastic strain.
    #[inline]
    pub fn value(&self, plastic: f64) -> YieldParameters {
        self.point(plastic).map_or(self.last, |point| point.value())
    }
}

impl Piece {
    /// A piece with so many cells that the error is below `CLOSE` times the largest value, or with `MOST`.
    fn new(definition: &SurfaceDefinition, start: f64, end: f64) -> Piece {
        const CLOSE: f64 = 1e-12;
        const MOST: u32 = 4096;
        let mut cells = 64;
        loop {
            let piece = Piece::of_cells(definition, start, end, cells);
            if cells >= MOST || piece.error(definition) <= CLOSE {
                return piece;
            }
            cells *= 2;
        }
    }

    fn of_cells(definition: &SurfaceDefinition, start: f64, end: f64, cells: u32) -> Piece {
        let width = (end - start) / f64::from(cells);
        // at a jump the values are those on this side of it
        let node = |k: u32| definition.at((start + f64::from(k) * width).clamp(start.next_up(), end.next_down()));
        let nodes: Vec<WithDerivatives> = (0..=cells).map(node).collect();
        let cells = nodes.windows(2).map(|w| Cell::between(&w[0], &w[1], width)).collect();
        Piece { start, end, width, per_width: 1.0 / width, cells }
    }

    /// A piece that is the plastic strain 0 alone.
    fn of_start(initial: WithDerivatives) -> Piece {
        let none = YieldParameters::default();
        let cell = Cell([initial.value, initial.slope, none, none, none, none]);
        Piece { start: 0.0, end: 0.0, width: 0.0, per_width: 1.0, cells: vec![cell] }
    }

    /// Largest error of the polynomials over the largest value, sampled at three points of each cell.
    fn error(&self, definition: &SurfaceDefinition) -> f64 {
        let (mut error, mut most) = (YieldParameters::default(), YieldParameters::default());
        for k in 0..self.cells.len() {
            for part in [0.25, 0.5, 0.75] {
                let plastic = self.start + (k as f64 + part) * self.width;
                let (is, should) = (self.at(plastic).value(), definition.at(plastic).value);
                error.alpha = error.alpha.max((is.alpha - should.alpha).abs());
                error.kappa = error.kappa.max((is.kappa - should.kappa).abs());
                most.alpha = most.alpha.max(should.alpha);
                most.kappa = most.kappa.max(should.kappa);
            }
        }
        (error.alpha / most.alpha.max(f64::MIN_POSITIVE)).max(error.kappa / most.kappa.max(f64::MIN_POSITIVE))
    }

    #[inline]
    fn at(&self, plastic: f64) -> SurfacePoint<'_> {
        let cells = ((plastic - self.start) * self.per_width).max(0.0);
        let k = (cells as usize).min(self.cells.len() - 1);
        SurfacePoint { piece: self, cell: &self.cells[k], plastic, x: cells - k as f64 }
    }
}

impl Cell {
    /// The polynomial with given values and first and second derivatives at both ends (Hermite interpolation).
    fn between(a: &WithDerivatives, b: &WithDerivatives, width: f64) -> Cell {
        let of = |of: fn(&YieldParameters) -> f64| {
            let (value, slope, curvature) = (of(&a.value), width * of(&a.slope), width * (width * of(&a.curvature)));
            // at the end, what the Taylor polynomial of second degree about the start misses
            let value_left = of(&b.value) - value - slope - 0.5 * curvature;
            let slope_left = width * of(&b.slope) - slope - curvature;
            let curvature_left = width * (width * of(&b.curvature)) - curvature;
            let third = 10.0 * value_left - 4.0 * slope_left + 0.5 * curvature_left;
            let fourth = -15.0 * value_left + 7.0 * slope_left - curvature_left;
            let fifth = 6.0 * value_left - 3.0 * slope_left + 0.5 * curvature_left;
            let terms = [value, slope, 0.5 * curvature, third, fourth, fifth];
            // linear where the terms overflow, in very wide cells
            if terms.iter().all(|c| c.is_finite()) { terms } else { [value, of(&b.value) - value, 0.0, 0.0, 0.0, 0.0] }
        };
        let (alpha, kappa) = (of(|s| s.alpha), of(|s| s.kappa));
        Cell(std::array::from_fn(|k| YieldParameters { alpha: alpha[k], kappa: kappa[k] }))
    }
}

impl SurfacePoint<'_> {
    /// The point at a plastic strain larger by `by`, with the polynomial of the same cell, which is as accurate up to an eighth of a cell beyond its end. `None`
    /// for more than an eighth of a cell, backwards, and across a jump.
    #[inline]
    pub fn advanced_by(self, by: f64) -> Option<Self> {
        let near = by >= 0.0 && by <= 0.125 * self.piece.width && self.plastic + by <= self.piece.end;
        near.then_some(SurfacePoint { plastic: self.plastic + by, x: self.x + by * self.piece.per_width, ..self })
    }

    /// The surface at this point.
    #[inline]
    pub fn value(&self) -> YieldParameters {
        let Cell([a, b, c, d, e, f]) = self.cell;
        let x = self.x;
        let of = |a: f64, b: f64, c: f64, d: f64, e: f64, f: f64| a + x * (b + x * (c + x * (d + x * (e + x * f))));
        YieldParameters {
            alpha: of(a.alpha, b.alpha, c.alpha, d.alpha, e.alpha, f.alpha),
            kappa: of(a.kappa, b.kappa, c.kappa, d.kappa, e.kappa, f.kappa),
        }
    }

    /// Its derivative with respect to the plastic strain.
    #[inline]
    pub fn slope(&self) -> YieldParameters {
        let Cell([_, b, c, d, e, f]) = self.cell;
        let (x, per_width) = (self.x, self.piece.per_width);
        let of = |b: f64, c: f64, d: f64, e: f64, f: f64| {
            per_width * (b + x * (2.0 * c + x * (3.0 * d + x * (4.0 * e + x * (5.0 * f)))))
        };
        YieldParameters {
            alpha: of(b.alpha, c.alpha, d.alpha, e.alpha, f.alpha),
            kappa: of(b.kappa, c.kappa, d.kappa, e.kappa, f.kappa),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::evolution::tests::LI;
    use super::*;

    fn definitions() -> Vec<SurfaceDefinition> {
        let softening = Evolution::Linear { initial: 3e4, last: 1e3, strain: 0.013 };
        let mut out = Vec::new();
        for cone in [Cone::Outer, Cone::Inner, Cone::PlaneStrain] {
            for friction in [LI, Evolution::Linear { initial: 0.3, last: 0.7, strain: 0.1 }, Evolution::Constant(0.5)] {
                for cohesion in [softening, Evolution::Constant(2e3), Evolution::Constant(0.0)] {
                    out.push(SurfaceDefinition { cone, friction, cohesion });
                }
            }
        }
        out
    }

    fn close(a: YieldParameters, b: YieldParameters, within: f64) -> bool {
        (a.alpha - b.alpha).abs() <= within * b.alpha.abs() && (a.kappa - b.kappa).abs() <= within * b.kappa.abs()
    }

    #[test]
    fn it_is_the_surface_of_the_angle_and_the_cohesion() {
        for definition in definitions() {
            let surface = Surface::new(&definition);
            let settled = surface.settled();
            for k in 0..=20_000 {
                let plastic = 1.1 * settled * f64::from(k) / 20_000.0;
                let (is, should) = (surface.value(plastic), definition.at(plastic));
                assert!(close(is, should.value, 1e-11), "{definition:?} {plastic}: {is:?} {should:?}");
                let Some(point) = surface.point(plastic) else { continue };
                let (is, should) = (point.slope(), should.slope);
                let (a, k) = ((is.alpha - should.alpha).abs(), (is.kappa - should.kappa).abs());
                assert!(a < 1e-7 * (1.0 + should.alpha.abs()) && k < 1e-7 * (1.0 + should.kappa.abs()), "{definition:?} {plastic}");
            }
        }
    }

    /// Jumps stay where they are, to the last bit of the plastic strain, and no place goes over one.
    #[test]
    fn jumps_are_kept() {
        let definition = SurfaceDefinition { cone: Cone::Outer, friction: LI, cohesion: Evolution::Constant(2e3) };
        let surface = Surface::new(&definition);
        let peak: f64 = 0.022;
        for plastic in [0.0, 5e-324, 1e-300, peak.next_down(), peak, peak.next_up(), surface.settled()] {
            assert!(close(surface.value(plastic), definition.at(plastic).value, 1e-13), "{plastic}");
        }
        assert!(!close(surface.value(0.0), surface.value(5e-324), 1e-3));
        assert!(!close(surface.value(peak), surface.value(peak.next_up()), 1e-3));
        let point = surface.point(peak - 1e-7).expect("a surface that changes");
        assert!(point.advanced_by(0.9e-7).is_some() && point.advanced_by(1.1e-7).is_none() && point.advanced_by(-1e-9).is_none());
        assert!(surface.point(0.0).expect("a surface that changes").advanced_by(1e-12).is_none());
    }

    /// An eighth of a cell beyond its end a polynomial is as close as within, and no place goes further.
    #[test]
    fn a_place_goes_on_beyond_its_cell() {
        for definition in definitions() {
            for piece in &Surface::new(&definition).pieces {
                for k in 0..piece.cells.len().saturating_sub(1) {
                    let plastic = piece.start + (k as f64 + 1.0 - 1e-9) * piece.width;
                    let point = piece.at(plastic);
                    assert!(std::ptr::eq(point.cell, &piece.cells[k]));
                    let by = 0.1249 * piece.width;
                    let on = point.advanced_by(by).expect("a point within reach").value();
                    assert!(close(on, definition.at(plastic + by).value, 1e-12), "{definition:?} {plastic}");
                    assert!(point.advanced_by(0.1251 * piece.width).is_none());
                }
            }
        }
    }

    /// Ends beside each other; parts too narrow to be seen, and very wide ones.
    #[test]
    fn extreme_evolutions_have_a_surface() {
        let linear = |strain: f64| Evolution::Linear { initial: 3e4, last: 1e3, strain };
        let eq_43 = |peak_strain: f64, decay: f64| match LI {
            Evolution::CubicExponential { initial, peak, residual, .. } => {
                Evolution::CubicExponential { initial, cubic: [0.0, 0.0, 0.0, 0.4], peak_strain, peak, residual, decay }
            }
            _ => unreachable!(),
        };
        for friction in [eq_43(0.022, 50.0), eq_43(1e-70, 50.0), eq_43(0.022, 1e-200), eq_43(0.022, 1e200), eq_43(30.0, 1e-9)] {
            for cohesion in [linear(0.022f64.next_up()), linear(1e-300), linear(0.8), linear(1e200)] {
                let definition = SurfaceDefinition { cone: Cone::Outer, friction, cohesion };
                let surface = Surface::new(&definition);
                for plastic in [0.0, 1e-8, 1e-5, 0.0219, 0.0221, 0.3, 31.0, 1e6] {
                    let (is, should) = (surface.value(plastic), definition.at(plastic).value);
                    assert!(close(is, should, 1e-9), "{definition:?} {plastic}: {is:?} {should:?}");
                }
            }
        }
    }

    /// What changes over no strain at all jumps at the start.
    #[test]
    fn a_brittle_law_keeps_its_strength_until_it_yields() {
        let cohesion = Evolution::Linear { initial: 3e4, last: 1e3, strain: 1e-10 };
        let definition = SurfaceDefinition { cone: Cone::Outer, friction: Evolution::Constant(0.5), cohesion };
        let surface = Surface::new(&definition);
        assert_eq!(surface.value(0.0), definition.at(0.0).value);
        assert_eq!(surface.value(1e-9), definition.at(1e-9).value);
        // a peak and a decay that nobody can see
        let cubic = [0.0, 0.0, 0.0, 0.4];
        let friction =
            Evolution::CubicExponential { initial: 0.4, cubic, peak_strain: 5e-10, peak: 0.5, residual: 0.3, decay: 3e10 };
        let definition = SurfaceDefinition { cone: Cone::Outer, friction, cohesion: Evolution::Constant(1e3) };
        let surface = Surface::new(&definition);
        for plastic in [0.0, 1e-11, 4e-10, 6e-10, 1e-9, 2e-9, 1e-3] {
            let alpha = surface.value(plastic).alpha;
            // between the residual angle and the peak
            assert!(alpha >= Cone::Outer.at(0.3).alpha && alpha <= Cone::Outer.at(0.5).alpha, "{plastic}: {alpha}");
        }
    }

    #[test]
    fn what_stays_has_no_table() {
        let definition =
            SurfaceDefinition { cone: Cone::Inner, friction: Evolution::Constant(0.4), cohesion: Evolution::Constant(1e3) };
        let surface = Surface::new(&definition);
        assert!(surface.pieces.is_empty() && surface.settled() == 0.0 && surface.value(0.0) == definition.at(0.0).value);
    }
}
