//! The walls of a test of points as a program sees them: loading plates and fixed sides of a specimen; in a free scene the walls of the scene and the sides of the grid.

use super::grains::smooth;
use super::specimen::{at_side, face};
use super::{MpmTest, State, dimensions};
use crate::record::contacts;
use ::engine::boundary::{Drive, Wall, WallShape, WallSpec};
use ::engine::mpm::{GridWall, LoadingPlate};

/// Names of the sides of the grid, as in the keys of a scene.
const SIDES: [&str; 6] = ["x_low", "x_high", "y_low", "y_high", "z_low", "z_high"];

/// A wall, by the index that it has where it stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// A loading plate of a specimen.
    Plate(usize),
    /// A fixed side of a specimen: x low, x high, y low, …
    Fixed(usize),
    /// A wall of a free scene.
    Wall(usize),
    /// A side of the grid of a free scene.
    Grid(usize),
}

/// A wall at an instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SideNow {
    /// Shape and place.
    pub shape: WallShape,
    /// Speed towards the material, m/s.
    pub speed: f64,
    /// Normal force of all that presses on it, N, compression positive.
    pub force: f64,
    /// Sum of the z components of the tangential forces of grains on it, N.
    pub shear_z: f64,
    /// Work on points, grains and bodies, J.
    pub work: f64,
    /// Area on which the force is a stress, m² (m in plane strain); `None` where there is none.
    pub area: Option<f64>,
}

/// The wall of which a loading plate is the surface.
pub fn shape_of(plate: &LoadingPlate) -> WallShape {
    match plate.radius {
        Some(radius) => WallShape::Cylinder { centre: [plate.point[0], plate.point[1]], radius },
        None => WallShape::Plane { point: plate.point, normal: plate.normal },
    }
}

impl State {
    /// The walls with their names: of a specimen its fixed sides, then its loading plates, in the order of the grains' walls and named as in `contacts_*.csv`; of a free scene its walls, then the
    /// sides of the grid that hold points.
    pub fn walls(&self, rig: &MpmTest) -> Vec<(String, Side)> {
        if rig.specimen().is_none() {
            return self.of_free_scene(rig);
        }
        let fixed = (0..2 * dimensions(rig)).filter(|&k| at_side(rig, k).is_none()).map(Side::Fixed);
        let sides: Vec<Side> = fixed.chain((0..self.plates.len()).map(Side::Plate)).collect();
        let shaped = |side: &Side| Wall::new(&WallSpec { shape: self.wall(rig, *side).shape, ..smooth([0.0; 3], [0.0; 3]) });
        let walls: Vec<Wall> = sides.iter().map(shaped).collect();
        contacts::names(&walls, true).into_iter().zip(sides).collect()
    }

    fn of_free_scene(&self, rig: &MpmTest) -> Vec<(String, Side)> {
        let walls = self.mixture.as_ref().map_or(&[][..], |m| &m.grains.walls);
        let named = contacts::names(walls, false).into_iter().enumerate().map(|(k, name)| (name, Side::Wall(k)));
        let there = (0..2 * dimensions(rig)).filter(|&k| rig.settings.walls[k] != GridWall::Open);
        named.chain(there.map(|k| (SIDES[k].to_string(), Side::Grid(k)))).collect()
    }

    /// A wall at this instant, whose forces are known.
    pub fn wall(&self, rig: &MpmTest, side: Side) -> SideNow {
        let still = SideNow {
            shape: WallShape::Plane { point: [0.0; 3], normal: [0.0; 3] },
            speed: 0.0,
            force: 0.0,
            shear_z: 0.0,
            work: 0.0,
            area: None,
        };
        let inwards = |k: usize| {
            let mut normal = [0.0; 3];
            normal[k / 2] = [1.0, -1.0][k % 2];
            normal
        };
        match side {
            Side::Plate(k) => {
                let plate = &self.plates[k];
                // the last walls of the grains are the loading plates
                let behind = |m: &::engine::coupling::Mixture| {
                    let first = m.grains.walls.len().checked_sub(self.plates.len())?;
                    Some(m.grains.walls[first + k].work)
                };
                SideNow {
                    shape: shape_of(plate),
                    speed: plate.speed,
                    force: plate.force(),
                    work: plate.work + self.mixture.as_deref().and_then(behind).unwrap_or(0.0),
                    area: Some(face(rig, self.extents_now(rig), plate.axis())),
                    ..still
                }
            }
            Side::Fixed(k) => {
                let point = rig.specimen().map_or([0.0; 3], |s| {
                    std::array::from_fn(|a| s.lower[a] + if a == k / 2 && k % 2 == 1 { s.size[a] } else { 0.0 })
                });
                SideNow {
                    shape: WallShape::Plane { point, normal: inwards(k) },
                    force: self.on_side(rig, k),
                    area: Some(face(rig, self.extents_now(rig), k / 2)),
                    ..still
                }
            }
            Side::Grid(k) => {
                let settings = &rig.settings;
                let mut point = settings.lower;
                if k % 2 == 1 {
                    point[k / 2] += f64::from(settings.cells[k / 2]) * settings.cell;
                }
                SideNow { shape: WallShape::Plane { point, normal: inwards(k) }, force: self.on_grid_side(k), ..still }
            }
            Side::Wall(k) => {
                let Some(mixture) = &self.mixture else { return still };
                let wall = &mixture.grains.walls[k];
                let area = if let Drive::Stress { area, .. } = wall.drive { Some(area) } else { None };
                SideNow {
                    shape: wall.shape,
                    speed: wall.speed,
                    force: mixture.force_on_wall(k),
                    shear_z: wall.shear_z,
                    work: wall.work,
                    area,
                }
            }
        }
    }
}
