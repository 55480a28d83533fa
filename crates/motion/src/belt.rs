//! Commands of conveyor tracking and its encoders, and the belt's share of a setpoint.
//!
//! Owns when tracking begins and ends; how it moves the arm is in `modes::conveyor`, what encoders count in
//! `modes::encoder`.

use kinematics::bounds::within;
use kinematics::elementary::{cube, square};
use kinematics::{JointSpeeds, Pose, RpyPose};
use motion_api::form::check_tick_count;
use motion_api::{CommandId, EncoderRange, PulseDecoding, Refusal, StopReason};
use nalgebra::{Unit, Vector3};

use crate::config::MotionLimits;
use crate::constants::{LIMIT_SLACK, SHARE_OF_BELT, SHARE_ON_BELT, SLOWEST};
use crate::cycle::{Cycle, Generator};
use crate::intake::{Answer, Ending, bad_value};
use crate::modes::axis::Axis;
use crate::modes::conveyor::{Route, Tracking};
use crate::modes::encoder::Encoder;
use crate::modes::points::Points;
use crate::modes::{online_axes, stands, states};
use crate::setpoint::{Setpoint, elbow_speed};
use crate::waiting::WaitingFor;

impl Cycle {
    pub(crate) fn track_linear(
        &mut self,
        direction: [f64; 3],
        ticks_per_meter: f64,
        encoder: u8,
    ) -> Answer {
        let along = Unit::try_new(Vector3::from(direction), 1e-9);
        let Some(along) = along.filter(|unit| unit.iter().all(|x| x.is_finite())) else {
            let length = Vector3::from(direction).norm();
            return Err(bad_value("the length of direction", length, "more than 0"));
        };
        self.track(
            Route::Linear(along),
            encoder,
            "ticks_per_meter",
            ticks_per_meter,
            1.0,
        )
    }

    pub(crate) fn track_circular(
        &mut self,
        center: &RpyPose,
        ticks_per_revolution: f64,
        rotate_tool: bool,
        encoder: u8,
    ) -> Answer {
        if !center.is_finite() {
            return Err(bad_value("center", f64::NAN, "a pose of finite numbers"));
        }
        let center = Pose::from_rpy(center);
        let route = Route::Circular {
            center: center.translation,
            axis: Unit::new_normalize(center.rotation * Vector3::z()),
            rotate_tool,
        };
        let name = "ticks_per_revolution";
        self.track(
            route,
            encoder,
            name,
            ticks_per_revolution,
            core::f64::consts::TAU,
        )
    }

    fn track(
        &mut self,
        route: Route,
        encoder: u8,
        name: &'static str,
        ticks: f64,
        unit: f64,
    ) -> Answer {
        if !(ticks.is_finite() && ticks.abs() >= SLOWEST) {
            return Err(bad_value(name, ticks, "a finite number other than 0"));
        }
        let (start, _) = self.encoder(encoder)?.position();
        let tcp = (self.target_frames.base_from_flange * self.flange_from_tcp).translation;
        let encoder = usize::from(encoder);
        let tracking = Tracking::new(route, encoder, unit / ticks, start, tcp, self.step);
        self.tracking = Some(tracking);
        Ok(Ending::Now)
    }

    pub(crate) fn stop_tracking(&mut self, id: CommandId) -> Ending {
        let Some(tracking) = &mut self.tracking else {
            return Ending::Now;
        };
        tracking.stop();
        self.stop_motion_underneath();
        self.waiting.add(id, WaitingFor::Stop);
        Ending::Later
    }

