//! Mean stress of a single grain (Love–Weber), for failure criteria that use it.
//!
//! ```text
//! σ = 1/V Σ_contacts x ⊗ F     x = r n, V = 4/3 π r³:     σ = 3/(4 π r²) Σ n ⊗ F
//! ```
//!
//! Here x is the vector from the grain's centre to its surface at the contact, and F the force on the grain. So two opposite forces F between platens give the
//! uniaxial stress F/(π d²/6). If a grain is not in equilibrium, the symmetric part is used. Contacts are summed in the order of identities, walls last.

use super::{State, Workspace, gather};
use crate::breakage::Criterion;
use crate::breakage::criterion::{Judges, MeanStress};
use crate::contact::pairs::Pairs;
use crate::dem::physics::Physics;
use crate::neighbours::Neighbours;
use rayon::prelude::*;
use std::f64::consts::PI;

/// Number of grains in a parallel task.
const TASK: usize = 256;

/// Mean stress of grain `i` of radius `r`, m, under the contact forces that were computed last, Pa, compression positive.
pub fn of_grain(i: usize, r: f64, neighbours: &Neighbours, pairs: &Pairs, wall_pairs: &Pairs) -> MeanStress {
    let mut sum = [0.0; 6];
    for e in neighbours.contacts.links(i) {
        let touch = if e.is_wall() { &wall_pairs.touch[e.slot()] } else { &pairs.touch[e.slot()] };
        // at the second end normal and force both change sign, so their product does not
        let (n, f) = (touch.normal, touch.force());
        for (k, (a, b)) in [(0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (2, 0)].into_iter().enumerate() {
            sum[k] -= 0.5 * (n[a] * f[b] + n[b] * f[a]);
        }
    }
    MeanStress(sum.map(|s| s * 3.0 / (4.0 * PI * r * r)))
}

/// Load of grain `i` that the criterion compares with its breakage threshold: the largest load of a contact, or the equivalent of its mean stress, Pa.
pub fn load(criterion: &Criterion, i: usize, r: f64, neighbours: &Neighbours, pairs: &Pairs, wall_pairs: &Pairs) -> f64 {
    match criterion.judges() {
        Judges::Contacts => {
            let of = |wall: bool| if wall { wall_pairs } else { pairs };
            neighbours.contacts.of(i).fold(0.0, |load, e| f64::max(load, of(e.is_wall()).load(e.slot())))
        }
        Judges::MeanStress => criterion.equivalent_stress(&of_grain(i, r, neighbours, pairs, wall_pairs)),
    }
}

/// Flags the grains whose equivalent stress exceeds their threshold. Does nothing for criteria on contacts.
pub(super) fn judge(physics: &Physics, state: &State, work: &mut Workspace) {
    let Some(crush) = physics.crush.as_ref().filter(|_| gather::judged(physics, state, Judges::MeanStress)) else { return };
    let State { grains, pairs, wall_pairs, .. } = state;
    let Workspace { neighbours, flags, .. } = work;
    let neighbours = &*neighbours;
    flags.par_iter_mut().enumerate().with_min_len(TASK).for_each(|(i, flag)| {
        let threshold = grains.breakage_threshold[i];
        if threshold.is_finite() && !neighbours.contacts.links(i).is_empty() {
            let stress = of_grain(i, grains.radius(i), neighbours, pairs, wall_pairs);
            if crush.criterion.equivalent_stress(&stress) > threshold {
                *flag |= gather::FAILED;
            }
        }
    });
}
