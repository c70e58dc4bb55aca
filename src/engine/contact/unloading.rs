//! What the tangential force of a contact does when the normal force falls.

/// What the tangential force does when the normal force falls.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TangentialUnloading {
    /// The tangential force stays (the paper).
    Keep,
    /// The tangential force falls in proportion to k_S.
    Rescale,
}