    /// The generator's setpoint carried along with the conveyor.
    pub(crate) fn carried(&mut self, nominal: &Setpoint) -> Result<Setpoint, StopReason> {
        let Some(tracking) = &mut self.tracking else {
            return Ok(*nominal);
        };
        let belt = self.encoders[tracking.encoder].position();
        let tcp = (self.target_frames.base_from_flange * self.flange_from_tcp).translation;
        let twist = tracking.unit_twist(tcp);
        let jacobian = self.target_frames.jacobian(tcp).lu();
        if let Some(per_way) = jacobian.solve(&twist.to_vector()) {
            let able = (0..6).fold(f64::INFINITY, |least, joint| {
                least.min(self.limits.acceleration[joint] / per_way[joint].abs())
            });
            // While the arm does nothing else the belt may use what motions would need.
            let share = match self.generator {
                Generator::Hold if self.lag.is_none() => SHARE_OF_BELT + SHARE_ON_BELT,
                _ => SHARE_OF_BELT,
            };
            let elbow = elbow_speed(&self.target_frames, &JointSpeeds(per_way.into()));
            let points = [
                (twist.linear.norm(), self.limits.tcp_speed),
                (elbow, self.limits.elbow_speed),
            ];
            let rate = tracking.rate(belt.1);
            let mut fastest = f64::INFINITY;
            // Faster than the belt only as far as the joints bear it, where they are and in the bends that they are led through.
            let unit = JointSpeeds(per_way.into());
            let bias = self.target_frames.jacobian_rate_times_speeds(&unit, tcp);
            let bend = tracking.unit_bend(tcp).to_vector() - bias.to_vector();
            let bend = jacobian.solve(&bend).unwrap_or_default();
            for joint in 0..6 {
                let most = SHARE_OF_JOINT_SPEED * self.limits.speed[joint] / per_way[joint].abs();
                let bent = SHARE_OF_BELT * self.limits.acceleration[joint] / bend[joint].abs();
                fastest = fastest.min(most).min(bent.sqrt());
            }
            fastest = fastest.max(FASTER_THAN_BELT * rate);
            for (number, (per_way, limit)) in points.into_iter().enumerate() {
                let (value, most) = (rate * per_way, FASTEST_BELT * limit);
                if value > most && !tracking.is_stopping() {
                    return Err(match number {
                        0 => StopReason::TcpSpeed { value, limit },
                        _ => StopReason::ElbowSpeed { value, limit },
                    });
                }
                fastest = fastest.min(value.max(BELT_SHARE_OF_POINTS * limit) / per_way);
            }
            tracking.limit(share * able, fastest);
            // Motions that are planned now have what the belt leaves.
            let speed = rate.max(tracking.speed());
            let left = points.map(|(per_way, limit)| {
                (BELT_SHARE_OF_POINTS * limit - speed * per_way).max(LEAST_POINT_SHARE * limit)
            });
            self.limits_on_belt.tcp_speed = left[0];
            self.limits_on_belt.elbow_speed = left[1];
        }
        tracking.advance(belt, self.step);
        let carried = tracking
            .carry(nominal, &self.commanded, &self.model, &self.flange_from_tcp)
            .ok_or(StopReason::ConveyorLost)?;
        Ok(carried)
    }

    /// What was laid over the motion underneath must not ask more of the joints than they can do: a motion is planned where it
    /// begins, not where it is carried. It is stopped while the joints can still come to rest within their limits.
    pub(crate) fn check_laid_over(&mut self, wanted: &Setpoint) -> Result<(), StopReason> {
        if self.tracking.is_none() && !self.path_offset.is_on() {
            return Ok(());
        }
        let (able, checked) = (self.limit_sets.able(), self.limit_sets.checked());
        let is_within = is_within_rates(wanted, &self.commanded, self.step, able);
        if self.tracking.is_some() {
            if !(is_within && leaves_a_way_to_rest(wanted, checked)) {
                return Err(StopReason::ConveyorLost);
            }
            return self.slow_for_points(wanted);
        }
        if is_within && leaves_a_way_to_rest(wanted, checked) {
            Ok(())
        } else {
            Err(StopReason::PathOffsetLost)
        }
    }

