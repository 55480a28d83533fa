//! Follows a program cycle by cycle and measures how near each of its motions comes to anything.

use std::collections::{BTreeMap, VecDeque};
use std::sync::{Arc, OnceLock, Weak};

use elite_runtime::Robot;
use elite_runtime::message::Observer;
use elite_syntax::SourceFile;
use elite_syntax::parser::parse;
use kinematics::{JointPositions, Pose, RpyPose};
use motion_api::{CommandId, CommandKind, CycleFrame, OverlayCommand, ProgramId, RobotState};
use parking_lot::Mutex;
use path_planning::{ClearanceTracker, CollisionScene, ObstaclePlace};
use world::description::BodyShape;

use crate::cell::shape::distance_pieces;
use crate::cell_world::CellWorld;
use crate::cell_world::topic::{PartRow, WorldMessage};

use super::motion_row::{GripChange, LeastDistance, MotionClearance};

/// Most motions that are told one by one; of a program with more the rest is one row.
const ROWS_MAX: usize = 100_000;

/// Most cycles whose distance is kept.
const HISTORY_MAX: usize = 1_000_000;

/// Most changes of grips that are kept.
const GRIPS_MAX: usize = 100_000;

/// Measures clearances of the newest program; passes everything on.
pub struct ClearanceObserver {
    measured: Mutex<MeasuredProgram>,
    /// Knows commands by their numbers.
    robot: OnceLock<Weak<Robot>>,
    next: Arc<dyn Observer>,
}

struct MeasuredProgram {
    scene: CollisionScene,
    tracker: ClearanceTracker,
    rows: Vec<MotionClearance>,
    /// The command of the last row.
    command: CommandId,
    /// The place of the cycle before.
    last: Option<JointPositions>,
    /// The nodes of the pendant's task, by the line at which each begins.
    nodes: Vec<(u32, String)>,
    has_begun: bool,
    /// Cycles in which the arm has not moved, since it last did.
    still_cycles: u64,
    /// Where somebody wants them: times and distances of all cycles.
    history: Option<Vec<(f64, f64)>>,
    /// What hangs on the flange whatever the world says.
    held_throughout: Vec<String>,
    /// Shapes of parts by the names of their templates.
    part_shapes: Vec<(String, BodyShape)>,
    /// What the world said of cycles that have not been shown yet.
    world_messages: VecDeque<WorldMessage>,
    /// The gripper that holds a part, by the name of the part.
    holders: BTreeMap<String, String>,
    grips: Vec<GripChange>,
}

impl ClearanceObserver {
    /// Measures in `scene`; `next` is told everything as well.
    pub fn new(scene: CollisionScene, next: Arc<dyn Observer>) -> Self {
        let is_held = |name: &&str| {
            let place = scene.obstacle(name).and_then(|id| scene.place(id));
            matches!(place, Some(ObstaclePlace::Held(_)))
        };
        let held = scene.obstacle_names().filter(is_held);
        let held_throughout = held.map(str::to_owned).collect();
        Self {
            measured: Mutex::new(MeasuredProgram {
                scene,
                tracker: ClearanceTracker::default(),
                rows: Vec::new(),
                command: CommandId::NONE,
                last: None,
                nodes: Vec::new(),
                has_begun: false,
                still_cycles: 0,
                history: None,
                held_throughout,
                part_shapes: Vec::new(),
                world_messages: VecDeque::new(),
                holders: BTreeMap::new(),
                grips: Vec::new(),
            }),
            robot: OnceLock::new(),
            next,
        }
    }

    /// Keeps the distance of every cycle as well.
    pub fn with_history(mut self) -> Self {
        self.measured.get_mut().history = Some(Vec::new());
        self
    }

    /// The least distance, m, at the end of every cycle, by its simulated time, s.
    pub fn history(&self) -> Vec<(f64, f64)> {
        self.measured.lock().history.clone().unwrap_or_default()
    }

    /// Says whose commands they are, once.
    pub fn connect(&self, robot: &Arc<Robot>) {
        let _ = self.robot.set(Arc::downgrade(robot));
    }

    /// Measures from now on, whatever moves the arm.
    pub fn begin(&self) {
        self.measured.lock().has_begun = true;
    }

    /// Whether the program compiled, so that there is something to measure.
    pub fn has_begun(&self) -> bool {
        self.measured.lock().has_begun
    }

    /// How many cycles ago the arm moved last.
    pub fn still_cycles(&self) -> u64 {
        self.measured.lock().still_cycles
    }

