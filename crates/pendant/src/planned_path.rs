//! The path that a program would drive, and where it comes near to something: the program in the editor, run beside the
//! robot before anything moves.
//!
//! Owns the form of question and answer. What runs is a simulated arm of its own; what it may reach is decided by
//! whoever gives its settings. How paths are measured is [`controller::clearance`]'s matter.

use std::collections::BTreeMap;

use controller::ControllerConfig;
use controller::clearance::{
    ClearanceError, LeastDistance, MeasureOptions, MeasuredEnd, PathRun, measure_with_path,
};
use elite_runtime::ProgramText;
use kinematics::JointPositions;
use serde::Deserialize;
use serde_json::{Value, json};

use crate::editor_queries::QuestionError;
use crate::orders::{NAME_BYTES_MAX, PROGRAM_BYTES_MAX};

/// A program is followed for so long of its own time, s.
const SIMULATED_SECS: f64 = 600.0;
/// Most places of one answer.
const PLACES_MAX: usize = 20;
/// Points are told to this fraction of a metre.
const PER_METRE: f64 = 1e5;

/// What is asked.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PathQuery {
    /// How errors call the program.
    #[serde(default)]
    pub name: String,
    /// The program.
    pub text: String,
    /// Joint positions from which it begins, rad; without them the robot's.
    pub start: Option<[f64; 6]>,
}

impl PathQuery {
    /// Looks at its sizes.
    ///
    /// # Errors
    /// [`QuestionError`]
    pub fn check(&self) -> Result<(), QuestionError> {
        match (self.text.len(), self.name.len()) {
            (bytes, _) if bytes > PROGRAM_BYTES_MAX => Err(QuestionError::Text(bytes)),
            (_, bytes) if bytes > NAME_BYTES_MAX => Err(QuestionError::Name(bytes)),
            _ => Ok(()),
        }
    }
}

/// Runs the program on an arm of its own with these settings; the path as JSON. `keep_going` is asked now and then, and
/// the path is told as far as it was followed.
///
/// # Errors
/// [`ClearanceError`]; what the program itself does wrong is in the answer.
pub fn planned_path(
    config: &ControllerConfig,
    query: PathQuery,
    keep_going: &mut dyn FnMut() -> bool,
) -> Result<Value, ClearanceError> {
    let config = ControllerConfig {
        home: query.start.map_or(config.home, JointPositions),
        ..config.clone()
    };
    let program = ProgramText {
        name: query.name,
        text: query.text,
    };
    let options = MeasureOptions {
        limit: SIMULATED_SECS,
        ..MeasureOptions::default()
    };
    measure_with_path(&config, program, &options, keep_going).map(|ran| answer(&ran))
}

fn answer(ran: &PathRun) -> Value {
    let run = &ran.run;
    let (end, line) = match &run.end {
        MeasuredEnd::Finished => ("finished", 0),
        MeasuredEnd::NotCompiled { line, .. } => ("not_compiled", *line),
        MeasuredEnd::Waits { line } => ("waits", *line),
        MeasuredEnd::TimedOut { line, .. } | MeasuredEnd::Interrupted { line } => {
            ("goes_on", *line)
        }
        MeasuredEnd::Failed { line, .. } => ("failed", *line),
        _ => ("failed", 0),
    };
    let error = match &run.end {
        MeasuredEnd::NotCompiled { error, .. } | MeasuredEnd::Failed { error, .. } => Some(error),
        _ => None,
    };
    let rounded = |number: f64| (number * PER_METRE).round() / PER_METRE;
    let pieces = ran.path.pieces.iter().map(|piece| {
        let points = piece.iter().map(|point| json!(point.map(rounded)));
        points.collect::<Value>()
    });
    json!({
        "pieces": pieces.collect::<Value>(),
        "tolerance": ran.path.tolerance,
        "motions": run.rows.len(),
        "time": run.result.time,
        "end": end,
        "line": line,
        "error": error,
        "places": places(ran),
    })
}

/// Where the program touches something, the deepest of each line, and where it comes nearest; the nearest first. An arm
/// with nothing around it is always near to itself only, which is told where it touches.
fn places(ran: &PathRun) -> Value {
    let mut nearest: BTreeMap<u32, &LeastDistance> = BTreeMap::new();
    let overall = ran.run.nearest();
    for row in &ran.run.rows {
        let is_nearest = ran.has_obstacles && overall.is_some_and(|one| core::ptr::eq(one, row));
        let Some(least) = row.least.as_ref() else {
            continue;
        };
        if least.distance >= 0.0 && !is_nearest {
            continue;
        }
        let found = nearest.entry(row.line).or_insert(least);
        if least.distance < found.distance {
            *found = least;
        }
    }
    let mut found: Vec<_> = nearest.into_iter().collect();
    found.sort_by(|(_, a), (_, b)| a.distance.total_cmp(&b.distance));
    found.truncate(PLACES_MAX);
    let rows = found.into_iter().map(|(line, least)| {
        json!({
            "distance": least.distance,
            "a": least.a,
            "b": least.b,
            "line": line,
            "time": least.time,
            "tcp": least.tcp,
        })
    });
    rows.collect()
}

