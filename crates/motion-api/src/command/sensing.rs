//! Commands of what feels forces: the force sensor, the wrenches that act on it, force mode's gains, collisions.

/// A setting of the force sensor, of force mode or of collision detection, or a wrench from outside.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SensingCommand {
    /// Gain of force mode, 0 to 2; kept until the controller ends (manual 4.2).
    SetForceGain(f64),
    /// Damping of force mode, 0 to 1; kept until the controller ends (manual 4.3).
    SetForceDamping(f64),
    /// A wrench that acts on the tool from outside until the next one: N and Nm, base axes, about the TCP. Counts while
    /// [`FtRtsiInput`](Self::FtRtsiInput) is on.
    SetExternalWrench([f64; 6]),
    /// A load on the tool from now on, like one of `[[wrench]]` of the cell: felt by the arm, not only by its sensor.
    /// Loads add up.
    Push {
        /// N and Nm, about the TCP.
        wrench: [f64; 6],
        /// True when the wrench has the TCP's axes, otherwise it has the base's.
        in_tool_axes: bool,
        /// How long the load acts, s.
        duration: f64,
        /// Earlier loads end when this one begins.
        replaces: bool,
    },
    /// Whether wrenches from a port count (`ft_rtsi_input_enable`), and the sensor that they come from.
    FtRtsiInput {
        /// True when wrenches from a port count.
        enabled: bool,
        /// Mass of that sensor, kg; its weight is in the readings.
        mass: f64,
        /// The point about which the sensor measures moments, flange frame, m; zero means the TCP.
        measuring_offset: [f64; 3],
        /// Centre of gravity of the sensor, flange frame, m.
        cog: [f64; 3],
    },
    /// What the force sensor reads now counts as nothing (manual 4.4).
    ZeroFtSensor,
    /// Collision detection on or off (manual 3.1.43).
    SetCollisionDetection(bool),
    /// Sensitivity of collision detection, 10 to 100 % (manual 3.1.46).
    SetCollisionSensitivity(u8),
}

impl SensingCommand {
    /// The name used in the recording and in messages: the script function's where there is one.
    pub const fn name(&self) -> &'static str {
        match self {
            Self::SetForceGain(_) => "force_mode_set_gain_scaling",
            Self::SetForceDamping(_) => "force_mode_set_damping",
            Self::SetExternalWrench(_) => "set_external_wrench",
            Self::Push { .. } => "push",
            Self::FtRtsiInput { .. } => "ft_rtsi_input_enable",
            Self::ZeroFtSensor => "zero_ftsensor",
            Self::SetCollisionDetection(_) => "set_collision_detect_enabled",
            Self::SetCollisionSensitivity(_) => "set_dyn_collision_force_min_ratio",
        }
    }
}
