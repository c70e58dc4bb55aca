//! The contacts of a mixture as plain lists, to be taken to a graphics device and back.

use super::{Body, Mixture, PointContact};
use crate::contact::ContactLaw;
use crate::contact::pair::{Pair, PairTable};
use crate::contact::pairs::{ContactForce, FREE, Kept, Pairs};
use crate::contact::sweep::r_eff;
use crate::dem::physics::Physics;
use crate::mpm::loading_plate::ghost_radius;
use crate::mpm::{Continuum, Dimension};
use crate::point_contacts::{ActsOn, GhostFace, PointContactTable};

/// A contact that touches, or that has a face.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ExchangedContact {
    /// Its two ends. Between grains: their numbers in the order of identities, the lower first. On a wall: number of the grain, index of the wall. Of a
    /// point: index of the grain or wall, index of the point.
    pub ends: [u32; 2],
    /// Force of the contact.
    pub touch: ContactForce,
    /// Tangential spring, N.
    pub spring: [f64; 3],
    /// Normal tangent stiffness, N/m.
    pub stiffness: f64,
    /// Of a point: the overlap that bears no force, m, finite.
    pub reference: f64,
    /// Of a point: the face on which the body presses.
    pub face: Option<GhostFace>,
}

/// All contacts of a mixture that touch, and those of points that have a face or an overlap without force still.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ExchangedContacts {
    /// Contacts between grains.
    pub grains: Vec<ExchangedContact>,
    /// Contacts of grains with walls.
    pub walls: Vec<ExchangedContact>,
    /// Contacts of points with grains and walls. A grain is given by its number in the order of identities.
    pub points: Vec<(Body, ExchangedContact)>,
}

/// Tangential over normal stiffness of a pair.
fn ratio(law: ContactLaw, pair: &Pair) -> f64 {
    pair.tangential_stiffness / if law.is_hertzian() { 1.5 * pair.normal_stiffness } else { pair.normal_stiffness }
}

impl Mixture {
    /// All contacts that touch or have a face or an overlap without force, with the forces that were computed last. `table`: parameters of contacts between grains and with walls.
    pub fn contacts(&self, physics: &Physics, table: &PairTable) -> ExchangedContacts {
        let (g, viscous) = (&self.grains.grains, physics.contact.law.is_viscous());
        let mut place = vec![0; g.len()];
        for (k, i) in (0..).zip(g.by_id()) {
            place[i as usize] = k;
        }
        let of = |pairs: &Pairs, ends: &dyn Fn([u32; 2]) -> [u32; 2], of_pair: &dyn Fn([usize; 2]) -> (f64, Pair)| {
            let touching = |s: &usize| pairs.ends[*s][0] != FREE && pairs.touch[*s].overlap > 0.0;
            let contact = |s: usize| {
                let (touch, (r_eff, pair)) = (pairs.touch[s], of_pair(pairs.ends[s].map(|i| i as usize)));
                let stiffness = physics.contact.law.elastic(touch.overlap, touch.overlap, r_eff, &pair).k_n;
                let (ends, spring) = (ends(pairs.ends[s]), pairs.spring(s));
                ExchangedContact { ends, touch, spring, stiffness, reference: 0.0, face: None }
            };
            (0..pairs.slots()).filter(touching).map(contact).collect()
        };
        let of_grains = |[i, j]: [usize; 2]| (r_eff(g.radius(i), g.radius(j)), *table.grains(g.material[i], g.material[j]));
        let of_point = |contact: &PointContact| {
            let body = match contact.body {
                Body::Grain(_) => Body::Grain(place[contact.place[0] as usize]),
                wall => wall,
            };
            let spring = if viscous { contact.spring } else { contact.touch.tangential };
            let PointContact { touch, reference, face, .. } = *contact;
            (body, ExchangedContact { ends: contact.place, touch, spring, stiffness: contact.stiffness[0], reference, face })
        };
        ExchangedContacts {
            grains: of(&self.grains.pairs, &|ends| ends.map(|i| place[i as usize]), &of_grains),
            walls: of(&self.grains.wall_pairs, &|[i, k]| [place[i as usize], k], &|[i, k]| {
                (g.radius(i), *table.wall(k, g.material[i]))
            }),
            points: self.point_contacts.candidates.with_history().map(of_point).collect(),
        }
    }

