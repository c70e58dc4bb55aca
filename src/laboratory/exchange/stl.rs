//! STL, binary: triangles with corners in single precision, m.

use super::Surfaces;
use engine::math::vector::{cross, dot, less};

/// The bytes of an STL file.
pub fn write(surfaces: &Surfaces) -> Vec<u8> {
    let mut head = [b' '; 80];
    let words = b"comminute: grains and bodies, lengths in m";
    head[..words.len()].copy_from_slice(words);
    let mut bytes = head.to_vec();
    bytes.extend((surfaces.triangles.len() as u32).to_le_bytes());
    for triangle in &surfaces.triangles {
        let [p, q, r] = triangle.map(|k| surfaces.corners[k as usize]);
        let normal = cross(less(q, p), less(r, p));
        let length = dot(normal, normal).sqrt();
        let normal = if length > 0.0 { normal.map(|x| x / length) } else { [0.0; 3] };
        bytes.extend([normal, p, q, r].as_flattened().iter().flat_map(|x| (*x as f32).to_le_bytes()));
        bytes.extend([0; 2]);
    }
    bytes
}

#[cfg(test)]
mod tests {
    use super::super::surfaces::tests::two;
    use super::*;

    #[test]
    fn what_is_written_is_read_as_a_mesh() {
        let made = Surfaces::of(&two(), 80).expect("surfaces");
        let (corners, triangles) = crate::scene::stl(&write(&made)).expect("an STL file");
        assert_eq!(triangles.len(), 160);
        for (read, of) in triangles.iter().flatten().zip(made.triangles.as_flattened()) {
            let (p, q) = (corners[*read as usize], made.corners[*of as usize]);
            assert!(p.iter().zip(q).all(|(a, b)| *a == f64::from(b as f32)), "{p:?} of {q:?}");
        }
    }
}
