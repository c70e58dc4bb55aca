//! Sheets against what holds for any of them.

use super::*;
use crate::math::vector::plus;
use proptest::prelude::*;

/// A hilly sheet of 2 × `n` × `n` triangles over the square from −1 to 1.
fn hills(n: u32, height: f64, rounding: f64) -> Sheet {
    let at = |k: u32| 2.0 * f64::from(k) / f64::from(n) - 1.0;
    let place = |j: u32, i: u32| {
        let (x, y) = (at(i), at(j));
        [x, y, height * (x * x - 0.7 * y * y * y + 0.3 * x * y)]
    };
    let vertices: Vec<[f64; 3]> = (0..=n).flat_map(|j| (0..=n).map(move |i| (j, i))).map(|(j, i)| place(j, i)).collect();
    let corner = |j: u32, i: u32| j * (n + 1) + i;
    let squares = (0..n).flat_map(|j| (0..n).map(move |i| (j, i)));
    let triangles: Vec<[u32; 3]> = squares
        .flat_map(|(j, i)| {
            [[corner(j, i), corner(j, i + 1), corner(j + 1, i + 1)], [corner(j, i), corner(j + 1, i + 1), corner(j + 1, i)]]
        })
        .collect();
    Sheet::of(&vertices, &triangles, rounding).expect("a sheet")
}

/// Contacts of a sphere, with their facets.
fn meets(sheet: &Sheet, at: [f64; 3], radius: f64) -> Vec<(u32, Meet)> {
    let mut near = Vec::new();
    sheet.facets_near(at, radius, &mut near);
    near.into_iter().filter_map(|facet| sheet.meet(facet, at, radius).map(|meet| (facet, meet))).collect()
}

/// Energy of a sphere whose contacts have the energy δ², shared over borders.
fn energy(sheet: &Sheet, at: [f64; 3], radius: f64) -> f64 {
    let of = |nearest: &Nearest| (radius - nearest.distance).max(0.0).powi(2);
    let one = |meet: &Meet| {
        let whole = of(&meet.nearest);
        meet.borders.iter().fold(whole, |left, (_, border)| left * (1.0 - of(border) / whole))
    };
    meets(sheet, at, radius).iter().map(|(_, meet)| one(meet)).sum()
}

