//! Nothing that people are told lacks its Chinese form: the sentences of findings, of the robot's functions, of stops
//! and of commands are taken from where the source declares them, those of functions from their declarations.

use std::collections::BTreeSet;
use std::path::Path;

use editor::analysis::words::{Language, LanguageWords as _};
use elite_syntax::chinese::PhraseTable;

/// What commands say; the tables are `server`'s, which this crate does not know.
#[path = "../../server/src/language/sentences.rs"]
mod of_commands;
#[path = "../../server/src/language/libraries.rs"]
mod of_libraries;
#[path = "../../server/src/language/script_tests.rs"]
mod of_script_tests;
#[path = "../../server/src/language/words.rs"]
mod words_of_commands;

/// Where sentences about texts of programs are declared.
const OF_TEXTS: &[&str] = &[
    "elite-syntax/src/lexer",
    "elite-syntax/src/parser",
    "elite-syntax/src/resolve",
    "elite-syntax/src/lint",
    "elite-syntax/src/habits.rs",
    "elite-syntax/src/program.rs",
    "elite-lang/src/advice.rs",
];

/// Where those about the robot are, all of which people are told.
const OF_ROBOT: &[&str] = &[
    "elite-runtime/src/builtins/call",
    "elite-runtime/src/builtins/hints/mod.rs",
    "elite-runtime/src/builtins/hints/limits.rs",
    "elite-runtime/src/builtins/declare.rs",
    "elite-runtime/src/message.rs",
    "elite-runtime/src/task/report.rs",
    "motion-api/src/event.rs",
    "motion-api/src/form.rs",
    "kinematics/src/collision.rs",
];

/// Functions one by one: of these texts only those that begin with a function are sentences of it, the others
/// declarations.
const OF_FUNCTIONS: &str = "elite-runtime/src/builtins";

