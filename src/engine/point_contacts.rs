//! Shared by all contacts of material points (with grains, walls and rigid bodies): contact parameters, their bound on the time step, and the age of
//! a list of candidates.

use crate::boundary::Wall;
use crate::check::{self, Checked};
use crate::contact::ContactLaw;
use crate::contact::pair::{Pair, PairTable};
use crate::material::{InterfaceFriction, Material};
use crate::math::vector::{dot, less, scaled};
use crate::mpm::Continuum;
use serde::{Deserialize, Serialize};

/// Smallest and largest skin of a candidate list, in cells of the grid. The list holds pairs whose gap is below the skin; it stays valid until two
/// bodies may have come closer by that much. A wide skin lists many pairs that do not touch; a narrow one needs many searches.
const SKIN: [f64; 2] = [0.02, 0.25];
/// Steps for which a list should stay valid: the skin is chosen for it.
const STEPS: f64 = 100.0;
/// Share of the skin that may be used up before the next search; the rest is a reserve, as positions extrapolated in time are guesses.
const TRUST: f64 = 0.5;
/// Index that stands for "no such grain or point any more".
pub const NOWHERE: u32 = u32::MAX;

/// Age of a list of candidates: tells when the list has to be made again. Listed pairs that do not touch change no bit of a result.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Age {
    /// Skin of the present list, m; 0 before the first search.
    skin: f64,
    /// Distance by which a body and a point may have come closer since the search, m.
    travelled: f64,
    /// Numbers of bodies and of points at the search.
    searched: [usize; 2],
}

impl Age {
    /// Skin, m, for a new search if one is due now, else `None`. A search is due when a pair outside of the list may touch, or when the numbers of bodies
    /// and points (`alive`) have changed. `way`: distance by which a body and a point may have come closer since the last call, m; `cell`: edge of
    /// a cell, m.
    pub fn due(&mut self, way: f64, alive: [usize; 2], cell: f64) -> Option<f64> {
        self.travelled += way;
        // a breakage changes the number of grains: the first daughter takes the index of the broken grain, the others are added
        if self.skin > 0.0 && self.searched == alive && self.travelled <= TRUST * self.skin {
            return None;
        }
        let [least, most] = SKIN.map(|cells| cells * cell);
        *self = Age { skin: (STEPS / TRUST * way).clamp(least, most), travelled: 0.0, searched: alive };
        Some(self.skin)
    }

    /// Skin of the present list, m.
    pub fn skin(&self) -> f64 {
        self.skin
    }

    /// Whether the list may stand as it is at the next call of [`Self::due`], with so many bodies and points.
    pub fn may_stand(&self, alive: [usize; 2]) -> bool {
        self.searched == alive
    }

    /// Checks the two distances.
    ///
    /// # Errors
    /// The one that is wrong.
    pub fn check(&self) -> Checked {
        check::not_negative("age of a list", [self.skin, self.travelled])
    }

    /// Makes a search due at the next call of [`Self::due`].
    pub fn forget(&mut self) {
        self.searched = [usize::MAX; 2];
    }
}

/// Where the force of a contact with a point acts on the continuum.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ActsOn {
    /// The face of the point ([`GhostFace`]), for slow tests: a ball that hits a ball of points of ten cells goes back with 4 % less of its speed when few faces bear it, with
    /// the centres 1 %.
    Face,
    /// The centre of the point (Li et al. 2023, eq. 29; Jiang et al. 2020, eqs 46, 47).
    #[default]
    Centre,
    /// The node that is nearest to the point: the scheme MPM-GRID of Jiang et al. 2020 (section 5.4), to compare with. What moves the node is not what the contact sees of the point, so
    /// contacts do not keep their energy.
    Node,
    /// The nodes that the points and rigid bodies both reach, where the two may not approach each other ([`crate::mpm::BodyPoint`]): the scheme MPM-DEM of the same section. Points then
    /// touch no rigid body by themselves.
    MutualNodes,
}

