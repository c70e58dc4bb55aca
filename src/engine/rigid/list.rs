//! The contacts of rigid bodies, touching or near, in one order: body by body, of each those with points, grains and walls, then those with bodies of higher index. Sums over them are taken in it.

use super::BlockContact;
use super::contact::PosedBlock;
use super::near::Near;
use super::ways::Ways;
use crate::check::{Checked, ensure};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::borrow::Cow;

/// Pairs of one parallel task that adds up ways.
const MOVED: usize = 1024;

/// All contacts of rigid bodies.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(super) struct Contacts {
    /// Those with points, grains and walls, touching or not, in order.
    pub others: Vec<BlockContact>,
    /// Pairs of bodies that are near each other, in order.
    pub pairs: Vec<Near>,
    /// How the bodies have moved since the last look.
    #[serde(skip)]
    ways: Ways,
    /// Those that touch; `None` where they have to be looked for.
    #[serde(skip)]
    touching: Option<Vec<Place>>,
    /// The first that is too deep.
    #[serde(skip)]
    deep: Option<Place>,
}

/// Where a contact stands.
#[derive(Clone, Copy, Debug)]
enum Place {
    /// Index among the others.
    Other(u32),
    /// Indices of the pair and of the contact in it.
    Pair(u32, u32),
}

impl Contacts {
    /// Memory in use, bytes.
    pub fn bytes(&self) -> usize {
        size_of::<BlockContact>() * self.others.capacity()
            + self.pairs.iter().map(Near::bytes).sum::<usize>()
            + self.touching.as_ref().map_or(0, |touching| size_of::<Place>() * touching.capacity())
            + self.ways.bytes()
    }

    /// Checks the order of contacts that come from outside, and that those of a pair are of its bodies.
    ///
    /// # Errors
    /// What is wrong, in words.
    pub fn check(&self) -> Checked {
        let keys: Vec<_> = self.all().into_iter().map(BlockContact::key).collect();
        let pairs_sorted =
            self.pairs.windows(2).all(|w| w[0].bodies < w[1].bodies) && self.pairs.iter().all(|p| p.bodies[0] < p.bodies[1]);
        let others = self.others.iter().all(|c| c.other.partner_body().is_none());
        let of_pair =
            |pair: &Near| pair.contacts.iter().all(|c| (c.block, c.other.partner_body()) == (pair.bodies[0], Some(pair.bodies[1])));
        let ordered = pairs_sorted && others && self.pairs.iter().all(of_pair) && keys.is_sorted_by(|a, b| a < b);
        ensure(ordered, || "contacts of rigid bodies are not in their order".into())
    }

    /// Notes where the bodies are now: pairs whose bodies have moved against each other have done so.
    pub fn follow(&mut self, bodies: &[PosedBlock<'_>]) {
        let Contacts { pairs, ways, .. } = self;
        if ways.follow(bodies) {
            pairs.par_iter_mut().with_min_len(MOVED).for_each(|pair| pair.way += ways.between(pair.bodies));
        }
    }

    /// Forgets how far bodies have moved: some are others now.
    pub fn forget(&mut self) {
        self.ways = Ways::default();
        self.pairs.iter_mut().for_each(Near::forget);
        self.unlist();
    }

    /// Makes those that touch be looked for again: contacts have changed.
    pub fn unlist(&mut self) {
        self.touching = None;
    }

    /// Takes out contacts.
    pub fn retain(&mut self, stays: impl Fn(&BlockContact) -> bool) {
        self.others.retain(&stays);
        self.pairs.iter_mut().for_each(|pair| pair.contacts.retain(&stays));
        self.unlist();
    }

    /// Puts other contacts with points, grains and walls in the place of those before.
    pub fn replace_others(&mut self, others: Vec<BlockContact>) {
        self.others = others;
        self.unlist();
    }

    /// Lists the pairs of these bodies, in order. Those that were listed before keep what is known of them.
    pub fn list_pairs(&mut self, bodies: &[[usize; 2]]) {
        let mut before = std::mem::take(&mut self.pairs).into_iter().peekable();
        let listed = |&bodies: &[usize; 2]| {
            let new = Near::new(bodies);
            while before.next_if(|old| old.bodies < new.bodies).is_some() {}
            before.next_if(|old| old.bodies == new.bodies).unwrap_or(new)
        };
        self.pairs = bodies.iter().map(listed).collect();
        self.unlist();
    }

    /// Visits every contact with its place, in order.
    fn visit<'a>(&'a self, mut visit: impl FnMut(Place, &'a BlockContact)) {
        let mut others = (0..).zip(&self.others).peekable();
        for (n, pair) in (0..).zip(&self.pairs) {
            while let Some((k, c)) = others.next_if(|(_, c)| c.block <= pair.bodies[0]) {
                visit(Place::Other(k), c);
            }
            (0..).zip(&pair.contacts).for_each(|(k, c)| visit(Place::Pair(n, k), c));
        }
        others.for_each(|(k, c)| visit(Place::Other(k), c));
    }

    /// Every contact, in order.
    pub fn all(&self) -> Vec<&BlockContact> {
        let mut all = Vec::new();
        self.visit(|_, c| all.push(c));
        all
    }

    /// Lists the contacts that touch and the first that is too deep, after they have been looked at.
    pub fn list(&mut self) {
        let (mut touching, mut deep) = (self.touching.take().unwrap_or_default(), None);
        touching.clear();
        self.visit(|place, c| {
            if c.touch.overlap > 0.0 {
                touching.push(place);
            }
            if c.too_deep && deep.is_none() {
                deep = Some(place);
            }
        });
        (self.touching, self.deep) = (Some(touching), deep);
    }

    /// The contacts that touch, in order.
    pub fn touching(&self) -> impl Iterator<Item = &BlockContact> + Clone {
        let places = self.touching.as_ref().map_or_else(
            || {
                let mut found = Vec::new();
                self.visit(|place, c| found.extend((c.touch.overlap > 0.0).then_some(place)));
                Cow::Owned(found)
            },
            |listed| Cow::Borrowed(&listed[..]),
        );
        (0..places.len()).map(move |k| self.at(places[k]))
    }

    /// The first contact that was too deep when it was last looked at.
    pub fn deep(&self) -> Option<&BlockContact> {
        self.deep.filter(|_| self.touching.is_some()).map(|place| self.at(place))
    }

    fn at(&self, place: Place) -> &BlockContact {
        match place {
            Place::Other(k) => &self.others[k as usize],
            Place::Pair(pair, k) => &self.pairs[pair as usize].contacts[k as usize],
        }
    }
}
