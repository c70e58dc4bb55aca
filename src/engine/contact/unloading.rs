//! What happens to the tangential force of a contact when its normal force falls.

/// What happens to the tangential force of a contact when its normal force falls.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TangentialUnloading {
    /// It stays as it is, up to the limit of friction (Ciantia et al. 2015).
    Keep,
    /// It falls in proportion to the tangential stiffness k_S, which falls with the overlap.
    Rescale,
}
