//! `run --ros2-profile`: the bag of ROS 2 beside the recording.

use std::path::PathBuf;

use controller::options::RecordTarget;
use messages::Localized;
use recorder::Recording;
use thiserror::Error;

use crate::command::CommandError;
use crate::commands::replay::rosbag::{folder_beside, prepare_folder, write_into};
use crate::config::RunConfig;

/// Why there can be no bag.
#[derive(Debug, Error, Localized)]
enum ProfileError {
    #[error("--ros2-profile writes a bag beside the recording: give --record FILE as well")]
    #[zh("--ros2-profile 在记录旁写入 bag：请同时给出 --record 文件")]
    NoRecording,
    #[error("--ros2-profile makes a bag of one recording: leave --record-rotate out")]
    #[zh("--ros2-profile 由一个记录生成 bag：请去掉 --record-rotate")]
    Rotation,
}

/// A bag that is made of the recording once that is complete.
pub(super) struct BagBesideRecording {
    recording: PathBuf,
    folder: PathBuf,
}

impl BagBesideRecording {
    /// Makes room for the bag before the program runs, where one is wanted: what stands in its way is then said at
    /// once.
    ///
    /// # Errors
    /// There is no one recording to make it of, or its folder is somebody else's.
    pub(super) fn prepare(config: &RunConfig) -> Result<Option<Self>, CommandError> {
        if !config.ros2_profile {
            return Ok(None);
        }
        let RecordTarget::File(recording) = &config.robot.record else {
            return Err(ProfileError::NoRecording.into());
        };
        if config.robot.record_rotate.is_some() {
            return Err(ProfileError::Rotation.into());
        }
        let folder = folder_beside(recording);
        prepare_folder(&folder)?;
        Ok(Some(Self {
            recording: recording.clone(),
            folder,
        }))
    }

    /// Writes the bag.
    ///
    /// # Errors
    /// The recording cannot be read, or the bag not be written.
    pub(super) fn write(&self) -> Result<(), CommandError> {
        let recording = Recording::open(&self.recording)?;
        write_into(&recording, &self.folder)?;
        Ok(())
    }
}