    /// Replaces all contacts by those that a device has computed for this instant; `dt`: the last step of the grains, s. The caller has to make the
    /// grains' neighbour lists anew.
    pub fn take_contacts(
        &mut self,
        physics: &Physics,
        table: &PointContactTable,
        continuum: &Continuum,
        contacts: &ExchangedContacts,
        dt: f64,
    ) {
        let order = self.grains.grains.by_id();
        let kept = self.grains.pairs.kept();
        let fill = |contacts: &[ExchangedContact], walls: bool| {
            let mut pairs = Pairs::new(Kept { ..kept });
            for c in contacts {
                let [i, k] = c.ends;
                let slot = pairs.add(order[i as usize], if walls { k } else { order[k as usize] }) as usize;
                pairs.touch[slot] = c.touch;
                if kept.spring {
                    pairs.spring[slot] = c.spring;
                }
            }
            pairs
        };
        let (mut pairs, mut wall_pairs) = (fill(&contacts.grains, false), fill(&contacts.walls, true));
        if kept.load {
            let (g, materials) =
                (&self.grains.grains, physics.contact.law.pairs(&physics.materials, &self.grains.walls, self.grains.friction));
            let weigh = |pairs: &mut Pairs, r_eff: &dyn Fn([usize; 2]) -> f64, pair: &dyn Fn([usize; 2]) -> Pair| {
                for s in 0..pairs.slots() {
                    let ends = pairs.ends[s].map(|i| i as usize);
                    let weight = pair(ends).e_eff / r_eff(ends);
                    pairs.load[s] = pairs.touch[s].normal_force * (weight * weight);
                }
            };
            let reduced = |[i, j]: [usize; 2]| g.radius(i) * g.radius(j) / (g.radius(i) + g.radius(j));
            weigh(&mut pairs, &reduced, &|[i, j]| *materials.grains(g.material[i], g.material[j]));
            weigh(&mut wall_pairs, &|[i, _]| g.radius(i), &|[i, k]| *materials.wall(k, g.material[i]));
        }
        (self.grains.pairs, self.grains.wall_pairs) = (pairs, wall_pairs);
        let points = continuum.points();
        let of_point = |(body, c): &(Body, ExchangedContact)| {
            let point = c.ends[1] as usize;
            let (body, place, pair) = match *body {
                Body::Grain(k) => {
                    let i = order[k as usize];
                    let g = &self.grains.grains;
                    (Body::Grain(g.id[i as usize]), i, table.of_grain(points.law[point], g.material[i as usize]))
                }
                Body::Wall(k) => (Body::Wall(k), k, table.of_wall(points.law[point], k as usize)),
            };
            PointContact {
                body,
                point: points.id[point],
                place: [place, c.ends[1]],
                law: points.law[point],
                radius: ghost_radius(Dimension::Space, points.solid(point)),
                mass: points.velocity[point][3],
                touch: c.touch,
                spring: if physics.contact.law.is_viscous() { c.spring } else { [0.0; 3] },
                stiffness: [c.stiffness, c.stiffness * ratio(physics.contact.law, pair)],
                reference: c.reference,
                face: c.face.filter(|_| table.acts_on == ActsOn::Face),
            }
        };
        let mut candidates: Vec<PointContact> = contacts.points.iter().map(of_point).collect();
        candidates.sort_unstable_by_key(|g| (g.body, g.point));
        self.point_contacts.candidates = candidates.into();
        // makes a search and a look at the grains' time step due
        self.point_contacts.forget();
        self.grains.births = true;
        (self.grains.dt, self.last) = (dt, dt);
    }
}
