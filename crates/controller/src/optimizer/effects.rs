//! What a run does beside moving: the order of prints, outputs and grips, and where the arm and the parts were then.

use std::sync::Arc;

use elite_runtime::message::{Message, Observer};
use kinematics::{JointPositions, Payload, RpyPose};
use motion_api::{CycleFrame, RegisterImage};
use parking_lot::Mutex;

use crate::clearance::GripChange;

/// Joint positions this near to each other are the same place, rad.
const SAME_PLACE: f64 = 1e-3;
/// Parts that are let go this near to each other, in each axis, are let go at the same place, m: another cycle of a
/// moving gripper is within it, a part that falls on the way is not.
const SAME_RELEASE: f64 = 5e-3;
/// Most effects that are noted; a program with more cannot be compared.
const EFFECTS_MAX: usize = 200_000;

/// One effect.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Effect {
    /// Something was said. Numbers in the text, such as times, may differ.
    Said(String),
    /// An output, a register, the tool or its load changed to this, with the arm there.
    Changed {
        /// What they are now.
        to: Box<OutputImage>,
        /// Where the arm was.
        q: JointPositions,
    },
    /// A gripper took a part or let it go.
    Gripped(GripChange),
}

/// An effect and its control cycle.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct TimedEffect {
    cycle: u64,
    effect: Effect,
}

/// What a program sets beside the motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct OutputImage {
    digital: u64,
    analog: [f64; 3],
    tcp: RpyPose,
    payload: Payload,
    registers: RegisterImage,
}

/// The effects of a run.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct RunEffects {
    all: Vec<TimedEffect>,
    /// Where the arm stood at the end.
    pub(super) end: JointPositions,
    is_full: bool,
}

impl RunEffects {
    /// Whether another run does the same, in the same order, with the arm in the same places.
    pub(super) fn are_those_of(&self, other: &Self) -> bool {
        let is_same = |(a, b): (&TimedEffect, &TimedEffect)| match (&a.effect, &b.effect) {
            (Effect::Said(a), Effect::Said(b)) => a == b,
            (Effect::Changed { to: a, q: p }, Effect::Changed { to: b, q }) => {
                a == b && is_same_place(p, q)
            }
            (Effect::Gripped(a), Effect::Gripped(b)) => is_same_grip(a, b),
            _ => false,
        };
        !self.is_full
            && !other.is_full
            && self.all.len() == other.all.len()
            && self.all.iter().zip(&other.all).all(is_same)
            && is_same_place(&self.end, &other.end)
    }

    fn push(&mut self, cycle: u64, effect: Effect) {
        match self.all.len() < EFFECTS_MAX {
            true => self.all.push(TimedEffect { cycle, effect }),
            false => self.is_full = true,
        }
    }

    /// With what grippers took and let go, each behind what else happened until its cycle.
    pub(super) fn with_grips(mut self, grips: Vec<GripChange>) -> Self {
        for grip in grips {
            self.push(grip.cycle, Effect::Gripped(grip));
        }
        // The sort keeps the order of what happened in one cycle.
        self.all.sort_by_key(|timed| timed.cycle);
        self
    }
}

/// True where the same part goes to or from the same gripper, and one that is let go lies at the same place. A belt may
/// have moved one that is taken.
fn is_same_grip(a: &GripChange, b: &GripChange) -> bool {
    let is_near = |(p, q): (&f64, &f64)| (p - q).abs() <= SAME_RELEASE;
    let is_there = a.held_by.is_some() || a.place.iter().zip(&b.place).all(is_near);
    a.part == b.part && a.held_by == b.held_by && is_there
}

fn is_same_place(p: &JointPositions, q: &JointPositions) -> bool {
    (0..6).all(|joint| (p[joint] - q[joint]).abs() <= SAME_PLACE)
}

/// Notes the effects of a run; passes everything on.
pub(super) struct EffectRecorder {
    noted: Mutex<NotedRun>,
    next: Arc<dyn Observer>,
}

#[derive(Default)]
struct NotedRun {
    effects: RunEffects,
    /// The newest control cycle.
    cycle: u64,
    outputs: Option<OutputImage>,
}

impl EffectRecorder {
    pub(super) fn new(next: Arc<dyn Observer>) -> Self {
        Self {
            noted: Mutex::default(),
            next,
        }
    }

    pub(super) fn effects(&self) -> RunEffects {
        self.noted.lock().effects.clone()
    }
}

impl Observer for EffectRecorder {
    fn next(&self) -> Option<&dyn Observer> {
        Some(&*self.next)
    }

    fn message(&self, message: &Message) {
        let said = match message {
            Message::Print { text, .. } => Some(text),
            _ => None,
        };
        if let Some(text) = said {
            let without_numbers = text.chars().filter(|c| !c.is_ascii_digit());
            let said = Effect::Said(without_numbers.collect());
            let mut noted = self.noted.lock();
            let cycle = noted.cycle;
            noted.effects.push(cycle, said);
        }
        self.next.message(message);
    }

    fn cycle_ended(&self, frame: &CycleFrame) {
        {
            let mut noted = self.noted.lock();
            let state = &frame.state;
            noted.effects.end = state.actual_q;
            noted.cycle = state.cycle;
            let outputs = OutputImage {
                digital: state.digital_out,
                analog: state.analog_out,
                tcp: state.tcp_offset,
                payload: state.payload,
                registers: frame.registers.output,
            };
            match &noted.outputs {
                Some(before) if *before == outputs => {}
                before => {
                    if before.is_some() {
                        let changed = Effect::Changed {
                            to: Box::new(outputs),
                            q: state.actual_q,
                        };
                        noted.effects.push(state.cycle, changed);
                    }
                    noted.outputs = Some(outputs);
                }
            }
        }
        self.next.cycle_ended(frame);
    }
}
