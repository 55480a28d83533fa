//! Commands of what is laid over a motion: force mode, belts and turntables, offsets of the path.

use kinematics::RpyPose;

use crate::OffsetAxes;

/// The beginning, the end or the settings of a motion that is added to the one which moves the arm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum OverlayCommand {
    /// Force control along the selected axes from now on, over whatever moves the arm (manual 4.1). While it is on, the
    /// same command gives it new axes and a new target.
    ForceMode {
        /// The reference frame in the base.
        frame: RpyPose,
        /// The axes of the force frame that are force controlled: x, y, z, rx, ry, rz.
        selection: [bool; 6],
        /// What the tool is to apply to the environment along the selected axes: N and Nm.
        wrench: [f64; 6],
        /// How the force frame follows from the reference frame: 0 fixed, 1 point, 2 motion, 3 TCP.
        mode: u8,
        /// Largest TCP speeds along the selected axes, m/s and rad/s.
        speed_limits: [f64; 6],
    },
    /// Back to position control (manual 4.7); nothing to do when force mode is off.
    EndForceMode,
    /// Motion goes along with a belt from now on (manual 3.1.30).
    TrackConveyorLinear {
        /// Where the belt runs to, base frame; its length does not count.
        direction: [f64; 3],
        /// Encoder ticks a metre.
        ticks_per_meter: f64,
        /// 0 or 1.
        encoder: u8,
    },
    /// Motion goes along with a turntable from now on (manual 3.1.29).
    TrackConveyorCircular {
        /// Centre of the table in the base frame; it turns about its z axis.
        center: RpyPose,
        /// Encoder ticks a turn.
        ticks_per_revolution: f64,
        /// The tool turns with the table.
        rotate_tool: bool,
        /// 0 or 1.
        encoder: u8,
    },
    /// Ends tracking and brings the tool to rest (manual 3.1.31).
    StopConveyorTracking,
    /// Offsets of the path count from now on (from controller output, not from the manual, as the next four).
    PathOffsetEnable,
    /// Offsets count no more; the joints brake with `acceleration` wherever that leads, and the next motion begins
    /// there.
    PathOffsetDisable {
        /// rad/s².
        acceleration: f64,
    },
    /// The offset laid over the TCP's path from now on.
    PathOffsetSet {
        /// Translation and rotation.
        offset: RpyPose,
        /// Along and about which axes.
        axes: OffsetAxes,
    },
    /// Share of a new offset that is taken over in each cycle, 0 to 1.
    PathOffsetFilter(f64),
    /// Largest offsets; beyond them is a protective stop.
    PathOffsetMax {
        /// m.
        translation: f64,
        /// rad.
        rotation: f64,
    },
}

impl OverlayCommand {
    /// The name used in the recording and in messages: the script function's where there is one.
    pub const fn name(&self) -> &'static str {
        match self {
            Self::ForceMode { .. } => "force_mode",
            Self::EndForceMode => "end_force_mode",
            Self::TrackConveyorLinear { .. } => "track_conveyor_linear",
            Self::TrackConveyorCircular { .. } => "track_conveyor_circular",
            Self::StopConveyorTracking => "stop_conveyor_tracking",
            Self::PathOffsetEnable => "path_offset_enable",
            Self::PathOffsetDisable { .. } => "path_offset_disable",
            Self::PathOffsetSet { .. } => "path_offset_set",
            Self::PathOffsetFilter(_) => "path_offset_set_alpha_filter",
            Self::PathOffsetMax { .. } => "path_offset_set_max_offset",
        }
    }

    /// True for what begins to move the arm.
    pub const fn starts_motion(&self) -> bool {
        matches!(
            self,
            Self::ForceMode { .. }
                | Self::TrackConveyorLinear { .. }
                | Self::TrackConveyorCircular { .. }
                | Self::PathOffsetEnable
        )
    }

    /// True for what brings the arm to rest: a [reserved slot](crate::CommandKind::uses_reserved_slot) is kept for it.
    pub const fn ends_motion(&self) -> bool {
        matches!(
            self,
            Self::EndForceMode | Self::StopConveyorTracking | Self::PathOffsetDisable { .. }
        )
    }
}
