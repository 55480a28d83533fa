//! Commands of conveyor tracking and its encoders, and the belt's share of a setpoint.
//!
//! Owns when tracking begins and ends; how it moves the arm is in `modes::conveyor`, what encoders count in
//! `modes::encoder`.

use kinematics::{JointSpeeds, Pose, RpyPose};
use messages::Text;
use motion_api::form::check_tick_count;
use motion_api::{CommandId, EncoderRange, PulseDecoding, Refusal, StopReason, phrase};
use nalgebra::{Unit, Vector3};

use crate::constants::{LIMIT_SLACK, MIN_REQUESTED_RATE, SHARE_OF_BELT, SHARE_ON_BELT};
use crate::cycle::{ControlLoop, Generator};
use crate::intake::{CommandResult, Completion, bad_value};
use crate::modes::conveyor::{ConveyorPath, ConveyorTracking};
use crate::modes::encoder::Encoder;
use crate::modes::points::PointSpeedLimits;
use crate::modes::{is_setpoint_at_rest, online_axes, states};
use crate::setpoint::{Setpoint, elbow_speed};
use crate::waiting::RestCommand;

impl ControlLoop {
    pub(crate) fn track_linear(
        &mut self,
        direction: [f64; 3],
        ticks_per_meter: f64,
        encoder: u8,
    ) -> CommandResult {
        let along = Unit::try_new(Vector3::from(direction), 1e-9);
        let Some(along) = along.filter(|unit| unit.iter().all(|x| x.is_finite())) else {
            let length = Vector3::from(direction).norm();
            return Err(bad_value(
                phrase!("the length of direction", "方向的长度"),
                length,
                phrase!("more than 0", "大于 0"),
            ));
        };
        self.track(
            ConveyorPath::Linear(along),
            encoder,
            phrase!("ticks_per_meter"),
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
    ) -> CommandResult {
        if !center.is_finite() {
            return Err(bad_value(
                phrase!("center"),
                f64::NAN,
                phrase!("a pose of finite numbers", "由有限的数组成的位姿"),
            ));
        }
        let center = Pose::from_rpy(center);
        let route = ConveyorPath::Circular {
            center: center.translation,
            axis: Unit::new_normalize(center.rotation * Vector3::z()),
            rotate_tool,
        };
        let name = phrase!("ticks_per_revolution");
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
        route: ConveyorPath,
        encoder: u8,
        name: &'static Text,
        ticks: f64,
        unit: f64,
    ) -> CommandResult {
        if !(ticks.is_finite() && ticks.abs() >= MIN_REQUESTED_RATE) {
            return Err(bad_value(
                name,
                ticks,
                phrase!("a finite number other than 0", "不为 0 的有限数"),
            ));
        }
        let (start, _) = self.encoder(encoder)?.position();
        let tcp = self.tool.position(self.commanded.frames());
        let encoder = usize::from(encoder);
        let mut tracking =
            ConveyorTracking::new(route, encoder, unit / ticks, start, tcp, self.step);
        self.limits.reset_overlay_share();
        if !matches!(self.generator, Generator::Hold) {
            tracking.wait();
        }
        self.tracking = Some(tracking);
        if matches!(self.generator, Generator::Path(_)) {
            self.queue.clear_speed_caps();
            self.keep_way();
        }
        Ok(Completion::Immediate)
    }

    pub(crate) fn stop_tracking(&mut self, id: CommandId) -> Completion {
        let Some(tracking) = &mut self.tracking else {
            return Completion::Immediate;
        };
        tracking.stop();
        self.stop_motion_underneath();
        self.rest_commands.add(id, RestCommand::Stop);
        Completion::Deferred
    }

    /// The generator's setpoint carried along with the conveyor.
    pub(crate) fn apply_conveyor(&mut self, nominal: &Setpoint) -> Result<Setpoint, StopReason> {
        let Some(tracking) = &self.tracking else {
            return Ok(*nominal);
        };
        let belt = self.encoders[tracking.encoder].position();
        if let Some(budget) = self.belt_budget(tracking, belt)? {
            self.share_with_belt(&budget);
        }
        self.await_motion();
        let Some(tracking) = &mut self.tracking else {
            return Ok(*nominal);
        };
        tracking.advance(belt, self.step);
        tracking
            .superimpose(
                nominal,
                self.commanded.setpoint(),
                &self.model,
                self.tool.flange_from_tcp(),
            )
            .ok_or(StopReason::ConveyorLost)
    }

    /// What the arm's way along the belt may be where the arm is, and what it leaves; `None` in a singular position.
    fn belt_budget(
        &self,
        tracking: &ConveyorTracking,
        belt: (f64, f64),
    ) -> Result<Option<Budget>, StopReason> {
        let frames = self.commanded.frames();
        let tcp = self.tool.position(frames);
        let twist = tracking.unit_twist(tcp);
        let jacobian = frames.jacobian(tcp).lu();
        let Some(per_way) = jacobian.solve(&twist.to_vector()) else {
            return Ok(None);
        };
        let limits = self.limits.in_force();
        let able = (0..6).fold(f64::INFINITY, |least, joint| {
            least.min(limits.acceleration[joint] / per_way[joint].abs())
        });
        // While the arm does nothing else the belt may use what motions would need.
        let share = match self.generator {
            Generator::Hold if self.lag.is_none() => SHARE_OF_BELT + SHARE_ON_BELT,
            _ => SHARE_OF_BELT,
        };
        let unit = JointSpeeds(per_way.into());
        let points = [
            (twist.linear.norm(), limits.tcp_speed),
            (elbow_speed(frames, &unit), limits.elbow_speed),
        ];
        let rate = tracking.rate(belt.1);
        for (number, (per_way, limit)) in points.into_iter().enumerate() {
            let value = rate * per_way;
            if value > FASTEST_BELT * limit && !tracking.is_stopping() {
                return Err(match number {
                    0 => StopReason::TcpSpeed { value, limit },
                    _ => StopReason::ElbowSpeed { value, limit },
                });
            }
        }
        // Faster than the belt only as far as the joints bear it, where they are and in the bends that they are led
        // through.
        let bias = frames.jacobian_rate_times_speeds(&unit, tcp);
        let bend = tracking.unit_curvature(tcp).to_vector() - bias.to_vector();
        let bend = jacobian.solve(&bend).unwrap_or_default();
        let mut fastest = f64::INFINITY;
        for joint in 0..6 {
            let most = SHARE_OF_JOINT_SPEED * limits.speed[joint] / per_way[joint].abs();
            let bent = SHARE_OF_BELT * limits.acceleration[joint] / bend[joint].abs();
            fastest = fastest.min(most).min(bent.sqrt());
        }
        fastest = fastest.max(FASTER_THAN_BELT * rate);
        // What the motion underneath leaves of the speeds of TCP and elbow.
        let heading = tracking.heading(belt);
        let way = tracking.way_speed();
        let own = JointSpeeds(core::array::from_fn(|joint| {
            self.commanded.setpoint().qd[joint] - way * per_way[joint]
        }));
        let own_tcp = frames.twist(&own, tcp).linear;
        let tcp_room = beside(
            &own_tcp,
            &(twist.linear * heading),
            SHARE_OF_POINTS * limits.tcp_speed,
        );
        let elbow_left = SHARE_OF_POINTS * limits.elbow_speed - elbow_speed(frames, &own);
        fastest = fastest.min(tcp_room).min(elbow_left.max(0.0) / points[1].0);
        // Motions that are planned now have what the belt leaves.
        let speed = rate.max(tracking.speed());
        let left = points.map(|(per_way, limit)| {
            (BELT_SHARE_OF_POINTS * limit - speed * per_way).max(LEAST_POINT_SHARE * limit)
        });
        Ok(Some(Budget {
            acceleration: share * able,
            speed: fastest,
            left,
        }))
    }

    /// Gives the belt its share, and motions what it leaves of the speeds of TCP and elbow: those that are planned now,
    /// and the one under way.
    fn share_with_belt(&mut self, budget: &Budget) {
        if let Some(tracking) = &mut self.tracking {
            tracking.limit(budget.acceleration, budget.speed);
        }
        self.limits.leave_under_belt(budget.left);
        if !matches!(self.generator, Generator::Path(_)) {
            self.limits.keep_way_within(budget.left);
            if let Some(tracking) = &mut self.tracking {
                tracking.end_early_motion();
            }
            return;
        }
        let Some(kept) = self.limits.way_speeds() else {
            return self.limits.keep_way_within(budget.left);
        };
        let is_other = |(now, kept): (&f64, &f64)| (now - kept).abs() > OTHER_LIMITS * kept;
        let is_due = self.out.cycle.is_multiple_of(CYCLES_APART);
        if is_due && budget.left.iter().zip(&kept).any(is_other) {
            self.limits.keep_way_within(budget.left);
            self.queue.clear_speed_caps();
        }
    }

    /// A motion that began before the belt was tracked was planned with everything the joints can do: the belt waits
    /// until it has slowed down so far that it leaves the belt its share.
    fn await_motion(&mut self) {
        let Some(tracking) = &mut self.tracking else {
            return;
        };
        if !tracking.is_waiting() {
            return;
        }
        let is_slow = match &self.generator {
            Generator::Path(_) => {
                let pace = self.queue.kept_pace();
                pace.is_some_and(|pace| tracking.pace() <= pace + LIMIT_SLACK)
            }
            Generator::Hold | Generator::Online(_) | Generator::Stop(_) => true,
        };
        let limits = self.limits.in_force();
        let leaves = |joint: usize| {
            self.target.qdd[joint].abs() <= (1.0 - SHARE_OF_BELT) * limits.acceleration[joint]
                && self.target.qd[joint].abs() <= (1.0 - SHARE_OF_BELT) * limits.speed[joint]
        };
        if is_slow && (0..6).all(leaves) {
            tracking.end_wait();
        }
    }

    /// The share of its speed at which a motion on a belt goes on.
    pub(crate) fn stretch_to_duration(&self) -> f64 {
        self.tracking.as_ref().map_or(1.0, ConveyorTracking::pace)
    }

    /// The setpoint of the belt within the speed limits of TCP and elbow, also while the joints come to rest; a motion
    /// on the belt is slowed down when it comes near to what joints, TCP and elbow can do.
    pub(crate) fn slow_for_belt(&mut self, carried: &Setpoint) -> Result<(), StopReason> {
        let able = self.limits.able();
        let soon = states(carried).map(|state| state.after(LOOK_AHEAD_TIME, 0.0));
        let mut used = (0..6).fold(0.0_f64, |most, joint| {
            let speed = carried.qd[joint].abs().max(soon[joint].speed.abs());
            most.max(speed / self.limits.in_force().speed[joint])
                .max(carried.qdd[joint].abs() / able.acceleration[joint])
        });
        let arm = (&self.model, self.tool.flange_from_tcp());
        if let Some(points) =
            PointSpeedLimits::new(arm.0, arm.1, self.limits.in_force(), &carried.q)
        {
            let axes = online_axes(able, self.step);
            let braking = points.max_speeds_while_braking(&states(carried), &axes, self.step);
            let checked = PointSpeedLimits::new(arm.0, arm.1, self.limits.enforced(), &carried.q);
            if let Some(reason) = checked.and_then(|points| points.exceeded(braking)) {
                return Err(reason);
            }
            // Online modes keep what the belt leaves of these speeds by themselves.
            let is_online = matches!(self.generator, Generator::Online(_));
            // Joints that brake each for itself may lead the TCP on faster than together.
            let soon_braking = points.max_speeds_while_braking(&soon, &axes, self.step);
            let soon = JointSpeeds(soon.map(|state| state.speed));
            let of_points = points
                .utilization_at(&carried.qd)
                .max(points.utilization_at(&soon))
                .max(points.utilization(braking))
                .max(points.utilization(soon_braking));
            used = used.max(if is_online { 0.0 } else { of_points });
        }
        // Who is still too fast for new limits comes down to them by those of the way ahead and of online modes; from
        // then on the joints must be able to brake as well.
        let used = if self.limits.is_slowing() && self.limit_utilization() > 1.0 {
            0.0
        } else {
            used
        };
        let kept_pace = self.queue.kept_pace();
        if let Some(tracking) = &mut self.tracking {
            let most = kept_pace.filter(|_| tracking.has_early_motion());
            tracking.adapt_pace(used, most.unwrap_or(1.0), self.step);
        }
        Ok(())
    }

    /// Ends tracking once it has come to rest, and the joints have made good what they lagged behind: from then on the
    /// generator starts where the arm is.
    pub(crate) fn settle_tracking(&mut self) {
        let is_braked = (self.joint_hold.is_none() && self.lag.is_none())
            || is_setpoint_at_rest(self.commanded.setpoint());
        let has_stopped = self
            .tracking
            .as_ref()
            .is_some_and(ConveyorTracking::has_stopped);
        if has_stopped && is_braked && matches!(self.generator, Generator::Hold) {
            self.tracking = None;
            self.limits.reset_overlay_share();
            self.lag = None;
            self.commanded.stand();
            self.target = *self.commanded.setpoint();
        }
    }

    pub(crate) fn encoder(&mut self, number: u8) -> Result<&mut Encoder, Refusal> {
        self.encoders.get_mut(usize::from(number)).ok_or_else(|| {
            bad_value(
                phrase!("encoder_index"),
                f64::from(number),
                phrase!("0 or 1", "0 或 1"),
            )
        })
    }

    pub(crate) fn set_tick_count(&mut self, number: u8, count: f64) -> CommandResult {
        let encoder = self.encoder(number)?;
        check_tick_count(encoder.is_from_program(), encoder.range(), count)?;
        self.update_encoder(usize::from(number), |encoder| encoder.set_count(count));
        Ok(Completion::Immediate)
    }

    pub(crate) fn count_by_program(&mut self, number: u8, range: EncoderRange) -> CommandResult {
        self.encoder(number)?;
        let take = |encoder: &mut Encoder| {
            encoder.take_from_program(range);
            true
        };
        self.update_encoder(usize::from(number), take);
        Ok(Completion::Immediate)
    }

    /// Changes what an encoder counts. Where that says where the counter is, not that the belt moved, a belt that is
    /// followed stays where it is.
    fn update_encoder(&mut self, number: usize, change: impl FnOnce(&mut Encoder) -> bool) {
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
    ) -> CommandResult {
        let inputs = self.io.image.digital_in.into();
        let is_fast = |channel: u8| (16..=17).contains(&channel);
        if !is_fast(channel_a) {
            return Err(bad_value(
                phrase!("A"),
                f64::from(channel_a),
                phrase!("16 or 17", "16 或 17"),
            ));
        }
        let two = decoding == PulseDecoding::Quadrature;
        if two && (!is_fast(channel_b) || channel_a == channel_b) {
            let needed = phrase!(
                "the other one of 16 and 17 in quadrature mode",
                "正交模式下 16 和 17 中的另一个"
            );
            return Err(bad_value(phrase!("B"), f64::from(channel_b), needed));
        }
        self.encoder(encoder)?;
        self.update_encoder(usize::from(encoder), |encoder| {
            encoder.take_pulses(decoding, channel_a, channel_b, inputs);
            true
        });
        Ok(Completion::Immediate)
    }
}

/// Share of the speed limits of TCP and elbow that a belt and what is planned on it may use together.
const BELT_SHARE_OF_POINTS: f64 = 0.93;
/// A belt is followed up to this share of the speed limits of TCP and elbow.
const FASTEST_BELT: f64 = 0.985;
/// Share of the points' speed limits that a motion on a belt is planned with at least, however much the belt takes: the
/// two need not have the same direction.
const LEAST_POINT_SHARE: f64 = 0.1;
/// A belt is caught up with at least this much faster than it is.
const FASTER_THAN_BELT: f64 = 1.2;
/// Share of the joints' speeds with which a belt is caught up with.
const SHARE_OF_JOINT_SPEED: f64 = 0.8;
/// Share of the speeds of TCP and elbow that a belt and the motion on it use while the belt is caught up with.
const SHARE_OF_POINTS: f64 = 0.95;
/// How far ahead the speeds of a motion on a belt are looked at, s.
const LOOK_AHEAD_TIME: f64 = 0.08;
/// Share by which limits have to change before the way ahead is looked at again.
const OTHER_LIMITS: f64 = 0.05;
/// The way ahead is looked at again in every so many cycles at most.
const CYCLES_APART: u64 = 8;

/// What the arm's way along a belt may do, in units of the way, and what it leaves.
struct Budget {
    /// Acceleration of the way.
    acceleration: f64,
    /// Speed of the way.
    speed: f64,
    /// Speeds of TCP and elbow that are left for motions, m/s.
    left: [f64; 2],
}

/// The largest speed along `unit` at which a point that already moves with `own` is no faster than `most`.
fn beside(own: &Vector3<f64>, unit: &Vector3<f64>, most: f64) -> f64 {
    let square = unit.norm_squared();
    if most.is_infinite() || square == 0.0 {
        return f64::INFINITY;
    }
    let along = own.dot(unit) / square;
    let under = along * along + (most * most - own.norm_squared()) / square;
    if under <= 0.0 {
        return 0.0;
    }
    (under.sqrt() - along).max(0.0)
}