/// The face of a point's ghost on which a body presses: where the force acts on the material, and what the contact's overlap is measured from.
///
/// At the first touch it lies on the line from the point to the body, a ghost radius from the point (Li et al. 2023, eq. 22). From then on it moves with
/// the nodes, as the face under a loading plate does ([`crate::mpm::loading_plate`]): material between the face and the centre of the point may be
/// pressed together. With the force at the centre everything within a spline's reach of the centre, up to 1.5 cells from it, moves with the body, and
/// grains act as if they were wider by more than a cell.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct GhostFace {
    /// Unit normal from the body to the point.
    pub normal: [f64; 3],
    /// Distance of the face from the centre of the point, less the ghost radius, m; at most [`GhostFace::FURTHEST`].
    pub beyond: f64,
    /// Velocity of the face, m/s.
    pub velocity: [f64; 3],
}

impl GhostFace {
    /// How far the face may be beyond the ghost, cells. Material between the two that has expanded by as much is torn: the face comes away from the body.
    pub const FURTHEST: f64 = 1.0;

    /// The face of a point at the first touch.
    pub fn at_first_touch(normal: [f64; 3], transport_velocity: [f64; 3]) -> GhostFace {
        GhostFace { normal, beyond: 0.0, velocity: transport_velocity }
    }

    /// From the centre of the point to where the force acts, m: the middle of the overlap, as for the grain (Li et al. 2023, eq. 27), but no further than
    /// half a cell. `radius`: ghost radius, m.
    pub fn offset(&self, radius: f64, overlap: f64, cell: f64) -> [f64; 3] {
        scaled(self.normal, -(radius + self.beyond - 0.5 * overlap).clamp(0.0, 0.5 * cell))
    }

    /// Moves the face with the nodes by a step of the continuum of `dt` seconds, which has just been made. `point`: index of the point.
    pub fn follow(&mut self, continuum: &Continuum, point: usize, [radius, overlap]: [f64; 2], dt: f64) {
        let cell = continuum.settings().cell;
        self.velocity = continuum.velocity_beside(point, self.offset(radius, overlap, cell));
        let way = dt * dot(less(continuum.points().transport_velocity[point], self.velocity), self.normal);
        self.beyond = (self.beyond + way).min(Self::FURTHEST * cell);
    }

    /// Pushes point `point` for the next step: at the face if it has one, else as `acts_on` says. `touch`: ghost radius and overlap, m.
    pub fn push(
        (acts_on, face): (ActsOn, Option<GhostFace>),
        touch: [f64; 2],
        continuum: &mut Continuum,
        point: usize,
        force: [f64; 3],
        stiffness: f64,
    ) {
        match (face, acts_on) {
            (Some(face), _) => {
                let offset = face.offset(touch[0], touch[1], continuum.settings().cell);
                continuum.add_force_beside(point, force, stiffness, offset);
            }
            (None, ActsOn::Node) => {
                let offset = continuum.nearest_node(point);
                continuum.add_force_beside(point, force, stiffness, offset);
            }
            (None, ActsOn::Face | ActsOn::Centre | ActsOn::MutualNodes) => continuum.add_external_force(point, force, stiffness),
        }
    }

    /// All its numbers.
    pub fn numbers(&self) -> impl Iterator<Item = f64> {
        self.normal.into_iter().chain(self.velocity).chain([self.beyond])
    }
}

/// Largest sums of contact stiffness over mass, 1/s², each as if the other end of every contact stood still: what contacts of points ask of
/// the time step.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ContactRates {
    /// The largest sum over the contacts of one point.
    pub points: f64,
    /// The largest sum over the contacts of one grain or rigid body with points (rotation included).
    pub grains: f64,
}

impl ContactRates {
    /// Factors 1 + ε and 1 + 1/ε by which a contact's stiffness counts at the point and at the grain, with ε = 2. The energy of a contact is then
    /// bounded by energies of its two ends alone: k (u_p − u_g)² ≤ (1 + ε) k u_p² + (1 + 1/ε) k u_g² holds for every ε > 0. The point gets the larger
    /// factor, as nodes spread its stiffness over the masses of its neighbours ([`Continuum::contact_frequency_bound`]).
    ///
    /// [`Continuum::contact_frequency_bound`]: crate::mpm::Continuum::contact_frequency_bound
    pub const END_SHARES: [f64; 2] = [3.0, 1.5];

    /// Bound on the square of a frequency, 1/s², if every point moved by itself: 1 + ε times the sum over its contacts with grains, plus the largest
    /// rate of the loading plates, `plates`, 1/s².
    pub fn isolated_bound(&self, plates: f64) -> f64 {
        Self::END_SHARES[0] * self.points + plates
    }

