//! A planned leg: the way from one waypoint to the next, and where its blend zone begins.
//!
//! A blend zone is the last part of a leg, in which the TCP is within the radius of the waypoint, never more than half
//! of the leg. Where the TCP hardly moves all that time, its turning counts as way as it does for the length of lines
//! ([`ROTATION_LENGTH`]), so that a leg which only turns has a zone too.

use kinematics::elementary::cbrt;
use kinematics::{Pose, RobotModel};
use motion_api::{Refusal, Warning};

use super::{MotionRequest, PlanningContext, Warnings};
use crate::constants::{
    BLEND_ACCELERATION_FACTOR, CURVATURE_SHARES, MIN_REQUESTED_RATE, PROCESS_ZONE, ROTATION_LENGTH,
    ZONE_PLACES, ZONE_TURNING_SHARE,
};
use crate::path::Path;

/// A leg in whose half the TCP gets no farther than this share of the radius counts by its turning.
const TURNING_SHARE: f64 = 0.1;

/// From one waypoint to the next.
#[derive(Clone, Copy, Debug)]
pub struct MotionSegment {
    /// Where.
    pub path: Path,
    /// The speed, acceleration and time that are asked for.
    pub request: MotionRequest,
    /// Distance from the end at which a blend may begin, m; 0 stops there.
    pub radius: f64,
    /// Where the arc of a process move touches, m; 0 for other moves.
    pub arc_tangent_distance: f64,
    /// The path's s where the blend zone begins; the end without a radius.
    pub blend_start: f64,
    /// Speed of s at which the arm may be some way in the zone while the next leg is not known.
    pub blend_entry_speed: f64,
    /// The TCP whose distance counts.
    pub flange_from_tcp: Pose,
    /// How distances from the end are measured.
    pub measure: DistanceMeasure,
    /// The refusal to report when the leg ends, because it leads less far than the program asked; `None` when it does
    /// not.
    pub beyond: Option<Refusal>,
}

/// How far a place is from a waypoint.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DistanceMeasure {
    /// The TCP's distance.
    Tcp,
    /// The TCP's distance, or the way with its turning where that is longer.
    TcpOrRotation,
}

impl MotionSegment {
    /// Finds the blend zone. A radius that the leg is too short for is shortened, with a warning.
    pub fn new(
        path: Path,
        wish: &MotionRequest,
        arm: &PlanningContext,
        warnings: &mut Warnings,
    ) -> Self {
        let touch = if wish.is_process_move {
            wish.radius
        } else {
            0.0
        };
        let mut wish = *wish;
        if wish.duration > 0.0 {
            // What neighbours are told: how fast it is on the whole.
            wish.speed = (path.length() / wish.duration).max(MIN_REQUESTED_RATE);
        }
        let mut leg = Self {
            path,
            request: wish,
            radius: wish.radius,
            arc_tangent_distance: touch,
            blend_start: path.length(),
            blend_entry_speed: f64::INFINITY,
            flange_from_tcp: *arm.flange_from_tcp,
            measure: DistanceMeasure::TcpOrRotation,
            beyond: None,
        };
        if wish.radius <= 0.0 || path.length() <= 0.0 {
            leg.radius = 0.0;
            return leg;
        }
        let length = path.length();
        if wish.is_process_move {
            // The curve reaches a little beyond where its arc touches.
            leg.radius *= PROCESS_ZONE;
        }
        let (place, measure) = leg.parameter_at_distance(arm.model, leg.radius, SegmentEnd::Target);
        leg.measure = measure;
        match place {
            Some(before) => leg.begin_zone(length - before, arm),
            None => leg.shorten_blend_zone(length / 2.0, arm, warnings),
        }
        leg
    }

    /// Moves the beginning of the zone to `blend_start`, nearer to the end.
    pub fn shorten_blend_zone(
        &mut self,
        zone: f64,
        arm: &PlanningContext,
        warnings: &mut Warnings,
    ) {
        let wanted = self.radius;
        self.begin_zone(zone, arm);
        self.radius = self.distance(arm.model, zone, SegmentEnd::Target, self.measure);
        let wanted = if self.request.is_process_move {
            self.arc_tangent_distance
        } else {
            wanted
        };
        if wanted > self.radius {
            warnings.add(Warning::RadiusShortened {
                wanted,
                planned: self.radius,
            });
        }
    }

