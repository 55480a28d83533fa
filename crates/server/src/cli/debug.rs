//! Options of `debug`.

use std::path::PathBuf;

use clap::Args;

use super::{LogArgs, ROBOT};

/// Options of `debug`.
#[derive(Args, Clone, Debug)]
pub struct DebugArgs {
    /// A script or a recording (.mcap) to debug here, at the terminal; without it an editor talks to the debugger on
    /// standard input and output
    #[arg(value_name = "FILE", conflicts_with = "port")]
    pub file: Option<PathBuf>,
    /// Listen on this port of this machine for editors, one client after the other; 0: any free port
    #[arg(long, value_name = "N")]
    pub port: Option<u16>,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub robot: DebugRobotArgs,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub log: LogArgs,
}

/// The robot of `debug FILE`, by the options of `run`; each is a key of `launch` as well, which checks it.
#[derive(Args, Clone, Debug, Default)]
#[group(requires = "file")]
pub struct DebugRobotArgs {
    /// Which program of a recording, from 1 [default: 1]
    #[arg(long, value_name = "N")]
    pub number: Option<u64>,
    /// A global variable that is set before the program; repeat it for more: --set speed=0.25 --set 'name="left"'
    #[arg(long, value_name = "NAME=VALUE", help_heading = ROBOT)]
    pub set: Vec<String>,
    /// A TOML file whose keys are the names of the options of run
    #[arg(long, value_name = "FILE", help_heading = ROBOT)]
    pub config: Option<String>,
    /// The arm [default: cs66]
    #[arg(long, value_name = "MODEL", help_heading = ROBOT)]
    pub model: Option<String>,
    /// The lengths and twists of this very arm [default: as the model]
    #[arg(long, value_name = "FILE", help_heading = ROBOT)]
    pub calibration: Option<String>,
    /// What stands around the arm [default: nothing]
    #[arg(long, value_name = "FILE", help_heading = ROBOT)]
    pub cell: Option<String>,
    /// Length of a control cycle, 1 to 8 ms [default: 4]
    #[arg(long, value_name = "MS", help_heading = ROBOT)]
    pub step_ms: Option<String>,
    /// How the arm is simulated [default: rigid]
    #[arg(long, value_name = "rigid|rapier|ideal", help_heading = ROBOT)]
    pub plant: Option<String>,
    /// Folder of the task files [default: ./tasks]
    #[arg(long, value_name = "PATH", help_heading = ROBOT)]
    pub task_dir: Option<String>,
    /// The recording of the first run [default: off]
    #[arg(long, value_name = "PATH|off", help_heading = ROBOT)]
    pub record: Option<String>,
    /// Tool centre point from the flange, m and rad [default: 0,0,0,0,0,0]
    #[arg(long, value_name = "x,y,z,rx,ry,rz", allow_hyphen_values = true, help_heading = ROBOT)]
    pub tcp: Option<String>,
    /// Payload and its centre of gravity, kg and m [default: 0]
    #[arg(long, value_name = "kg[,cx,cy,cz]", help_heading = ROBOT)]
    pub payload: Option<String>,
    /// Joint positions at start, rad [default: 0,-1.5708,1.5708,-1.5708,-1.5708,0]
    #[arg(long, value_name = "q1,…,q6", allow_hyphen_values = true, help_heading = ROBOT)]
    pub home: Option<String>,
    /// Seed of random() and of every simulated noise [default: 0]
    #[arg(long, value_name = "N", help_heading = ROBOT)]
    pub seed: Option<String>,
    /// What the program may reach beyond the robot; repeat it for more [default: net]
    #[arg(long, value_name = "fs|fs=DIR|process|env|net", help_heading = ROBOT)]
    pub allow: Vec<String>,
}
