//! MCAP recordings: writer thread, reader, comparison.
