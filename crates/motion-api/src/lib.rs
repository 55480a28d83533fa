//! The contract between scripts and ports on one side and the motion thread on the other.
