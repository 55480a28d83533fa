//! When a condition held in a recording: rows of cycles, with what the script was doing then.
//!
//! Reads a recording once, from its beginning, and gives each row to its caller as it ends; keeps none of them.

use std::collections::BTreeMap;

use recorder::{CycleMessage, ReadError, Recording, RecordingEntry, Topic};

use crate::cell::Cell;
use crate::cell_world::facts::WorldFacts;
use crate::cell_world::topic::{self, WorldMessage};
use crate::clearance::collision_scene_of;
use crate::condition::{Condition, ConditionError, ProgramPosition};
use crate::recorded_run::cell_of;

/// Commands that are remembered by name; more than a controller can have waiting.
const COMMANDS_MAX: usize = 1024;

/// A row of cycles in which the condition held.
#[derive(Clone, Debug)]
pub struct MatchInterval {
    /// The first of them.
    pub first: CycleMessage,
    /// Time of the last one, s.
    pub last: f64,
    /// Number of cycles in which the condition held.
    pub cycles: u64,
    /// What the script was doing in the first.
    pub doing: ProgramPosition,
}

/// Totals of the cycles in which a condition held.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SearchStats {
    /// Rows of cycles.
    pub stretches: u64,
    /// Cycles in which it held.
    pub found: u64,
    /// Cycles that were looked at.
    pub cycles: u64,
}

/// The messages of `/world` beside the cycles, for a condition over parts.
struct WorldCursor<'a> {
    messages: Box<dyn Iterator<Item = Result<WorldMessage, ReadError>> + 'a>,
    next: Option<WorldMessage>,
}

impl<'a> WorldCursor<'a> {
    fn new(recording: &'a Recording, condition: &Condition) -> Result<Option<Self>, ReadError> {
        if !condition.uses_world() {
            return Ok(None);
        }
        let cell = recording
            .setup()
            .and_then(|setup| cell_of(setup).ok().flatten());
        condition.set_world(
            cell.filter(Cell::has_world)
                .map(|cell| WorldFacts::of_cell(&cell)),
        );
        let mut messages = Box::new(topic::messages(recording)?);
        let next = messages.next().transpose()?;
        Ok(Some(Self { messages, next }))
    }

    /// Lets the condition see the world after a cycle.
    fn advance(&mut self, cycle: u64, condition: &Condition) -> Result<(), ReadError> {
        while let Some(message) = self.next.take_if(|message| message.cycle <= cycle) {
            condition.advance_world(&message);
            self.next = self.messages.next().transpose()?;
        }
        Ok(())
    }
}

/// Looks at every cycle of a recording. `place` is what the condition is called in messages; `each` is given every row
/// as it ends and says whether the search goes on, `wanted` is asked before every cycle.
///
/// # Errors
/// The condition cannot be read or fails, the recording cannot be read, or `each` fails.
pub fn search<E>(
    recording: &Recording,
    (place, text): (&str, &str),
    wanted: impl Fn() -> bool,
    mut each: impl FnMut(&MatchInterval) -> Result<bool, E>,
) -> Result<SearchStats, E>
where
    E: From<ReadError> + From<ConditionError>,
{
    let condition = Condition::new(place, text)?;
    let mut world = WorldCursor::new(recording, &condition)?;
    if condition.uses_clearance()
        && let Some(setup) = recording.setup()
    {
        // An arm or a cell that cannot be made is said by the condition.
        if let Ok(scene) = collision_scene_of(setup) {
            condition.set_scene(scene);
        }
    }
    let mut doing = ProgramPosition::default();
    let mut commands: BTreeMap<u64, String> = BTreeMap::new();
    let mut current: Option<MatchInterval> = None;
    let mut tally = SearchStats::default();
    for entry in recording.entries(&[Topic::Cycle, Topic::Command, Topic::Script])? {
        match entry?.1 {
            RecordingEntry::Command(command) => {
                commands.insert(command.id, command.name);
                if commands.len() > COMMANDS_MAX {
                    commands.pop_first();
                }
            }
            RecordingEntry::Script(script) => match (script.thread, script.line) {
                (Some(0), Some(line)) => doing.line = line,
                (Some(_), _) => {}
                _ => {
                    doing.program = script.program;
                    doing.line = 0;
                }
            },
            RecordingEntry::Cycle(cycle) => {
                if !wanted() {
                    return Ok(tally);
                }
                tally.cycles += 1;
                if let Some(world) = &mut world {
                    world.advance(cycle.cycle, &condition)?;
                }
                while let Some(oldest) = commands.first_entry()
                    && *oldest.key() < cycle.command_id
                {
                    oldest.remove();
                }
                doing.command.clear();
                if let Some(name) = commands.get(&cycle.command_id) {
                    doing.command.push_str(name);
                }
                if condition.holds(&cycle, &doing)? {
                    tally.found += 1;
                    match &mut current {
                        Some(stretch) => {
                            stretch.last = cycle.time;
                            stretch.cycles += 1;
                        }
                        None => {
                            current = Some(MatchInterval {
                                last: cycle.time,
                                first: *cycle,
                                cycles: 1,
                                doing: doing.clone(),
                            });
                        }
                    }
                } else if let Some(stretch) = current.take() {
                    tally.stretches += 1;
                    if !each(&stretch)? {
                        return Ok(tally);
                    }
                }
            }
            RecordingEntry::Log(_) | RecordingEntry::Io(_) | RecordingEntry::Variable(_) => {}
        }
    }
    if let Some(stretch) = current.take() {
        tally.stretches += 1;
        each(&stretch)?;
    }
    Ok(tally)
}
