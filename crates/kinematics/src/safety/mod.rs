//! What the safety settings allow: joint ranges, safety planes, and the tool against them.
//!
//! Owns the one check that both `is_within_safety_limits` (manual 3.1.35) and the control cycle make, so that they
//! agree. Knows no inputs and no modes of the machine: the caller says which planes count ([`PlaneSwitches`]). Fixed
//! size, no allocation. Speeds and forces are not looked at, they are no property of a position.

mod plane;

use crate::chain::Frames;
use crate::collision::{LinkIndex, link_name};
use crate::elementary;
use crate::joint::JointPositions;
use crate::model::RobotModel;
use crate::pose::Pose;
use messages::{Language, Localized, Text, text};
use nalgebra::Vector3;
use std::sync::Arc;

pub use plane::{PlaneMode, PlaneSwitches, SafetyPlane};

/// The most safety planes.
pub const SAFETY_PLANES_MAX: usize = 8;

/// Pairs of configurable inputs that can switch planes: CI0/1, CI2/3, CI4/5, CI6/7.
pub const CI_PAIRS: usize = 4;

/// Joint positions may lie outside their ranges by this, rad: what printing and reading them again leaves.
pub const POSITION_SLACK: f64 = 1e-6;

/// A safety setting that cannot be used.
#[derive(Clone, Debug, PartialEq, thiserror::Error, Localized)]
#[non_exhaustive]
#[expect(missing_docs, reason = "the messages say what the fields are")]
pub enum SafetySettingError {
    #[error("the {what} of a safety plane is {value:?}, it must be {allowed}")]
    #[zh("安全平面的 {what} 为 {value:?}，应为{allowed}")]
    Plane {
        what: &'static str,
        value: [f64; 3],
        allowed: Text,
    },
    #[error("ci_pair is {0}, it must be 0 to 3 (CI0/1, CI2/3, CI4/5, CI6/7)")]
    #[zh("ci_pair 为 {0}，应为 0 到 3（CI0/1、CI2/3、CI4/5、CI6/7）")]
    CiPair(u8),
    #[error("there are {SAFETY_PLANES_MAX} safety planes already, more are not possible")]
    #[zh("已有 {SAFETY_PLANES_MAX} 个安全平面，不能再多")]
    TooManyPlanes,
    #[error("the size of the tool's {shape} is {size:?}, every number must be finite and positive")]
    #[zh("工具的 {shape} 尺寸为 {size:?}，每个数都必须是有限的正数")]
    ToolSize { shape: &'static str, size: [f64; 3] },
    #[error(
        "the hull of the tool has the point {point:?}, at least one point is needed and all must be finite"
    )]
    #[zh("工具的凸包有点 {point:?}，至少需要一个点，且必须都是有限值")]
    ToolPoint { point: Option<[f64; 3]> },
}

/// Shape of the tool beyond its TCP; all but a hull are centred on their own frame. Metres.
#[derive(Clone, Debug, PartialEq)]
enum Shape {
    Ball {
        radius: f64,
    },
    Box {
        half: [f64; 3],
    },
    Cylinder {
        radius: f64,
        half_length: f64,
    },
    /// The smallest convex body around points.
    Hull(Arc<[Vector3<f64>]>),
}

/// A tool that must not cross safety planes either.
#[derive(Clone, Debug, PartialEq)]
pub struct SafetyTool {
    flange_from_shape: Pose,
    shape: Shape,
}

impl SafetyTool {
    fn new(
        flange_from_shape: Pose,
        name: &'static str,
        size: [f64; 3],
        shape: Shape,
    ) -> Result<Self, SafetySettingError> {
        if !size.iter().all(|x| x.is_finite() && *x > 0.0) {
            return Err(SafetySettingError::ToolSize { shape: name, size });
        }
        Ok(Self {
            flange_from_shape,
            shape,
        })
    }

    /// A ball of `radius` m around the origin of its frame.
    ///
    /// # Errors
    /// A radius that is not positive.
    pub fn ball(flange_from_shape: Pose, radius: f64) -> Result<Self, SafetySettingError> {
        Self::new(
            flange_from_shape,
            "ball",
            [radius; 3],
            Shape::Ball { radius },
        )
    }

    /// A box with edges of `size` m along its axes, centred.
    ///
    /// # Errors
    /// An edge that is not positive.
    pub fn cuboid(flange_from_shape: Pose, size: [f64; 3]) -> Result<Self, SafetySettingError> {
        let half = size.map(|edge| edge / 2.0);
        Self::new(flange_from_shape, "box", size, Shape::Box { half })
    }

