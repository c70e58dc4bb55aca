//! Pairs of bodies that are near each other, and their contacts.
//!
//! Pairs are listed within a skin, which follows the fastest of all bodies. Most of them are far from each other or move little. So each pair has a skin of its own, within which its
//! sites are sought, and sought again when these two bodies have moved. A site with a gap sleeps until they have moved by as much. What is sought and looked at later or sooner changes no bit of
//! a result: it does not touch.

use super::contact::PosedBlock;
use super::pair::{Site, clearance, sites};
use super::ways::HAIR;
use super::{BlockContact, Other};
use crate::shape::Rounded;
use serde::{Deserialize, Serialize};

/// Skin of a pair of convex bodies, or of a superquadric and facets, over that of the list: at first, and the least.
const SHARE: [f64; 2] = [0.1, 0.02];
/// Looks that a pair should keep its sites for: its skin is doubled where they come to half of that, and halved where they come to twice that.
const LOOKS: u64 = 20;
/// Share of the skin of a pair, or of its gap, that its bodies may move before the next search, as positions extrapolated in time are guesses.
const TRUST: f64 = 0.5;

/// Two bodies that are near each other.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct Near {
    /// Their indices, the lower one first.
    pub bodies: [u32; 2],
    /// Their contacts at sites that touch or of which no gap is known, sorted by site and facet.
    pub contacts: Vec<BlockContact>,
    /// What its bodies have moved against each other since they were listed, m: no two of their places have come nearer by more.
    #[serde(skip)]
    pub way: f64,
    /// The other sites.
    #[serde(skip)]
    asleep: Vec<Asleep>,
    /// The least of their [`Asleep::wake`], m.
    #[serde(skip)]
    wake: f64,
    /// The last search for sites; `None`: they have to be sought.
    #[serde(skip)]
    sought: Option<Sought>,
}

/// A site at which two bodies do not touch.
#[derive(Clone, Copy, Debug)]
struct Asleep {
    site: Site,
    facet: u32,
    /// [`Near::way`] up to which they do not touch there, m.
    wake: f64,
}

/// A search for the sites of a pair.
#[derive(Clone, Copy, Debug)]
struct Sought {
    /// [`Near::way`] at which the next one is due, m.
    due: f64,
    /// Skin of the pair, m.
    skin: f64,
    /// Number of the look.
    look: u64,
}

/// Moment of a search.
#[derive(Clone, Copy, Debug)]
pub(super) struct Moment {
    /// Number of the look, counted from the first.
    pub look: u64,
    /// Skin of the list, m.
    pub skin: f64,
}

impl Near {
    /// A pair whose sites have to be sought.
    pub fn new(bodies: [usize; 2]) -> Near {
        Near { bodies: bodies.map(|k| k as u32), contacts: Vec::new(), way: 0.0, asleep: Vec::new(), wake: 0.0, sought: None }
    }

    /// Makes its sites be sought anew.
    pub fn forget(&mut self) {
        self.asleep.clear();
        self.sought = None;
    }

    /// Memory in use, bytes.
    pub fn bytes(&self) -> usize {
        size_of::<Near>() + size_of::<BlockContact>() * self.contacts.capacity() + size_of::<Asleep>() * self.asleep.capacity()
    }

    /// Whether its sites have to be sought.
    pub fn is_due(&self) -> bool {
        self.sought.is_none_or(|last| self.way >= last.due)
    }

    /// Seeks its sites. `born`: the overlaps that are found are without a force. Contacts at sites that are found again keep their history.
    pub fn seek(&mut self, bodies: &[PosedBlock<'_>], now: Moment, born: bool) {
        let [first, second] = self.bodies.map(|k| &bodies[k as usize]);
        let all =
            |is: fn(&Rounded) -> bool| [first, second].iter().all(|body| body.outline.is_some_and(|outline| is(&outline.body)));
        // where looking at a site is cheap, rather many of them than another search
        let few = all(Rounded::is_convex) || !all(|body| !body.is_smooth());
        let skin = match self.sought {
            _ if !few => now.skin,
            None => SHARE[0] * now.skin,
            Some(last) => {
                let looks = now.look - last.look;
                let factor = if looks < LOOKS / 2 {
                    2.0
                } else if looks > 2 * LOOKS {
                    0.5
                } else {
                    1.0
                };
                (factor * last.skin).clamp(SHARE[1] * now.skin, now.skin)
            }
        };
        let hair = HAIR * (first.block.solid().reach() + second.block.solid().reach());
        let gap = clearance(first, second, now.skin) - hair;
        self.sought = Some(Sought { due: self.way + TRUST * gap.max(skin), skin, look: now.look });
        let found = if gap < skin { sites(first, second, skin) } else { Vec::new() };
        self.contacts.retain(|c| found.iter().any(|&(site, facet)| c.is_at(site, facet)));
        let before = std::mem::take(&mut self.asleep);
        let sleeps = all(Rounded::has_gaps) && !born;
        for (site, facet) in found {
            if self.contacts.iter().any(|c| c.is_at(site, facet)) {
                continue;
            }
            if sleeps {
                let known = before.iter().find(|old| (old.site, old.facet) == (site, facet));
                self.asleep.push(Asleep { site, facet, wake: known.map_or(f64::NEG_INFINITY, |old| old.wake) });
            } else {
                let reference = if born { f64::INFINITY } else { 0.0 };
                self.contacts.push(BlockContact { reference, ..contact(self.bodies, site, facet) });
            }
        }
        self.contacts.sort_unstable_by_key(BlockContact::key);
        self.wake = self.least();
    }

    /// The least of the ways at which a site wakes, m.
    fn least(&self) -> f64 {
        self.asleep.iter().map(|site| site.wake).fold(f64::INFINITY, f64::min)
    }

    /// Looks at the sites that do not sleep. `gap` returns a bound below on the gap at a site of two bodies, m, 0 if none is known; `look` that of a contact that does not touch.
    pub fn look(&mut self, gap: impl Fn([u32; 2], Site) -> f64, look: impl Fn(&mut BlockContact) -> f64) {
        let way = self.way;
        let woken = way >= self.wake;
        if woken {
            let (bodies, contacts) = (self.bodies, &mut self.contacts);
            self.asleep.retain_mut(|site| {
                let left = if way >= site.wake { gap(bodies, site.site) } else { return true };
                site.wake = way + left;
                if left == 0.0 {
                    contacts.push(contact(bodies, site.site, site.facet));
                }
                left > 0.0
            });
            self.contacts.sort_unstable_by_key(BlockContact::key);
        }
        let before = self.asleep.len();
        let asleep = &mut self.asleep;
        self.contacts.retain_mut(|c| {
            let gap = look(c);
            if let Other::Block { site, .. } = c.other
                && gap > 0.0
            {
                asleep.push(Asleep { site, facet: c.facet, wake: way + gap });
                return false;
            }
            true
        });
        if woken || self.asleep.len() > before {
            self.wake = self.least();
        }
    }
}

/// A contact of two bodies without a force.
fn contact([block, other]: [u32; 2], site: Site, facet: u32) -> BlockContact {
    BlockContact::new(block, Other::Block { block: other, site }, facet, 0, 0.0)
}