    /// What contacts add at most to the square of a frequency, 1/s². `plates`: largest rate of the loading plates, 1/s².
    ///
    /// `bound_ratio`: the bound at the nodes over [`Self::isolated_bound`], for tests in which contacts need only be stable. `None`: contacts are to be resolved
    /// as in an impact; points then count as isolated, and the best ε, `grains` / `points`, makes both ends equal.
    pub fn frequency2(&self, plates: f64, bound_ratio: Option<f64>) -> f64 {
        match bound_ratio {
            Some(ratio) => (ratio * self.isolated_bound(plates)).max(Self::END_SHARES[1] * self.grains),
            None => self.points + self.grains + plates,
        }
    }
}

/// Contact parameters between material points and grains or walls. A point touches as a grain of the fines that it stands for; its friction on grains and rigid
/// bodies is that of its material as a continuum, where that is given ([`Material::interface_friction`]).
#[derive(Clone, Debug)]
pub struct PointContactTable {
    /// Contact law of all point contacts.
    pub law: ContactLaw,
    /// Where the forces of contacts with grains and rigid bodies act.
    pub acts_on: ActsOn,
    /// Pair of each constitutive law (outer) with each material of grains (inner).
    grains: Vec<Vec<Pair>>,
    /// Friction on grains and rigid bodies of each constitutive law that changes with plastic strain; empty where none does.
    softening: Vec<Option<InterfaceFriction>>,
    /// Pair of each wall (outer) with each constitutive law (inner); empty where points do not touch the grains' walls.
    walls: Vec<Vec<Pair>>,
}

impl PointContactTable {
    /// Table for the contact law `law`. `fines`: index into `materials` of the fines' grains, for each constitutive law of the continuum; `walls`: the
    /// walls of the grains that points touch as well.
    pub fn new(law: ContactLaw, fines: &[u8], materials: &[Material], walls: &[Wall]) -> PointContactTable {
        let material = |m: &u8| &materials[usize::from(*m)];
        let on_grain = |other: &Material, own: &Material| {
            let pair = law.between(other, own);
            Pair { friction: own.interface_friction.map_or(pair.friction, |own| own.initial), ..pair }
        };
        let of_law = |m: &u8| materials.iter().map(|other| on_grain(other, material(m))).collect();
        let on_wall =
            |w: &Wall| fines.iter().map(|m| PairTable::on_wall(law.table().coefficients, material(m), w, materials)).collect();
        let softens = |m: &u8| material(m).interface_friction.filter(|friction| friction.decay > 0.0);
        let softening: Vec<Option<InterfaceFriction>> = fines.iter().map(softens).collect();
        PointContactTable {
            law,
            acts_on: ActsOn::default(),
            grains: fines.iter().map(of_law).collect(),
            softening: if softening.iter().any(Option::is_some) { softening } else { Vec::new() },
            walls: walls.iter().map(on_wall).collect(),
        }
    }

    /// The same table for contacts whose forces act elsewhere.
    #[must_use]
    pub fn acting_on(self, acts_on: ActsOn) -> PointContactTable {
        PointContactTable { acts_on, ..self }
    }

    /// Number of walls that points touch.
    pub fn touched_walls(&self) -> usize {
        self.walls.len()
    }

    /// Whether the friction of any constitutive law on grains and rigid bodies changes with plastic strain.
    #[inline(always)]
    pub fn softens(&self) -> bool {
        !self.softening.is_empty()
    }

    /// Friction of constitutive law `law` on grains and rigid bodies, where it changes with plastic strain.
    #[inline(always)]
    pub fn softening(&self, law: u8) -> Option<InterfaceFriction> {
        self.softening.get(usize::from(law)).copied().flatten()
    }

    /// Parameters of the contact of a point of constitutive law `law` with a grain of material `material`, before any plastic strain.
    pub fn of_grain(&self, law: u8, material: u8) -> &Pair {
        &self.grains[usize::from(law)][usize::from(material)]
    }

    /// Coefficient of friction of a contact whose parameters before any plastic strain are `pair`; `plastic`: looks up the plastic strain of the point, where it counts.
    #[inline(always)]
    pub fn friction(&self, law: u8, pair: &Pair, plastic: impl FnOnce() -> f64) -> f64 {
        self.softening(law).map_or(pair.friction, |softening| softening.at(plastic()))
    }

