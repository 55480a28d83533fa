//! Commands of path offsets, and their share of a setpoint.
//!
//! Owns when offsets begin and end; how they move is in `modes::path_offset`. While they count, `target` is what the
//! motion underneath asks for and `commanded` what the arm gets.

use kinematics::{JointSpeeds, RpyPose};
use motion_api::{Command, MotionMode, OffsetAxes, Outcome, StopReason, phrase};
use nalgebra::{Rotation3, Vector3, Vector6};

use crate::constants::{MAX_DURATION, MIN_REQUESTED_RATE, STOP_ACCELERATION};
use crate::cycle::{ControlLoop, Generator};
use crate::intake::{CommandResult, Completion, bad_value};
use crate::modes::joint_speed::JointSpeedMode;
use crate::modes::path_offset::OffsetLimits;
use crate::modes::{ActiveOnlineMode, CallCompletion, OnlineMode, is_setpoint_at_rest, states};
use crate::setpoint::{Setpoint, elbow_speed};
use motion_api::form::{TOOL_REACH_MAX, check_magnitude};

/// Share of what the motion underneath leaves of the joints' accelerations that an offset may use.
const SHARE_OF_ACCELERATION: f64 = 0.85;
/// Share of the joints' jerks: the motion may use the rest.
const SHARE_OF_JERK: f64 = 0.4;
/// Share of what the motion underneath leaves of the speeds of joints, TCP and elbow that an offset may use.
const SHARE_OF_SPEED: f64 = 0.9;

impl ControlLoop {
    pub(crate) fn path_offset_enable(&mut self) -> CommandResult {
        self.path_offset.enable();
        Ok(Completion::Immediate)
    }

    pub(crate) fn path_offset_set(&mut self, offset: &RpyPose, axes: OffsetAxes) -> CommandResult {
        check_magnitude(
            &offset.to_array(),
            TOOL_REACH_MAX,
            phrase!("a component of the offset", "偏移的分量"),
            phrase!("a number of at most 10", "不超过 10 的数"),
        )?;
        let tool = self
            .model
            .tcp_pose(&self.target.q, self.tool.flange_from_tcp());
        self.path_offset.set(offset, axes, &tool.rotation);
        Ok(Completion::Immediate)
    }

    pub(crate) fn path_offset_filter(&mut self, share: f64) -> CommandResult {
        if !(0.0..=1.0).contains(&share) {
            return Err(bad_value(
                phrase!("alpha"),
                share,
                phrase!("0 to 1", "0 到 1"),
            ));
        }
        self.path_offset.set_share(share);
        Ok(Completion::Immediate)
    }

    pub(crate) fn path_offset_max(&mut self, translation: f64, rotation: f64) -> CommandResult {
        for (name, value) in [
            (phrase!("translation"), translation),
            (phrase!("rotation"), rotation),
        ] {
            if !(0.0..=MAX_DURATION).contains(&value) {
                return Err(bad_value(
                    name,
                    value,
                    phrase!("a number of at least 0", "不小于 0 的数"),
                ));
            }
        }
        self.path_offset.set_most([translation, rotation]);
        Ok(Completion::Immediate)
    }

    /// Offsets end: the joints brake from what they do now, and a motion underneath ends with them.
    pub(crate) fn path_offset_disable(
        &mut self,
        command: &Command,
        acceleration: f64,
    ) -> CommandResult {
        if !(acceleration >= MIN_REQUESTED_RATE && acceleration.is_finite()) {
            let needed = phrase!("a number of at least 0.000001", "不小于 0.000001 的数");
            return Err(bad_value(phrase!("a"), acceleration, needed));
        }
        if !self.path_offset.is_on() {
            self.path_offset.end();
            return Ok(Completion::Immediate);
        }
        self.end_motions(Outcome::Aborted);
        self.is_paused = false;
        self.leave_path_offset(acceleration);
        if let Generator::Online(online) = &mut self.generator {
            online.id = command.id;
            online.origin = command.origin;
            online.call_completion = CallCompletion::OnGoal;
            return Ok(Completion::Deferred);
        }
        Ok(Completion::Immediate)
    }

    /// From here on the joints come to rest from what they do now.
    fn leave_path_offset(&mut self, acceleration: f64) {
        self.path_offset.end();
        self.lag = None;
        self.target = *self.commanded.setpoint();
        self.generator = Generator::Hold;
        if is_setpoint_at_rest(&self.target) {
            return;
        }
        let now = states(&self.target);
        let brake = JointSpeedMode::new(&now, &JointSpeeds::ZERO, acceleration);
        self.generator = Generator::Online(ActiveOnlineMode {
            id: motion_api::CommandId::NONE,
            origin: motion_api::Origin::default(),
            mode: MotionMode::Stopping,
            call_completion: CallCompletion::Returned,
            kind: OnlineMode::JointSpeed(brake),
            is_stopping: true,
            is_warned: true,
        });
    }

