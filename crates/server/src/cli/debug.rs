//! Options of `debug`.

use std::path::PathBuf;

use clap::Args;
use controller::options::ControllerOptions;
use elite_runtime::Preset;
use messages::LocalizedHelp;

use super::{LogArgs, ROBOT, preset};

/// Options of `debug`.
#[derive(Args, Clone, Debug, LocalizedHelp)]
pub struct DebugArgs {
    /// A script or a recording (.mcap) to debug here, at the terminal; without it an editor talks to the debugger on
    /// standard input and output
    #[zh("在终端上调试的脚本或记录（.mcap）；不给出时，由编辑器通过标准输入输出与调试器通信")]
    #[arg(value_name = "FILE", conflicts_with = "port")]
    pub file: Option<PathBuf>,
    /// Listen on this port of this machine for editors, one client after the other; 0: any free port
    #[zh("在本机此端口上等待编辑器连接，一次一个；0：任一空闲端口")]
    #[arg(long, value_name = "N")]
    pub port: Option<u16>,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub robot: DebugRobotArgs,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub log: LogArgs,
}

/// The robot of `debug FILE`, by the options of `run`.
#[derive(Args, Clone, Debug, Default, LocalizedHelp)]
pub struct DebugRobotArgs {
    /// Which program of a recording, from 1 [default: 1]
    #[zh("记录中的第几个程序，从 1 数起 [默认：1]")]
    #[arg(long, value_name = "N")]
    pub number: Option<u64>,
    /// A global variable that is set before the program; repeat it for more: --set speed=0.25 --set 'name="left"'
    #[zh("程序开始前设置的全局变量；可重复给出：--set speed=0.25 --set 'name=\"left\"'")]
    #[arg(long, value_name = "NAME=VALUE", value_parser = preset, help_heading = ROBOT)]
    pub set: Vec<Preset>,
    /// A TOML file whose keys are the names of the options of run
    #[zh("TOML 文件，其键就是 run 的选项名")]
    #[arg(long, value_name = "FILE", help_heading = ROBOT)]
    pub config: Option<PathBuf>,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub options: ControllerOptions,
}

impl DebugRobotArgs {
    /// The first option that was given, without its dashes.
    pub(crate) fn first_given(&self) -> Option<String> {
        let own = [
            ("number", self.number.is_some()),
            ("set", !self.set.is_empty()),
            ("config", self.config.is_some()),
        ];
        let own = own.into_iter().filter(|(_, is_given)| *is_given);
        own.map(|(name, _)| name.to_owned())
            .chain(self.options.given_keys())
            .next()
    }
}
