//! Stacks, slopes and arches: what stands and what falls.
