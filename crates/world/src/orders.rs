//! Orders to a running world and questions about it: what tests, the page and buses ask for between two steps.

use crate::check::{FLOOR, MAX_PARTS};
use crate::description::{BodyShape, FaultDescription, FaultKind, Trigger};
use crate::error::OrderError;
use crate::fingers::FingerOrder;
use crate::gripper::Kind;
use crate::materials::Owner;
use crate::parts::PartNumber;
use crate::state::PartState;
use crate::world::World;
use kinematics::{Pose, RigidBody};
use messages::{Text, text};
use std::sync::Arc;

/// Faults at most, those of the description and of orders together.
const MAX_FAULTS: usize = 1000;
/// Two things nearer than this touch, m.
pub(crate) const TOUCHING: f64 = 1e-3;

impl World {
    /// A part by name; `None` for one that was there and is not any more.
    ///
    /// # Errors
    /// A name that no part has or had.
    pub fn part(&self, name: &str) -> Result<Option<&PartState>, OrderError> {
        let part = self.state.parts.iter().find(|part| &*part.name == name);
        match part {
            None if !self.parts.has_existed(name) => Err(unknown(text!("part", "工件"), name)),
            found => Ok(found),
        }
    }

    /// Names of what a part touches: parts, obstacles, conveyors, grippers, `floor`, `tool`, `link 1` to `link 6`.
    ///
    /// # Errors
    /// A name that no part has.
    pub fn touching(&self, name: &str) -> Result<Vec<String>, OrderError> {
        let collider = self.parts.bodies[&self.number(name)?].collider;
        Ok(self
            .engine
            .near(collider, TOUCHING)
            .into_iter()
            .map(|owner| self.name_of(owner))
            .collect())
    }

    /// Puts a part somewhere, at rest. A gripper loses it.
    ///
    /// # Errors
    /// A name that no part has, or a pose that is none.
    pub fn place(&mut self, name: &str, pose: &Pose) -> Result<(), OrderError> {
        check_pose(pose)?;
        let number = self.number(name)?;
        let Some(part) = self.take_out(number) else {
            return Err(unknown(text!("part", "工件"), name));
        };
        self.parts
            .add(&mut self.engine, part.template, part.name, pose);
        self.picture();
        Ok(())
    }

    /// Takes a part out of the world.
    ///
    /// # Errors
    /// A name that no part has.
    pub fn remove(&mut self, name: &str) -> Result<(), OrderError> {
        let number = self.number(name)?;
        self.take_out(number);
        self.picture();
        Ok(())
    }

    /// Puts another part of a template into the world, and says its name.
    ///
    /// # Errors
    /// A name that no table of parts has, a pose that is none, or too many parts.
    pub fn add(&mut self, template: &str, pose: &Pose) -> Result<Arc<str>, OrderError> {
        check_pose(pose)?;
        let of = self
            .parts
            .template(template)
            .ok_or_else(|| unknown(text!("part", "工件"), template))?;
        if self.parts.bodies.len() >= MAX_PARTS {
            return Err(OrderError::TooManyParts {
                given: MAX_PARTS + 1,
                allowed: MAX_PARTS,
            });
        }
        let number = self.parts.make(&mut self.engine, of, pose);
        self.picture();
        Ok(self.parts.bodies[&number].name.clone())
    }

    /// Lets something go wrong from the next step on, for `duration` seconds or for ever.
    ///
    /// # Errors
    /// A name that nothing has, a duration that is none, or more than 1000 faults.
    pub fn fail(&mut self, what: FaultKind, duration: Option<f64>) -> Result<(), OrderError> {
        if let Some(duration) = duration
            && !(duration > 0.0 && duration <= 1e6)
        {
            return Err(OrderError::OutOfRange {
                argument: "duration",
                given: Text::verbatim(duration.to_string()),
                allowed: text!("more than 0 s, up to 1e6 s", "大于 0 s、不超过 1e6 s"),
            });
        }
        if self.faults.len() >= MAX_FAULTS {
            return Err(OrderError::OutOfRange {
                argument: "what",
                given: text!("fault {}", "故障 {}", self.faults.len() + 1),
                allowed: text!("up to 1000 faults in a run", "一次运行最多 1000 个故障"),
            });
        }
        let names = &self.names;
        match &what {
            FaultKind::Missing(name) | FaultKind::Turned(name) | FaultKind::Drop(name) => {
                _ = self.number(name)?
            }
            FaultKind::Leak(name) if !names.grippers.contains(name) => {
                return Err(unknown(text!("gripper", "夹爪"), name));
            }
            FaultKind::Blocked(name) | FaultKind::Slow(name)
                if !names.actuators.contains(name) && !names.conveyors.contains(name) =>
            {
                return Err(unknown(
                    text!("actuator or conveyor", "执行机构或传送带"),
                    name,
                ));
            }
            _ => {}
        }
        self.add_fault(FaultDescription {
            when: Trigger::Time(0.0),
            what,
            duration,
        });
        Ok(())
    }

    /// Tells fingers that are on a bus where to go.
    ///
    /// # Errors
    /// A gripper that has no fingers, or an order beyond what they can do.
    pub fn order_fingers(&mut self, gripper: usize, order: &FingerOrder) -> Result<(), OrderError> {
        match self.grippers.get_mut(gripper).map(|g| &mut g.kind) {
            Some(Kind::Fingers(fingers)) => fingers.order(order)?,
            _ => {
                return Err(unknown(
                    text!("gripper with fingers of number", "带手指的夹爪，号码"),
                    &gripper.to_string(),
                ));
            }
        }
        self.picture();
        Ok(())
    }

    /// Shape of the parts of a template.
    pub fn part_shape(&self, template: usize) -> Option<BodyShape> {
        self.parts.templates.get(template).map(|t| t.shape.clone())
    }

    /// Mass properties of the parts of a template, in the frame of the part.
    pub fn part_mass(&self, template: usize) -> Option<RigidBody> {
        self.parts.templates.get(template).map(|t| t.mass)
    }

    fn number(&self, name: &str) -> Result<PartNumber, OrderError> {
        self.parts
            .by_name(name)
            .ok_or_else(|| unknown(text!("part", "工件"), name))
    }

    fn name_of(&self, owner: Owner) -> String {
        let of = |names: &[String], i: u32| names.get(i as usize).cloned().unwrap_or_default();
        match owner {
            Owner::Floor => FLOOR.to_owned(),
            Owner::Obstacle(i) => of(&self.names.obstacles, i),
            Owner::Part(number, _) => self
                .parts
                .bodies
                .get(&number)
                .map(|p| p.name.to_string())
                .unwrap_or_default(),
            Owner::Link(i) => format!("link {}", i + 1),
            Owner::Tool => "tool".to_owned(),
            Owner::Gripper(i) => of(&self.names.grippers, i),
            Owner::Conveyor(i) => of(&self.names.conveyors, i),
        }
    }
}

fn unknown(what: Text, name: &str) -> OrderError {
    OrderError::UnknownName {
        what,
        name: name.to_owned(),
    }
}

fn check_pose(pose: &Pose) -> Result<(), OrderError> {
    let numbers = pose.to_rpy().to_array();
    match numbers.iter().all(|x| x.abs() <= 1e3) {
        true => Ok(()),
        false => Err(OrderError::OutOfRange {
            argument: "pose",
            given: Text::verbatim(format!("{numbers:?}")),
            allowed: text!("numbers between -1000 and 1000", "-1000 到 1000 之间的数"),
        }),
    }
}