    /// The setpoint of the belt within the speed limits of TCP and elbow, also while the joints come to rest; a motion on
    /// the belt is slowed down when it comes near to them.
    fn slow_for_points(&mut self, carried: &Setpoint) -> Result<(), StopReason> {
        let arm = (&self.model, &self.flange_from_tcp);
        let Some(points) = Points::new(arm.0, arm.1, &self.limits, &carried.q) else {
            return Ok(());
        };
        let axes = online_axes(self.limit_sets.able(), self.step);
        let braking = points.while_braking(&states(carried), &axes, self.step);
        let checked = Points::new(arm.0, arm.1, self.limit_sets.checked(), &carried.q);
        if let Some(reason) = checked.and_then(|points| points.exceeded(braking)) {
            return Err(reason);
        }
        let soon = states(carried).map(|state| state.after(AHEAD, 0.0));
        let used = points.used(&carried.qd);
        let used = used.max(points.used(&JointSpeeds(soon.map(|state| state.speed))));
        // Joints that brake each for itself may lead the TCP on faster than together.
        let used = used.max(points.share(braking));
        let used = used.max(points.share(points.while_braking(&soon, &axes, self.step)));
        if let Some(tracking) = &mut self.tracking {
            let change = if used > SLOWING_FROM {
                -SLOWING_RATE * self.step
            } else if used < SPEEDING_UNTIL {
                SPEEDING_RATE * self.step
            } else {
                0.0
            };
            tracking.slowing = within(tracking.slowing + change, 0.0, 1.0);
        }
        Ok(())
    }

    /// Ends tracking once it has come to rest: from then on the generator starts where the arm is.
    pub(crate) fn settle_tracking(&mut self) {
        let is_braked = self.holding.is_none() || stands(&self.commanded);
        let has_stopped = self.tracking.as_ref().is_some_and(Tracking::has_stopped);
        if has_stopped && is_braked && matches!(self.generator, Generator::Hold) {
            self.tracking = None;
            self.lag = None;
            self.commanded = Setpoint::standing(self.commanded.q);
            self.target = self.commanded;
        }
    }

    pub(crate) fn encoder(&mut self, number: u8) -> Result<&mut Encoder, Refusal> {
        self.encoders
            .get_mut(usize::from(number))
            .ok_or_else(|| bad_value("encoder_index", f64::from(number), "0 or 1"))
    }

    pub(crate) fn set_tick_count(&mut self, number: u8, count: f64) -> Answer {
        let encoder = self.encoder(number)?;
        check_tick_count(encoder.is_from_program(), encoder.range(), count)?;
        self.recount(usize::from(number), |encoder| encoder.set(count));
        Ok(Ending::Now)
    }

    pub(crate) fn count_by_program(&mut self, number: u8, range: EncoderRange) -> Answer {
        self.encoder(number)?;
        let take = |encoder: &mut Encoder| {
            encoder.take_from_program(range);
            true
        };
        self.recount(usize::from(number), take);
        Ok(Ending::Now)
    }

    /// Changes what an encoder counts. Where that says where the counter is, not that the belt moved, a belt that is followed
    /// stays where it is.
    fn recount(&mut self, number: usize, change: impl FnOnce(&mut Encoder) -> bool) {
        let Some(encoder) = self.encoders.get_mut(number) else {
            return;
        };
        let (before, _) = encoder.position();
        let is_new_count = change(encoder);
        let (after, _) = encoder.position();
        if let Some(tracking) = &mut self.tracking
            && tracking.encoder == number
            && is_new_count
        {
            tracking.recount(after - before);
        }
    }

