//! Admittance force control and the joint-speed limiter.