/// Where commands and the crates whose errors they pass on declare what they say.
const OF_COMMANDS: &[&str] = &[
    "server/src/cli/identify.rs",
    "server/src/cli/import.rs",
    "server/src/cli/mod.rs",
    "server/src/cli/paths.rs",
    "server/src/cli/replay.rs",
    "server/src/cli/robot.rs",
    "server/src/cli/ros2.rs",
    "server/src/cli/test.rs",
    "server/src/commands/calibrate.rs",
    "server/src/commands/cell/mod.rs",
    "server/src/commands/check.rs",
    "server/src/commands/clearance.rs",
    "server/src/commands/compare/bag",
    "server/src/commands/doctor",
    "server/src/commands/excite.rs",
    "server/src/commands/fleet/file.rs",
    "server/src/commands/fleet/mod.rs",
    "server/src/commands/fleet/robot.rs",
    "server/src/commands/identify",
    "server/src/commands/import.rs",
    "server/src/commands/mcp/mod.rs",
    "server/src/commands/optimize.rs",
    "server/src/commands/place.rs",
    "server/src/commands/plan.rs",
    "server/src/commands/record",
    "server/src/commands/replay/csv.rs",
    "server/src/commands/replay/diff.rs",
    "server/src/commands/replay/error_line.rs",
    "server/src/commands/replay/find.rs",
    "server/src/commands/replay/mod.rs",
    "server/src/commands/replay/plot.rs",
    "server/src/commands/replay/programs.rs",
    "server/src/commands/replay/rerun.rs",
    "server/src/commands/replay/rosbag.rs",
    "server/src/commands/replay/script.rs",
    "server/src/commands/replay/serve/mod.rs",
    "server/src/commands/replay/state.rs",
    "server/src/commands/replay/summary.rs",
    "server/src/commands/robot_consent.rs",
    "server/src/commands/ros2.rs",
    "server/src/commands/run/bag.rs",
    "server/src/commands/send/mod.rs",
    "server/src/commands/send/program/mod.rs",
    "server/src/commands/serve_error.rs",
    "server/src/commands/shell",
    "server/src/commands/test.rs",
    "server/src/commands/translate.rs",
    "server/src/config",
    "server/src/options.rs",
    "server/src/plot/canvas.rs",
    "server/src/plot/mod.rs",
    "controller/src/cell",
    "controller/src/clearance",
    "controller/src/command_replay.rs",
    "controller/src/condition.rs",
    "controller/src/loaded_model.rs",
    "controller/src/optimizer",
    "controller/src/options/declared.rs",
    "controller/src/options/slot.rs",
    "controller/src/options/values.rs",
    "controller/src/planned_path",
    "controller/src/recorded_run.rs",
    "controller/src/rerun.rs",
    "controller/src/search.rs",
    "controller/src/start.rs",
    "controller/src/start_configuration.rs",
    "controller/src/stepped.rs",
    "elite-runtime/src/external/calls.rs",
    "elite-runtime/src/external/rerun.rs",
    "elite-runtime/src/preset.rs",
    "kinematics/src/calibration",
    "kinematics/src/identification",
    "kinematics/src/payload.rs",
    "kinematics/src/safety",
    "kinematics/src/text_file.rs",
    "kinematics/src/urdf",
    "mesh/src",
    "motion/src/config_error.rs",
    "motion/src/realtime.rs",
    "path-planning/src",
    "program-import/src/toolpath",
    "program-import/src/translate",
    "program-import/src/urscript",
    "recorder/src/arguments.rs",
    "recorder/src/compare.rs",
    "recorder/src/cycle.rs",
    "recorder/src/files.rs",
    "recorder/src/json_values.rs",
    "recorder/src/messages.rs",
    "recorder/src/read_error.rs",
    "recorder/src/reader.rs",
    "recorder/src/recorder.rs",
    "recorder/src/records.rs",
    "recorder/src/setup.rs",
    "recorder/src/table.rs",
    "robot-client/src/address.rs",
    "robot-client/src/calibrate.rs",
    "robot-client/src/interpreter.rs",
    "robot-client/src/primary.rs",
    "robot-client/src/rtsi.rs",
    "script-test/src/discover.rs",
    "script-test/src/pool.rs",
    "ros2/src/names.rs",
    "wire/src/rtsi.rs",
    "world/src/check.rs",
    "world/src/check_entry.rs",
    "world/src/error.rs",
    "world/src/fingers.rs",
    "world/src/orders.rs",
];

/// Where tests of programs say what they have found. Reports for machines stay English.
const OF_SCRIPT_TESTS: &[&str] = &[
    "script-test/src/discover.rs",
    "script-test/src/expect.rs",
    "script-test/src/golden_path.rs",
    "script-test/src/near.rs",
    "script-test/src/pool.rs",
    "script-test/src/report/human.rs",
    "script-test/src/report/mod.rs",
    "script-test/src/runner.rs",
    "script-test/src/simulated_peers",
    "script-test/src/simulated_servers.rs",
    "script-test/src/test_context.rs",
    "script-test/src/test_object.rs",
    "script-test/src/world_functions.rs",
    "server/src/commands/test.rs",
];

/// What the debugger says at a terminal has its Chinese beside it or in the tables; much of it is the protocol's.
const OF_DEBUGGER: &[&str] = &["server/src/commands/debug/console", "editor/src/dap"];

/// Functions of other robots with a remark each, behind the last bar.
const FUNCTIONS_OF_OTHERS: &str = include_str!("../../program-import/src/translate/functions.txt");

/// Begins what is wrong with a command.
const PROGRAM: &str = "eliteserver: ";

