//! `eliteserver calibrate`: the arm's own kinematics from a controller into a calibration file.

use messages::{Text, text};
use robot_client::RobotAddress;
use robot_client::calibrate::read;

use crate::cli::CalibrateArgs;
use crate::command::{CommandError, CommandResult, CommandStatus};
use crate::{language, ready_file};

/// An arm that moves may be so far on between two values of one state, m.
const UNEXPLAINED_MAX: f64 = 0.0005;

/// Exit status: 0 written, 2 not.
pub fn calibrate(args: &CalibrateArgs) -> CommandResult {
    let summary = written(args)?;
    language::say(&summary);
    Ok(CommandStatus::Success)
}

fn written(args: &CalibrateArgs) -> Result<Text, CommandError> {
    let runtime = tokio::runtime::Builder::new_current_thread()
        .enable_all()
        .build();
    let runtime = runtime.map_err(|error| {
        CommandError::sentence(text!("cannot start: {error}", "无法启动：{error}"))
    })?;
    let address = RobotAddress::new(&args.robot.robot, args.robot.primary_port);
    let reading = runtime.block_on(read(&address, &args.out))?;
    let out = args.out.display();
    ready_file::replace(&args.out, &reading.calibration.to_toml()).map_err(|error| {
        CommandError::sentence(text!(
            "cannot write the calibration file {out}: {error}",
            "无法写入标定文件 {out}：{error}"
        ))
    })?;
    if let Some(unexplained) = reading.tcp_residual.filter(|by| *by > UNEXPLAINED_MAX) {
        language::say(&text!(
            "the robot has its TCP {:.3} mm from where these numbers put it: it counts with something that it does \
             not send, such as offsets of its joints",
            "机器人的 TCP 与按这些数计算的位置相差 {:.3} mm：它还用了没有发送的数据，例如关节零位偏差",
            unexplained * 1e3
        ));
    }
    let distance = reading.distance;
    Ok(text!(
        "{out}: the {} at {address}, whose flange is up to {:.3} mm ({:.3} mm on average) and {:.4} degrees from \
         where its sheet has it",
        "{out}：{address} 处的 {}，其法兰与数据表中的位置最多相差 {:.3} mm（平均 {:.3} mm）和 {:.4} 度",
        reading.calibration.model(),
        distance.position * 1e3,
        distance.position_mean * 1e3,
        distance.angle.to_degrees(),
    ))
}
