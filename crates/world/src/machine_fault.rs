//! What a fault does to an actuator or a conveyor.

/// How a machine is impaired.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum MachineFault {
    /// No fault acts.
    #[default]
    None,
    /// Half of its speed is left.
    Slow,
    /// The machine stands.
    Blocked,
}

impl MachineFault {
    /// What is left of the speed.
    pub(crate) fn speed_share(self) -> f64 {
        match self {
            Self::None => 1.0,
            Self::Slow => 0.5,
            Self::Blocked => 0.0,
        }
    }
}