    /// As [`Self::of_grain`], with the friction at a plastic strain of the point.
    pub fn at_plastic_strain(&self, law: u8, material: u8, plastic: f64) -> Pair {
        let pair = *self.of_grain(law, material);
        Pair { friction: self.friction(law, &pair, || plastic), ..pair }
    }

    /// Parameters of the contact of a point of constitutive law `law` with wall `wall`.
    pub fn of_wall(&self, law: u8, wall: usize) -> &Pair {
        &self.walls[wall][usize::from(law)]
    }
}

/// Copies the history of contacts from an old list into a new one: `keep(old, new)` is called for each pair of entries with the same key. Both lists
/// are sorted by `key`.
pub fn remember<'a, T: 'a, K: Ord>(
    old: impl Iterator<Item = &'a T>,
    found: &mut [T],
    key: impl Fn(&T) -> K,
    keep: impl Fn(&T, &mut T),
) {
    let mut fresh = found.iter_mut().peekable();
    for old in old {
        while fresh.next_if(|new| key(new) < key(old)).is_some() {}
        if let Some(new) = fresh.next_if(|new| key(new) == key(old)) {
            keep(old, new);
        }
    }
}

/// Fills `index` with the position in `ids` of every identity below `next`; [`NOWHERE`] for identities that are no more.
pub fn by_id(index: &mut Vec<u32>, ids: &[u32], next: u32) {
    index.clear();
    index.resize(next as usize, NOWHERE);
    for (i, &id) in ids.iter().enumerate() {
        index[id as usize] = i as u32;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The friction of a continuum on grains replaces that of its grains; nothing else changes.
    #[test]
    fn a_continuum_has_a_friction_of_its_own_on_grains() {
        let of = |friction, interface_friction| Material {
            name: "any".into(),
            density: 2650.0,
            internal_porosity: 0.0,
            young: 1e9,
            poisson: 0.2,
            friction,
            contact: [0.0; 4],
            rolling_friction: 0.0,
            interface_friction,
        };
        let table = |own| PointContactTable::new(ContactLaw::Hertz, &[1], &[of(0.5, None), of(0.35, own)], &[]);
        let (grains, continuum) = (table(None), table(Some(InterfaceFriction::constant(0.1))));
        assert_eq!([grains.of_grain(0, 0).friction, continuum.of_grain(0, 0).friction], [0.35, 0.1]);
        assert_eq!(grains.of_grain(0, 0).normal_stiffness, continuum.of_grain(0, 0).normal_stiffness);
        let falling = table(Some(InterfaceFriction { initial: 0.2, residual: 0.08, decay: 20.0 }));
        assert_eq!([grains.softens(), continuum.softens(), falling.softens()], [false, false, true]);
        let at = |table: &PointContactTable, e| table.at_plastic_strain(0, 0, e);
        assert_eq!([0.0, 0.05].map(|e| at(&continuum, e)), [*continuum.of_grain(0, 0); 2]);
        assert_eq!(at(&falling, 0.0), Pair { friction: 0.2, ..*grains.of_grain(0, 0) });
        assert!((at(&falling, 0.05).friction - (0.08 + 0.12 * (-1f64).exp())).abs() < 1e-15);
    }

    #[test]
    fn a_list_is_used_no_longer_than_it_is_good() {
        let (mut age, cell, mut gone, mut skin, mut searches) = (Age::default(), 0.1, 0.0, 0.0, 0);
        for k in 0..10_000 {
            // at rest, ever faster, and at rest again
            let way = if k < 9000 { 1e-5 * f64::from(k / 1000) } else { 0.0 };
            gone += way;
            if let Some(new) = age.due(way, [3, 5], cell) {
                (skin, gone) = (new, 0.0);
                searches += 1;
                assert!((SKIN[0] * cell..=SKIN[1] * cell).contains(&skin), "{skin}");
            }
            assert!(gone <= TRUST * skin, "{gone} of {skin}");
        }
        assert!((60..=120).contains(&searches), "{searches} searches");
        assert_eq!(age.due(0.0, [3, 5], cell), None);
        assert!(age.due(0.0, [4, 5], cell).is_some(), "somebody has come");
        age.forget();
        assert!(age.due(0.0, [4, 5], cell).is_some());
    }
}
