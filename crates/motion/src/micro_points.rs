//! The points of a moveml: taken a few at a time, kept until the next line begins.
//!
//! Their place is reserved when the controller starts, so that taking them allocates nothing. One script thread at a time
//! gives a line, and only that thread can run it.

use kinematics::JointPositions;
use motion_api::{Command, MotionMode, Origin, ProgramId, Refusal, ThreadNumber};

use crate::constants::{LONGEST, MICRO_POINTS_MAX, MICRO_START, SLOWEST};
use crate::cycle::Cycle;
use crate::intake::{Answer, Ending, bad_value};
use crate::path::MicroLine;
use crate::plan::MicroLinePlanner;
use crate::upcoming::Planned;

/// The list.
pub(crate) struct MicroPoints {
    points: Vec<JointPositions>,
    giver: Option<(ProgramId, ThreadNumber)>,
}

impl MicroPoints {
    /// Empty, with room for all.
    pub(crate) fn new() -> Self {
        Self {
            points: Vec::with_capacity(MICRO_POINTS_MAX),
            giver: None,
        }
    }

    /// The points so far.
    pub(crate) fn points(&self) -> &[JointPositions] {
        &self.points
    }
}

impl Cycle {
    /// Takes points of a micro line.
    pub(crate) fn micro_points(
        &mut self,
        origin: Origin,
        begins: bool,
        count: usize,
        points: &[JointPositions; 4],
    ) -> Answer {
        let list = &mut self.micro_points;
        let given = points.get(..count).filter(|given| !given.is_empty());
        let given = given.ok_or_else(|| bad_value("count", count as f64, "1 to 4"))?;
        if begins {
            list.points.clear();
            list.giver = Some((origin.program, origin.thread));
        } else if list.giver != Some((origin.program, origin.thread)) {
            return Err(self.other_line());
        }
        for point in given {
            if let Some(angle) = point.0.into_iter().find(|x| !x.is_finite()) {
                return Err(bad_value("a joint position", angle, "a finite number"));
            }
            if list.points.len() >= MICRO_POINTS_MAX {
                let value = (MICRO_POINTS_MAX + 1) as f64;
                return Err(bad_value("the number of points", value, "at most 100000"));
            }
            list.points.push(*point);
        }
        Ok(Ending::Now)
    }

    fn other_line(&self) -> Refusal {
        let value = self.micro_points.points.len() as f64;
        bad_value(
            "the number of points given by this thread",
            value,
            "that of the line: another thread has begun one of its own",
        )
    }

    /// Begins a moveml.
    pub(crate) fn moveml(&mut self, command: &Command, count: u32, interval: f64) -> Answer {
        if !(SLOWEST..=LONGEST).contains(&interval) {
            let needed = "0.000001 to 1000000 s";
            return Err(bad_value("the time between points", interval, needed));
        }
        let giver = Some((command.origin.program, command.origin.thread));
        if self.micro_points.giver != giver
            || self.micro_points.points.len() != usize::try_from(count).unwrap_or(usize::MAX)
        {
            return Err(self.other_line());
        }
        let start = self.next_start();
        if let Some(first) = self.micro_points.points.first_mut() {
            for joint in 0..6 {
                let away = (first[joint] - start[joint]).abs();
                if away > MICRO_START {
                    let needed = "at most 0.0001 rad";
                    return Err(bad_value("the way to the first point", away, needed));
                }
            }
            // Exactly from where the arm is.
            *first = start;
        }
        let Some(line) = MicroLine::new(&self.micro_points.points, interval) else {
            let value = self.micro_points.points.len() as f64;
            return Err(bad_value("the number of points", value, "at least 2"));
        };
        // The points between are looked at while the motion is planned, a few a cycle.
        self.check_target(&line.end())?;
        let planner = MicroLinePlanner::new(line);
        self.follow_with(
            (command.id, command.origin),
            MotionMode::MoveMl,
            Planned::Micro(planner),
        );
        Ok(Ending::Later)
    }
}