/// Texts of commands that stay as they are.
const COMMANDS_STAY: &[&str] = &[
    // Fields of a cycle, and their units.
    "cycle: {}",
    "kg, m, kg m²",
    "m/s, rad/s",
    "robot_mode: {}",
    "safety_mode: {}",
    "time: {} s",
    "TCP {} m, rad",
    "{} s {}",
    "{} s {}: {}",
    // An answer to an assistant.
    "the settings of the tests in {} allow more than there is here: of files fs, which is the folder that eliteserver \
     mcp was started in, of machines those that a test plays",
    // Texts of pictures, whose letters are Latin.
    ", too many to be marked: {}; --from and --to show a part",
    "Force on the tool, TCP frame",
    "Joint accelerations, target",
    "Joint positions, actual",
    "Joint speeds, actual",
    "Joint torques, actual",
    "{}   {}, {} plant",
    // How a report of Python's form begins, and a line of it.
    "in node",
    "Traceback (most recent call last):",
    // Parts of sentences that are in the table as wholes.
    "(by {})",
    "({} line {})",
    ", line {}",
    ", node {}",
    "and {} more fields",
    "command: {} {}{}",
    "cycle {}, {} parts moved",
    "program {} at cycle {}",
    "script: {} line {}{} (thread {})",
    // Messages of a recording.
    "line {}, column {}: {}{}",
    // Numbers with their units.
    "kg m²",
    "m, rad",
    "N, Nm",
    "Nm s/rad",
    "x = {} m, y = {} m, yaw = {} rad",
    "{} mm",
    "{} s",
    "{}  {} {}  {} {} {} rad {}{}{}",
    // Lines of programs and of cell files.
    "# Turns each joint at several speeds in both directions, so that its friction can be told.",
    "# Turns the flange about all axes, so that what hangs on it can be told. Keep away from the arm.",
    "# The arm has to stand at {}.",
    "# Translated from {}",
    "# line {}: {}",
    "def planned_path():",
    "Pose([{}], [{}])",
    ", mode=1",
    ", r={}",
    "at({}, {}, {})",
    "at({}, {}, {}, {}, {}, {})",
    "elementwise(\"*\", {}, -1)",
    "elementwise(\"{}\", {}, {})",
    "frame = {}",
    "inertia = {}",
    "movec({}, {}",
    "movej({}, a=1.0, v=0.5)",
    "movej({}, a={}, v={})",
    "movej({}, a={}, v={}, r={})",
    "movel({}, a={}, v={})",
    "movel({}, v={})",
    "names \"{}\"",
    "return {}",
    "set_standard_digital_out({}, {})",
    "set_payload({}, {}{})",
    "start_thread({}, {}, False)",
    "switch_tool_digital_out({}, {})",
    "{}, v={}{}{})",
    "{}set_payload({}, {}{})",
    "AutoCAD Binary DXF",
    "d[1] + d[2] + d[3]",
    "def {}():",
    "def {}():\n{}tinterpreter_mode(clearQueueOnEnter=False, clearOnEnd=True)\nend",
    "tglobal {}",
    // Lines of a port, and of the report of an error.
    "ack {}",
    "ack: {}: {}",
    "discard: {}",
    "state: {}: {}",
    "{} s  {}",
    ", column",
    ", in",
    ", line",
    "{}{}, line {}, column {}, in {}",
    // With its Chinese beside it.
    ", line {}{}",
    "{} [{}] rad",
    "stop task",
    "{}, column {},{}",
    "{}, line",
    "robot {}, program {}, speed {} %",
    "safety {}, inputs {}, outputs {}",
    "TCP [{}] m, rad",
    // Parts of others.
    "{}, the program that it sends, is XML too",
    "{}, the program that it sends, is not beside it",
    "{} is a task of the pendant in XML, and {}",
    // Headings of help, which another test looks after.
    "Ports and server",
    "Ports of --serve",
    // Lines of the log, which stays English.
    "all robots are restarted",
    "all robots have ended",
    "no advice for: {}",
    "nothing is restarted: {}",
    "nothing is restarted: {} has other robots now; end the fleet and start it again",
    "robot {} did not come up, the others are not restarted",
    "robot {} did not come up, the others are not restarted: {}",
    "robot {} is restarted",
    "robot {}: {}; it is started again in {} s",
    "the recording ends at {} s",
    "{} is off in a replay",
    "{} on {}:{}",
    "{} robots, page on http://{}/",
    "cell: {}",
    // What no person sees.
    "knots are in order",
    "lines count from 1",
    "no length is below a micrometre",
    "a box",
    "at line {} column {}",
    // The Chinese of serde's words has it.
    "an object",
    "the figures as documented, not the constant",
    "the messages say what the fields are",
    // A finding of runs again.
    "command {} cannot be given again: {}",
];

