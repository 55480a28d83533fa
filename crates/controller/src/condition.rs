//! A condition on cycles, in the language of the robot's own programs.
//!
//! `tcp_force[2] < -20 and mode == "movel"`: an expression of EliteScript over the fields of `/cycle` and what the
//! script was doing. Modes are their names in lower case, which are also words of their own: `safety_mode != normal`.
//! Owns the names and their values; what to do with the answer is its callers' business.

use std::cell::RefCell;
use std::collections::BTreeSet;
use std::rc::Rc;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use elite_lang::{
    ExceptionKind, Host, Interpreter, Limits, NativeBody, NativeFunction, Param, Resume,
    ResumeOutcome, ScriptThread, ThreadId, Value, render_script_error,
};
use elite_syntax::{KnownNames, Severity, SourceFile, check, compile, picture};
use kinematics::{JointPositions, Pose, RpyPose};
use messages::{Localized, Text, text};
use motion_api::{MotionMode, RobotMode, SafetyMode};
use path_planning::{ClearanceTracker, CollisionScene, PairDistance};
use recorder::{CycleMessage, FieldValue};
use thiserror::Error;

use crate::cell_world::facts::{self, WorldFacts, WorldFactsCell};
use crate::cell_world::topic::WorldMessage;
pub use crate::program_position::ProgramPosition;

/// Safepoints that one turn of an evaluation may pass, and the turns: a condition is looked at for every cycle, it
/// cannot be a program. It may need a second turn however easy it is, since the interpreter gives way after so much
/// work of all evaluations.
const FUEL: u32 = 2_000;
const TURNS_MAX: u32 = 5;
/// Numbers of modes that are looked for.
const MODE_NUMBERS: std::ops::Range<i32> = -1..256;

/// A reason why a condition has no answer.
#[derive(Debug, Error, Localized)]
#[non_exhaustive]
pub enum ConditionError {
    /// The text is no expression, or names something that is not in a cycle. Rendered with the place marked.
    #[error(
        "the condition cannot be read:\n{0}\nnames are the columns of --csv /cycle, \
         line, program, command and the names of modes; functions are norm, and part, held, count, fallen of a cell \
         with parts"
    )]
    #[zh(
        "无法读取条件：\n{0}\n名称为 --csv /cycle 的列、line、program、command 和各模式的名称；函数为 norm，以及有工件的单元的 part、held、count、fallen"
    )]
    Text(Text),
    /// The condition raised an exception.
    #[error("the condition fails at {time:.3} s:\n{report}")]
    #[zh("条件在 {time:.3} s 处出错：\n{report}")]
    Raised {
        /// Time of the cycle, s.
        time: f64,
        /// The exception.
        report: Text,
    },
    /// The condition asks for distances where nothing is known of arm and cell.
    #[error("clearance() needs the arm and its cell, which are not known here")]
    #[zh("clearance() 需要机械臂及其单元，这里不知道")]
    NoScene,
    /// The condition computes too long: it is a program rather than an expression.
    #[error("the condition takes too long for one cycle")]
    #[zh("条件对一个周期来说计算太久")]
    StepLimit,
}

/// A compiled condition.
pub struct Condition {
    interpreter: Interpreter,
    function: Value,
    /// Names that occur in the text; only these are set.
    used: BTreeSet<String>,
    world: Rc<WorldFactsCell>,
    uses_world: bool,
    /// The bits of what `clearance()` answers in this cycle, m.
    clearance: Arc<AtomicU64>,
    uses_clearance: bool,
    scene: RefCell<Option<FollowedScene>>,
}

/// The arm among what stands around it, for conditions that ask for `clearance()`.
struct FollowedScene {
    scene: CollisionScene,
    tracker: ClearanceTracker,
    cycle: u64,
    /// What was nearest since the cycle before.
    nearest: Option<PairDistance>,
}

