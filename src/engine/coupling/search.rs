//! Search for candidates: points near the surface of a grain or wall.

use super::candidates::{Candidates, Side};
use super::{Body, PointContact, PointContacts};
use crate::boundary::Wall;
use crate::contact::pairs::ContactForce;
use crate::grains::Grains;
use crate::mpm::Continuum;
use crate::mpm::loading_plate::ghost_radius;
use crate::point_contacts::{NOWHERE, by_id, remember};

impl PointContacts {
    /// Makes the list of candidates anew if a pair outside of it may touch; else only brings the indices of grains and points up to date. `way`: distance by
    /// which a point and a surface may have come closer since the last call, m.
    pub(super) fn update(&mut self, grains: &Grains, walls: &[Wall], continuum: &Continuum, way: f64) {
        let alive = [grains.len(), continuum.points().len()];
        match self.age.due(way, alive, continuum.settings().cell) {
            Some(skin) => self.search(grains, walls, continuum, skin),
            None => self.locate(grains, continuum),
        }
    }

    /// Removes all candidates and contacts.
    pub(super) fn clear(&mut self) {
        self.candidates = Candidates::default();
    }

    /// Makes the list of candidates anew: all points that are nearer to a surface than the largest distance of a face plus `skin`, m. Contacts keep their
    /// history.
    fn search(&mut self, grains: &Grains, walls: &[Wall], continuum: &Continuum, skin: f64) {
        let (points, dimension) = (continuum.points(), continuum.settings().dimension);
        let most = (0..points.len()).map(|i| points.solid(i)).fold(0.0, f64::max);
        // a face may lie further from its point than the ghost radius
        let beyond = self.candidates.with_history().filter_map(|g| g.face).map(|face| face.beyond).fold(0.0, f64::max);
        let reach = ghost_radius(dimension, most) + beyond + skin;
        let mut found: Vec<PointContact> = Vec::new();
        let mut add = |body: Body, place: u32, i: usize| {
            let radius = ghost_radius(dimension, points.solid(i));
            let (point, mass) = (points.id[i], points.velocity[i][3]);
            let (touch, none) = (ContactForce::default(), [0.0; 3]);
            found.push(PointContact {
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
                face: None,
            });
        };
        for (g, p) in grains.pos.iter().enumerate() {
            let far = p[3] + reach;
            let corners = [-far, far].map(|by| std::array::from_fn(|a| p[a] + by));
            continuum.visit(corners, |i| {
                let q = points.position[i];
                let d: [f64; 3] = std::array::from_fn(|a| q[a] - p[a]);
                if d[0] * d[0] + d[1] * d[1] + d[2] * d[2] < far * far {
                    add(Body::Grain(grains.id[g]), g as u32, i);
                }
            });
        }
        for (k, wall) in walls.iter().enumerate() {
            for (i, &[x, y, z, _]) in points.position.iter().enumerate() {
                if wall.shape.towards([x, y, z, 0.0]).1 < reach {
                    add(Body::Wall(k as u32), k as u32, i);
                }
            }
        }
        found.sort_unstable_by_key(|g| (g.body, g.point));
        let known = self.candidates.with_history();
        let keep = |old: &PointContact, new: &mut PointContact| {
            (new.touch, new.spring, new.reference, new.face) = (old.touch, old.spring, old.reference, old.face);
        };
        remember(known, &mut found, |g| (g.body, g.point), keep);
        if let Some(born) = &mut self.newborn {
            let new = |g: &PointContact| g.point >= born.points || matches!(g.body, Body::Grain(id) if id >= born.grains);
            for g in found.iter_mut().filter(|g| g.point >= born.first && new(g)) {
                g.reference = f64::INFINITY;
            }
            (born.grains, born.points) = (grains.next_id, points.next_id);
        }
        self.candidates = found.into();
        self.candidates.note_located(Side::Grains, &grains.id);
        self.candidates.note_located(Side::Points, &points.id);
    }

    /// Brings the indices of grains and points up to date, whose arrays may have been sorted. Candidates of grains that have broken are removed.
    fn locate(&mut self, grains: &Grains, continuum: &Continuum) {
        self.locate_points(continuum);
        if self.candidates.are_located(Side::Grains, &grains.id) {
            return;
        }
        let [by_grain, _] = &mut self.index;
        let moved = |g: &PointContact| matches!(g.body, Body::Grain(id) if grains.id.get(g.place[0] as usize) != Some(&id));
        if self.candidates.iter().any(moved) {
            by_id(by_grain, &grains.id, grains.next_id);
            for g in self.candidates.iter_mut() {
                if let Body::Grain(id) = g.body {
                    g.place[0] = by_grain[id as usize];
                }
            }
            // grains that have broken; their daughters are found by the next search
            self.candidates.retain(|g| g.place[0] != NOWHERE);
        }
        self.candidates.note_located(Side::Grains, &grains.id);
    }

    /// Brings the indices of points up to date. Candidates of points that have been taken out are removed.
    pub(super) fn locate_points(&mut self, continuum: &Continuum) {
        let points = continuum.points();
        if self.candidates.are_located(Side::Points, &points.id) {
            return;
        }
        let [_, by_point] = &mut self.index;
        if self.candidates.iter().any(|g| points.id.get(g.place[1] as usize) != Some(&g.point)) {
            by_id(by_point, &points.id, points.next_id);
            for g in self.candidates.iter_mut() {
                g.place[1] = by_point[g.point as usize];
            }
            self.candidates.retain(|g| g.place[1] != NOWHERE);
        }
        self.candidates.note_located(Side::Points, &points.id);
    }
}