proptest! {
    /// The nearest point of all triangles is a contact, it counts whole, and no other is nearer.
    #[test]
    fn the_nearest_facet_is_met(x in -1.2..1.2_f64, y in -1.2..1.2_f64, z in -0.5..0.6_f64, fine in 1..8_u32) {
        let sheet = hills(fine, 0.3, 0.05);
        let at = [x, y, z];
        let least = (0..sheet.triangles()).map(|t| sheet.foot(t, at).square).fold(f64::INFINITY, f64::min).sqrt() - 0.05;
        prop_assert!((sheet.nearest(at).distance - least).abs() < 1e-15);
        prop_assert!(sheet.clearance(at) <= least + 1e-15);
        let met = meets(&sheet, at, 0.8);
        let nearest = met.iter().min_by(|a, b| a.1.nearest.distance.total_cmp(&b.1.nearest.distance));
        match nearest {
            Some((_, meet)) => {
                prop_assert!((meet.nearest.distance - least).abs() < 1e-15 && meet.borders.is_empty());
                let foot = less(at, scaled(meet.nearest.normal, meet.nearest.distance + 0.05));
                prop_assert!((sheet.nearest(foot).distance + 0.05).abs() < 1e-12);
            }
            None => prop_assert!(least >= 0.8),
        }
    }

    /// On the way of a sphere over a sheet the energy changes with the way and does not jump, over one inner edge and over hills where six facets meet. (Where facets with only
    /// a vertex in common do not count, it halves at once.)
    #[test]
    fn energy_does_not_jump(x in -0.8..0.8_f64, y in -0.8..0.8_f64, depth in 0.02..0.3_f64, fold in 0.001..0.3_f64, along in -1.0..1.0_f64) {
        let vertices = [[-1.0, -1.0, fold], [-1.0, 1.0, fold], [0.0, -1.0, 0.0], [0.0, 1.0, 0.0], [1.0, -1.0, fold], [1.0, 1.0, fold]];
        let folded = Sheet::of(&vertices, &[[0, 2, 1], [1, 2, 3], [2, 4, 3], [3, 4, 5]], 0.0).expect("a sheet");
        prop_assert_eq!(folded.facets(), 2);
        let hills = hills(6, 0.2, 0.0);
        for (sheet, share) in [(&folded, 1e-9), (&hills, 0.01)] {
            let radius = 0.35;
            let start = [x, y, sheet.bounds()[1][2] + 0.01];
            let Nearest { distance, normal } = sheet.nearest(start);
            let mut at = plus(less(start, scaled(normal, distance)), scaled(normal, radius * (1.0 - depth)));
            let step = scaled([along, 1.0 - along.abs(), 0.0], 1e-3);
            let mut last = energy(sheet, at, radius);
            for _ in 0..200 {
                at = plus(at, step);
                let now = energy(sheet, at, radius);
                // force times way, and what a jump may be
                let most = 8.0 * radius * 1e-3 * radius + share * now.max(last);
                prop_assert!((now - last).abs() <= most, "{last} {now} at {at:?}");
                last = now;
            }
        }
    }

    /// What passes over a facet's border is seen to go to the facet beyond.
    #[test]
    fn a_border_leads_to_the_facet_beyond(y in -0.9..0.9_f64, x in 0.01..0.2_f64) {
        let vertices = [[-1.0, -1.0, -0.5], [-1.0, 1.0, -0.5], [0.0, -1.0, 0.0], [0.0, 1.0, 0.0], [1.0, -1.0, -0.5], [1.0, 1.0, -0.5]];
        let roof = Sheet::of(&vertices, &[[0, 2, 1], [1, 2, 3], [2, 4, 3], [3, 4, 5]], 0.0).expect("a roof");
        let at = [x, y, 0.1];
        prop_assert_eq!(meets(&roof, at, 0.3).len(), 1);
        prop_assert!(roof.passes(0, 1, at, 0.3) && !roof.passes(1, 0, [0.3, y, 0.1], 0.5) && !roof.passes(0, 0, at, 0.3));
    }
}

/// A cube of sixteen triangles a side is six facets, twelve edges and eight corners, and is closed; without a side it is open.
#[test]
fn a_cube_is_six_facets_twelve_edges_and_eight_corners() {
    let cube = Mesh::of_cube(4, |p| p.map(|x| 0.5 * x));
    let sheet = Sheet::of(&cube.corners, &cube.triangles, 0.0).expect("a cube");
    assert_eq!((sheet.facets(), sheet.edges().len(), sheet.corners().len(), sheet.is_closed()), (6, 12, 8, true));
    for [p, q] in sheet.edges() {
        let along = less(p, q);
        assert!((dot(along, along).sqrt() - 1.0).abs() < 1e-15);
    }
    let [corners, edges] = sheet.sharp_near([0.5, 0.5, 0.5], 0.1);
    assert_eq!((corners.len(), edges.len()), (1, 3));
    // outwards they act, inwards they do not
    let outwards = scaled(sheet.corners()[corners[0] as usize], 2.0 / 3.0_f64.sqrt());
    assert!(sheet.corner_acts(corners[0] as usize, outwards) && !sheet.corner_acts(corners[0] as usize, outwards.map(|x| -x)));
    let open = Sheet::of(&cube.corners, &cube.triangles[32..], 0.0).expect("a cube without a side");
    assert_eq!((open.facets(), open.edges().len(), open.corners().len(), open.is_closed()), (5, 12, 8, false));
}

/// What is kept of a sheet gives it again, and what makes none is refused.
#[test]
fn a_sheet_is_read_back_and_a_false_one_is_not() {
    let sheet = hills(3, 0.2, 0.01);
    let plain = Plain::from(sheet.clone());
    assert_eq!(Sheet::try_from(plain.clone()).expect("the same"), sheet);
    for spoil in
        [|p: &mut Plain| p.triangles[2][1] = 99, |p: &mut Plain| p.vertices[3][0] = f64::NAN, |p: &mut Plain| p.rounding = -1.0]
    {
        let mut plain = plain.clone();
        spoil(&mut plain);
        assert!(Sheet::try_from(plain).is_err());
    }
}