    /// A cylinder of `radius` and `length` m along its z axis, centred.
    ///
    /// # Errors
    /// A length that is not positive.
    pub fn cylinder(
        flange_from_shape: Pose,
        radius: f64,
        length: f64,
    ) -> Result<Self, SafetySettingError> {
        let shape = Shape::Cylinder {
            radius,
            half_length: length / 2.0,
        };
        Self::new(
            flange_from_shape,
            "cylinder",
            [radius, radius, length],
            shape,
        )
    }

    /// The smallest convex body around points, m.
    ///
    /// # Errors
    /// No points, or one that is not finite.
    pub fn hull(
        flange_from_shape: Pose,
        points: Arc<[Vector3<f64>]>,
    ) -> Result<Self, SafetySettingError> {
        let is_sound = |p: &Vector3<f64>| p.iter().all(|x| x.is_finite());
        match points.iter().find(|p| !is_sound(p)) {
            Some(bad) => Err(SafetySettingError::ToolPoint {
                point: Some((*bad).into()),
            }),
            None if points.is_empty() => Err(SafetySettingError::ToolPoint { point: None }),
            None => Ok(Self {
                flange_from_shape,
                shape: Shape::Hull(points),
            }),
        }
    }

    /// How far the shape reaches from its origin along a unit vector of its own frame, m.
    fn reach(&self, direction: Vector3<f64>) -> f64 {
        match self.shape {
            Shape::Hull(ref points) => points
                .iter()
                .map(|p| p.dot(&direction))
                .fold(f64::NEG_INFINITY, f64::max),
            Shape::Ball { radius } => radius,
            Shape::Box { half } => direction.abs().dot(&Vector3::from(half)),
            Shape::Cylinder {
                radius,
                half_length,
            } => {
                radius * elementary::hypot(direction.x, direction.y)
                    + half_length * direction.z.abs()
            }
        }
    }

    /// Height of the tool's lowest point above a plane, m.
    fn height(&self, plane: &SafetyPlane, base_from_flange: &Pose) -> f64 {
        let base_from_shape = *base_from_flange * self.flange_from_shape;
        plane.height(base_from_shape.translation)
            - self.reach(-base_from_shape.rotate_back(plane.normal))
    }
}

/// What a safety plane holds back.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ProtectedPart {
    /// The tool centre point.
    Tcp,
    /// The tool's shape.
    Tool,
    /// The elbow (origin of joint 3).
    Elbow,
}

impl ProtectedPart {
    const fn text(self) -> Text {
        match self {
            Self::Tcp => text!("the TCP", "TCP"),
            Self::Tool => text!("the tool", "工具"),
            Self::Elbow => text!("the elbow", "肘部"),
        }
    }
}

impl core::fmt::Display for ProtectedPart {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        core::fmt::Display::fmt(&self.text(), f)
    }
}

impl Localized for ProtectedPart {
    fn fmt_in(&self, language: Language, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        self.text().fmt_in(language, f)
    }
}

/// A reason why a position is not allowed.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error, Localized)]
#[non_exhaustive]
#[expect(missing_docs, reason = "the messages say what the fields are")]
pub enum SafetyViolation {
    #[error("no joint positions inside the limits reach the pose")]
    #[zh("限位之内没有关节位置能到达该位姿")]
    Unreachable,
    #[error("joint {} is at {value_rad:.4} rad, allowed are {min_rad:.4} to {max_rad:.4} rad", .joint + 1)]
    #[zh("关节 {} 位于 {value_rad:.4} rad，允许 {min_rad:.4} 到 {max_rad:.4} rad", .joint + 1)]
    JointPosition {
        joint: usize,
        value_rad: f64,
        min_rad: f64,
        max_rad: f64,
    },
    #[error("{part} is {depth_m:.4} m behind safety plane {plane}")]
    #[zh("{part}在安全平面 {plane} 之后 {depth_m:.4} m")]
    Plane {
        plane: usize,
        part: ProtectedPart,
        depth_m: f64,
    },
    #[error("{} and {} overlap by {depth_m:.4} m", link_name(.links[0]), link_name(.links[1]))]
    #[zh("{}与{}重叠 {depth_m:.4} m", link_name(.links[0]), link_name(.links[1]))]
    Links { links: [LinkIndex; 2], depth_m: f64 },
}

