//! The fabric tensor of contacts.

/// Mean n n over contacts (Satake 1982): how their normals lie. Its trace is 1.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Fabric {
    sum: [f64; 6],
    pub contacts: u64,
}

impl Fabric {
    /// A contact with this unit normal; which of its two makes no difference.
    pub fn add(&mut self, [x, y, z]: [f64; 3]) {
        for (sum, term) in self.sum.iter_mut().zip([x * x, y * y, z * z, x * y, y * z, z * x]) {
            *sum += term;
        }
        self.contacts += 1;
    }

    /// xx, yy, zz, xy, yz, zx; zeros without a contact.
    pub fn tensor(&self) -> [f64; 6] {
        self.sum.map(|s| s / self.contacts.max(1) as f64)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn normals_make_a_tensor_of_trace_one() {
        let mut fabric = Fabric::default();
        assert_eq!(fabric.tensor(), [0.0; 6]);
        for n in [[0.0, 0.0, 1.0], [0.0, 0.6, 0.8], [-1.0, 0.0, 0.0], [0.8, 0.0, -0.6]] {
            fabric.add(n);
        }
        let expected = [0.41, 0.09, 0.5, 0.0, 0.12, -0.12];
        let tensor = fabric.tensor();
        assert!(tensor.iter().zip(expected).all(|(t, e)| (t - e).abs() < 1e-15), "{tensor:?}");
        assert!((tensor[..3].iter().sum::<f64>() - 1.0).abs() < 1e-15);
    }
}
