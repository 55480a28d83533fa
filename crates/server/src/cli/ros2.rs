//! Options of the ROS 2 node.

use std::net::IpAddr;

use clap::{Args, ValueEnum};
use messages::{LocalizedHelp, Text, text};

use crate::options::{RosFactor, RosName, RosPrefix, RosRate};

/// Options of the node that `serve` starts.
#[derive(Args, Clone, Debug, Default, LocalizedHelp)]
#[command(next_help_heading = "ROS 2")]
pub struct Ros2Args {
    /// Be a node of ROS 2 as well, named elite_controller: topics, services and the action of the vendor's driver
    #[zh("同时作为 ROS 2 节点，名称为 elite_controller：厂家驱动的主题、服务和动作")]
    #[arg(long, num_args = 0..=1, require_equals = true, default_missing_value = "true", value_name = "true|false")]
    pub ros2: Option<bool>,
    /// The DDS domain, 0 to 232 [default: ROS_DOMAIN_ID, else 0]
    #[zh("DDS 域，0 到 232 [默认：ROS_DOMAIN_ID，否则 0]")]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(0..=232))]
    pub ros_domain: Option<u16>,
    /// What the names of topics, services and the action begin with [default: /]
    #[zh("主题、服务和动作的名称以什么开头 [默认：/]")]
    #[arg(long, value_name = "NS")]
    pub ros_namespace: Option<RosName>,
    /// What the names of joints and frames begin with [default: nothing]
    #[zh("关节和坐标系的名称以什么开头 [默认：无]")]
    #[arg(long, value_name = "PREFIX")]
    pub ros_tf_prefix: Option<RosPrefix>,
    /// Messages a second on topics that come cyclically [default: every cycle]
    #[zh("周期性主题每秒的消息数 [默认：每个周期]")]
    #[arg(long, value_name = "HZ")]
    pub ros_rate: Option<RosRate>,
    /// Addresses of the machines that the node may speak with: DDS goes out to the network by the interfaces that lead
    /// there [default: this machine alone]
    #[zh("节点可以与之通信的机器的地址：DDS 从通往那里的网络接口发出 [默认：仅本机]")]
    #[arg(
        long,
        value_name = "A,B",
        value_delimiter = ',',
        conflicts_with = "ros_network"
    )]
    pub ros_peers: Option<Vec<IpAddr>>,
    /// The address of the interface whose whole network the node speaks with [default: this machine alone]
    #[zh("网络接口的地址，节点与其整个网络通信 [默认：仅本机]")]
    #[arg(long, value_name = "ADDRESS")]
    pub ros_network: Option<IpAddr>,
    /// How services are mapped onto DDS: as by rmw_fastrtps or as by rmw_cyclonedds [default: fastdds]
    #[zh("服务如何映射到 DDS：按 rmw_fastrtps 或按 rmw_cyclonedds [默认：fastdds]")]
    #[arg(long, value_name = "fastdds|cyclonedds")]
    pub ros_rmw: Option<RosMiddleware>,
    /// Under the virtual clock, simulated seconds a second [default: as many as the node keeps up with]
    #[zh("虚拟时钟下每秒的仿真秒数 [默认：节点跟得上的最大值]")]
    #[arg(long, value_name = "X")]
    pub ros_time_factor: Option<RosFactor>,
}

/// Mapping of services onto DDS, by the middleware of the peers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum, LocalizedHelp)]
pub enum RosMiddleware {
    /// rmw_fastrtps.
    #[zh("按 rmw_fastrtps")]
    #[default]
    Fastdds,
    /// rmw_cyclonedds.
    #[zh("按 rmw_cyclonedds")]
    Cyclonedds,
}

impl std::str::FromStr for RosMiddleware {
    type Err = Text;

    fn from_str(text: &str) -> Result<Self, Text> {
        <Self as ValueEnum>::from_str(text, false).map_err(|_| {
            text!(
                "allowed are fastdds and cyclonedds",
                "允许 fastdds 和 cyclonedds"
            )
            .to_owned()
        })
    }
}

impl Ros2Args {
    /// The first option that only means something with `--ros2`, where one was given.
    pub(crate) fn first_detail(&self) -> Option<&'static str> {
        let given = [
            (self.ros_domain.is_some(), "--ros-domain"),
            (self.ros_namespace.is_some(), "--ros-namespace"),
            (self.ros_tf_prefix.is_some(), "--ros-tf-prefix"),
            (self.ros_rate.is_some(), "--ros-rate"),
            (self.ros_peers.is_some(), "--ros-peers"),
            (self.ros_network.is_some(), "--ros-network"),
            (self.ros_rmw.is_some(), "--ros-rmw"),
            (self.ros_time_factor.is_some(), "--ros-time-factor"),
        ];
        given.iter().find(|(is, _)| *is).map(|(_, option)| *option)
    }
}