/// The safety settings that bound positions. Starts with none; joint ranges are the model's.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SafetyBounds {
    planes: [Option<SafetyPlane>; SAFETY_PLANES_MAX],
    tool: Option<SafetyTool>,
    restrict_elbow: bool,
    /// Smallest and largest joint positions in reduced mode.
    reduced_range: Option<[JointPositions; 2]>,
    /// How far links may overlap, m; `None`: as far as they like.
    link_overlap: Option<f64>,
}

/// An overlap of links that is there already may be as deep as it is, up to rounding, m.
pub const OVERLAP_SLACK: f64 = 1e-6;

impl SafetyBounds {
    /// These bounds and one more plane, which gets the next number from 0.
    ///
    /// # Errors
    /// [`SafetySettingError::TooManyPlanes`].
    pub fn with_plane(mut self, plane: SafetyPlane) -> Result<Self, SafetySettingError> {
        let free = self.planes.iter_mut().find(|slot| slot.is_none());
        *free.ok_or(SafetySettingError::TooManyPlanes)? = Some(plane);
        Ok(self)
    }

    /// These bounds with another tool; without one, only the TCP is held back.
    pub fn with_tool(self, tool: Option<SafetyTool>) -> Self {
        Self { tool, ..self }
    }

    /// These bounds with planes that hold back the elbow too (by default they do not).
    pub fn with_restricted_elbow(self, restrict_elbow: bool) -> Self {
        Self {
            restrict_elbow,
            ..self
        }
    }

    /// These bounds with other joint ranges in reduced mode, rad.
    pub fn with_reduced_range(self, min: JointPositions, max: JointPositions) -> Self {
        Self {
            reduced_range: Some([min, max]),
            ..self
        }
    }

    /// These bounds with links of the arm that may overlap by `allowed`, m; an infinite value allows any overlap.
    pub fn with_link_overlap(self, allowed: f64) -> Self {
        Self {
            link_overlap: allowed.is_finite().then_some(allowed),
            ..self
        }
    }

    /// The planes by number.
    pub fn planes(&self) -> impl Iterator<Item = (usize, &SafetyPlane)> {
        self.planes
            .iter()
            .enumerate()
            .filter_map(|(number, plane)| Some((number, plane.as_ref()?)))
    }

    /// The first active plane that is crossed at the given joint frames. A NaN counts as crossed.
    pub fn plane_violation(
        &self,
        frames: &Frames,
        flange_from_tcp: &Pose,
        switches: &PlaneSwitches,
    ) -> Option<SafetyViolation> {
        let flange = &frames.base_from_flange;
        let tcp = flange.transform_point(flange_from_tcp.translation);
        for (number, plane) in self.planes().filter(|(_, p)| p.is_active(switches)) {
            let heights = [
                (ProtectedPart::Tcp, Some(plane.height(tcp))),
                (
                    ProtectedPart::Tool,
                    self.tool.as_ref().map(|tool| tool.height(plane, flange)),
                ),
                (
                    ProtectedPart::Elbow,
                    self.restrict_elbow.then(|| plane.height(frames.elbow())),
                ),
            ];
            for (part, height) in heights {
                if let Some(height) = height.filter(|h| *h < 0.0 || h.is_nan()) {
                    return Some(SafetyViolation::Plane {
                        plane: number,
                        part,
                        depth_m: -height,
                    });
                }
            }
        }
        None
    }

    /// What keeps the arm from standing at `q`: a joint outside its range (first; [`POSITION_SLACK`] is for rounding),
    /// or a plane.
    pub fn violation_at(
        &self,
        model: &RobotModel,
        q: &JointPositions,
        flange_from_tcp: &Pose,
        switches: &PlaneSwitches,
    ) -> Option<SafetyViolation> {
        let limits = model.limits();
        let own = [limits.position_min, limits.position_max];
        let reduced = self.reduced_range.filter(|_| switches.reduced);
        let outside = outside_of(&own, POSITION_SLACK, q).or_else(|| outside_of(&reduced?, 0.0, q));
        outside.or_else(|| self.plane_violation(&model.forward(q), flange_from_tcp, switches))
    }

    /// Two links that would overlap too much at `q`, for an arm that is at `here`: one that stands in itself may move
    /// as long as it does not get deeper.
    pub fn link_violation(
        &self,
        model: &RobotModel,
        q: &JointPositions,
        here: &JointPositions,
    ) -> Option<SafetyViolation> {
        let most = self.link_overlap?;
        let nearest = |q| model.collision().self_distance(&model.forward(q));
        let found = nearest(q).filter(|found| -found.distance > most)?;
        let deep = nearest(here).map_or(0.0, |found| -found.distance);
        let (a, b) = found.links;
        let is_deeper = deep <= most || -found.distance > deep + OVERLAP_SLACK;
        is_deeper.then_some(SafetyViolation::Links {
            links: [a, b],
            depth_m: -found.distance,
        })
    }

