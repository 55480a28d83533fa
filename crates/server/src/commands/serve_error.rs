//! What kept a server from starting, in sentences.

use std::path::{Path, PathBuf};

use messages::Localized;
use thiserror::Error;

use crate::controller_host::HostError;
use crate::ports::listen::BindError;

/// What kept the server from starting.
#[derive(Debug, Error, Localized)]
#[non_exhaustive]
pub enum ServeError {
    /// The controller.
    #[error(transparent)]
    Start(#[from] HostError),
    /// A port.
    #[error(transparent)]
    Bind(#[from] BindError),
    /// The port of grippers.
    #[error("cannot open port {port} for the grippers of the cell file: {source}")]
    #[zh("无法为单元文件的夹爪打开端口 {port}：{source}")]
    Grippers {
        /// The port.
        port: u16,
        /// Error of the operating system.
        source: std::io::Error,
    },
    /// The ready file.
    #[error("cannot write the ready file {}: {source}", path.display())]
    #[zh("无法写入就绪文件 {}：{source}", path.display())]
    ReadyFile {
        /// The file as it was given.
        path: PathBuf,
        /// Error of the operating system.
        source: std::io::Error,
    },
    /// A ready file of an earlier server.
    #[error("cannot remove the old ready file {}: {source}", path.display())]
    #[zh("无法删除旧的就绪文件 {}：{source}", path.display())]
    StaleReadyFile {
        /// The file as it was given.
        path: PathBuf,
        /// Error of the operating system.
        source: std::io::Error,
    },
    /// A node that this program does not have.
    #[error("--ros2: {}", super::ros2::WITHOUT_NODE)]
    #[zh("--ros2：{}", super::ros2::WITHOUT_NODE)]
    NoRos2,
    /// The way to the node's peers, or what the node tells of the arm.
    #[error("--ros2: {0}")]
    #[zh("--ros2：{0}")]
    Ros2(std::io::Error),
    /// Threads or signals.
    #[error("the operating system refused what a server needs: {0}")]
    #[zh("操作系统拒绝了服务器所需的资源：{0}")]
    System(#[from] std::io::Error),
}

impl ServeError {
    /// The old ready file at `path` cannot be removed.
    pub(crate) fn stale(path: &Path, source: std::io::Error) -> Self {
        Self::StaleReadyFile {
            path: path.to_owned(),
            source,
        }
    }
}