    /// Ends offsets that a stop has brought to rest once nothing moves underneath.
    pub(crate) fn settle_path_offset(&mut self) {
        let is_braked = self.joint_hold.is_none() || is_setpoint_at_rest(self.commanded.setpoint());
        if self.path_offset.has_stopped() && self.is_holding() && is_braked {
            self.leave_path_offset(STOP_ACCELERATION);
        }
    }

    /// The generator's setpoint with the offset laid over it.
    pub(crate) fn apply_path_offset(&mut self, nominal: &Setpoint) -> Result<Setpoint, StopReason> {
        if !self.path_offset.is_on() {
            return Ok(*nominal);
        }
        if let Some((asked, most)) = self.path_offset.excess() {
            return Err(StopReason::PathOffset {
                translation: asked[0],
                rotation: asked[1],
                most_translation: most[0],
                most_rotation: most[1],
            });
        }
        let tool = self.model.tcp_pose(&nominal.q, self.tool.flange_from_tcp());
        let frames = self.model.forward(&nominal.q);
        let velocity = frames.twist(&nominal.qd, tool.translation).linear;
        self.path_offset.follow(&velocity);
        let room = self.offset_limits(nominal, &tool.rotation, velocity.norm());
        let is_held = self.is_held();
        self.path_offset
            .advance(&tool.rotation, &room, is_held, self.step);
        let arm = (&self.model, self.tool.flange_from_tcp());
        let laid = self
            .path_offset
            .superimpose(nominal, self.commanded.setpoint(), arm.0, arm.1)
            .ok_or(StopReason::PathOffsetLost)?;
        Ok(laid)
    }

    /// What joints, TCP and elbow leave for changes of the offset where the arm is, along and about the axes in which
    /// it is asked for.
    fn offset_limits(
        &self,
        nominal: &Setpoint,
        tool: &Rotation3<f64>,
        tcp_speed: f64,
    ) -> OffsetLimits {
        let frames = self.commanded.frames();
        let tcp = self.tool.position(frames);
        let lu = frames.jacobian(tcp).lu();
        let limits = self.limits.in_force();
        let (axes, is_used) = self.path_offset.in_use(tool);
        // What is in use may all move at once, with the worst signs.
        let parts = is_used
            .chunks(3)
            .filter(|part| part.contains(&true))
            .count();
        let parts = parts.max(1) as f64;
        let elbow_used = elbow_speed(&self.model.forward(&nominal.q), &nominal.qd);
        let mut room = OffsetLimits {
            speed: [f64::INFINITY; 2],
            acceleration: [f64::INFINITY; 2],
            jerk: [f64::INFINITY; 2],
        };
        for part in 0..2 {
            let mut per_unit = [0.0_f64; 6];
            let mut elbow = 0.0;
            let mut count = 0.0_f64;
            for k in (0..3).filter(|k| is_used[3 * part + k]) {
                let mut along = Vector3::zeros();
                along[k] = 1.0;
                let mut unit = Vector6::zeros();
                unit.fixed_rows_mut::<3>(3 * part)
                    .copy_from(&(axes * along));
                let Some(rates) = lu.solve(&unit) else {
                    return OffsetLimits {
                        speed: [0.0; 2],
                        acceleration: [0.0; 2],
                        jerk: [0.0; 2],
                    };
                };
                let rates: [f64; 6] = rates.into();
                (0..6).for_each(|joint| per_unit[joint] += rates[joint].abs());
                elbow += elbow_speed(frames, &JointSpeeds(rates));
                count += 1.0;
            }
            for (joint, per_unit) in per_unit.iter().enumerate() {
                let per_unit = parts * per_unit;
                let left = limits.speed[joint] - nominal.qd[joint].abs();
                room.speed[part] = room.speed[part].min(SHARE_OF_SPEED * left / per_unit);
                let left = limits.acceleration[joint] - nominal.qdd[joint].abs();
                let share = SHARE_OF_ACCELERATION * self.yields.share() * left / per_unit;
                room.acceleration[part] = room.acceleration[part].min(share);
                let jerk = SHARE_OF_JERK * limits.jerk[joint] / per_unit;
                room.jerk[part] = room.jerk[part].min(jerk);
            }
            let left = SHARE_OF_SPEED * limits.elbow_speed - elbow_used;
            room.speed[part] = room.speed[part].min(left / (parts * elbow));
            if part == 0 {
                let left = SHARE_OF_SPEED * limits.tcp_speed - tcp_speed;
                room.speed[0] = room.speed[0].min(left / count.max(1.0).sqrt());
            }
        }
        // Nothing in use needs nothing, and what is used next has to begin somewhere.
        room.speed = room.speed.map(|x| x.max(0.0));
        room.acceleration = room.acceleration.map(|x| x.max(0.0));
        room
    }
}