    pub(crate) fn decode_pulses(
        &mut self,
        encoder: u8,
        decoding: PulseDecoding,
        channel_a: u8,
        channel_b: u8,
    ) -> Answer {
        let inputs = self.io.image.digital_in.into();
        let is_fast = |channel: u8| (16..=17).contains(&channel);
        if !is_fast(channel_a) {
            return Err(bad_value("A", f64::from(channel_a), "16 or 17"));
        }
        let two = decoding == PulseDecoding::Quadrature;
        if two && (!is_fast(channel_b) || channel_a == channel_b) {
            let needed = "the other one of 16 and 17 in quadrature mode";
            return Err(bad_value("B", f64::from(channel_b), needed));
        }
        self.encoder(encoder)?;
        self.recount(usize::from(encoder), |encoder| {
            encoder.take_pulses(decoding, channel_a, channel_b, inputs);
            true
        });
        Ok(Ending::Now)
    }
}

/// Share of the speed limits of TCP and elbow that a belt and what is planned on it may use together.
const BELT_SHARE_OF_POINTS: f64 = 0.93;
/// A belt is followed up to this share of them.
const FASTEST_BELT: f64 = 0.985;
/// Share of them that a motion on a belt is planned with at least, however much the belt takes: the two need not have the
/// same direction.
const LEAST_POINT_SHARE: f64 = 0.1;
/// A belt is caught up with at least this much faster than it is.
const FASTER_THAN_BELT: f64 = 1.2;
/// Share of the joints' speeds with which a belt is caught up with.
const SHARE_OF_JOINT_SPEED: f64 = 0.8;
/// A motion on a belt is slowed down above this share of those limits, looked at so far ahead, s, and so fast, 1/s; it is let go
/// on below the other share.
const SLOWING_FROM: f64 = 0.96;
/// See [`SLOWING_FROM`].
const AHEAD: f64 = 0.08;
/// See [`SLOWING_FROM`].
const SLOWING_RATE: f64 = 8.0;
/// See [`SLOWING_FROM`].
const SPEEDING_UNTIL: f64 = 0.85;
/// See [`SLOWING_FROM`].
const SPEEDING_RATE: f64 = 1.0;

/// No joint exceeds its acceleration, or its jerk between two setpoints that are `step` seconds apart.
pub(crate) fn is_within_rates(
    next: &Setpoint,
    before: &Setpoint,
    step: f64,
    limits: &MotionLimits,
) -> bool {
    (0..6).all(|joint| {
        let most = limits.jerk[joint];
        let jerk = (next.qdd[joint] - before.qdd[joint]) / step;
        // Near singular positions inverse kinematics may go over into another branch: then position, speed and acceleration
        // do not belong to one motion, although each is within its limit.
        let evenly = 0.5 * step * (before.qd[joint] + next.qd[joint]);
        let off = next.q[joint] - before.q[joint] - evenly;
        let evenly = 0.5 * step * (before.qdd[joint] + next.qdd[joint]);
        let speed_off = next.qd[joint] - before.qd[joint] - evenly;
        next.qdd[joint].abs() <= limits.acceleration[joint] * (1.0 + RATE_SLACK)
            && jerk.abs() <= most * (1.0 + RATE_SLACK)
            && off.abs() <= most * cube(step) / 6.0 + OFF_SLACK * step
            && speed_off.abs() <= most * square(step) / 4.0 + OFF_SLACK
    })
}

/// No joint exceeds its speed or leaves its range when all of them brake from here.
fn leaves_a_way_to_rest(from: &Setpoint, limits: &MotionLimits) -> bool {
    states(from).iter().enumerate().all(|(joint, state)| {
        let axis = Axis {
            min: limits.position_min[joint] - LIMIT_SLACK,
            max: limits.position_max[joint] + LIMIT_SLACK,
            speed: limits.speed[joint] + LIMIT_SLACK / 2.0,
            acceleration: limits.acceleration[joint] * (1.0 + RATE_SLACK),
            jerk: limits.jerk[joint],
        };
        axis.is_safe(state)
    })
}

/// Positions and speeds may differ by this, rad/s, from what goes on from the ones before.
const OFF_SLACK: f64 = 1e-6;
/// Accelerations and jerks may exceed their limits by this part through rounding.
const RATE_SLACK: f64 = 1e-6;
