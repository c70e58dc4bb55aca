//! The fabric tensor of contacts.

/// The fabric tensor: the mean of n_i n_j over the unit normals n of contacts (Satake 1982). It says in which directions contacts lie; its trace is 1.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Fabric {
    sum: [f64; 6],
    /// Number of contacts added so far.
    pub contacts: u64,
}

impl Fabric {
    /// Adds a contact with this unit normal; n and -n count the same.
    pub fn add(&mut self, [x, y, z]: [f64; 3]) {
        for (sum, term) in self.sum.iter_mut().zip([x * x, y * y, z * z, x * y, y * z, z * x]) {
            *sum += term;
        }
        self.contacts += 1;
    }

    /// Components xx, yy, zz, xy, yz, zx, -; zeros where there is no contact.
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