/// Texts of tests of programs that stay as they are: names, units, commands, an answer to an assistant, and parts of
/// sentences that are in the table as wholes.
const SCRIPT_TESTS_STAY: &[&str] = &[
    "--timeout {}",
    "--wall-timeout {}",
    "; part {}",
    "; {} was {}",
    "; {} was {} mm from {}",
    ", line {} of the program",
    ", line {} of the test",
    "<class '",
    "AssertionError: {}",
    "always: `{}` did not hold",
    "at {}",
    "at {} s, cycle {}",
    "did not end in its time",
    "eliteserver test {} -k {} --seed {}",
    "ended by a protective stop",
    "ended by an emergency stop",
    "never: `{}` held",
    "one has {} items, the other {}{}",
    "one is a number, the other is not{}",
    "the program under test {}{}: {}",
    "the settings of the tests in {} allow more than there is here: of files fs, which is the folder that eliteserver \
     mcp was started in, of machines those that a test plays",
    "the test {}",
    "they differ by {}{}",
    "was stopped",
    "{} and {} cannot be compared{}; numbers and lists of numbers can",
    "{} ms",
    "{} s",
    "{} µs",
    "{}, line",
];

/// Sentences of commands that the source makes of parts.
const COMPOSED: &[&str] = &[
    "## {}",
    "{} is a task of the pendant in XML, and {}, the program that it sends, is XML too",
    "{} is a task of the pendant in XML, and {}, the program that it sends, is not beside it",
    "{} is left out",
    "{} is left out; {}",
    "is {} here; {}",
    "is {} of the program's head",
    "is {} of the program's head; {}",
    "command: {} {} ({} line {})",
    "command: {} {}",
    "goal_in_collision: {}",
    "in node {}",
    "no path was found {}; most often in the way were {}; --time gives it longer",
    "no path was found {}; most often in the way were {}; a position in --via or a smaller --margin may help",
    "no_path: {}",
    "out_of_reach: {}",
    "start_in_collision: {}",
    "program {} at cycle {}, line {}: {}",
    "program {} at cycle {}: {}",
    "script: {} line {} (thread {})",
    "script: {} line {}, node {} (thread {})",
    "the condition cannot be read:",
    "the condition fails at {} s:",
    "names are the columns of --csv /cycle, line, program, command and the names of modes; functions are norm, and part, \
     held, count, fallen of a cell with parts",
    "there is no order {}; did you mean {}?",
    "there is no order {}; help lists the orders",
    "there is nothing called {} in the cell that could be held; there is nothing",
    "world cycle {}, {} parts moved and cycle {}, {} parts moved",
    "world cycle {}, {} parts moved and nothing",
    "world nothing and cycle {}, {} parts moved",
    "{} and {} (by {})",
    "{} and {} (by {}) and {} more fields",
    "{} and {} and {} more fields",
    "{}, {}",
    "{}; {}",
    "{}, line {}, column {}, in {}",
    "{}: {} has {} = nothing; {}",
    "| line | name | what |",
];

/// Texts in those places that stay as they are.
const STAY: &[&str] = &[
    // CPython's words about literals.
    "(unicode error) 'unicodeescape' codec can't decode bytes in position {}-{}: {}",
    "(value error) invalid \\x escape at position {}",
    "illegal Unicode character",
    "malformed \\N character escape",
    "truncated \\{}{} escape",
    "unknown Unicode character name",
    // Parts of others, and what no person sees.
    "can only concatenate str (not ",
    "write '",
    "declared as another kind",
    "has no default",
    "line {}\n{}",
    // Types and ranges, which are written alike; what stands instead of a section.
    "each 0 or 1",
    "from controller output, not from the manual",
    "list | str",
    "m/s, rad/s",
    "list[6] float",
    "list[6] float | str",
    "list[float] | float",
    "list[{}] bool",
    "list[{}] float",
    "thread id",
    // A name and what the system or another sentence says.
    "get_micro_line_values_by_index(): {}",
    "load_micro_line_file(): {}",
    "load_micro_line_file(): {}: {}",
    "moveml(): {}",
    "pow(): {} to the power {}",
    "rpc_factory(): url {}",
    "set_payload(): {}",
    "start_thread(): {}",
    "track_conveyor_circular(): ticks_per_revolution",
    "track_conveyor_linear(): ticks_per_meter",
];

