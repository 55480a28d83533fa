//! A faster program that does the same: speeds up to the limits, blends, and no waypoints that nobody needs.
//!
//! Every change is a change of the text, and none is believed: after each the program is run as a whole, and must say
//! and set the same in the same order with the arm in the same places, keep the margin, and take less time. A change
//! that does not is taken back.

mod diff;
mod effects;
mod motion_call;

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use elite_runtime::{Preset, ProgramText};
use messages::{Localized, Text};
use path_planning::CollisionScene;
use thiserror::Error;

use crate::clearance::{
    ClearanceError, ClearanceRun, MeasureOptions, MeasuredEnd, TOUCHING, collision_scene,
    measure_and_tell,
};
use crate::config::ControllerConfig;
use crate::outcome::NullObserver;
use crate::start::StartError;
use effects::{EffectRecorder, RunEffects};
use motion_call::{CallChange, MotionCall, MotionKind, changed_text, motion_calls};

/// Runs of one program at most.
const RUNS_MAX: u32 = 400;
/// A change must gain so much to be kept, s.
const GAIN_MIN: f64 = 5e-4;
/// Distances this much below what is allowed are rounding, m.
const DISTANCE_TOLERANCE: f64 = 1e-4;
/// Shares of the joints' limits that are tried for speeds and accelerations.
const JOINT_SHARES: [f64; 3] = [1.0, 0.7, 0.5];
/// Speeds and accelerations of the TCP that are tried, m/s and m/s².
const LINE_SPEEDS: [(f64, f64); 4] = [(2.0, 10.0), (1.2, 6.0), (0.7, 4.0), (0.4, 2.0)];
/// Blend radii that are tried, m.
const RADII: [f64; 6] = [0.2, 0.12, 0.07, 0.04, 0.02, 0.01];
/// Defaults of `movej` and of motions of the TCP: acceleration and speed.
const JOINT_DEFAULTS: (f64, f64) = (1.4, 1.05);
const LINE_DEFAULTS: (f64, f64) = (1.2, 0.25);

/// How a program is made faster.
#[derive(Clone, Debug)]
pub struct OptimizeOptions {
    /// The distance that is kept, m; motions that are nearer already come no nearer.
    pub margin: f64,
    /// Lines that stay as they are, both ends included.
    pub keep: Vec<(u32, u32)>,
    /// Globals that the program finds set.
    pub presets: Vec<Preset>,
    /// Longest simulated time, s.
    pub limit: f64,
}

/// A faster program.
#[derive(Clone, Debug, PartialEq)]
pub struct OptimizedProgram {
    /// Text of the faster program.
    pub text: String,
    /// How long the program took before, s.
    pub before: f64,
    /// How long it takes now, s.
    pub after: f64,
    /// What was changed; empty if nothing could be gained.
    pub diff: String,
    /// How often the program was run.
    pub runs: u32,
}

/// A reason why a program cannot be made faster.
#[derive(Debug, Error, Localized)]
#[non_exhaustive]
pub enum OptimizeError {
    /// The program fails as it is, or does not end.
    #[error("the program cannot be made faster as it is: {0}")]
    #[zh("程序现状无法加快：{0}")]
    Program(MeasuredEnd),
    /// The program runs into something as it is.
    #[error(
        "the program runs into something as it is: {a} and {b} are {:.1} mm inside each other in line {line}, \
         at {time:.3} s",
        depth * 1e3
    )]
    #[zh("程序现状会发生碰撞：{a}与{b}重叠 {:.1} mm，在第 {line} 行，{time:.3} s 时", depth * 1e3)]
    Touches {
        /// What moves with the arm.
        a: Text,
        /// What is touched: a thing of the cell, or another part of the arm.
        b: Text,
        /// How deep, m.
        depth: f64,
        /// Line of the motion.
        line: u32,
        /// Simulated time, s.
        time: f64,
    },
    /// No controller.
    #[error(transparent)]
    Start(#[from] StartError),
    /// A run met a fault.
    #[error(transparent)]
    Run(#[from] ClearanceError),
}

/// Makes a program faster. `keep_going` is asked now and then, and ends the search with what was found.
///
/// # Errors
/// [`OptimizeError`]
pub fn optimize(
    config: &ControllerConfig,
    program: &ProgramText,
    options: &OptimizeOptions,
    keep_going: &mut dyn FnMut() -> bool,
) -> Result<OptimizedProgram, OptimizeError> {
    let scene = collision_scene(config)?;
    let mut search = ProgramSearch {
        config,
        options,
        program,
        calls: motion_calls(&program.text),
        scene,
        changes: BTreeMap::new(),
        base: RunEffects::default(),
        allowed: BTreeMap::new(),
        time: f64::INFINITY,
        runs: 0,
        keep_going,
    };
    let (run, base) = search.run(&program.text)?;
    if run.end != MeasuredEnd::Finished {
        return Err(OptimizeError::Program(run.end));
    }
    if let Some((row, least)) = run
        .nearest()
        .and_then(|row| Some((row, row.least.as_ref()?)))
        && least.distance < -TOUCHING
    {
        return Err(OptimizeError::Touches {
            a: least.a.clone(),
            b: least.b.clone(),
            depth: -least.distance,
            line: row.line,
            time: least.time,
        });
    }
    search.base = base;
    search.time = run.result.time;
    for row in &run.rows {
        let allowed = search.allowed.entry(row.line).or_insert(options.margin);
        let distance = row.distance();
        // What touches may touch: how deep a part sinks into what it lies on is the solver's matter.
        let least = if distance <= TOUCHING {
            -TOUCHING
        } else {
            distance
        };
        *allowed = allowed.min(least);
    }
    let in_force_mode: BTreeSet<u32> = run
        .rows
        .iter()
        .filter(|row| row.in_force_mode)
        .map(|row| row.line)
        .collect();
    let free: Vec<usize> = (0..search.calls.len())
        .filter(|number| {
            let line = search.calls[*number].line;
            let is_kept = options
                .keep
                .iter()
                .any(|(first, last)| (*first..=*last).contains(&line));
            !is_kept && !in_force_mode.contains(&line)
        })
        .collect();
    search.raise_speeds(&free)?;
    search.enlarge_blends(&free)?;
    search.drop_waypoints(&free)?;
    search.enlarge_blends(&free)?;
    search.finish(run.result.time)
}

struct ProgramSearch<'a> {
    config: &'a ControllerConfig,
    options: &'a OptimizeOptions,
    program: &'a ProgramText,
    calls: Vec<MotionCall>,
    scene: CollisionScene,
    /// The changes that are kept, by the numbers of the calls.
    changes: BTreeMap<usize, CallChange>,
    base: RunEffects,
    /// The least distance that each line may have, m.
    allowed: BTreeMap<u32, f64>,
    /// Time of the program with these changes, s.
    time: f64,
    runs: u32,
    keep_going: &'a mut dyn FnMut() -> bool,
}