impl FollowedScene {
    /// The least distance since the cycle before, m.
    fn clearance(&mut self, cycle: &CycleMessage) -> Option<f64> {
        let numbers = |values: &[f64]| <[f64; 6]>::try_from(values).ok();
        let q = JointPositions(numbers(&cycle.actual_q)?);
        if let Some(tcp) = numbers(&cycle.tcp_offset) {
            self.scene
                .set_tcp(Pose::from_rpy(&RpyPose::from_array(tcp)));
        }
        if self.cycle + 1 != cycle.cycle {
            self.tracker = ClearanceTracker::default();
        }
        self.cycle = cycle.cycle;
        let place = self.tracker.advance(&self.scene, &q, f64::INFINITY);
        self.nearest = place.map(|place| place.nearest);
        Some(self.nearest.map_or(f64::INFINITY, |pair| pair.distance))
    }
}

/// A condition can reach nothing.
struct ConditionHost;

impl Host for ConditionHost {
    fn print(&self, _: ThreadId, _: &str) {}
    fn unix_time(&self) -> f64 {
        0.0
    }
    fn monotonic(&self) -> f64 {
        0.0
    }
    fn random_u64(&self) -> u64 {
        0
    }
    fn wake(&self, _: ThreadId) {}
    fn start(&self, _: ScriptThread) -> Result<(), String> {
        Err("a condition cannot start threads".to_owned())
    }
}

impl Condition {
    /// `place` is what the text is called in messages: the option or the argument that it was given as.
    ///
    /// # Errors
    /// [`ConditionError::Text`].
    pub fn new(place: &str, text: &str) -> Result<Self, ConditionError> {
        let words = mode_words();
        let cycle = CycleMessage::default();
        let fields = cycle.fields().map(|(name, _)| name.to_owned());
        let of_the_script = ["line", "program", "command"].map(str::to_owned);
        let values: BTreeSet<String> = fields.into_iter().chain(of_the_script).collect();
        let world = Rc::new(WorldFactsCell::default());
        let clearance = Arc::new(AtomicU64::new(f64::INFINITY.to_bits()));
        let natives: Vec<NativeFunction> = [norm(), clearance_native(clearance.clone())]
            .into_iter()
            .chain(facts::functions(&world))
            .collect();
        let known = KnownNames::new(
            values
                .iter()
                .chain(&words)
                .cloned()
                .chain(natives.iter().map(|native| native.name.to_owned())),
        );
        if text.trim().is_empty() {
            return Err(ConditionError::Text(text!("it is empty", "条件为空")));
        }
        let file = SourceFile::new(place, format!("{text}\n"));
        let findings: Vec<Text> = check(file.clone(), &known)
            .iter()
            .filter(|finding| {
                finding.severity == Severity::Error || finding.code == "undefined-name"
            })
            .map(|finding| picture(finding, &file))
            .collect();
        if !findings.is_empty() {
            return Err(ConditionError::Text(Text::joined(findings, "\n", "\n")));
        }
        let interpreter = Interpreter::new(Rc::new(ConditionHost), natives, Limits::default());
        for word in &words {
            interpreter.set_global(word, Value::from(word.as_str()));
        }
        // On a line of its own, so that a report shows the text as it was given.
        let file = SourceFile::new(place, format!("holds = lambda: bool((\n{text}\n))\n"));
        let program = compile(file.clone(), &known).map_err(|findings| {
            let pictures = findings.iter().map(|finding| picture(finding, &file));
            ConditionError::Text(Text::joined(pictures, "\n", "\n"))
        })?;
        let mut thread = interpreter.spawn_program(&program);
        let (ResumeOutcome::Done(_), Some(function)) = (
            thread.resume(Resume::Continue, FUEL),
            interpreter.global("holds"),
        ) else {
            return Err(ConditionError::Text(text!(
                "it is not one expression",
                "不是单个表达式"
            )));
        };
        let used = values
            .into_iter()
            .filter(|name| text.contains(name.as_str()))
            .collect();
        let mut names = facts::FUNCTION_NAMES.iter();
        Ok(Self {
            uses_world: names.any(|name| text.contains(name)),
            interpreter,
            function,
            used,
            world,
            clearance,
            uses_clearance: text.contains(CLEARANCE),
            scene: RefCell::new(None),
        })
    }