/// The string literals of a source text, comments and tests left out.
fn literals(source: &str) -> Vec<String> {
    let source = source.split("#[cfg(test)]\nmod").next().unwrap();
    let text: Vec<char> = source.chars().collect();
    let at = |index: usize| text.get(index).copied().unwrap_or('\0');
    let (mut found, mut index) = (Vec::new(), 0);
    while index < text.len() {
        match at(index) {
            '/' if at(index + 1) == '/' => {
                while index < text.len() && at(index) != '\n' {
                    index += 1;
                }
            }
            // A character; otherwise a lifetime.
            '\'' if at(index + 1) == '\\' => {
                index += 3;
                while at(index) != '\'' {
                    index += 1;
                }
                index += 1;
            }
            '\'' if at(index + 2) == '\'' => index += 3,
            '"' => {
                let mut literal = String::new();
                index += 1;
                while at(index) != '"' {
                    if at(index) != '\\' {
                        literal.push(at(index));
                        index += 1;
                        continue;
                    }
                    match at(index + 1) {
                        '\n' => {
                            index += 2;
                            while at(index).is_whitespace() {
                                index += 1;
                            }
                            continue;
                        }
                        'n' => literal.push('\n'),
                        other => literal.push(other),
                    }
                    index += 2;
                }
                index += 1;
                found.push(literal);
            }
            _ => index += 1,
        }
    }
    found
}

/// A text for `format!` with all its places alike.
fn form(literal: &str) -> String {
    let hidden = literal.replace("{{", "\u{1}").replace("}}", "\u{2}");
    let mut form = String::new();
    let mut rest = &*hidden;
    while let Some((before, after)) = rest.split_once('{') {
        form.push_str(before);
        form.push_str("{}");
        rest = after.split_once('}').map_or("", |(_, after)| after);
    }
    form.push_str(rest);
    form.replace('\u{1}', "{").replace('\u{2}', "}")
}

fn declared(places: &[&str]) -> BTreeSet<String> {
    let crates = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let mut open: Vec<_> = places.iter().map(|place| crates.join(place)).collect();
    let mut found = BTreeSet::new();
    while let Some(path) = open.pop() {
        if path.is_dir() {
            let inner = std::fs::read_dir(&path).unwrap();
            open.extend(inner.map(|entry| entry.unwrap().path()));
            continue;
        }
        let is_source = path.extension().is_some_and(|ending| ending == "rs");
        if !is_source || path.ends_with("tests.rs") {
            continue;
        }
        for literal in literals(&std::fs::read_to_string(&path).unwrap()) {
            // What is no text for `format!` may have braces of its own.
            found.insert(form(&literal));
            found.insert(literal);
        }
    }
    found
}

fn english(tables: &[PhraseTable]) -> BTreeSet<&'static str> {
    let entries = tables.iter().copied().flatten();
    entries.map(|(english, _)| *english).collect()
}

/// The texts for people among those of the source that no table has.
fn gaps(declared: &BTreeSet<String>, known: &BTreeSet<&str>) -> Vec<String> {
    let is_text = |text: &&String| {
        let has_words =
            text.trim().contains(' ') && text.contains(|c: char| c.is_ascii_lowercase());
        has_words && form(text) == **text
    };
    // A plain text with a doubled brace is in the table as it is.
    let doubled: BTreeSet<String> = known.iter().map(|known| form(known)).collect();
    let texts = declared.iter().filter(is_text);
    let missing = texts.filter(|text| {
        !known.contains(&***text) && !doubled.contains(&**text) && !STAY.contains(&&***text)
    });
    missing.cloned().collect()
}

