//! The border between the control cycle and the world around the arm: what each gives to the other, and the rings
//! between them.
//!
//! The cycle gives the arm at its end and all outputs ([`WorldInput`]), the world gives inputs, wrenches and what the
//! grippers hold ([`WorldOutput`]). Neither waits for the other. Points are named by [`IoPoint`]; whether an input or
//! an output is meant follows from the field it stands in. Digital points, boolean registers and analog points cross;
//! integer and float registers do not.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use kinematics::bounds::within;
use kinematics::{DOF, Pose, RigidBody, Wrench};
use rtrb::{Consumer, Producer, RingBuffer};

use crate::IoPoint;

/// PointLevels of all points of one direction. Copied across the border to the motion thread, so of fixed size.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PointLevels {
    /// Digital points by bit (`motion_api::DigitalBank::bit`).
    pub digital: u32,
    /// Boolean registers, 64 a word.
    pub booleans: [u64; 2],
    /// Analog points as a part of their largest value, 0 to 1: standard 0, standard 1, tool.
    pub analog: [f64; 3],
}

impl PointLevels {
    /// Level of a digital point or boolean register; an analog point is true above half of its range.
    pub fn level(&self, point: IoPoint) -> bool {
        match point {
            IoPoint::Digital(bit) => bit < 32 && self.digital >> bit & 1 == 1,
            IoPoint::BooleanRegister(index) => {
                index < 128 && self.booleans[usize::from(index / 64)] >> (index % 64) & 1 == 1
            }
            _ => self.ratio(point) > 0.5,
        }
    }

    /// Value of an analog point as a part of its largest value; 1 or 0 for the others.
    pub fn ratio(&self, point: IoPoint) -> f64 {
        match point {
            IoPoint::Analog(port) => self.analog.get(usize::from(port)).copied().unwrap_or(0.0),
            IoPoint::Digital(_) | IoPoint::BooleanRegister(_) => {
                f64::from(u8::from(self.level(point)))
            }
            IoPoint::IntegerRegister(_) | IoPoint::FloatRegister(_) => 0.0,
        }
    }

    /// Sets a digital point or a boolean register; an analog point goes to the end of its range.
    pub fn set_level(&mut self, point: IoPoint, level: bool) {
        match point {
            IoPoint::Digital(bit) if bit < 32 => {
                self.digital = self.digital & !(1 << bit) | u32::from(level) << bit;
            }
            IoPoint::BooleanRegister(index) if index < 128 => {
                let word = &mut self.booleans[usize::from(index / 64)];
                *word = *word & !(1 << (index % 64)) | u64::from(level) << (index % 64);
            }
            _ => self.set_ratio(point, f64::from(u8::from(level))),
        }
    }

    /// Sets an analog point, clamped to 0 to 1; other points are left alone.
    pub fn set_ratio(&mut self, point: IoPoint, ratio: f64) {
        if let IoPoint::Analog(port) = point
            && let Some(value) = self.analog.get_mut(usize::from(port))
        {
            *value = within(ratio, 0.0, 1.0);
        }
    }
}

/// A set of points of one direction.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PointSet {
    /// Digital points by bit.
    pub digital: u32,
    /// Boolean registers, 64 a word.
    pub booleans: [u64; 2],
    /// Analog points by bit.
    pub analog: u8,
}

impl PointSet {
    /// Adds a point; false when it was in the set before.
    pub fn insert(&mut self, point: IoPoint) -> bool {
        let is_new = !self.contains(point);
        match point {
            IoPoint::Digital(bit) if bit < 32 => self.digital |= 1 << bit,
            IoPoint::BooleanRegister(index) if index < 128 => {
                self.booleans[usize::from(index / 64)] |= 1 << (index % 64);
            }
            IoPoint::Analog(port) if port < 8 => self.analog |= 1 << port,
            _ => {}
        }
        is_new
    }

    /// Whether a point is in the set.
    pub fn contains(&self, point: IoPoint) -> bool {
        match point {
            IoPoint::Digital(bit) => bit < 32 && self.digital >> bit & 1 == 1,
            IoPoint::BooleanRegister(index) => {
                index < 128 && self.booleans[usize::from(index / 64)] >> (index % 64) & 1 == 1
            }
            IoPoint::Analog(port) => port < 8 && self.analog >> port & 1 == 1,
            IoPoint::IntegerRegister(_) | IoPoint::FloatRegister(_) => false,
        }
    }
}

