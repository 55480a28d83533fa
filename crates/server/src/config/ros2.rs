//! Settings of the ROS 2 node, and its table `[ros2]` of the configuration file.

use std::collections::BTreeSet;
use std::net::{IpAddr, Ipv4Addr};
use std::path::Path;

use super::ConfigError;
use super::file::FileEntry;
use crate::cli::{Ros2Args, RosMiddleware};

/// Who the node speaks with.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum RosNetwork {
    /// This machine alone.
    #[default]
    Loopback,
    /// The network of an interface.
    Interface(IpAddr),
    /// Machines, by the interfaces that lead to them.
    Peers(Vec<IpAddr>),
}

/// Settings of the node.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Ros2Config {
    /// The DDS domain.
    pub domain: u16,
    /// The namespace, with its slash.
    pub namespace: String,
    /// What joints and frames begin with.
    pub prefix: String,
    /// Messages a second; without it one a cycle.
    pub rate: Option<f64>,
    /// Who the node speaks with.
    pub network: RosNetwork,
    /// How services are mapped.
    pub middleware: RosMiddleware,
    /// Simulated seconds a second under the virtual clock; without it as many as the node keeps up with.
    pub time_factor: Option<f64>,
}

/// Keys of the table, each that of the option `--ros-KEY`; `enabled` is `--ros2`.
pub(super) const ROS2_KEYS: [&str; 9] = [
    "domain",
    "enabled",
    "namespace",
    "network",
    "peers",
    "rate",
    "rmw",
    "tf-prefix",
    "time-factor",
];

/// Most peers.
const PEERS_MAX: usize = 16;

impl Ros2Config {
    /// The settings, none where no node is wanted.
    pub(super) fn of(args: Ros2Args) -> Result<Option<Self>, ConfigError> {
        if args.ros2 != Some(true) {
            return match args.first_detail() {
                // A file may keep the settings of a node that is off.
                Some(option) if args.ros2.is_none() => Err(ConfigError::Ros2Missing { option }),
                _ => Ok(None),
            };
        }
        let domain = match args.ros_domain {
            Some(domain) => domain,
            None => domain_of_environment(std::env::var("ROS_DOMAIN_ID").ok())?,
        };
        let network = match (args.ros_network, args.ros_peers) {
            (Some(address), _) => RosNetwork::Interface(address),
            (None, Some(peers)) if peers.len() > PEERS_MAX || peers.is_empty() => {
                return Err(ConfigError::TooManyPeers {
                    count: peers.len(),
                    allowed: PEERS_MAX,
                });
            }
            (None, Some(peers)) => RosNetwork::Peers(peers),
            (None, None) => RosNetwork::Loopback,
        };
        Ok(Some(Self {
            domain,
            namespace: args.ros_namespace.unwrap_or_default().0,
            prefix: args.ros_tf_prefix.unwrap_or_default().0,
            rate: args.ros_rate.map(|rate| rate.0),
            network,
            middleware: args.ros_rmw.unwrap_or_default(),
            time_factor: args.ros_time_factor.map(|factor| factor.0),
        }))
    }

    /// True when nothing leaves this machine.
    pub fn is_loopback_only(&self) -> bool {
        self.network == RosNetwork::Loopback
    }

    /// Addresses of the interfaces that are used.
    ///
    /// # Errors
    /// No interface leads to a peer.
    pub fn interfaces(&self) -> std::io::Result<Vec<IpAddr>> {
        match &self.network {
            RosNetwork::Loopback => Ok(vec![IpAddr::V4(Ipv4Addr::LOCALHOST)]),
            RosNetwork::Interface(address) => Ok(vec![*address]),
            RosNetwork::Peers(peers) => {
                let mut found = BTreeSet::new();
                for peer in peers {
                    found.insert(interface_towards(*peer)?);
                }
                Ok(found.into_iter().collect())
            }
        }
    }
}

/// The address of the interface by which a machine is reached. Nothing is sent.
fn interface_towards(peer: IpAddr) -> std::io::Result<IpAddr> {
    let any: IpAddr = match peer {
        IpAddr::V4(_) => Ipv4Addr::UNSPECIFIED.into(),
        IpAddr::V6(_) => std::net::Ipv6Addr::UNSPECIFIED.into(),
    };
    let socket = std::net::UdpSocket::bind((any, 0))?;
    // The discard port: a datagram socket only looks up the way.
    socket.connect((peer, 9))?;
    Ok(socket.local_addr()?.ip())
}

/// The domain that ROS 2 of this environment is in.
fn domain_of_environment(value: Option<String>) -> Result<u16, ConfigError> {
    let Some(text) = value.filter(|text| !text.is_empty()) else {
        return Ok(0);
    };
    match text.parse() {
        Ok(domain @ 0..=232) => Ok(domain),
        _ => Err(ConfigError::BadDomain { given: text }),
    }
}

/// Reads the table, or `ros2 = true`.
pub(super) fn merge_ros2(
    args: &mut Ros2Args,
    path: &Path,
    entry: &FileEntry<'_>,
) -> Result<(), ConfigError> {
    let toml::Value::Table(table) = entry.value else {
        return entry.fill(&mut args.ros2);
    };
    let mut seen = BTreeSet::new();
    let mut enabled = None;
    for (written, value) in table {
        let key = written.replace('_', "-");
        let full = format!("ros2.{written}");
        if !seen.insert(key.clone()) {
            let path = path.to_owned();
            return Err(ConfigError::Twice { path, key: full });
        }
        let entry = FileEntry {
            path,
            key: &full,
            value,
        };
        match key.as_str() {
            "domain" => entry.fill(&mut args.ros_domain)?,
            "enabled" => entry.fill(&mut enabled)?,
            "namespace" => entry.fill(&mut args.ros_namespace)?,
            "network" => entry.fill(&mut args.ros_network)?,
            "peers" => entry.fill(&mut args.ros_peers)?,
            "rate" => entry.fill(&mut args.ros_rate)?,
            "rmw" => entry.fill(&mut args.ros_rmw)?,
            "tf-prefix" => entry.fill(&mut args.ros_tf_prefix)?,
            "time-factor" => entry.fill(&mut args.ros_time_factor)?,
            _ => {
                return Err(ConfigError::UnknownKey {
                    path: path.to_owned(),
                    key: full,
                    allowed: ROS2_KEYS.map(str::to_owned).to_vec(),
                });
            }
        }
        if let Some(domain) = args.ros_domain.filter(|domain| *domain > 232) {
            return Err(ConfigError::BadDomain {
                given: domain.to_string(),
            });
        }
    }
    args.ros2.get_or_insert(enabled.unwrap_or(true));
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_domain_of_the_environment_counts_and_a_wrong_one_is_named() {
        assert_eq!(domain_of_environment(None).unwrap(), 0);
        assert_eq!(domain_of_environment(Some("42".to_owned())).unwrap(), 42);
        let error = domain_of_environment(Some("300".to_owned())).unwrap_err();
        assert!(error.to_string().contains("300"), "{error}");
    }
}
