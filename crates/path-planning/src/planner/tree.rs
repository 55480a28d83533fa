//! Trees of joint positions that can be reached from their roots, and how two of them meet (RRT-Connect, Kuffner and
//! LaValle, ICRA 2000).

use kinematics::JointPositions;

use super::edge::ClearanceCheck;
use crate::tracker::interpolate;

/// Longest line of a tree, rad (Euclidean over the joints).
const STEP: f64 = 0.6;

/// Joint positions, each with the number of the one it was reached from; roots have none.
#[derive(Debug, Default)]
pub(crate) struct JointTree {
    nodes: Vec<(JointPositions, Option<usize>)>,
}

/// What a tree made of a target.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Extension {
    /// The target is the node of this number.
    Reached(usize),
    /// The last node on the way there.
    Advanced(usize),
    /// Nothing was added.
    Blocked,
}

impl JointTree {
    /// A tree with these roots.
    pub(crate) fn new(roots: &[JointPositions]) -> Self {
        Self {
            nodes: roots.iter().map(|q| (*q, None)).collect(),
        }
    }

    /// The joint positions of a node.
    pub(crate) fn at(&self, node: usize) -> &JointPositions {
        &self.nodes[node].0
    }

    /// How many nodes there are.
    pub(crate) fn len(&self) -> usize {
        self.nodes.len()
    }

    /// The node that is nearest to `q`.
    fn nearest(&self, q: &JointPositions) -> usize {
        let mut nearest = (f64::INFINITY, 0);
        for (number, (node, _)) in self.nodes.iter().enumerate() {
            let apart = node.distance_squared(q);
            if apart < nearest.0 {
                nearest = (apart, number);
            }
        }
        nearest.1
    }

    /// Goes one step towards a target.
    pub(crate) fn extend(
        &mut self,
        target: &JointPositions,
        check: &mut ClearanceCheck<'_>,
    ) -> Extension {
        let from = self.nearest(target);
        self.step_from(from, target, check)
    }

    /// Goes towards a target for as long as nothing is in the way.
    pub(crate) fn connect(
        &mut self,
        target: &JointPositions,
        check: &mut ClearanceCheck<'_>,
    ) -> Extension {
        let mut from = self.nearest(target);
        let mut last = Extension::Blocked;
        loop {
            match self.step_from(from, target, check) {
                Extension::Advanced(node) => {
                    from = node;
                    last = Extension::Advanced(node);
                }
                Extension::Reached(node) => return Extension::Reached(node),
                Extension::Blocked => return last,
            }
        }
    }

    fn step_from(
        &mut self,
        from: usize,
        target: &JointPositions,
        check: &mut ClearanceCheck<'_>,
    ) -> Extension {
        let start = *self.at(from);
        let apart = start.distance_squared(target).sqrt();
        if apart == 0.0 {
            return Extension::Reached(from);
        }
        let (next, is_there) = match apart > STEP {
            true => (interpolate(&start, target, STEP / apart), false),
            false => (*target, true),
        };
        if !check.is_clear(&start, &next) {
            return Extension::Blocked;
        }
        self.nodes.push((next, Some(from)));
        let node = self.len() - 1;
        match is_there {
            true => Extension::Reached(node),
            false => Extension::Advanced(node),
        }
    }

    /// The way from a node back to its root, both included.
    pub(crate) fn way_to_root(&self, node: usize) -> Vec<JointPositions> {
        let mut way = Vec::new();
        let mut at = Some(node);
        while let Some(node) = at {
            let (q, parent) = self.nodes[node];
            way.push(q);
            at = parent;
        }
        way
    }
}