/// Grippers at most.
pub const MAX_GRIPPERS: usize = 8;

/// What the cycle gives to the world: the arm at its end, and the outputs.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct WorldInput {
    /// Number of the cycle.
    pub cycle: u64,
    /// Number of the cycle whose result this one had.
    pub seen: u64,
    /// The six joint frames in the base frame.
    pub base_from_joint: [Pose; DOF],
    /// The flange in the base frame.
    pub base_from_flange: Pose,
    /// All outputs.
    pub outputs: PointLevels,
    /// What obstacles do to the part in each gripper, as the arm's contact law finds it: about the origin of the
    /// flange, base axes.
    pub held_contacts: [Wrench; MAX_GRIPPERS],
}

/// What the world gives to the next cycle.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct WorldOutput {
    /// Number of the cycle whose end this is the state of.
    pub cycle: u64,
    /// PointLevels of the inputs that the world drives; the others are 0.
    pub inputs: PointLevels,
    /// Inputs that keep their value, whoever drives them.
    pub stuck: PointSet,
    /// Inputs that are false or 0, whoever drives them.
    pub open: PointSet,
    /// What parts and moved obstacles do to tool, grippers and held parts, and what still bears a part that is being
    /// lifted: about the origin of the flange, base axes.
    pub tool_wrench: Wrench,
    /// What they do to the links: about the origin of each joint frame, base axes.
    pub link_wrenches: [Wrench; DOF],
    /// All held parts as one body in the flange frame: what acts on the flange as a payload does.
    pub held_body: RigidBody,
    /// The part in each gripper, with the number of its template.
    pub held_parts: [Option<HeldPart>; MAX_GRIPPERS],
    /// Way of the conveyors on encoders 0 and 1 since the start, m or rad.
    pub encoder_travel: [f64; 2],
}

/// A part in a gripper.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HeldPart {
    /// Number of the template, for its shape.
    pub template: u16,
    /// Where it is in the flange frame.
    pub flange_from_part: Pose,
    /// How far, and in which direction, the part can be pushed back before the gripper bears on it: from the part,
    /// flange frame, m. A cup that sealed from a distance has that distance left.
    pub play: [f64; 3],
}

/// Cycles that may wait for the world, and results of the world that may wait for a cycle.
const CYCLES_IN_FLIGHT: usize = 256;

/// Makes the border to the world: the control cycle's end and the world's.
pub fn world_channel() -> (WorldPort, WorldEndpoint) {
    let (to_world, from_cycle) = RingBuffer::new(CYCLES_IN_FLIGHT);
    let (to_cycle, from_world) = RingBuffer::new(CYCLES_IN_FLIGHT);
    let counts = Arc::<BorderCounts>::default();
    let port = WorldPort {
        to_world,
        from_world,
        latest: WorldOutput::default(),
        is_full: false,
        counts: counts.clone(),
    };
    let endpoint = WorldEndpoint {
        from_cycle,
        to_cycle,
        counts: LateCycles(counts),
    };
    (port, endpoint)
}

/// What the world's end, and whoever measures, may ask about the control cycle's end.
#[derive(Debug, Default)]
struct BorderCounts {
    /// Cycles for which the world came late.
    late: AtomicU64,
    /// Number of the newest cycle that began, whether the world is told of it or not.
    newest: AtomicU64,
}

/// The control cycle's end. Nothing here allocates, locks or waits.
pub struct WorldPort {
    to_world: Producer<WorldInput>,
    from_world: Consumer<WorldOutput>,
    latest: WorldOutput,
    /// The world was too far behind when this cycle began: it misses the cycle.
    is_full: bool,
    counts: Arc<BorderCounts>,
}

impl WorldPort {
    /// The newest result, for the cycle of this number; counted as late where the world has not come to the cycle
    /// before. A cycle that the world will miss has the result of the cycle before: so the numbers of missed cycles are
    /// all that a recording needs to repeat the run.
    pub fn receive(&mut self, cycle: u64) -> &WorldOutput {
        self.is_full = self.to_world.is_full();
        while !self.is_full
            && let Ok(next) = self.from_world.pop()
        {
            self.latest = next;
        }
        if self.latest.cycle + 1 < cycle {
            self.counts.late.fetch_add(1, Ordering::Relaxed);
        }
        self.counts.newest.store(cycle, Ordering::Relaxed);
        &self.latest
    }