    fn begin_zone(&mut self, zone: f64, arm: &PlanningContext) {
        self.blend_start = zone;
        let end = self.path.end_setpoint().q;
        let Some(place) = self.path.point(arm.model, zone, &end) else {
            return;
        };
        // A curve of twice the length of the zone that leads back the way it came goes f s - 2 f s³/L² + f s⁴/L³ for
        // each joint, with second and third derivatives of at most 3 f/L and 12 f/L².
        let length = 2.0 * (self.path.length() - zone);
        let most = match self.path {
            Path::Joint(_) if self.request.duration <= 0.0 => {
                BLEND_ACCELERATION_FACTOR * self.request.acceleration
            }
            _ => f64::INFINITY,
        };
        let speed = (0..6).fold(f64::INFINITY, |least, joint| {
            let bend = place.dq_ds[joint].abs() / length;
            let acceleration = arm.limits.acceleration[joint].min(most);
            let by_jerk = CURVATURE_SHARES.jerk * arm.limits.jerk[joint] / (12.0 * bend / length);
            let by_acceleration = CURVATURE_SHARES.acceleration * acceleration / (3.0 * bend);
            least.min(by_acceleration.sqrt()).min(cbrt(by_jerk))
        });
        self.blend_entry_speed = ZONE_TURNING_SHARE * speed;
    }

    /// How far the place s is from one end, m.
    pub fn distance(
        &self,
        model: &RobotModel,
        s: f64,
        end: SegmentEnd,
        measure: DistanceMeasure,
    ) -> f64 {
        let corner = match end {
            SegmentEnd::Start => 0.0,
            SegmentEnd::Target => self.path.length(),
        };
        let tcp = |s| self.path.tcp_position(model, &self.flange_from_tcp, s);
        let away = (tcp(s) - tcp(corner)).norm();
        match measure {
            DistanceMeasure::Tcp => away,
            DistanceMeasure::TcpOrRotation => {
                let metres_per_s = match self.path {
                    Path::Joint(_) => ROTATION_LENGTH,
                    Path::Cartesian(_)
                    | Path::MicroLine(_)
                    | Path::JointBlend(_)
                    | Path::ClothoidBlend(_) => 1.0,
                };
                away.max((s - corner).abs() * metres_per_s)
            }
        }
    }

    /// The way in s from one end to the nearest place that is `radius` metres away, `None` when there is none in this
    /// half of the leg; and how that was measured: by the TCP, or with its turning where the TCP hardly moves.
    pub fn parameter_at_distance(
        &self,
        model: &RobotModel,
        radius: f64,
        end: SegmentEnd,
    ) -> (Option<f64>, DistanceMeasure) {
        let middle = self.path.length() / 2.0;
        let reach = self.distance(model, middle, end, DistanceMeasure::Tcp);
        let measure = if reach < TURNING_SHARE * radius {
            DistanceMeasure::TcpOrRotation
        } else {
            DistanceMeasure::Tcp
        };
        (
            self.parameter_at_distance_by(model, radius, end, measure),
            measure,
        )
    }

    fn parameter_at_distance_by(
        &self,
        model: &RobotModel,
        radius: f64,
        end: SegmentEnd,
        measure: DistanceMeasure,
    ) -> Option<f64> {
        let length = self.path.length();
        let at = |way: f64| match end {
            SegmentEnd::Start => self.distance(model, way, end, measure),
            SegmentEnd::Target => self.distance(model, length - way, end, measure),
        };
        let half = length / 2.0;
        let mut near = 0.0;
        let far = (1..=ZONE_PLACES).find_map(|k| {
            let way = half * k as f64 / ZONE_PLACES as f64;
            if at(way) >= radius * (1.0 - 1e-12) {
                return Some(way);
            }
            near = way;
            None
        });
        let mut far = far?;
        for _ in 0..40 {
            let middle = 0.5 * (near + far);
            if at(middle) >= radius {
                far = middle;
            } else {
                near = middle;
            }
        }
        // Not outside the radius by a rounding.
        Some(near)
    }
}

/// One end of a leg.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SegmentEnd {
    /// Where the leg begins.
    Start,
    /// Where the leg ends.
    Target,
}