    /// Whether the text asks for parts of the cell.
    pub const fn uses_world(&self) -> bool {
        self.uses_world
    }

    /// The parts of the cell from now on; without them, questions for parts fail.
    pub fn set_world(&self, facts: Option<WorldFacts>) {
        *self.world.facts.borrow_mut() = facts;
    }

    /// The part that the last answer was about, where it asked for one.
    pub fn deciding_part(&self) -> Option<String> {
        self.world.deciding.borrow().clone()
    }

    /// The parts of the cell go on to the state of a message.
    pub fn advance_world(&self, message: &WorldMessage) {
        if let Some(facts) = &mut *self.world.facts.borrow_mut() {
            facts.apply(message);
        }
    }

    /// Whether the text may ask for `clearance()`, so that [`set_scene`](Self::set_scene) is needed.
    pub const fn uses_clearance(&self) -> bool {
        self.uses_clearance
    }

    /// Says what `clearance()` measures in: the arm among what stands around it.
    pub fn set_scene(&self, scene: CollisionScene) {
        self.scene.replace(Some(FollowedScene {
            scene,
            tracker: ClearanceTracker::default(),
            cycle: 0,
            nearest: None,
        }));
    }

    /// The two names that the last answer of `clearance()` was about, and their distance, m; `None` for a text that
    /// does not ask for it.
    pub fn nearest_pair(&self) -> Option<(String, String, f64)> {
        let scene = self.scene.borrow();
        let scene = scene.as_ref().filter(|_| self.uses_clearance)?;
        let PairDistance { distance, pair } = scene.nearest?;
        let (a, b) = scene.scene.names(pair);
        Some((a.to_owned(), b.to_owned(), distance))
    }

    /// # Errors
    /// [`ConditionError::Raised`], [`ConditionError::StepLimit`], [`ConditionError::NoScene`].
    pub fn holds(
        &self,
        cycle: &CycleMessage,
        doing: &ProgramPosition,
    ) -> Result<bool, ConditionError> {
        for (name, value) in cycle.fields() {
            self.set(name, || value_of(name, value));
        }
        self.set("program", || Value::from(doing.program.as_str()));
        self.set("line", || Value::from(i64::from(doing.line)));
        self.set("command", || Value::from(doing.command.as_str()));
        if self.uses_clearance {
            let mut scene = self.scene.borrow_mut();
            let distance = scene.as_mut().and_then(|scene| scene.clearance(cycle));
            let distance = distance.ok_or(ConditionError::NoScene)?;
            self.clearance.store(distance.to_bits(), Ordering::Relaxed);
        }
        let raised = |error: &elite_lang::ScriptError| ConditionError::Raised {
            time: cycle.time,
            report: render_script_error(error),
        };
        self.world.deciding.take();
        let mut thread = self
            .interpreter
            .spawn_call(self.function.clone(), Vec::new())
            .map_err(|error| raised(&error))?;
        let mut turns = 0;
        while turns < TURNS_MAX {
            match thread.resume(Resume::Continue, FUEL) {
                ResumeOutcome::Done(value) => return Ok(value.as_bool() == Some(true)),
                ResumeOutcome::Failed(error) => return Err(raised(&error)),
                // What earlier evaluations left is looked through slice by slice; that is no work of this one, whose
                // fuel is kept.
                ResumeOutcome::OutOfFuel if self.interpreter.is_gc_running() => {}
                ResumeOutcome::OutOfFuel => turns += 1,
                _ => break,
            }
        }
        Err(ConditionError::StepLimit)
    }

