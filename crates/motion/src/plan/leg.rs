//! A planned leg: the way from one waypoint to the next, from rest to rest, and where its blend zone begins.
//!
//! A blend zone is the last part of a leg, in which the TCP is within the radius of the waypoint, never more than half of
//! the leg. Where the TCP hardly moves all that time, its turning counts as way as it does for the length of lines
//! ([`ROTATION_LENGTH`]), so that a leg which only turns has a zone too.

use kinematics::{Pose, RobotModel};
use motion_api::Warning;

use super::able::{Shares, speed_for_bend};
use super::{Arm, Warnings, Wish};
use crate::config::MotionLimits;
use crate::constants::{ROTATION_LENGTH, ZONE_PLACES, ZONE_TURNING_SHARE};
use crate::path::{Geometry, Path};
use crate::scalar::Course;

/// A leg in whose half the TCP gets no farther than this share of the radius counts by its turning.
const TURNING_SHARE: f64 = 0.1;

/// Planner error: the course along the path could not be planned.
pub(super) const NO_COURSE: u32 = 1;

/// The course in the wanted duration, or as fast as it is with a warning when that is longer.
pub(super) fn with_duration(course: Course, wanted: f64, warnings: &mut Warnings) -> Course {
    let planned = course.duration();
    if wanted > 0.0 && planned > wanted * (1.0 + 1e-9) {
        warnings.add(Warning::DurationStretched { wanted, planned });
    }
    course.stretched_to(wanted)
}

/// From one waypoint to the next.
#[derive(Clone, Copy, Debug)]
pub struct Leg {
    /// Where.
    pub path: Path,
    /// How fast, from rest to rest and as if there were no blend zone.
    pub course: Course,
    /// Wanted duration, s; 0 when there is none.
    pub duration: f64,
    /// Blend radius at the end, m; 0 stops there.
    pub radius: f64,
    /// The path's s where the blend zone begins; the end without a radius.
    pub zone: f64,
    /// Speed of s at which the zone may be entered while the next leg is not known.
    pub zone_speed: f64,
    /// The TCP whose distance counts.
    pub flange_from_tcp: Pose,
    /// How distances from the end are measured.
    pub measure: Measure,
}

/// How far a place is from a waypoint.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Measure {
    /// The TCP's distance.
    Tcp,
    /// That, or the way with its turning where that is longer.
    Turning,
}

impl Leg {
    /// Finds the blend zone. A radius that the leg is too short for is shortened, with a warning.
    pub fn new(
        path: Path,
        course: Course,
        wish: &Wish,
        arm: &Arm,
        warnings: &mut Warnings,
    ) -> Self {
        let mut leg = Self {
            path,
            course,
            duration: wish.duration,
            radius: wish.radius,
            zone: path.length(),
            zone_speed: f64::INFINITY,
            flange_from_tcp: *arm.flange_from_tcp,
            measure: Measure::Turning,
        };
        if wish.radius > 0.0 && leg.path.length() > 0.0 {
            let length = path.length();
            let (place, measure) = leg.place(arm.model, wish.radius, End::Last);
            leg.measure = measure;
            match place {
                Some(before) => leg.begin_zone(length - before, arm),
                None => leg.shorten(length / 2.0, arm, warnings),
            }
        } else {
            leg.radius = 0.0;
        }
        leg
    }

    /// Moves the beginning of the zone to `zone`, nearer to the end.
    pub fn shorten(&mut self, zone: f64, arm: &Arm, warnings: &mut Warnings) {
        let wanted = self.radius;
        self.begin_zone(zone, arm);
        self.radius = self.distance(arm.model, zone, End::Last, self.measure);
        warnings.add(Warning::RadiusShortened {
            wanted,
            planned: self.radius,
        });
    }

    fn begin_zone(&mut self, zone: f64, arm: &Arm) {
        self.zone = zone;
        let end = self.path.end().q;
        let place = self.path.point(arm.model, zone, &end);
        self.zone_speed = place.map_or(f64::INFINITY, |place| {
            let room = self.path.length() - zone;
            ZONE_TURNING_SHARE * turning_speed(&place.first, room, arm.limits)
        });
    }

    /// How far the place s is from one end, m.
    pub fn distance(&self, model: &RobotModel, s: f64, end: End, measure: Measure) -> f64 {
        let corner = match end {
            End::First => 0.0,
            End::Last => self.path.length(),
        };
        let tcp = |s| self.path.tcp(model, &self.flange_from_tcp, s);
        let away = (tcp(s) - tcp(corner)).norm();
        match measure {
            Measure::Tcp => away,
            Measure::Turning => {
                let metres_per_s = match self.path.geometry() {
                    Geometry::Joint(_) => ROTATION_LENGTH,
                    Geometry::Cartesian(_) | Geometry::Micro(_) | Geometry::Blend(_) => 1.0,
                };
                let way = (self.path.way(s).s - self.path.way(corner).s).abs();
                away.max(way * metres_per_s)
            }
        }
    }

    /// The way in s from one end to the nearest place that is `radius` metres away, `None` when there is none in this half
    /// of the leg; and how that was measured: by the TCP, or with its turning where the TCP hardly moves.
    pub fn place(&self, model: &RobotModel, radius: f64, end: End) -> (Option<f64>, Measure) {
        let middle = self.path.length() / 2.0;
        let reach = self.distance(model, middle, end, Measure::Tcp);
        let measure = if reach < TURNING_SHARE * radius {
            Measure::Turning
        } else {
            Measure::Tcp
        };
        (self.place_by(model, radius, end, measure), measure)
    }

    fn place_by(&self, model: &RobotModel, radius: f64, end: End, measure: Measure) -> Option<f64> {
        let length = self.path.length();
        let at = |way: f64| match end {
            End::First => self.distance(model, way, end, measure),
            End::Last => self.distance(model, length - way, end, measure),
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

/// The speed of s at which a curve of twice the length `room` can lead back the way it came, where the joints go `rates`
/// per s: f s - 2 f s³/L² + f s⁴/L³ for each joint, with second and third derivatives of at most 3 f/L and 12 f/L².
fn turning_speed(rates: &[f64; 6], room: f64, limits: &MotionLimits) -> f64 {
    let length = 2.0 * room;
    (0..6).fold(f64::INFINITY, |least, joint| {
        let rate = rates[joint].abs();
        least.min(speed_for_bend(
            (3.0 * rate / length, 12.0 * rate / (length * length)),
            joint,
            limits,
            &Shares::EVEN,
        ))
    })
}

/// One end of a leg.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum End {
    /// Where it begins.
    First,
    /// Where it ends.
    Last,
}