#[test]
fn every_sentence_about_texts_is_there_in_chinese() {
    let known = english(&[
        elite_syntax::chinese::SENTENCES,
        elite_syntax::chinese::WORDS,
    ]);
    let declared = declared(OF_TEXTS);
    assert!(declared.len() > 300, "{}", declared.len());
    assert_eq!(gaps(&declared, &known), [""; 0]);
    let dead: Vec<_> = known
        .iter()
        .filter(|known| !declared.contains(**known))
        .collect();
    assert_eq!(dead, [&""; 0], "no source says so any more");
}

#[test]
fn every_sentence_about_the_robot_is_there_in_chinese() {
    use elite_runtime::chinese::{SENTENCES, WORDS};
    let known = english(&[SENTENCES, WORDS]);
    let own = declared(OF_ROBOT);
    assert_eq!(gaps(&own, &known), [""; 0]);
    let of_functions = declared(&[OF_FUNCTIONS]);
    let sentences = of_functions.iter().filter(|text| text.contains("(): "));
    let sentences: BTreeSet<String> = sentences.cloned().collect();
    assert_eq!(gaps(&sentences, &known), [""; 0]);
    // What ends a thread is an error of the task.
    let of_tasks = declared(&["elite-runtime/src/task/context/thread_table.rs"]);
    // The page's refusals are sentences of the robot.
    let of_page = declared(&["pendant/src/orders.rs", "server/src/backend/page.rs"]);
    let said = |known: &&&str| {
        let sources = [&own, &of_functions, &of_tasks, &of_page];
        sources.iter().any(|texts| texts.contains(**known))
    };
    // The source has a place for what is not there, and the language puts together what an assertion tells.
    let composed = [
        "there is no part \"{}\"",
        "the left side is {}",
        "a text of {} characters: {}",
        "a {} of {} items",
    ];
    let is_composed = |known: &str| composed.iter().any(|begin| known.starts_with(begin));
    let is_said = |known: &&&str| said(known) || is_composed(known);
    let dead: Vec<_> = known.iter().filter(|known| !is_said(known)).collect();
    assert_eq!(dead, [&""; 0], "no source says so any more");
}

#[test]
fn every_sentence_of_commands_is_there_in_chinese() {
    use elite_runtime::chinese as robot;
    use elite_syntax::chinese as texts;
    let own = english(&[of_commands::SENTENCES, words_of_commands::WORDS]);
    let others = [robot::SENTENCES, robot::WORDS, texts::SENTENCES];
    let known: BTreeSet<&str> = own.union(&english(&others)).copied().collect();
    let mut said: BTreeSet<String> = BTreeSet::new();
    for text in declared(OF_COMMANDS) {
        let line = text.trim_matches('\n');
        // Several lines are a program or a file.
        if !line.contains('\n') {
            said.insert(line.strip_prefix(PROGRAM).unwrap_or(line).to_owned());
        }
    }
    let rows = FUNCTIONS_OF_OTHERS
        .lines()
        .filter(|row| !row.starts_with('#'));
    let remarks = rows.filter_map(|row| row.rsplit_once('|'));
    said.extend(remarks.map(|(_, remark)| remark.trim().to_owned()));
    let without: Vec<String> = gaps(&said, &known)
        .into_iter()
        .filter(|text| !known.contains(text.trim()) && !COMMANDS_STAY.contains(&text.trim()))
        .collect();
    assert_eq!(without, [""; 0]);
    said.extend(declared(OF_DEBUGGER));
    let is_dead = |known: &&&str| {
        let trimmed = said.iter().any(|text| text.trim() == **known);
        !trimmed && !said.contains(**known) && !COMPOSED.contains(*known)
    };
    let dead: Vec<_> = own.iter().filter(is_dead).collect();
    assert_eq!(dead, [&""; 0], "no source says so any more");
}

