//! Beams, presence boxes and distance sensors: what they see, and when their input tells it.

use crate::description::{Detector as Plan, DetectorKind};
use crate::engine::{Engine, vector};
use crate::parts::PartTable;
use crate::state::DetectorState;
use kinematics::Pose;
use motion_api::PointLevels;
use nalgebra::Vector3;
use rapier3d_f64::geometry::Ray;
use rapier3d_f64::pipeline::QueryFilter;
use std::collections::VecDeque;

/// A detector.
#[derive(Clone, Debug)]
pub(crate) struct Detector {
    plan: Plan,
    pub(crate) state: DetectorState,
    /// Share of the analog range, or 0 and 1, of the cycles whose signal is still under way; the oldest first.
    under_way: VecDeque<f64>,
    delay_cycles: usize,
    signal: f64,
}

impl Detector {
    pub(crate) fn new(plan: &Plan, period: f64) -> Self {
        let delay_cycles = (plan.delay / period).round() as usize;
        Self {
            plan: plan.clone(),
            state: DetectorState::default(),
            under_way: VecDeque::with_capacity(delay_cycles + 1),
            delay_cycles,
            signal: 0.0,
        }
    }

    /// After the engine's step.
    pub(crate) fn look(&mut self, engine: &Engine, parts: &PartTable) {
        let share;
        (self.state, share) = match &self.plan.kind {
            DetectorKind::Beam { from, until } => {
                let way = Vector3::from(*until) - Vector3::from(*from);
                let distance = first_hit(engine, (*from).into(), way.normalize(), way.norm());
                let sees = distance.is_some();
                (
                    DetectorState {
                        sees,
                        distance: distance.unwrap_or(way.norm()),
                    },
                    f64::from(u8::from(sees)),
                )
            }
            DetectorKind::Presence { pose, size } => {
                let sees = parts
                    .bodies
                    .values()
                    .any(|part| is_inside(pose, size, &parts.center(engine, part)));
                (
                    DetectorState {
                        sees,
                        distance: 0.0,
                    },
                    f64::from(u8::from(sees)),
                )
            }
            DetectorKind::Distance { pose, range } => {
                let distance =
                    first_hit(engine, pose.translation, pose.rotate(Vector3::z()), *range);
                let sees = distance.is_some();
                let distance = distance.unwrap_or(*range);
                (DetectorState { sees, distance }, distance / range)
            }
        };
        let signal = if self.plan.inverted {
            1.0 - share
        } else {
            share
        };
        self.under_way.push_back(signal);
        // While the first signal is under way, the input has what the detector saw first.
        if self.under_way.len() > self.delay_cycles || self.under_way.len() == 1 {
            self.signal = self.under_way.front().copied().unwrap_or(signal);
        }
        if self.under_way.len() > self.delay_cycles {
            self.under_way.pop_front();
        }
    }

    /// Tells the input.
    pub(crate) fn report(&self, inputs: &mut PointLevels) {
        match self.plan.kind {
            DetectorKind::Distance { .. } => inputs.set_ratio(self.plan.to, self.signal),
            _ => inputs.set_level(self.plan.to, self.signal > 0.5),
        }
    }
}

fn first_hit(
    engine: &Engine,
    from: Vector3<f64>,
    direction: Vector3<f64>,
    range: f64,
) -> Option<f64> {
    let ray = Ray::new(vector(from), vector(direction));
    engine
        .physics
        .cast_ray(&ray, range, true, QueryFilter::default())
        .map(|(_, distance)| distance)
}

/// Whether a point is inside a box.
pub(crate) fn is_inside(middle: &Pose, size: &[f64; 3], point: &Vector3<f64>) -> bool {
    let at = middle.rotate_back(point - middle.translation);
    (0..3).all(|k| at[k].abs() <= size[k] / 2.0)
}