#[cfg(test)]
mod tests {
    use std::io::Write as _;

    use super::*;

    const POST: &str = "[[obstacle]]\nname = \"post\"\nshape = \"cylinder\"\nsize = [0.04, 1.0]\n\
                        pose = [-0.45, 0, 0.5, 0, 0, 0]\n";
    const LEFT: [f64; 6] = [0.8, -1.57, 1.57, -1.57, -1.57, 0.0];

    fn asked(text: &str) -> PathQuery {
        PathQuery {
            name: "a.script".to_owned(),
            text: text.to_owned(),
            start: Some(LEFT),
        }
    }

    fn path(config: &ControllerConfig, text: &str) -> Value {
        planned_path(config, asked(text), &mut || true).unwrap()
    }

    #[test]
    fn the_path_begins_at_the_start_and_says_what_it_touches_in_which_line() {
        let mut cell = tempfile::NamedTempFile::new().unwrap();
        cell.write_all(POST.as_bytes()).unwrap();
        let config = ControllerConfig {
            cell: Some(cell.path().to_owned()),
            ..ControllerConfig::default()
        };
        let through =
            "movej([0.8, -1.4, 1.4, -1.57, -1.57, 0])\nmovej([-0.8, -1.4, 1.4, -1.57, -1.57, 0])\n";
        let found = path(&config, through);
        assert_eq!(
            (&found["end"], &found["motions"]),
            (&json!("finished"), &json!(2))
        );
        let places = found["places"].as_array().unwrap();
        assert_eq!(places.len(), 1, "{places:?}");
        assert!(places[0]["distance"].as_f64().unwrap() < 0.0);
        assert_eq!(
            (&places[0]["b"], &places[0]["line"]),
            (&json!("post"), &json!(2))
        );
        let first = &found["pieces"][0][0];
        let last = found["pieces"][0].as_array().unwrap().last().unwrap();
        // From one side of the post to the other.
        assert!(
            first[1].as_f64().unwrap() * last[1].as_f64().unwrap() < 0.0,
            "{first} {last}"
        );
        // Beside it nothing is touched, and the nearest place is told.
        let beside = path(&config, "movej([0.9, -1.57, 1.57, -1.57, -1.57, 0])\n");
        let places = beside["places"].as_array().unwrap();
        assert_eq!(places.len(), 1, "{places:?}");
        assert!(places[0]["distance"].as_f64().unwrap() > 0.0);
    }

    #[test]
    fn without_anything_around_it_an_arm_is_near_to_nothing() {
        let found = path(
            &ControllerConfig::default(),
            "movej([0.9, -1.57, 1.57, -1.57, -1.57, 0])\n",
        );
        assert_eq!(found["places"], json!([]));
        assert!(found["pieces"][0].as_array().unwrap().len() > 2);
    }

    #[test]
    fn a_path_is_known_as_far_as_the_program_runs() {
        let config = ControllerConfig::default();
        for (text, end, line) in [
            ("x = (\n", "not_compiled", 1),
            (
                "movej([0.9, -1.57, 1.57, -1.57, -1.57, 0])\n1 / 0\n",
                "failed",
                2,
            ),
            (
                "movej([0.9, -1.57, 1.57, -1.57, -1.57, 0])\nwhile not get_standard_digital_in(0):\n  sync()\n",
                "waits",
                3,
            ),
        ] {
            let found = path(&config, text);
            assert_eq!(
                (&found["end"], &found["line"]),
                (&json!(end), &json!(line)),
                "{found}"
            );
            assert_eq!(found["error"].is_null(), end == "waits", "{found}");
            let has_path = !found["pieces"].as_array().unwrap().is_empty();
            assert_eq!(has_path, end != "not_compiled", "{found}");
        }
        let mut left = 3;
        let endless = asked(
            "while True:\n  movej([0.9, -1.57, 1.57, -1.57, -1.57, 0])\n  movej([0.8, -1.57, 1.57, -1.57, -1.57, 0])\n",
        );
        let mut keep_going = || {
            left -= 1;
            left > 0
        };
        let found = planned_path(&config, endless, &mut keep_going).unwrap();
        assert_eq!(found["end"], "goes_on");
    }
}
