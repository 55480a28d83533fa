//! The Python wheel elitescript.