    /// The motions so far.
    pub fn rows(&self) -> Vec<MotionClearance> {
        self.measured.lock().rows.clone()
    }

    /// What grippers have taken and let go so far, in this order.
    pub fn grips(&self) -> Vec<GripChange> {
        self.measured.lock().grips.clone()
    }

    /// The least distance so far, with the line of its motion; `None` before the first motion, or where nothing can
    /// touch.
    pub fn least(&self) -> Option<(LeastDistance, u32)> {
        let measured = self.measured.lock();
        let rows = measured.rows.iter();
        let nearest = rows.min_by(|a, b| a.distance().total_cmp(&b.distance()))?;
        Some((nearest.least.clone()?, nearest.line))
    }

    /// Has parts and actuators where the world has them in every cycle.
    pub fn follow_world(self: &Arc<Self>, world: &CellWorld) {
        let parts = world.description().parts.iter();
        let shapes = parts.map(|part| (part.name.clone(), part.shape.clone()));
        self.measured.lock().part_shapes = shapes.collect();
        let observer = Arc::downgrade(self);
        world.follow(Box::new(move |message| {
            if let Some(observer) = observer.upgrade() {
                let mut measured = observer.measured.lock();
                measured.world_messages.push_back(message.clone());
            }
        }));
    }
}

impl MeasuredProgram {
    fn cycle(&mut self, state: &RobotState, robot: Option<&Robot>) {
        self.scene.set_tcp(Pose::from_rpy(&state.tcp_offset));
        let q = state.actual_q;
        let flange = self.scene.model().flange_pose(&q);
        while let Some(message) = self.world_messages.pop_front_if(|m| m.cycle <= state.cycle) {
            self.apply(&message, &flange);
        }
        let has_moved = self.last.replace(q).is_none_or(|last| last != q);
        match has_moved {
            true => self.still_cycles = 0,
            false => self.still_cycles += 1,
        }
        if let Some(history) = &mut self.history
            && history.len() < HISTORY_MAX
            && let Some(nearest) = self.scene.nearest(&q)
        {
            history.push((state.time, nearest.distance));
        }
        let before = self.rows.len();
        if let Some(robot) = robot {
            self.note_short_motions(state.cycle, robot);
        }
        if state.command_id != CommandId::NONE && state.command_id != self.command {
            self.command = state.command_id;
            self.begin_row(robot);
        }
        let Some(row) = self.rows.last() else {
            // The arm stands and no motion has begun: only the place counts from which one will.
            self.tracker.advance(&self.scene, &q, f64::NEG_INFINITY);
            return;
        };
        // The cycle in which one motion takes over from another is of both.
        let is_shared = self.rows.len() > before;
        let threshold = match is_shared {
            true => f64::INFINITY,
            false => row.distance(),
        };
        let found = self.tracker.advance(&self.scene, &q, threshold);
        // The rows that are new, and the one before them.
        let first = match is_shared {
            true => before.saturating_sub(1),
            false => before - 1,
        };
        for row in &mut self.rows[first..] {
            if let Some(place) = &found {
                row.note_place(place, &self.scene, state);
            }
            row.in_force_mode |= state.force_mode;
            if has_moved || is_shared {
                row.note_posture(&q, &self.scene);
            }
        }
    }

    /// Parts and machines are where the world has them.
    fn apply(&mut self, message: &WorldMessage, flange: &Pose) {
        let pose = |numbers: [f64; 6]| Pose::from_rpy(&RpyPose::from_array(numbers));
        for obstacle in &message.obstacles {
            if let Some(id) = self.scene.obstacle(&obstacle.name) {
                let place = ObstaclePlace::Standing(pose(obstacle.pose));
                self.scene.set_place(id, place);
            }
        }
        for part in &message.parts {
            self.note_grip(message.cycle, part);
            if self.held_throughout.contains(&part.name) {
                continue;
            }
            let there = pose(part.pose);
            let place = match part.held_by {
                Some(_) => ObstaclePlace::Held(flange.inverse() * there),
                None => ObstaclePlace::Standing(there),
            };
            match self.scene.obstacle(&part.name) {
                Some(id) => {
                    // What is held keeps its place on the flange: rounding is no motion.
                    let is_held = matches!(self.scene.place(id), Some(ObstaclePlace::Held(_)));
                    if !(is_held && part.held_by.is_some()) {
                        self.scene.set_place(id, place);
                    }
                }
                None => {
                    let name = part.name.split(['[', '#']).next().unwrap_or_default();
                    let mut shapes = self.part_shapes.iter();
                    if let Some((_, shape)) = shapes.find(|(template, _)| template == name) {
                        let pieces = distance_pieces(shape, Pose::IDENTITY);
                        self.scene.add_obstacle(part.name.clone(), pieces, place);
                    }
                }
            }
        }
        for name in message.removed.iter().chain(&message.lost) {
            self.holders.remove(name);
            if let Some(id) = self.scene.obstacle(name) {
                self.scene.set_place(id, ObstaclePlace::Absent);
            }
        }
    }

