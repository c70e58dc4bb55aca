//! Rigid bodies as a user types them.
