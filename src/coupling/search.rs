//! Which points are near which surface.

use super::{Body, Ghost, Ghosts};
use crate::boundary::Wall;
use crate::contact::pairs::Touch;
use crate::grains::Grains;
use crate::mpm::Continuum;
use crate::mpm::platen::ghost_radius;
use serde::{Deserialize, Serialize};

/// A body and a point further apart than a skin are not looked at until one of them has gone so far. Least and most of it, in cells: a wide skin
/// brings many that do not touch, a narrow one many searches.
const SKIN: [f64; 2] = [0.02, 0.25];
/// Steps that a list should last.
const STEPS: f64 = 100.0;
/// Share of the skin that may be used up: places ahead of time are guesses.
const TRUST: f64 = 0.5;
/// Not a place.
pub(crate) const NOWHERE: u32 = u32::MAX;

/// How long a list of who is near whom stays good. What it lists beyond those in touch changes no bit of a result.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(crate) struct Age {
    skin: f64,
    /// Way that a body and a point may have gone towards each other since the search, m.
    travelled: f64,
    /// Bodies and points alive then.
    searched: [usize; 2],
}

impl Age {
    /// The skin, m, of the search that is due where something may have come into reach since the last one. `way`: how much nearer a body and another
    /// may have come since the last call, m.
    pub fn due(&mut self, way: f64, alive: [usize; 2], cell: f64) -> Option<f64> {
        self.travelled += way;
        // a broken grain leaves its place to a daughter, and more than one daughter comes
        if self.searched == alive && self.travelled <= TRUST * self.skin {
            return None;
        }
        let [least, most] = SKIN.map(|share| share * cell);
        *self = Age { skin: (STEPS / TRUST * way).clamp(least, most), travelled: 0.0, searched: alive };
        Some(self.skin)
    }

    /// A search is due.
    pub fn forget(&mut self) {
        self.searched = [usize::MAX; 2];
    }
}

impl Ghosts {
    /// Makes the list anew where something may have come into reach since the last search, and finds everybody's present index. `way`: how much
    /// nearer a point and a surface may have come since the last call, m.
    pub(super) fn update(&mut self, grains: &Grains, walls: &[Wall], continuum: &Continuum, way: f64) {
        let alive = [grains.len(), continuum.points().len()];
        match self.age.due(way, alive, continuum.settings().cell) {
            Some(skin) => self.search(grains, walls, continuum, skin),
            None => self.locate(grains, continuum),
        }
    }

    /// Forgets all contacts.
    pub(super) fn clear(&mut self) {
        self.near.clear();
    }

    fn search(&mut self, grains: &Grains, walls: &[Wall], continuum: &Continuum, skin: f64) {
        let (points, dimension) = (continuum.points(), continuum.settings().dimension);
        let most = (0..points.len()).map(|i| points.solid(i)).fold(0.0, f64::max);
        let reach = ghost_radius(dimension, most) + skin;
        let mut found: Vec<Ghost> = Vec::new();
        let mut near = |body: Body, place: u32, i: usize| {
            let radius = ghost_radius(dimension, points.solid(i));
            let (point, mass) = (points.id[i], points.velocity[i][3]);
            let (touch, none) = (Touch::default(), [0.0; 3]);
            found.push(Ghost {
                body,
                point,
                place: [place, i as u32],
                law: points.law[i],
                radius,
                mass,
                touch,
                spring: none,
                stiffness: [0.0; 2],
                reference: 0.0,
            });
        };
        for (g, p) in grains.pos.iter().enumerate() {
            let far = p[3] + reach;
            let corners = [-far, far].map(|by| std::array::from_fn(|a| p[a] + by));
            continuum.visit(corners, |i| {
                let q = points.position[i];
                let d: [f64; 3] = std::array::from_fn(|a| q[a] - p[a]);
                if d[0] * d[0] + d[1] * d[1] + d[2] * d[2] < far * far {
                    near(Body::Grain(grains.id[g]), g as u32, i);
                }
            });
        }
        for (k, wall) in walls.iter().enumerate() {
            for (i, &[x, y, z, _]) in points.position.iter().enumerate() {
                if wall.shape.towards([x, y, z, 0.0]).1 < reach {
                    near(Body::Wall(k as u32), k as u32, i);
                }
            }
        }
        found.sort_unstable_by_key(|g| (g.body, g.point));
        let known = self.near.iter().filter(|g| g.touch.overlap > 0.0 || g.reference > 0.0);
        let keep = |old: &Ghost, new: &mut Ghost| {
            (new.touch, new.spring, new.reference) = (old.touch, old.spring, old.reference);
        };
        remember(known, &mut found, |g| (g.body, g.point), keep);
        if let Some(born) = &mut self.newborn {
            let new = |g: &Ghost| g.point >= born.points || matches!(g.body, Body::Grain(id) if id >= born.grains);
            for g in found.iter_mut().filter(|g| g.point >= born.first && new(g)) {
                g.reference = f64::INFINITY;
            }
            (born.grains, born.points) = (grains.next_id, points.next_id);
        }
        self.near = found;
    }

    /// Present indices of grains and points, whose arrays may have been put in another order.
    fn locate(&mut self, grains: &Grains, continuum: &Continuum) {
        let points = continuum.points();
        let [by_grain, by_point] = &mut self.index;
        let (mut grain_moved, mut point_moved) = (false, false);
        for g in &self.near {
            grain_moved |= matches!(g.body, Body::Grain(id) if grains.id.get(g.place[0] as usize) != Some(&id));
            point_moved |= points.id.get(g.place[1] as usize) != Some(&g.point);
        }
        if grain_moved {
            by_id(by_grain, &grains.id, grains.next_id);
            for g in &mut self.near {
                if let Body::Grain(id) = g.body {
                    g.place[0] = by_grain[id as usize];
                }
            }
            // those that are no more; their daughters are found in a search
            self.near.retain(|g| g.place[0] != NOWHERE);
        }
        if point_moved {
            by_id(by_point, &points.id, points.next_id);
            for g in &mut self.near {
                g.place[1] = by_point[g.point as usize];
            }
        }
    }
}

/// Contacts that are found again keep what they remember; both lists are in the order of `key`.
pub(crate) fn remember<'a, T: 'a, K: Ord>(
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

/// Index of each identity.
pub(crate) fn by_id(index: &mut Vec<u32>, ids: &[u32], next: u32) {
    index.clear();
    index.resize(next as usize, NOWHERE);
    for (i, &id) in ids.iter().enumerate() {
        index[id as usize] = i as u32;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
