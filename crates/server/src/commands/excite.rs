//! `eliteserver excite`: a program whose motion lets payload, friction or tool be told.
//!
//! The program is run on the simulated arm in the cell before it is written; where it comes too near to anything, its
//! motions become smaller.

use core::fmt::Write as _;
use std::io::Write;

use controller::clearance::{MeasureOptions, MeasuredEnd, measure};
use elite_runtime::ProgramText;
use kinematics::{DOF, JointPositions};
use messages::{Text, text};

use crate::cli::{ExciteArgs, ExciteTarget, RunArgs};
use crate::command::{CommandError, CommandResult, CommandStatus};
use crate::commands::clearance::refuse_ignored;
use crate::commands::translate::write;
use crate::config::RunConfig;
use crate::shutdown::Shutdown;

/// Sizes of the motion that are tried, one after the other.
const SIZES: [f64; 6] = [1.0, 0.75, 0.55, 0.4, 0.3, 0.2];
/// Nothing comes nearer, m.
const CLEARANCE_M: f64 = 0.01;
/// Longest simulated time of a program, s.
const TIME_MAX_S: f64 = 600.0;
/// Waves of the joints about their posture, one cycle of the excitation each, as shares of the largest turn: chosen so
/// that wrist and forearm turn the flange about all axes, at speeds of both signs.
const POSTURES: [[f64; DOF]; 12] = [
    [0.5, -0.3, 0.4, -0.6, 0.7, 0.9],
    [-0.4, 0.5, -0.3, 0.8, -0.8, -0.7],
    [0.3, 0.2, 0.6, -0.2, -0.5, 1.0],
    [-0.6, -0.5, 0.2, 0.5, 0.9, -0.9],
    [0.1, 0.4, -0.6, -0.9, 0.3, 0.4],
    [0.6, -0.1, -0.2, 0.9, -0.9, 0.8],
    [-0.2, 0.6, 0.5, 0.1, 0.6, -1.0],
    [0.4, -0.6, 0.1, -0.7, -0.3, -0.3],
    [-0.5, 0.1, -0.5, 0.3, 1.0, 0.6],
    [0.2, 0.3, 0.3, -1.0, -0.7, -0.8],
    [-0.3, -0.4, 0.6, 0.7, 0.2, 0.9],
    [0.5, 0.5, -0.4, -0.3, -1.0, -0.5],
];
/// Largest turn of each joint from its posture, rad.
const TURN_RAD: [f64; DOF] = [0.6, 0.45, 0.6, 0.9, 0.9, 1.5];
/// Turns of the tool about its tip, rad.
const TOOL_TURN_RAD: f64 = 0.45;

/// Exit status: 0 written, 2 there is no room.
///
/// # Errors
/// What kept it from being written.
pub fn excite(args: &ExciteArgs, config: &RunConfig) -> CommandResult {
    let run = RunArgs {
        shared: args.shared.clone(),
        ..RunArgs::default()
    };
    refuse_ignored(&run, "excite")?;
    let shutdown = Shutdown::start(CommandStatus::NotDone)?;
    let mut keep_going = || !shutdown.token().is_cancelled();
    let mut why = Text::verbatim("");
    for size in SIZES {
        let program = match args.what {
            ExciteTarget::Payload => joint_motion(&config.robot.home, size, args.speed, [2.0, 4.0]),
            ExciteTarget::Friction => slides(&config.robot.home, size, args.speed),
            ExciteTarget::Tool => tool_turns(size, args.speed),
        };
        let text = ProgramText {
            name: "excite.script".to_owned(),
            text: program.clone(),
        };
        let options = MeasureOptions {
            presets: Vec::new(),
            limit: TIME_MAX_S,
            has_history: false,
        };
        let measured = measure(&config.robot, text, &options, &mut keep_going)?;
        match &measured.end {
            MeasuredEnd::Finished if measured.distance() >= CLEARANCE_M => {
                match &args.output {
                    Some(path) => write(path, &program)?,
                    None => {
                        let _ = std::io::stdout().write_all(program.as_bytes());
                    }
                }
                return Ok(CommandStatus::Success);
            }
            MeasuredEnd::Finished => {
                why = text!(
                    "something comes nearer than {} mm",
                    "有物体距离小于 {} mm",
                    CLEARANCE_M * 1e3
                );
            }
            end => why = Text::of(end),
        }
        if !keep_going() {
            break;
        }
    }
    Err(CommandError::sentence(text!(
        "there is no room for the motion about --home: {why}",
        "--home 附近没有运动的空间：{why}"
    )))
}

