//! Options of `replay`, and of the ports of `replay --serve`.

use std::net::IpAddr;
use std::path::PathBuf;

use clap::Args;

use super::LogArgs;
use super::paths::recorded_time;
use crate::options::{PortSetting, TrustedHost};

/// Options of `replay`; without any of them a summary is printed.
#[derive(Args, Clone, Debug)]
pub struct ReplayArgs {
    /// The recording
    #[arg(value_name = "FILE.mcap")]
    pub file: PathBuf,
    /// Print the state at this time, s
    #[arg(long, value_name = "T", group = "what", value_parser = recorded_time, allow_negative_numbers = true)]
    pub at: Option<f64>,
    /// Print a topic as a table with one header line
    #[arg(long, value_name = "TOPIC", group = "what")]
    pub csv: Option<String>,
    /// Draw joint positions, speeds, torques and force over time
    #[arg(long, value_name = "OUT.png", group = "what")]
    pub plot: Option<PathBuf>,
    /// Begin of what --plot draws, s [default: the whole recording]
    #[arg(
        long,
        value_name = "T",
        requires = "plot",
        value_parser = recorded_time,
        allow_negative_numbers = true
    )]
    pub from: Option<f64>,
    /// End of what --plot draws, s
    #[arg(
        long,
        value_name = "T",
        requires = "plot",
        value_parser = recorded_time,
        allow_negative_numbers = true
    )]
    pub to: Option<f64>,
    /// Write it as a bag of ROS 2 (MCAP, CDR) into this new folder
    #[arg(long, value_name = "FOLDER", group = "what")]
    pub rosbag2: Option<PathBuf>,
    /// Print when a condition held, the line and the position then: "safety_mode != normal"
    #[arg(long, value_name = "CONDITION", group = "what")]
    pub find: Option<String>,
    /// Print the programs, with when each line ran, how often and how long
    #[arg(long, group = "what")]
    pub script: bool,
    /// Compare with another recording, cycle by cycle. Exit status 1 if they differ
    #[arg(long, value_name = "OTHER.mcap", group = "what")]
    pub diff: Option<PathBuf>,
    /// Send the recording through the ports, as if live
    #[arg(long, group = "what")]
    pub serve: bool,
    /// Run the recorded commands on a fresh controller and compare. Exit status 1 if a cycle differs
    #[arg(long, group = "what")]
    pub rerun: bool,
    /// Speed of --serve, 1 is as recorded
    #[arg(long, value_name = "X", requires = "serve", default_value_t = 1.0, value_parser = rate)]
    pub rate: f64,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub ports: ReplayPortArgs,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub log: LogArgs,
}

/// Where `replay --serve` listens. The same services as those of `serve`, but for the ones that only take orders.
#[derive(Args, Clone, Debug, Default)]
#[group(requires = "serve")]
#[command(next_help_heading = "Ports of --serve")]
pub struct ReplayPortArgs {
    /// Address that every port listens on [default: 127.0.0.1]
    #[arg(long, value_name = "ADDR")]
    pub bind: Option<IpAddr>,
    /// Robot state out; scripts are refused [default: 30001]
    #[arg(long, value_name = "PORT|off", allow_negative_numbers = true)]
    pub primary_port: Option<PortSetting>,
    /// Cyclic data out; inputs are refused [default: 30004]
    #[arg(long, value_name = "PORT|off", allow_negative_numbers = true)]
    pub rtsi_port: Option<PortSetting>,
    /// Health and metrics [default: 8080]
    #[arg(long, value_name = "PORT|off", allow_negative_numbers = true)]
    pub http_port: Option<PortSetting>,
    /// Live data for the Foxglove app [default: off]
    #[arg(long, value_name = "PORT|off", allow_negative_numbers = true)]
    pub foxglove_port: Option<PortSetting>,
    /// Robot state as on the primary port, nothing in, in every control mode
    /// [default: 30011; any free port where the primary port is not 30001]
    #[arg(long, value_name = "PORT|off", allow_negative_numbers = true)]
    pub state_port: Option<PortSetting>,
    /// Single lines of script in, their values out [default: 40011; any free port where the primary port is not 30001]
    #[arg(long, value_name = "PORT|off", allow_negative_numbers = true)]
    pub query_port: Option<PortSetting>,
    /// The serial line at the tool, bytes both ways, with the settings that a program gives it [default: off]
    #[arg(long, value_name = "PORT|off", allow_negative_numbers = true)]
    pub tool_serial_port: Option<PortSetting>,
    /// Another name of this machine, or of a machine whose pages may ask, on the http and Foxglove ports; repeat it for
    /// more [default: this machine's own names]
    #[arg(long, value_name = "NAME")]
    pub trust_host: Option<Vec<TrustedHost>>,
    /// Where to write process id and ports as JSON once every port listens
    #[arg(long, value_name = "PATH")]
    pub ready_file: Option<PathBuf>,
}

/// A speed of `--serve`.
fn rate(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(rate) if (0.01..=100.0).contains(&rate) => Ok(rate),
        _ => Err("allowed are numbers from 0.01 to 100; 1 is as recorded".to_owned()),
    }
}
