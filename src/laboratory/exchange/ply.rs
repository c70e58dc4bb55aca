//! PLY, binary: corners in double precision, m, each with radius (m) and generation of its grain and the number of its body, and triangles.

use super::Surfaces;

/// The bytes of a PLY file.
pub fn write(surfaces: &Surfaces) -> Vec<u8> {
    let mut bytes = format!(
        "ply\nformat binary_little_endian 1.0\n\
         comment comminute: grains and bodies, lengths in m; radius_m is 0 on bodies, body is -1 on grains\n\
         element vertex {}\nproperty double x\nproperty double y\nproperty double z\n\
         property float radius_m\nproperty int generation\nproperty int body\n\
         element face {}\nproperty list uchar int vertex_indices\nend_header\n",
        surfaces.corners.len(),
        surfaces.triangles.len()
    )
    .into_bytes();
    for (corner, (radius, generation, body)) in surfaces.corners.iter().zip(&surfaces.of_corner) {
        bytes.extend(corner.iter().flat_map(|x| x.to_le_bytes()));
        bytes.extend((*radius as f32).to_le_bytes());
        bytes.extend(generation.to_le_bytes());
        bytes.extend(body.to_le_bytes());
    }
    for triangle in &surfaces.triangles {
        bytes.push(3);
        bytes.extend(triangle.iter().flat_map(|k| k.to_le_bytes()));
    }
    bytes
}

#[cfg(test)]
mod tests {
    use super::super::surfaces::tests::two;
    use super::*;

    #[test]
    fn the_head_says_how_long_the_rest_is() {
        let made = Surfaces::of(&two(), 20).expect("surfaces");
        let bytes = write(&made);
        let end = bytes.windows(11).position(|w| w == b"end_header\n").expect("an end") + 11;
        let head = String::from_utf8_lossy(&bytes[..end]);
        assert!(head.contains("element vertex 24\n") && head.contains("element face 40\n"), "{head}");
        assert_eq!(bytes.len() - end, 24 * 36 + 40 * 13);
        // the last corner belongs to the second grain
        let last = &bytes[end + 23 * 36 + 24..end + 24 * 36];
        assert_eq!(last, [0.7_f32.to_le_bytes(), 1_i32.to_le_bytes(), (-1_i32).to_le_bytes()].concat());
    }
}