fn list(values: &[f64]) -> String {
    let texts: Vec<String> = values.iter().map(|x| format!("{x:.5}")).collect();
    format!("[{}]", texts.join(", "))
}

fn posture(home: &JointPositions, shares: &[f64; DOF], size: f64) -> [f64; DOF] {
    core::array::from_fn(|joint| home[joint] + shares[joint] * TURN_RAD[joint] * size)
}

/// Brisk motions of all joints with rests between them: forces from weight and from acceleration.
fn joint_motion(home: &JointPositions, size: f64, speed: f64, [v, a]: [f64; 2]) -> String {
    let mut text = String::from(
        "# Turns the flange about all axes, so that what hangs on it can be told. Keep away from the arm.\n",
    );
    let (v, a) = (v * speed, a * speed);
    for shares in POSTURES.iter().chain(POSTURES.iter().rev()) {
        let target = list(&posture(home, shares, size));
        let _ = writeln!(text, "movej({target}, a={a:.3}, v={v:.3})\nsleep(0.5)");
    }
    let _ = writeln!(text, "movej({}, a={a:.3}, v={v:.3})", list(&home.0));
    text
}

/// Each joint alone, there and back, at several speeds; then all of them.
fn slides(home: &JointPositions, size: f64, speed: f64) -> String {
    let mut text = String::from(
        "# Turns each joint at several speeds in both directions, so that its friction can be told.\n",
    );
    let _ = writeln!(text, "movej({}, a=1.0, v=0.5)", list(&home.0));
    for joint in 0..DOF {
        for v in [0.1, 0.3, 0.6, 1.0] {
            let v = v * speed;
            // Slow turns are shorter, so that the program ends some day.
            let turn = (0.15 + 0.5 * v).min(TURN_RAD[joint]) * size;
            for share in [1.0, -1.0] {
                let mut target = home.0;
                target[joint] += share * turn;
                let _ = writeln!(
                    text,
                    "movej({}, a={:.3}, v={v:.3})",
                    list(&target),
                    3.0 * speed
                );
            }
        }
        let _ = writeln!(text, "movej({}, a=1.0, v=0.5)", list(&home.0));
    }
    text
}

/// The tip stays where it is, the tool turns about it: the TCP that is active has to be about right.
fn tool_turns(size: f64, speed: f64) -> String {
    let turn = TOOL_TURN_RAD * size;
    format!(
        "# Turns the tool about its tip. The active TCP must be about right (set_tcp): lead the tip back to the point \
         at each rest.\n\
         point = get_target_tcp_pose()\n\
         turns = [[0, 0, 0], [{turn:.4}, 0, 0], [-{turn:.4}, 0, 0], [0, {turn:.4}, 0], [0, -{turn:.4}, 0], \
         [{turn:.4}, {turn:.4}, 0.5], [-{turn:.4}, {turn:.4}, -0.5], \
         [{turn:.4}, -{turn:.4}, -0.5], [-{turn:.4}, -{turn:.4}, 0.5]]\n\
         for turn in turns:\n    \
         movel(pose_trans(point, [0, 0, 0] + turn), a={a:.3}, v={v:.3})\n    \
         sleep(1)\n\
         end\n\
         movel(point, a={a:.3}, v={v:.3})\n",
        a = 0.5 * speed,
        v = 0.1 * speed,
    )
}