    /// Gives the end of a cycle to the world. A world that was too far behind at the cycle's beginning misses it.
    pub fn send(&mut self, input: WorldInput) {
        if self.is_full {
            return;
        }
        let seen = self.latest.cycle;
        // There was room at the cycle's beginning, and only the world's end has touched the ring since.
        let _ = self.to_world.push(WorldInput { seen, ..input });
    }
}

/// The world's end.
pub struct WorldEndpoint {
    from_cycle: Consumer<WorldInput>,
    to_cycle: Producer<WorldOutput>,
    counts: LateCycles,
}

impl WorldEndpoint {
    /// The next cycle that the world has not moved by.
    pub fn next_cycle(&mut self) -> Option<WorldInput> {
        self.from_cycle.pop().ok()
    }

    /// Gives a result to the next control cycle.
    pub fn answer(&mut self, output: &WorldOutput) {
        // As many fit as cycles may wait for the world, and every cycle takes all of them, but one for which there was
        // no room: the world has not come to an end of anything since the cycle before.
        let _ = self.to_cycle.push(*output);
    }

    /// The count of cycles for which the world came late.
    pub fn late_cycles(&self) -> LateCycles {
        self.counts.clone()
    }

    /// Number of the newest cycle that began; 0 before the first.
    pub fn newest_cycle(&self) -> u64 {
        self.counts.0.newest.load(Ordering::Relaxed)
    }
}

/// How often a cycle began before the world had moved by the cycle before.
#[derive(Clone, Debug, Default)]
pub struct LateCycles(Arc<BorderCounts>);

impl LateCycles {
    /// The number so far.
    pub fn count(&self) -> u64 {
        self.0.late.load(Ordering::Relaxed)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_are_set_and_read_one_by_one() {
        let mut levels = PointLevels::default();
        for point in [IoPoint::Digital(27), IoPoint::BooleanRegister(64)] {
            levels.set_level(point, true);
            assert!(levels.level(point));
        }
        assert_eq!((levels.digital, levels.booleans), (1 << 27, [0, 1]));
        levels.set_ratio(IoPoint::Analog(2), 1.5);
        assert_eq!(levels.analog, [0.0, 0.0, 1.0]);
        let mut set = PointSet::default();
        assert!(set.insert(IoPoint::Analog(2)) && !set.insert(IoPoint::Analog(2)));
        assert!(!set.contains(IoPoint::Analog(1)));
    }

    #[test]
    fn a_world_that_is_too_far_behind_misses_cycles_which_have_the_result_of_the_cycle_before() {
        let (mut port, mut world) = world_channel();
        let input = |cycle| WorldInput {
            cycle,
            ..WorldInput::default()
        };
        let waiting = CYCLES_IN_FLIGHT as u64;
        for cycle in 1..=waiting + 3 {
            assert_eq!(port.receive(cycle).cycle, 0);
            port.send(input(cycle));
        }
        assert_eq!(world.newest_cycle(), waiting + 3);
        // Room for one comes after the beginning of a cycle, which is missed all the same.
        assert_eq!(port.receive(waiting + 4).cycle, 0);
        let first = world.next_cycle().unwrap();
        world.answer(&WorldOutput {
            cycle: first.cycle,
            ..WorldOutput::default()
        });
        port.send(input(waiting + 4));
        assert_eq!(port.receive(waiting + 5).cycle, 1);
        port.send(input(waiting + 5));
        let cycles =
            core::iter::from_fn(|| world.next_cycle().map(|input| (input.cycle, input.seen)));
        let all: Vec<_> = (2..=waiting).map(|cycle| (cycle, 0)).collect();
        assert_eq!(
            cycles.collect::<Vec<_>>(),
            [all, vec![(waiting + 5, 1)]].concat()
        );
    }

    #[test]
    fn a_world_that_is_behind_is_counted_and_its_newest_result_holds() {
        let (mut port, mut world) = world_channel();
        let late = world.late_cycles();
        assert_eq!((port.receive(1).cycle, late.count()), (0, 0));
        for cycle in 1..=2 {
            port.send(WorldInput {
                cycle,
                ..WorldInput::default()
            });
        }
        assert_eq!((port.receive(3).cycle, late.count()), (0, 1));
        while let Some(input) = world.next_cycle() {
            world.answer(&WorldOutput {
                cycle: input.cycle,
                ..WorldOutput::default()
            });
        }
        assert_eq!((port.receive(3).cycle, late.count()), (2, 1));
    }
}
