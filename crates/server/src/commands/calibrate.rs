//! `eliteserver calibrate`: the arm's own kinematics from a controller into a calibration file.

use std::process::ExitCode;

use robot_client::RobotAddress;
use robot_client::calibrate::read;

use crate::cli::CalibrateArgs;
use crate::logging;

/// Exit status: 0 written, 2 not.
pub fn calibrate(args: &CalibrateArgs) -> ExitCode {
    match written(args) {
        Ok(sentence) => {
            logging::say(&sentence);
            ExitCode::SUCCESS
        }
        Err(sentence) => {
            logging::say(&format!("eliteserver: {sentence}"));
            ExitCode::from(2)
        }
    }
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
    std::fs::write(&args.out, reading.calibration.to_toml())
        .map_err(|error| format!("cannot write the calibration file {out}: {error}"))?;
    let distance = reading.distance;
    Ok(format!(
        "{out}: the {} at {address}, whose flange is up to {:.3} mm ({:.3} mm on average) and {:.4} degrees from where its sheet has it",
        reading.calibration.model(),
        distance.position * 1e3,
        distance.position_mean * 1e3,
        distance.angle.to_degrees(),
    ))
}
