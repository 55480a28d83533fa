//! Robot, safety and motion modes, with the numbers that the ports send (protocol: enums of the primary interface).

use core::fmt;

macro_rules! numbered {
    ($(#[$doc:meta])* $name:ident { $($(#[$vdoc:meta])* $variant:ident = $number:literal,
        $text:literal;)+ } else $fallback:ident) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
        pub enum $name { $($(#[$vdoc])* $variant = $number,)+ }

        impl $name {
            /// The number on the wire.
            pub const fn number(self) -> i32 { self as i32 }

            /// From the number on the wire; an unknown one gives the neutral mode.
            pub const fn from_number(number: i32) -> Self {
                match number { $($number => Self::$variant,)+ _ => Self::$fallback }
            }

            /// The name people know.
            pub const fn name(self) -> &'static str {
                match self { $(Self::$variant => $text,)+ }
            }
        }

        impl fmt::Display for $name {
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result { f.write_str(self.name()) }
        }
    };
}

numbered! {
    /// What the arm as a machine is doing.
    RobotMode {
        /// No controller answers.
        NoController = -1, "NO_CONTROLLER";
        /// The arm is not connected.
        Disconnected = 0, "DISCONNECTED";
        /// Waits for the safety configuration to be confirmed.
        ConfirmSafety = 1, "CONFIRM_SAFETY";
        /// Starting.
        Booting = 2, "BOOTING";
        /// No power on the joints.
        PowerOff = 3, "POWER_OFF";
        /// Power is being applied.
        PowerOn = 4, "POWER_ON";
        /// Powered, brakes engaged.
        Idle = 5, "IDLE";
        /// Moved by hand without power.
        Backdrive = 6, "BACKDRIVE";
        /// Brakes released, ready to move.
        Running = 7, "RUNNING";
        /// Firmware update.
        UpdatingFirmware = 8, "UPDATING_FIRMWARE";
        /// Calibration.
        WaitingCalibration = 9, "WAITING_CALIBRATION";
    } else Disconnected
}

numbered! {
    /// What the safety system allows.
    SafetyMode {
        /// Full limits.
        Normal = 1, "NORMAL";
        /// Reduced limits.
        Reduced = 2, "REDUCED";
        /// Stopped by a limit, a collision or an overload; needs an unlock.
        ProtectiveStop = 3, "PROTECTIVE_STOP";
        /// Being moved back inside the limits.
        Recovery = 4, "RECOVERY";
        /// Stopped by the safeguard input.
        SafeguardStop = 5, "SAFEGUARD_STOP";
        /// Emergency stop of the cell.
        SystemEmergencyStop = 6, "SYSTEM_EMERGENCY_STOP";
        /// Emergency stop of the robot.
        RobotEmergencyStop = 7, "ROBOT_EMERGENCY_STOP";
        /// A safety limit was violated.
        Violation = 8, "VIOLATION";
        /// The safety system has a fault.
        Fault = 9, "FAULT";
        /// Joint ids are being checked.
        ValidateJointId = 10, "VALIDATE_JOINT_ID";
        /// The safety mode is not known.
        Undefined = 11, "UNDEFINED_SAFETY_MODE";
    } else Undefined
}

numbered! {
    /// The generator that makes the setpoints: the `mode` of `/cycle`.
    MotionMode {
        /// Standing still.
        Idle = 0, "idle";
        /// Joint-space line.
        MoveJ = 1, "movej";
        /// Straight TCP line.
        MoveL = 2, "movel";
        /// Decelerating after a stop.
        Stopping = 3, "stopping";
        /// Held on the path by a pause.
        Paused = 4, "paused";
        /// Decelerating or standing in a protective stop.
        ProtectiveStop = 5, "protective_stop";
        /// No power or brakes engaged.
        PoweredOff = 6, "powered_off";
        /// Circular arc of the TCP.
        MoveC = 7, "movec";
        /// Points at equal times from a file.
        MoveMl = 8, "moveml";
        /// Straight TCP line with arcs as blends.
        MoveP = 9, "movep";
        /// A stream of joint positions.
        ServoJ = 20, "servoj";
        /// Joint speeds.
        SpeedJ = 21, "speedj";
        /// A TCP velocity.
        SpeedL = 22, "speedl";
        /// Led by hand.
        Freedrive = 23, "freedrive";
        /// Going along with a conveyor, with no motion of its own.
        Conveyor = 24, "conveyor";
        /// Pressing or giving way in force mode, with no motion of its own.
        ForceMode = 25, "force_mode";
        /// Another controller makes the setpoints and does not say how: recordings of robots elsewhere.
        Unknown = 99, "unknown";
    } else Idle
}

impl SafetyMode {
    /// True when motion is allowed.
    pub const fn allows_motion(self) -> bool {
        matches!(self, Self::Normal | Self::Reduced)
    }
}