    /// What keeps the TCP from being at a pose: no solution inside the joint ranges, or the one nearest to `near`
    /// crosses a plane.
    pub fn violation_at_pose(
        &self,
        model: &RobotModel,
        base_from_tcp: &Pose,
        flange_from_tcp: &Pose,
        near: &JointPositions,
        switches: &PlaneSwitches,
    ) -> Option<SafetyViolation> {
        match model.inverse_nearest(base_from_tcp, flange_from_tcp, near) {
            None => Some(SafetyViolation::Unreachable),
            Some(q) => self.violation_at(model, &q, flange_from_tcp, switches),
        }
    }
}

/// The first joint that is more than `slack` outside of a range.
fn outside_of(
    [min, max]: &[JointPositions; 2],
    slack: f64,
    q: &JointPositions,
) -> Option<SafetyViolation> {
    let is_inside = |joint: usize| (min[joint] - slack..=max[joint] + slack).contains(&q[joint]);
    let joint = (0..6).find(|joint| !is_inside(*joint))?;
    Some(SafetyViolation::JointPosition {
        joint,
        value_rad: q[joint],
        min_rad: min[joint],
        max_rad: max[joint],
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pose::RpyPose;
    use proptest::prelude::*;

    fn above(z: f64) -> SafetyPlane {
        SafetyPlane::new([0.0, 0.0, z], [0.0, 0.0, 2.0], PlaneMode::Both, None).unwrap()
    }

    fn cs66() -> RobotModel {
        RobotModel::built_in("cs66").unwrap()
    }

    /// TCP at z = 0.066, elbow at 0.1625.
    const STRETCHED: JointPositions = JointPositions::ZERO;

    #[test]
    fn a_plane_holds_back_the_tcp_the_tool_and_if_asked_the_elbow() {
        let arm = cs66();
        let check = |bounds: SafetyBounds, tcp: &Pose| {
            bounds.violation_at(&arm, &STRETCHED, tcp, &PlaneSwitches::default())
        };
        let bounds = SafetyBounds::default().with_plane(above(0.05)).unwrap();
        assert_eq!(check(bounds.clone(), &Pose::IDENTITY), None);
        // The flange's y axis points up here.
        let low = Pose::from_translation(0.0, -0.03, 0.0);
        let found = check(bounds.clone(), &low).unwrap();
        assert_eq!(
            found.to_string(),
            "the TCP is 0.0140 m behind safety plane 0"
        );
        let ball = SafetyTool::ball(Pose::IDENTITY, 0.02).unwrap();
        let found = check(bounds.with_tool(Some(ball)), &Pose::IDENTITY).unwrap();
        assert_eq!(
            found.to_string(),
            "the tool is 0.0040 m behind safety plane 0"
        );
        let below =
            SafetyPlane::new([0.0, 0.0, 0.1], [0.0, 0.0, -1.0], PlaneMode::Both, None).unwrap();
        let bounds = SafetyBounds::default().with_plane(below).unwrap();
        assert_eq!(check(bounds.clone(), &Pose::IDENTITY), None);
        let found = check(bounds.clone().with_restricted_elbow(true), &Pose::IDENTITY).unwrap();
        assert_eq!(
            found.to_string(),
            "the elbow is 0.0625 m behind safety plane 0"
        );
    }

    #[test]
    fn joints_come_before_planes_and_poses_must_be_reachable() {
        let arm = cs66();
        let switches = PlaneSwitches::default();
        let bounds = SafetyBounds::default().with_plane(above(9.0)).unwrap();
        let q = JointPositions([0.0, 0.0, 3.2, 0.0, 0.0, 0.0]);
        let found = bounds
            .violation_at(&arm, &q, &Pose::IDENTITY, &switches)
            .unwrap();
        assert_eq!(
            found.to_string(),
            "joint 3 is at 3.2000 rad, allowed are -3.1416 to 3.1416 rad"
        );
        let far = Pose::from_translation(3.0, 0.0, 0.0);
        let found = bounds.violation_at_pose(&arm, &far, &Pose::IDENTITY, &STRETCHED, &switches);
        assert_eq!(found, Some(SafetyViolation::Unreachable));
        let nan = JointPositions([f64::NAN; 6]);
        assert!(
            bounds
                .violation_at(&arm, &nan, &Pose::IDENTITY, &switches)
                .is_some()
        );
    }

    #[test]
    fn planes_count_in_their_mode_and_while_their_inputs_are_set() {
        let plane = |mode, pair| SafetyPlane::new([0.0; 3], [1.0, 0.0, 0.0], mode, pair).unwrap();
        let normal = PlaneSwitches::default();
        let reduced = PlaneSwitches {
            reduced: true,
            ..normal
        };
        let second = PlaneSwitches {
            ci_pairs: [false, true, false, false],
            ..normal
        };
        let active = |mode, pair| {
            [normal, reduced, second].map(|switches| plane(mode, pair).is_active(&switches))
        };
        assert_eq!(active(PlaneMode::Normal, None), [true, false, true]);
        assert_eq!(active(PlaneMode::Reduced, None), [false, true, false]);
        assert_eq!(active(PlaneMode::Both, None), [true, true, true]);
        assert_eq!(active(PlaneMode::Off, None), [false, false, false]);
        assert_eq!(active(PlaneMode::Both, Some(1)), [false, false, true]);
        assert_eq!(active(PlaneMode::Both, Some(0)), [false, false, false]);
    }

    #[test]
    fn settings_that_mean_nothing_are_refused() {
        let plane = |point, normal, pair| SafetyPlane::new(point, normal, PlaneMode::Both, pair);
        let z = [0.0, 0.0, 1.0];
        for (refused, word) in [
            (plane([f64::NAN; 3], z, None), "point"),
            (plane([0.0; 3], [0.0; 3], None), "normal"),
            (plane([0.0; 3], [f64::INFINITY; 3], None), "normal"),
            (plane([0.0; 3], z, Some(4)), "ci_pair is 4"),
        ] {
            assert!(refused.unwrap_err().to_string().contains(word));
        }
        assert!(SafetyTool::ball(Pose::IDENTITY, 0.0).is_err());
        assert!(SafetyTool::cuboid(Pose::IDENTITY, [1.0, f64::NAN, 1.0]).is_err());
        assert!(SafetyTool::cylinder(Pose::IDENTITY, 0.1, -1.0).is_err());
        let full = (0..SAFETY_PLANES_MAX).fold(SafetyBounds::default(), |bounds, _| {
            bounds.with_plane(above(0.0)).unwrap()
        });
        assert_eq!(full.planes().count(), SAFETY_PLANES_MAX);
        assert_eq!(
            full.with_plane(above(0.0)),
            Err(SafetySettingError::TooManyPlanes)
        );
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(200))]

        /// Corners and rims, the long way round.
        #[test]
        fn the_lowest_point_of_a_tool_is_the_lowest_of_its_surface(
            rpy in prop::array::uniform3(-3.0..3.0), flange in prop::array::uniform3(-3.0..3.0),
            normal in prop::array::uniform3(0.1..1.0),
        ) {
            let place = Pose::from_rpy(&RpyPose { xyz: [0.1, -0.2, 0.3], rpy });
            let base_from_flange = Pose::from_rpy(&RpyPose { xyz: [0.5, 0.1, 0.2], rpy: flange });
            let plane = SafetyPlane::new([0.1; 3], normal, PlaneMode::Both, None).unwrap();
            let height = |p: [f64; 3]| plane.height((base_from_flange * place).transform_point(p.into()));
            let corners = (0..8).map(|i| {
                [0, 1, 2].map(|k| if i >> k & 1 == 1 { 0.1 } else { -0.1 } * (1.0 + k as f64))
            });
            let lowest = corners.map(height).fold(f64::INFINITY, f64::min);
            let cuboid = SafetyTool::cuboid(place, [0.2, 0.4, 0.6]).unwrap();
            prop_assert!((cuboid.height(&plane, &base_from_flange) - lowest).abs() < 1e-12);
            let rims = (0..20_000).map(|i| {
                let angle = f64::from(i) * core::f64::consts::TAU / 10_000.0;
                [0.05 * angle.cos(), 0.05 * angle.sin(), if i < 10_000 { 0.2 } else { -0.2 }]
            });
            let lowest = rims.map(height).fold(f64::INFINITY, f64::min);
            let cylinder = SafetyTool::cylinder(place, 0.05, 0.4).unwrap();
            prop_assert!((cylinder.height(&plane, &base_from_flange) - lowest).abs() < 1e-7);
        }
    }
}