/// What makes the sentences of tests of programs, the source of which has parts, begin; and what the crate `controller`
/// says of conditions that cannot be read, in lines of their own.
const SCRIPT_TESTS_COMPOSED: &[&str] = &[
    "the condition cannot be read:",
    "names are the columns of --csv /cycle",
    "always: `{}` did not hold at {} s, cycle {}",
    "never: `{}` held at {} s, cycle {}",
    "one has {} items",
    "one is a number",
    "part {}",
    "the program under test ",
    "the test ",
    "they differ by {}",
    "{} and {} cannot be compared",
    "{} was {}",
];

#[test]
fn every_sentence_of_tests_of_programs_is_there_in_chinese() {
    use elite_runtime::chinese as robot;
    let own = english(&[of_script_tests::SENTENCES, of_script_tests::WORDS]);
    let others = [
        of_commands::SENTENCES,
        words_of_commands::WORDS,
        robot::SENTENCES,
    ];
    let known: BTreeSet<&str> = own.union(&english(&others)).copied().collect();
    let said: BTreeSet<String> = declared(OF_SCRIPT_TESTS)
        .iter()
        .map(|text| text.trim_matches('\n').to_owned())
        .filter(|text| !text.contains('\n'))
        .collect();
    let without: Vec<String> = gaps(&said, &known)
        .into_iter()
        .filter(|text| !known.contains(text.trim()) && !SCRIPT_TESTS_STAY.contains(&text.trim()))
        .collect();
    assert_eq!(without, [""; 0]);
    let is_composed = |known: &str| {
        let mut begins = SCRIPT_TESTS_COMPOSED.iter();
        begins.any(|begin| known.starts_with(begin))
    };
    let is_dead = |known: &&&str| {
        let trimmed = said.iter().any(|text| text.trim() == **known);
        !trimmed && !is_composed(known)
    };
    let dead: Vec<_> = own.iter().filter(is_dead).collect();
    assert_eq!(dead, [&""; 0], "no source says so any more");
}

#[test]
fn a_gap_is_found() {
    let declared = ["a sentence that is new: {}".to_owned(), "code".to_owned()].into();
    let known = BTreeSet::from(["another"]);
    assert_eq!(gaps(&declared, &known), ["a sentence that is new: {}"]);
    assert_eq!(
        literals("x(\"a {b}\", '\"', \"c\\\n   d\") // \"e\""),
        ["a {b}", "cd"]
    );
}

#[test]
fn tables_keep_what_varies_and_are_in_order() {
    let tables = [
        elite_syntax::chinese::SENTENCES,
        elite_syntax::chinese::WORDS,
        elite_runtime::chinese::SENTENCES,
        elite_runtime::chinese::WORDS,
        of_commands::SENTENCES,
        words_of_commands::WORDS,
        of_libraries::SENTENCES,
        of_libraries::WORDS,
        of_script_tests::SENTENCES,
        of_script_tests::WORDS,
    ];
    for table in tables {
        assert!(table.is_sorted_by_key(|(english, _)| *english));
        for (english, chinese) in table {
            for number in 0..english.matches("{}").count() {
                let place = |end: &str| chinese.contains(&format!("{{{number}{end}}}"));
                assert!(place("") || place("~"), "{english} | {chinese}");
            }
        }
    }
}

#[test]
fn every_function_is_described_in_chinese() {
    let is_chinese = |text: &str| text.chars().any(|c| ('\u{4e00}'..='\u{9fff}').contains(&c));
    for builtin in elite_runtime::builtins::all() {
        let (name, language) = (builtin.name, Language::Chinese);
        assert!(is_chinese(language.summary(builtin)), "{name}");
        for parameter in builtin.params {
            let meaning = parameter.meaning;
            assert!(
                meaning.is_empty() || is_chinese(language.phrase(meaning)),
                "{name}: {meaning}"
            );
        }
        // Types alone are written alike.
        let returns = builtin.returns;
        let is_prose = returns.contains(' ') && returns.len() > 24;
        assert!(
            !is_prose || is_chinese(language.phrase(returns)),
            "{name}: {returns}"
        );
    }
}