    /// A gripper has taken a part or let it go.
    fn note_grip(&mut self, cycle: u64, part: &PartRow) {
        if self.holders.get(&part.name) == part.held_by.as_ref() {
            return;
        }
        match &part.held_by {
            Some(gripper) => self.holders.insert(part.name.clone(), gripper.clone()),
            None => self.holders.remove(&part.name),
        };
        if self.grips.len() < GRIPS_MAX {
            let [x, y, z, ..] = part.pose;
            self.grips.push(GripChange {
                cycle,
                part: part.name.clone(),
                held_by: part.held_by.clone(),
                place: [x, y, z],
            });
        }
    }

    /// Motions that began and ended within this cycle, because the arm was there already, get their rows.
    fn note_short_motions(&mut self, cycle: u64, robot: &Robot) {
        let mut short = Vec::new();
        robot.for_motions_done_in(cycle, |command| {
            if command.id > self.command {
                short.push((command.id, command.origin.line, command.kind.name()));
            }
        });
        for (id, line, kind) in short {
            self.command = id;
            self.push_row(line, kind);
        }
    }

    fn push_row(&mut self, line: u32, kind: &'static str) {
        if self.rows.len() >= ROWS_MAX {
            return;
        }
        let before = self.nodes.partition_point(|(begins, _)| *begins <= line);
        let node = before.checked_sub(1).and_then(|at| self.nodes.get(at));
        let node = node.map(|(_, label)| label.clone());
        self.rows.push(MotionClearance::new(line, node, kind));
    }

    /// A command has begun: it gets a row, unless it goes on with what the last one did.
    fn begin_row(&mut self, robot: Option<&Robot>) {
        let command = robot.and_then(|robot| robot.command(self.command));
        let (line, kind, is_planned) = match &command {
            Some(command) => {
                let kind = &command.kind;
                (command.origin.line, kind.name(), kind.is_motion())
            }
            None => (0, "motion", false),
        };
        // A belt, a force or an offset is laid over motions and is none by itself.
        let is_overlay = matches!(
            command.map(|command| command.kind),
            Some(CommandKind::Overlay(
                OverlayCommand::ForceMode { .. }
                    | OverlayCommand::TrackConveyorLinear { .. }
                    | OverlayCommand::TrackConveyorCircular { .. }
                    | OverlayCommand::PathOffsetEnable
            ))
        );
        let goes_on = self
            .rows
            .last()
            .is_some_and(|last| !is_planned && last.line == line && last.kind == kind);
        if !goes_on && (!is_overlay || self.rows.is_empty()) {
            self.push_row(line, kind);
        }
    }
}

impl Observer for ClearanceObserver {
    fn next(&self) -> Option<&dyn Observer> {
        Some(&*self.next)
    }

    fn program_compiled(&self, program: ProgramId, text: &str) {
        {
            let mut measured = self.measured.lock();
            measured.has_begun = true;
            measured.nodes = task_nodes(text);
        }
        self.next.program_compiled(program, text);
    }

    fn cycle_ended(&self, frame: &CycleFrame) {
        {
            let mut measured = self.measured.lock();
            if measured.has_begun {
                let robot = self.robot.get().and_then(Weak::upgrade);
                measured.cycle(&frame.state, robot.as_deref());
            }
        }
        self.next.cycle_ended(frame);
    }
}

/// The nodes of the pendant's task that the text was made from, by the line at which each begins.
fn task_nodes(text: &str) -> Vec<(u32, String)> {
    if !text.contains('$') {
        return Vec::new();
    }
    let file = SourceFile::new("program", text);
    let parsed = parse(&file);
    let line_at = |start: u32| {
        1 + text
            .bytes()
            .take(start as usize)
            .filter(|b| *b == b'\n')
            .count()
    };
    let nodes = parsed.module.nodes.iter();
    nodes
        .map(|node| {
            (
                u32::try_from(line_at(node.start)).unwrap_or(u32::MAX),
                node.label.to_string(),
            )
        })
        .collect()
}
