//! `eliteserver optimize`: a faster program that does the same.

use std::io::Write;

use controller::clearance::MeasuredEnd;
use controller::optimizer::{OptimizeError, OptimizeOptions, optimize as make_faster};
use messages::text;

use crate::cli::OptimizeArgs;
use crate::command::{CommandError, CommandResult, CommandStatus};
use crate::commands::check::read_script;
use crate::commands::clearance::refuse_ignored;
use crate::config::RunConfig;
use crate::language;
use crate::ports::escape::EscapedText;
use crate::shutdown::Shutdown;

/// Exit status: 0 done, 1 the program fails or touches something as it is, 2 it cannot be run.
///
/// # Errors
/// What kept the program from being run.
pub fn optimize(args: &OptimizeArgs, config: &RunConfig) -> CommandResult {
    refuse_ignored(&args.run, "optimize")?;
    let shutdown = Shutdown::start(CommandStatus::NotDone)?;
    let program = read_script(&config.file).map_err(CommandError::sentence)?;
    let length = u32::try_from(program.text.lines().count()).unwrap_or(u32::MAX);
    if let Some((first, last)) = args.keep.iter().find(|(first, _)| *first > length) {
        return Err(CommandError::sentence(text!(
            "--keep {first}-{last}: the last line of {} is {length}",
            "--keep {first}-{last}：{} 的最后一行是第 {length} 行",
            EscapedText(&program.name)
        )));
    }
    if config.robot.cell.is_none() {
        language::complain(&text!(
            "there is no --cell: only the arm itself is kept from itself, whatever else stands there",
            "没有 --cell：只避免机械臂碰到自身，不论周围有什么"
        ));
    }
    let options = OptimizeOptions {
        margin: args.margin,
        keep: args.keep.clone(),
        presets: config.presets.clone(),
        limit: args.timeout,
    };
    let mut keep_going = || !shutdown.token().is_cancelled();
    let faster = match make_faster(&config.robot, &program, &options, &mut keep_going) {
        Ok(faster) => faster,
        Err(error) => {
            let status = match &error {
                OptimizeError::Touches { .. }
                | OptimizeError::Program(MeasuredEnd::Failed { .. }) => CommandStatus::Negative,
                _ => CommandStatus::NotDone,
            };
            return Err(CommandError::from(error).with_status(status));
        }
    };
    // Whoever reads may have seen enough; the status still tells.
    let mut out = std::io::stdout().lock();
    let _ = out.write_all(faster.diff.as_bytes());
    if let Some(path) = &args.output {
        std::fs::write(path, &faster.text).map_err(|error| {
            CommandError::sentence(text!(
                "cannot write {}: {error}",
                "无法写入 {}：{error}",
                path.display()
            ))
        })?;
    }
    let (before, after) = (faster.before, faster.after);
    language::say(&match faster.diff.is_empty() {
        true => text!(
            "nothing can be gained: the cycle takes {before:.3} s (simulated runs: {})",
            "没有可加快之处：节拍为 {before:.3} s（仿真运行 {} 次）",
            faster.runs
        ),
        false => text!(
            "cycle time {before:.3} s before, {after:.3} s after: {:.1} % shorter (simulated runs: {})",
            "节拍由 {before:.3} s 变为 {after:.3} s：缩短 {:.1} %（仿真运行 {} 次）",
            (before - after) / before.max(1e-9) * 100.0,
            faster.runs
        ),
    });
    Ok(CommandStatus::Success)
}
