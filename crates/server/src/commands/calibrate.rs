//! `eliteserver calibrate`: the arm's own kinematics from a controller into a calibration file.

use robot_client::RobotAddress;
use robot_client::calibrate::read;

use crate::cli::CalibrateArgs;
use crate::command::{CommandError, CommandResult, CommandStatus};
use crate::language::told;
use crate::{logging, ready_file};

/// An arm that moves may be so far on between two values of one state, m.
const UNEXPLAINED_MAX: f64 = 0.0005;

/// Exit status: 0 written, 2 not.
pub fn calibrate(args: &CalibrateArgs) -> CommandResult {
    let summary = written(args).map_err(CommandError::sentence)?;
    logging::say(&told(&summary));
    Ok(CommandStatus::Success)
}

fn written(args: &CalibrateArgs) -> Result<String, String> {
    let runtime = tokio::runtime::Builder::new_current_thread()
        .enable_all()
        .build();
    let runtime = runtime.map_err(|error| format!("cannot start: {error}"))?;
    let address = RobotAddress::new(&args.robot.robot, args.robot.primary_port);
    let reading = runtime
        .block_on(read(&address, &args.out))
        .map_err(|error| error.to_string())?;
    let out = args.out.display();
    ready_file::replace(&args.out, &reading.calibration.to_toml())
        .map_err(|error| format!("cannot write the calibration file {out}: {error}"))?;
    if let Some(unexplained) = reading.tcp_residual.filter(|by| *by > UNEXPLAINED_MAX) {
        logging::say(&told(&format!(
            "the robot has its TCP {:.3} mm from where these numbers put it: it counts with something that it does \
             not send, such as offsets of its joints",
            unexplained * 1e3
        )));
    }
    let distance = reading.distance;
    Ok(format!(
        "{out}: the {} at {address}, whose flange is up to {:.3} mm ({:.3} mm on average) and {:.4} degrees from \
         where its sheet has it",
        reading.calibration.model(),
        distance.position * 1e3,
        distance.position_mean * 1e3,
        distance.angle.to_degrees(),
    ))
}
