//! Where parts come from.

use crate::description::{SourceDescription as Plan, Trigger};
use crate::edges::Edge;
use crate::engine::{Engine, EngineShape, engine_pose};
use crate::parts::PartTable;
use crate::scatter::Scatter;
use crate::state::SourceState;
use kinematics::{Pose, rotation};
use motion_api::PointLevels;
use nalgebra::Vector3;
use rapier3d_f64::pipeline::QueryFilter;

/// A source.
#[derive(Clone, Debug)]
pub(crate) struct Source {
    plan: Plan,
    template: usize,
    scatter: Scatter,
    edge: Edge,
    /// When the next is due, s.
    due: f64,
    pub(crate) state: SourceState,
}

impl Source {
    pub(crate) fn new(plan: &Plan, parts: &PartTable, seed: u64, index: usize) -> Self {
        Self {
            // Checked: the template is there.
            template: parts.template(&plan.part).unwrap_or_default(),
            scatter: Scatter::new(seed, index as u64),
            edge: Edge::default(),
            due: plan.start_at,
            state: SourceState::default(),
            plan: plan.clone(),
        }
    }

    /// Before the engine's step: makes a part if one is due and its place is free.
    pub(crate) fn before_step(
        &mut self,
        engine: &mut Engine,
        parts: &mut PartTable,
        outputs: &PointLevels,
        inputs: &PointLevels,
        time: f64,
    ) {
        let is_due = match self.plan.when {
            Trigger::Time(every) => {
                let is_due = time + 1e-9 >= self.due;
                if is_due {
                    self.due += every;
                }
                is_due
            }
            when => self.edge.rises(&when, outputs, inputs) && time >= self.plan.start_at,
        };
        if !is_due
            || self
                .plan
                .limit
                .is_some_and(|limit| self.state.made >= limit)
        {
            return;
        }
        let pose = self.place();
        let EngineShape { solid, turn, .. } = &parts.templates[self.template].solid;
        let is_taken = engine
            .physics
            .intersect_shape(engine_pose(&pose) * *turn, &**solid, QueryFilter::default())
            .next()
            .is_some();
        if is_taken || parts.bodies.len() >= crate::check::MAX_PARTS {
            self.state.skipped += 1;
            return;
        }
        parts.make(engine, self.template, &pose);
        self.state.made += 1;
    }

    /// The pose with its scatter. Numbers are drawn even where a deviation is 0, so one deviation does not change the
    /// others.
    fn place(&mut self) -> Pose {
        let drawn = self
            .plan
            .scatter
            .map(|deviation| deviation * self.scatter.normal());
        let turn = rotation::rotation_from_rpy([drawn[3], drawn[4], drawn[5]]);
        let shift = Vector3::new(drawn[0], drawn[1], drawn[2]);
        Pose::new(
            turn * self.plan.pose.rotation,
            self.plan.pose.translation + shift,
        )
    }
}
