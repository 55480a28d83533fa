//! A recording as a bag of ROS 2, with the topics that the node publishes: `replay --rosbag2 FOLDER`, and
//! `run --ros2-profile`.
//!
//! A bag is a folder with one MCAP file of profile `ros2` (messages as CDR, definitions as schemas) and
//! `metadata.yaml`, which `ros2 bag`, rosbags and Foxglove read. One message a cycle and topic, at the time that the
//! cycle has in the recording.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::fs::File;
use std::io::{self, BufWriter};
use std::path::{Path, PathBuf};

use controller::recorded_run::{RecordedModelError, model_of};
use kinematics::RobotModel;
use mcap::WriteOptions;
use mcap::records::MessageHeader;
use messages::Localized;
use recorder::{ReadError, Recording};
use ros2::messages::{Message, RosRobotMode, RosSafetyMode, Text, TfMessage, Time};
use ros2::names::topic;
use ros2::sample::{NodeSample, fixed_frames, flange_in_wrist};
use thiserror::Error;

/// Why there is no bag.
#[derive(Debug, Error, Localized)]
#[non_exhaustive]
pub enum BagError {
    /// The recording cannot be read.
    #[error(transparent)]
    Read(#[from] ReadError),
    /// The recording does not say which arm it is of.
    #[error("{0} does not say how the controller was started, so there are no frames to write")]
    #[zh("{0} 没有说明控制器是如何启动的，因此没有可写的坐标系")]
    NoSetup(String),
    /// The arm is not known here.
    #[error(transparent)]
    Model(#[from] RecordedModelError),
    /// A cycle that is none.
    #[error("a cycle of the recording: {0}")]
    #[zh("记录中的一个周期：{0}")]
    Cycle(String),
    /// The folder.
    #[error("the bag {}: {source}", path.display())]
    #[zh("bag {}：{source}", path.display())]
    Folder {
        /// The folder as given.
        path: PathBuf,
        /// Error of the operating system.
        source: io::Error,
    },
    /// There is something else where the bag belongs.
    #[error("the bag {} cannot be written: there is something else in that folder", path.display())]
    #[zh("无法写入 bag {}：该文件夹中有别的内容", path.display())]
    Occupied {
        /// The folder.
        path: PathBuf,
    },
    /// The bag cannot be written.
    #[error("cannot write the bag: {0}")]
    #[zh("无法写入 bag：{0}")]
    Mcap(#[from] mcap::McapError),
    /// A message cannot be written.
    #[error("a message of the bag: {0}")]
    #[zh("bag 的消息：{0}")]
    Message(String),
}

/// The file in a bag that says what is in it.
const METADATA: &str = "metadata.yaml";

/// Where the bag of a recording belongs: the recording's path without its `.mcap`.
pub(crate) fn folder_beside(recording: &Path) -> PathBuf {
    match recording.extension() {
        Some(extension) if extension == "mcap" => recording.with_extension(""),
        _ => {
            let mut name = recording.as_os_str().to_owned();
            name.push("_bag");
            name.into()
        }
    }
}

/// The file of messages in a bag.
fn file_name(folder: &Path) -> String {
    let name = folder
        .file_name()
        .map_or_else(|| "bag".into(), |name| name.to_string_lossy());
    format!("{name}_0.mcap")
}

/// Makes room for the bag of a run: a new folder, or that of the bag which an earlier run of this name has left.
///
/// # Errors
/// The folder cannot be made, or has other files than those of such a bag.
pub(crate) fn prepare_folder(folder: &Path) -> Result<(), BagError> {
    let at = |source| BagError::Folder {
        path: folder.to_owned(),
        source,
    };
    match std::fs::create_dir(folder) {
        Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {}
        other => return other.map_err(at),
    }
    let own = [file_name(folder), METADATA.to_owned()];
    for entry in std::fs::read_dir(folder).map_err(at)? {
        let name = entry.map_err(at)?.file_name();
        if !own.iter().any(|own| name == own.as_str()) {
            let path = folder.to_owned();
            return Err(BagError::Occupied { path });
        }
    }
    Ok(())
}

/// QoS of a topic as bags tell it: reliable, keep last.
fn offered_qos(is_latched: bool) -> String {
    let durability = if is_latched { 1 } else { 2 };
    format!(
        "- history: 1\n  depth: 10\n  reliability: 1\n  durability: {durability}\n  deadline:\n    sec: 9223372036\n\
         \x20   nsec: 854775807\n  lifespan:\n    sec: 9223372036\n    nsec: 854775807\n  liveliness: 1\n  \
         liveliness_lease_duration:\n    sec: 9223372036\n    nsec: 854775807\n  avoid_ros_namespace_conventions: false"
    )
}

/// A topic of the bag.
struct BagTopic {
    kind: String,
    qos: String,
    channel: u16,
    count: u32,
}

/// A bag that is written.
struct Bag {
    writer: mcap::Writer<BufWriter<File>>,
    topics: BTreeMap<String, BagTopic>,
    first: Option<u64>,
    last: u64,
}

impl Bag {
    fn put<M: Message>(
        &mut self,
        name: &str,
        is_latched: bool,
        time: u64,
        message: &M,
    ) -> Result<(), BagError> {
        let name = match name.starts_with('/') {
            true => name.to_owned(),
            false => format!("/{name}"),
        };
        if !self.topics.contains_key(&name) {
            let (kind, qos) = (M::type_name(), offered_qos(is_latched));
            let schema = self
                .writer
                .add_schema(&kind, "ros2msg", M::definition().as_bytes())?;
            let metadata = BTreeMap::from([("offered_qos_profiles".to_owned(), qos.clone())]);
            let channel = self.writer.add_channel(schema, &name, "cdr", &metadata)?;
            let topic = BagTopic {
                kind,
                qos,
                channel,
                count: 0,
            };
            self.topics.insert(name.clone(), topic);
        }
        let bytes = message
            .to_cdr()
            .map_err(|error| BagError::Message(error.to_string()))?;
        if let Some(topic) = self.topics.get_mut(&name) {
            let header = MessageHeader {
                channel_id: topic.channel,
                sequence: topic.count,
                log_time: time,
                publish_time: time,
            };
            self.writer.write_to_known_channel(&header, &bytes)?;
            topic.count += 1;
        }
        self.first.get_or_insert(time);
        self.last = self.last.max(time);
        Ok(())
    }

    /// The text of `metadata.yaml` (version 5 of rosbag2, which Humble and later read).
    fn metadata(&self, file: &str) -> String {
        let (first, count) = (
            self.first.unwrap_or(0),
            self.topics
                .values()
                .map(|topic| u64::from(topic.count))
                .sum::<u64>(),
        );
        let duration = self.last.saturating_sub(first);
        let mut text = format!(
            "rosbag2_bagfile_information:\n  version: 5\n  storage_identifier: mcap\n  duration:\n    nanoseconds: \
             {duration}\n  starting_time:\n    nanoseconds_since_epoch: {first}\n  message_count: {count}\n  \
             topics_with_message_count:\n"
        );
        for (name, topic) in &self.topics {
            // A text in double quotes, as JSON and YAML write it alike.
            let qos = serde_json::Value::from(topic.qos.as_str());
            // Writing into a text does not fail.
            let _ = write!(
                text,
                "    - topic_metadata:\n        name: {name}\n        type: {}\n        serialization_format: cdr\n\
                 \x20       offered_qos_profiles: {qos}\n      message_count: {}\n",
                topic.kind, topic.count
            );
        }
        let _ = write!(
            text,
            "  compression_format: \"\"\n  compression_mode: \"\"\n  relative_file_paths:\n    - {file}\n  files:\n\
             \x20   - \
             path: {file}\n      starting_time:\n        nanoseconds_since_epoch: {first}\n      duration:\n        \
             nanoseconds: {duration}\n      message_count: {count}\n"
        );
        text
    }
}

/// Writes the recording as a bag into a new folder; the number of cycles.
///
/// # Errors
/// [`BagError`]
pub(super) fn write_new(recording: &Recording, folder: &Path) -> Result<u64, BagError> {
    // A bag that is there already is somebody's.
    std::fs::create_dir(folder).map_err(|source| BagError::Folder {
        path: folder.to_owned(),
        source,
    })?;
    write_into(recording, folder)
}

/// Writes the recording as a bag into a folder that is there; the number of cycles.
///
/// # Errors
/// [`BagError`]
pub(crate) fn write_into(recording: &Recording, folder: &Path) -> Result<u64, BagError> {
    let setup = recording
        .setup()
        .ok_or_else(|| BagError::NoSetup(recording.name().to_owned()))?;
    let model = model_of(setup)?;
    let at = |source| BagError::Folder {
        path: folder.to_owned(),
        source,
    };
    let file = file_name(folder);
    let out = BufWriter::new(File::create(folder.join(&file)).map_err(at)?);
    let writer = WriteOptions::new()
        .profile("ros2")
        .library(concat!("eliteserver ", env!("CARGO_PKG_VERSION")))
        .compression(Some(mcap::Compression::Zstd))
        .create(out)?;
    let mut bag = Bag {
        writer,
        topics: BTreeMap::new(),
        first: None,
        last: 0,
    };
    // Stamps are the node's: since 1970 under the real clock, since the start under the virtual one.
    let stamp_epoch = match setup.clock.as_str() {
        "virtual" => 0,
        _ => setup.epoch_ns as i64,
    };
    let mut cycles = 0;
    let mut modes: Option<(RosRobotMode, RosSafetyMode)> = None;
    for cycle in recording.cycles()? {
        let state = cycle?
            .to_state()
            .map_err(|error| BagError::Cycle(error.to_string()))?;
        let nanos = (state.time * 1e9).round() as i64;
        let time = setup.epoch_ns + nanos as u64;
        let sample = NodeSample::of(&state, &model, false, stamp_epoch + nanos);
        if cycles == 0 {
            let urdf = setup.urdf.clone();
            let urdf = urdf.or_else(|| RobotModel::built_in_urdf(&setup.model).map(str::to_owned));
            let text = Text {
                data: urdf.unwrap_or_default(),
            };
            bag.put(topic::ROBOT_DESCRIPTION, true, time, &text)?;
            let fixed: TfMessage = fixed_frames("", &flange_in_wrist(&model), Time::default());
            bag.put(topic::TF_STATIC, true, time, &fixed)?;
        }
        bag.put(topic::JOINT_STATES, false, time, &sample.joint_state(""))?;
        bag.put(topic::TF, false, time, &sample.moving_frames(""))?;
        bag.put(topic::WRENCH, false, time, &sample.wrench_stamped(""))?;
        bag.put(topic::TCP_POSE, false, time, &sample.tcp_pose(""))?;
        bag.put(topic::SPEED_SCALING, false, time, &sample.speed_scaling())?;
        bag.put(topic::IO_STATES, false, time, &sample.io_state())?;
        bag.put(topic::TOOL_DATA, false, time, &sample.tool_data())?;
        let now = (sample.robot_mode(), sample.safety_mode());
        if modes.as_ref() != Some(&now) {
            bag.put(topic::ROBOT_MODE, true, time, &now.0)?;
            bag.put(topic::SAFETY_MODE, true, time, &now.1)?;
            modes = Some(now);
        }
        cycles += 1;
    }
    bag.writer.finish()?;
    std::fs::write(folder.join(METADATA), bag.metadata(&file)).map_err(at)?;
    Ok(cycles)
}