    fn set(&self, name: &str, value: impl FnOnce() -> Value) {
        if self.used.contains(name) {
            self.interpreter.set_global(name, value());
        }
    }
}

fn value_of(name: &str, value: FieldValue<'_>) -> Value {
    match (name, value) {
        ("safety_mode", FieldValue::Unsigned(x)) => {
            Value::from(word(SafetyMode::from_number(x as i32).name()))
        }
        ("robot_mode", FieldValue::Unsigned(x)) => {
            Value::from(word(RobotMode::from_number(x as i32).name()))
        }
        (_, FieldValue::Unsigned(x)) => Value::from(i64::try_from(x).unwrap_or(i64::MAX)),
        (_, FieldValue::Number(x)) => Value::from(x),
        (_, FieldValue::Numbers(values)) => Value::list_of_f64(values),
        (_, FieldValue::Text(text)) => Value::from(text),
    }
}

fn word(name: &str) -> String {
    name.to_ascii_lowercase()
}

/// The names of all modes.
fn mode_words() -> BTreeSet<String> {
    MODE_NUMBERS
        .flat_map(|number| {
            [
                SafetyMode::from_number(number).name(),
                RobotMode::from_number(number).name(),
                MotionMode::from_number(number).name(),
            ]
        })
        .map(word)
        .collect()
}

/// The name of the function that measures.
const CLEARANCE: &str = "clearance";

/// `clearance()`: the least distance, m, since the cycle before.
fn clearance_native(bits: Arc<AtomicU64>) -> NativeFunction {
    NativeFunction {
        name: CLEARANCE,
        params: Vec::new(),
        call: NativeBody::new(move |_| {
            Ok(Value::from(f64::from_bits(bits.load(Ordering::Relaxed))))
        }),
    }
}