impl ProgramSearch<'_> {
    fn run(&mut self, text: &str) -> Result<(ClearanceRun, RunEffects), OptimizeError> {
        self.runs += 1;
        let recorder = Arc::new(EffectRecorder::new(Arc::new(NullObserver)));
        let program = ProgramText {
            name: self.program.name.clone(),
            text: text.to_owned(),
        };
        let options = MeasureOptions {
            presets: self.options.presets.clone(),
            limit: self.options.limit,
            has_history: false,
        };
        let run = measure_and_tell(
            self.scene.clone(),
            recorder.clone(),
            self.config,
            program,
            &options,
            self.keep_going,
        )?;
        let effects = recorder.effects().with_grips(run.grips.clone());
        Ok((run, effects))
    }

    /// Keeps further changes if the program then does the same in less time; false if it does not.
    fn keeps(&mut self, further: &[(usize, CallChange)]) -> Result<bool, OptimizeError> {
        if further.is_empty() || self.runs >= RUNS_MAX || !(self.keep_going)() {
            return Ok(false);
        }
        let mut changes = self.changes.clone();
        for (number, change) in further {
            let kept = changes.entry(*number).or_default();
            kept.acceleration = change.acceleration.or(kept.acceleration);
            kept.speed = change.speed.or(kept.speed);
            kept.radius = change.radius.or(kept.radius);
            kept.is_dropped |= change.is_dropped;
        }
        let text = changed_text(&self.program.text, &self.calls, &changes);
        let (run, effects) = self.run(&text)?;
        let is_far = run.rows.iter().all(|row| {
            let allowed = self.allowed.get(&row.line).copied();
            row.distance() >= allowed.unwrap_or(self.options.margin) - DISTANCE_TOLERANCE
        });
        let is_kept = run.end == MeasuredEnd::Finished
            && is_far
            && effects.are_those_of(&self.base)
            && run.result.time < self.time - GAIN_MIN;
        if is_kept {
            self.changes = changes;
            self.time = run.result.time;
        }
        Ok(is_kept)
    }

    /// Keeps as many of these changes as possible: all, or those of either half. The numbers of those that were not.
    fn keep_most(&mut self, further: &[(usize, CallChange)]) -> Result<Vec<usize>, OptimizeError> {
        if further.is_empty() || self.keeps(further)? {
            return Ok(Vec::new());
        }
        if further.len() == 1 {
            return Ok(vec![further[0].0]);
        }
        let (first, second) = further.split_at(further.len() / 2);
        let mut left = self.keep_most(first)?;
        left.extend(self.keep_most(second)?);
        Ok(left)
    }

    /// Speeds and accelerations, the highest first.
    fn raise_speeds(&mut self, free: &[usize]) -> Result<(), OptimizeError> {
        let limits = self.scene.model().limits();
        let least = |values: &[f64; 6]| values.iter().copied().fold(f64::INFINITY, f64::min);
        let joints = (least(&limits.acceleration.0), least(&limits.speed.0));
        let mut left = free.to_vec();
        for tier in 0..JOINT_SHARES.len().max(LINE_SPEEDS.len()) {
            let mut further = Vec::new();
            for &number in &left {
                let call = &self.calls[number];
                let (wanted, defaults) = match call.kind {
                    MotionKind::Joints => {
                        let share = JOINT_SHARES.get(tier);
                        let wanted = share
                            .map(|share| (rounded(joints.0 * share), rounded(joints.1 * share)));
                        (wanted, JOINT_DEFAULTS)
                    }
                    MotionKind::Line => {
                        let wanted = LINE_SPEEDS
                            .get(tier)
                            .map(|(speed, acceleration)| (*acceleration, *speed));
                        (wanted, LINE_DEFAULTS)
                    }
                };
                let Some((acceleration, speed)) = wanted else {
                    continue;
                };
                let more = |value: Option<f64>, wanted: f64| {
                    value.is_some_and(|value| value < wanted).then_some(wanted)
                };
                let change = CallChange {
                    acceleration: more(call.acceleration.value(defaults.0), acceleration),
                    speed: more(call.speed.value(defaults.1), speed),
                    ..CallChange::default()
                };
                if change != CallChange::default() {
                    further.push((number, change));
                }
            }
            left = self.keep_most(&further)?;
        }
        Ok(())
    }

    /// Blends into motions that follow at once, the largest first.
    fn enlarge_blends(&mut self, free: &[usize]) -> Result<(), OptimizeError> {
        let is_dropped = |number: &usize| {
            let change = self.changes.get(number);
            change.is_some_and(|change| change.is_dropped)
        };
        let mut left: Vec<usize> = free
            .iter()
            .copied()
            .filter(|number| self.calls[*number].precedes_motion && !is_dropped(number))
            .collect();
        for radius in RADII {
            let further: Vec<(usize, CallChange)> = left
                .iter()
                .filter(|number| {
                    let changed = self.changes.get(number).and_then(|change| change.radius);
                    let has = changed.or(self.calls[**number].radius.value(0.0));
                    has.is_some_and(|has| has < radius)
                })
                .map(|number| {
                    let change = CallChange {
                        radius: Some(radius),
                        ..CallChange::default()
                    };
                    (*number, change)
                })
                .collect();
            left = self.keep_most(&further)?;
        }
        Ok(())
    }

    /// Waypoints between two motions that are not needed.
    fn drop_waypoints(&mut self, free: &[usize]) -> Result<(), OptimizeError> {
        for &number in free {
            let call = &self.calls[number];
            if call.precedes_motion && call.follows_motion {
                let change = CallChange {
                    is_dropped: true,
                    ..CallChange::default()
                };
                self.keeps(&[(number, change)])?;
            }
        }
        Ok(())
    }

    /// The program with its changes, run once more as it will be written.
    fn finish(mut self, before: f64) -> Result<OptimizedProgram, OptimizeError> {
        let old = &self.program.text;
        let changed = changed_text(old, &self.calls, &self.changes);
        let mut gone = BTreeSet::new();
        for (number, change) in &self.changes {
            let call = &self.calls[*number];
            let range = call.statement.range();
            let begins = old[..range.start].rfind('\n').map_or(0, |at| at + 1);
            let ends = old[range.end..]
                .find('\n')
                .map_or(old.len(), |at| range.end + at);
            let around = [&old[begins..range.start], &old[range.end..ends]];
            let is_alone = around[0].trim().is_empty()
                && (around[1].trim().is_empty() || around[1].trim_start().starts_with('#'));
            if change.is_dropped && is_alone {
                let lines = old[range].matches('\n').count();
                let first = call.line as usize - 1;
                gone.extend(first..=first + lines);
            }
        }
        let lines: Vec<(&str, Option<String>)> = old
            .lines()
            .zip(changed.lines())
            .enumerate()
            .map(|(at, (old, new))| (old, (!gone.contains(&at)).then(|| new.to_owned())))
            .collect();
        let diff = diff::unified(&self.program.name, &lines);
        let mut text: String = lines
            .iter()
            .filter_map(|(_, new)| new.as_ref())
            .map(|line| format!("{line}\n"))
            .collect();
        if !old.ends_with('\n') {
            text.pop();
        }
        if diff.is_empty() {
            return Ok(OptimizedProgram {
                text: old.clone(),
                before,
                after: before,
                diff,
                runs: self.runs,
            });
        }
        let (run, effects) = self.run(&text)?;
        let is_same = run.end == MeasuredEnd::Finished && effects.are_those_of(&self.base);
        let least = self
            .allowed
            .values()
            .copied()
            .fold(self.options.margin, f64::min);
        if !is_same || run.distance() < least - DISTANCE_TOLERANCE || run.result.time > before {
            // What was proven line by line does not hold of the whole: nothing is changed then.
            return Ok(OptimizedProgram {
                text: old.clone(),
                before,
                after: before,
                diff: String::new(),
                runs: self.runs,
            });
        }
        Ok(OptimizedProgram {
            text,
            before,
            after: run.result.time,
            diff,
            runs: self.runs,
        })
    }
}

/// Two digits behind the point, never more than the number.
fn rounded(number: f64) -> f64 {
    (number * 100.0).floor() / 100.0
}