/// `norm(tcp_force[0:3])`: the length of a vector.
fn norm() -> NativeFunction {
    NativeFunction {
        name: "norm",
        params: vec![Param::required("vector")],
        call: NativeBody::new(|call| {
            let numbers = call.arg(0).and_then(Value::as_items).and_then(|items| {
                items
                    .iter()
                    .map(Value::as_f64)
                    .collect::<Option<Vec<f64>>>()
            });
            match numbers {
                Some(numbers) => Ok(Value::from(
                    numbers.iter().map(|x| x * x).sum::<f64>().sqrt(),
                )),
                None => Err(call.raise(
                    ExceptionKind::TypeError,
                    "norm() takes a list of numbers, for example norm(tcp_force[0:3])",
                )),
            }
        }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cycle() -> CycleMessage {
        CycleMessage {
            time: 1.5,
            safety_mode: SafetyMode::ProtectiveStop.number() as u32,
            robot_mode: RobotMode::Running.number() as u32,
            tcp_force: vec![3.0, 4.0, 0.0, 0.0, 0.0, 0.0],
            mode: "movel".to_owned(),
            ..CycleMessage::default()
        }
    }

    #[test]
    fn a_condition_reads_like_the_field_names_of_a_cycle() {
        let doing = ProgramPosition {
            program: "weld".to_owned(),
            line: 7,
            command: "movel".to_owned(),
        };
        for (text, holds) in [
            ("safety_mode != normal", true),
            (
                "safety_mode == protective_stop and robot_mode == running",
                true,
            ),
            ("norm(tcp_force[0:3]) >= 5", true),
            ("abs(tcp_force[0]) > 3 or line > 7", false),
            ("mode == movel", true),
            ("program == 'weld' and 5 < line < 8", true),
            ("time", true),
            ("command in ('movej',)", false),
        ] {
            let condition = Condition::new("--find", text).unwrap();
            assert_eq!(condition.holds(&cycle(), &doing).unwrap(), holds, "{text}");
        }
    }

    #[test]
    fn distances_are_known_where_the_arm_is() {
        use core::f64::consts::FRAC_PI_2;
        use kinematics::RobotModel;
        use path_planning::{ObstaclePlace, PlacedShape, Shape};
        let condition = Condition::new("condition", "clearance() < 0.03").unwrap();
        let home = [0.0, -FRAC_PI_2, FRAC_PI_2, -FRAC_PI_2, -FRAC_PI_2, 0.0];
        let mut cycle = CycleMessage {
            cycle: 1,
            actual_q: home.to_vec(),
            tcp_offset: vec![0.0; 6],
            ..cycle()
        };
        let doing = ProgramPosition::default();
        assert!(condition.uses_clearance());
        let error = condition.holds(&cycle, &doing).unwrap_err();
        assert!(matches!(error, ConditionError::NoScene), "{error}");
        let arm = RobotModel::built_in("cs66").unwrap();
        let flange = arm.flange_pose(&JointPositions(home)).translation;
        let mut scene = CollisionScene::new(arm, None, Pose::IDENTITY);
        let ball = PlacedShape::centred(Shape::Sphere { radius: 0.01 });
        let below = Pose::from_translation(flange.x, flange.y, flange.z - 0.1);
        scene.add_obstacle("ball", vec![ball], ObstaclePlace::Standing(below));
        condition.set_scene(scene);
        assert_eq!(condition.nearest_pair(), None);
        assert!(!condition.holds(&cycle, &doing).unwrap());
        // The arm passes the ball between two cycles.
        (cycle.cycle, cycle.actual_q[1]) = (2, home[1] + 0.4);
        assert!(condition.holds(&cycle, &doing).unwrap());
        let (_, b, distance) = condition.nearest_pair().unwrap();
        assert!(b == "ball" && distance < 0.03, "{b} {distance}");
    }

    #[test]
    fn a_condition_stays_easy_while_the_interpreter_tidies_up() {
        let text = "len([a.append(a) for a in [[] for k in range(3000)]]) == 3000";
        let condition = Condition::new("condition", text).unwrap();
        // Circles of garbage, of which some evaluations leave more than is looked through at once.
        for evaluation in 0..40 {
            let answer = condition.holds(&cycle(), &ProgramPosition::default());
            assert!(matches!(answer, Ok(true)), "{evaluation}: {answer:?}");
        }
    }

    #[test]
    fn a_condition_stays_easy_after_any_number_of_cycles() {
        let condition = Condition::new("condition", "norm(actual_tcp_speed[0:3]) > 0.3").unwrap();
        let cycle = CycleMessage {
            actual_tcp_speed: vec![0.3, 0.4, 0.0, 0.0, 0.0, 0.0],
            ..cycle()
        };
        for evaluation in 0..20_000 {
            let answer = condition.holds(&cycle, &ProgramPosition::default());
            assert!(matches!(answer, Ok(true)), "{evaluation}: {answer:?}");
        }
    }

    #[test]
    fn what_is_no_condition_is_said_with_the_place() {
        for (text, said) in [
            ("tcp_forse[2] > 1", "tcp_force"),
            ("time >", "^"),
            ("x = 1", "="),
            ("import os", "^"),
            (" ", "empty"),
        ] {
            let error = Condition::new("--find", text)
                .map(drop)
                .unwrap_err()
                .to_string();
            assert!(error.contains(said), "{text}: {error}");
        }
        let condition = Condition::new("condition", "tcp_force[9] > 1").unwrap();
        let error = condition
            .holds(&cycle(), &ProgramPosition::default())
            .unwrap_err();
        assert!(error.to_string().contains("IndexError"), "{error}");
        assert!(error.to_string().contains("1.500 s"), "{error}");
        let endless = Condition::new("condition", "[1 for i in range(10**9)]").unwrap();
        let error = endless
            .holds(&cycle(), &ProgramPosition::default())
            .unwrap_err();
        assert!(matches!(error, ConditionError::StepLimit), "{error}");
    }
}
