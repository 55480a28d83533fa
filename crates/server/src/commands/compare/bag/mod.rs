//! A bag of ROS 2 as a side of the comparison: what the vendor's driver, or a node of ours, has published.
//!
//! A bag is a folder with MCAP files, or one such file; messages are CDR. Joint states are needed; the pose of the TCP
//! and the wrench beside them are used where they are there. Everything in a bag is untrusted: what is none is refused
//! with a sentence, and memory grows with the samples, whose number is bounded.

use std::collections::{BTreeMap, BTreeSet};
use std::io;
use std::path::{Path, PathBuf};

use messages::{Localized, Text, text};
use nalgebra::{Quaternion, UnitQuaternion, Vector3};
use recorder::{FileEnd, ReadError, messages_of_file};
use robot_client::compare::{RunTrace, TraceSample};
use ros2::messages::{JointState, Message, PoseStamped, Time, WrenchStamped};
use ros2::names::{BASE, JOINTS, TOOL, topic};
use thiserror::Error;

use crate::language;

/// Most samples of a topic: eleven hours at 250 Hz.
const SAMPLES_MAX: usize = 10_000_000;
/// Most bytes of a message of these topics; one of the driver has some hundred.
const MESSAGE_BYTES_MAX: usize = 64 << 10;
/// Most joints of a message.
const JOINTS_MAX: usize = 256;
/// Most files of a bag.
const FILES_MAX: usize = 10_000;
/// Names that a sentence lists.
const NAMES_SHOWN: usize = 12;
/// Pose and wrench are interpolated between messages that are no further apart, s.
const GAP_MAX: f64 = 0.1;

/// A reason why a bag cannot be compared.
#[derive(Debug, Error, Localized)]
pub(super) enum BagReadError {
    #[error(transparent)]
    Read(#[from] ReadError),
    #[error("cannot read the bag {}: {source}", path.display())]
    #[zh("无法读取 bag {}：{source}", path.display())]
    Folder { path: PathBuf, source: io::Error },
    #[error("{} is no bag in MCAP: no file in that folder ends in .mcap", path.display())]
    #[zh("{} 不是 MCAP 格式的 bag：该文件夹中没有以 .mcap 结尾的文件", path.display())]
    NoMcap { path: PathBuf },
    #[error(
        "the bag {} keeps its messages in {file}; only MCAP is read: ros2 bag convert makes it of other bags",
        path.display()
    )]
    #[zh("bag {} 的消息保存在 {file} 中；只读取 MCAP：可用 ros2 bag convert 转换其他 bag", path.display())]
    OtherStorage { path: PathBuf, file: String },
    #[error("the bag {} has more than {FILES_MAX} files", path.display())]
    #[zh("bag {} 的文件多于 {FILES_MAX} 个", path.display())]
    TooManyFiles { path: PathBuf },
    #[error(
        "{name} has no joint states (sensor_msgs/msg/JointState as CDR); its topics are {topics}"
    )]
    #[zh("{name} 没有关节状态（CDR 编码的 sensor_msgs/msg/JointState）；其主题为 {topics}")]
    NoJointStates { name: String, topics: String },
    #[error("{name} has joint states of several robots, and which is meant is not known: {topics}")]
    #[zh("{name} 含有多台机器人的关节状态，不知道指哪一台：{topics}")]
    SeveralTopics { name: String, topics: String },
    #[error("{topic} of {name} has not the joints of the arm; the first message has {given}")]
    #[zh("{name} 的 {topic} 没有机械臂的关节；第一条消息含有 {given}")]
    OtherJoints {
        name: String,
        topic: String,
        given: String,
    },
    #[error("message {number} of {topic} in {name} cannot be read: {reason}")]
    #[zh("无法读取 {name} 中 {topic} 的第 {number} 条消息：{reason}")]
    Message {
        name: String,
        topic: String,
        number: usize,
        reason: Text,
    },
    #[error("{topic} of {name} has more than {SAMPLES_MAX} messages")]
    #[zh("{name} 的 {topic} 多于 {SAMPLES_MAX} 条消息")]
    TooLong { name: String, topic: String },
    #[error(
        "{0} is a bag, which does not say tool, payload and place of its arm: run the script with 'run --record FILE' \
         and compare the bag with that recording"
    )]
    #[zh(
        "{0} 是 bag，不含机械臂的工具、负载和位置：请用 'run --record 文件' 运行脚本，再与该记录比较"
    )]
    NoArm(String),
}

/// Reads the bag at a path.
///
/// # Errors
/// [`BagReadError`]
pub(super) fn read_bag(path: &Path) -> Result<RunTrace, BagReadError> {
    let files = files_of(path)?;
    let name = path.display().to_string();
    let topics = BagTopics::find(&files)?.chosen(&name)?;
    let mut content = BagContent::default();
    for file in &files {
        content.read(file, &name, &topics)?;
    }
    content.into_trace(name, topics.joints)
}

/// The MCAP files of a bag in the order in which they were written.
fn files_of(path: &Path) -> Result<Vec<PathBuf>, BagReadError> {
    if !path.is_dir() {
        return Ok(vec![path.to_owned()]);
    }
    let failed = |source| BagReadError::Folder {
        path: path.to_owned(),
        source,
    };
    let mut files = Vec::new();
    let mut other = None;
    for entry in std::fs::read_dir(path).map_err(failed)? {
        let file = entry.map_err(failed)?.path();
        let name = file.file_name().unwrap_or_default().to_string_lossy();
        match name.rsplit_once('.') {
            Some((_, "mcap")) => files.push(file),
            Some((_, "db3" | "zstd")) => other = Some(name.into_owned()),
            _ => {}
        }
    }
    let path = path.to_owned();
    match (files.len(), other) {
        (0, Some(file)) => return Err(BagReadError::OtherStorage { path, file }),
        (0, None) => return Err(BagReadError::NoMcap { path }),
        (count, _) if count > FILES_MAX => return Err(BagReadError::TooManyFiles { path }),
        _ => {}
    }
    files.sort_by_key(|file| (number_of(file), file.clone()));
    Ok(files)
}

/// The number at the end of a name, as `session_12.mcap` has it.
fn number_of(file: &Path) -> Option<u64> {
    let stem = file.file_stem()?.to_str()?;
    stem.rsplit_once('_')?.1.parse().ok()
}

/// Topics of a bag, by the type of their messages; CDR only.
#[derive(Default)]
struct BagTopics(BTreeMap<String, BTreeSet<String>>);

/// The topics that are compared.
struct ComparedTopics {
    joints: String,
    pose: String,
    wrench: String,
}

impl BagTopics {
    /// The topics that have messages.
    fn find(files: &[PathBuf]) -> Result<Self, BagReadError> {
        let mut topics = Self::default();
        for file in files {
            let mut seen = BTreeSet::new();
            let mut messages = messages_of_file(file)?;
            for message in messages.by_ref() {
                let channel = &message.channel;
                let schema = channel.schema.as_ref().map_or("", |schema| &schema.name);
                if seen.insert(channel.id) && channel.message_encoding == "cdr" {
                    let of_kind = topics.0.entry(schema.to_owned()).or_default();
                    of_kind.insert(channel.topic.clone());
                }
            }
            check_end(file, messages.ending())?;
        }
        Ok(topics)
    }

    fn chosen(&self, name: &str) -> Result<ComparedTopics, BagReadError> {
        let none = BTreeSet::new();
        let joints = self.0.get(&JointState::type_name()).unwrap_or(&none);
        let ending = format!("/{}", topic::JOINT_STATES);
        let named: Vec<_> = joints.iter().filter(|t| t.ends_with(&ending)).collect();
        let joints = match (joints.contains(&ending), named.as_slice(), joints.len()) {
            (true, ..) => ending.clone(),
            (_, [only], _) => (*only).clone(),
            (_, _, 0) => {
                return Err(BagReadError::NoJointStates {
                    name: name.to_owned(),
                    topics: list(self.0.values().flatten()),
                });
            }
            (_, [], 1) => joints.first().cloned().unwrap_or_default(),
            _ => {
                return Err(BagReadError::SeveralTopics {
                    name: name.to_owned(),
                    topics: list(joints.iter()),
                });
            }
        };
        let namespace = joints.strip_suffix(&ending).unwrap_or_default();
        Ok(ComparedTopics {
            pose: format!("{namespace}/{}", topic::TCP_POSE),
            wrench: format!("{namespace}/{}", topic::WRENCH),
            joints,
        })
    }
}

/// Some names for a sentence.
fn list<'n>(names: impl Iterator<Item = &'n String>) -> String {
    let mut shown: Vec<&str> = names.map(String::as_str).take(NAMES_SHOWN + 1).collect();
    match shown.len() {
        0 => return "none".to_owned(),
        count if count > NAMES_SHOWN => shown[NAMES_SHOWN] = "…",
        _ => {}
    }
    shown.join(", ")
}

/// A bag that was cut off counts as far as it goes; one that is damaged is none.
fn check_end(file: &Path, end: Option<&FileEnd>) -> Result<(), BagReadError> {
    match end {
        Some(FileEnd::Damaged(reason)) => Err(ReadError::Damaged {
            path: file.display().to_string(),
            reason: reason.clone(),
        }
        .into()),
        _ => Ok(()),
    }
}

/// The two times of a message, ns: its stamp, and when it was recorded.
#[derive(Clone, Copy)]
struct MessageTimes {
    stamp: i64,
    logged: u64,
}

/// A place and an orientation.
type BagPose = (Vector3<f64>, UnitQuaternion<f64>);

/// What was read so far.
#[derive(Default)]
struct BagContent {
    joints: Vec<(MessageTimes, [f64; 6])>,
    poses: Vec<(MessageTimes, BagPose)>,
    forces: Vec<(MessageTimes, Vector3<f64>)>,
    counts: BTreeMap<String, usize>,
    places: JointPlaces,
    /// Names of the first message, for whoever looks for the joints.
    first_names: Option<Vec<String>>,
}

impl BagContent {
    fn read(
        &mut self,
        file: &Path,
        name: &str,
        topics: &ComparedTopics,
    ) -> Result<(), BagReadError> {
        let mut messages = messages_of_file(file)?;
        for message in messages.by_ref() {
            let channel = &message.channel;
            let schema = channel.schema.as_ref().map_or("", |schema| &schema.name);
            if channel.message_encoding != "cdr" {
                continue;
            }
            let topic = &channel.topic;
            let added = if *topic == topics.joints && schema == JointState::type_name() {
                self.add_joints(&message.data, message.log_time_ns)
            } else if *topic == topics.pose && schema == PoseStamped::type_name() {
                self.add_pose(&message.data, message.log_time_ns)
            } else if *topic == topics.wrench && schema == WrenchStamped::type_name() {
                self.add_force(&message.data, message.log_time_ns)
            } else {
                continue;
            };
            let number = self.counts.entry(topic.clone()).or_default();
            *number += 1;
            if let Err(reason) = added {
                return Err(BagReadError::Message {
                    name: name.to_owned(),
                    topic: topic.clone(),
                    number: *number,
                    reason,
                });
            }
            if *number > SAMPLES_MAX {
                return Err(BagReadError::TooLong {
                    name: name.to_owned(),
                    topic: topic.clone(),
                });
            }
        }
        if messages.ending() == Some(&FileEnd::Truncated) {
            language::say(&text!(
                "{} was cut off; what it has is compared",
                "{} 被截断；只比较其已有内容",
                file.display()
            ));
        }
        Ok(())
    }

    fn add_joints(&mut self, data: &[u8], logged: u64) -> Result<(), Text> {
        let state: JointState = decoded(data)?;
        if state.position.len() != state.name.len() {
            return Err(text!(
                "it has {} joints and {} positions",
                "有 {} 个关节和 {} 个位置",
                state.name.len(),
                state.position.len()
            ));
        }
        // Others may publish under this name as well, as the driver of a gripper does.
        if let Some(places) = self.places.of(&state.name)? {
            let q = places.map(|place| state.position[place]);
            self.joints.push((times(&state.header.stamp, logged), q));
        }
        self.first_names.get_or_insert(state.name);
        Ok(())
    }

    fn add_pose(&mut self, data: &[u8], logged: u64) -> Result<(), Text> {
        let PoseStamped { header, pose } = decoded(data)?;
        let turn = pose.orientation;
        let turn = UnitQuaternion::try_new(Quaternion::new(turn.w, turn.x, turn.y, turn.z), 1e-6);
        // In another frame it would be another pose.
        if let Some(turn) = turn.filter(|_| header.frame_id.ends_with(BASE)) {
            let at = Vector3::new(pose.position.x, pose.position.y, pose.position.z);
            self.poses.push((times(&header.stamp, logged), (at, turn)));
        }
        Ok(())
    }

    fn add_force(&mut self, data: &[u8], logged: u64) -> Result<(), Text> {
        let WrenchStamped { header, wrench } = decoded(data)?;
        if header.frame_id.ends_with(TOOL) {
            let force = Vector3::new(wrench.force.x, wrench.force.y, wrench.force.z);
            self.forces.push((times(&header.stamp, logged), force));
        }
        Ok(())
    }

    /// The run over time, from its first joint state.
    fn into_trace(self, name: String, topic: String) -> Result<RunTrace, BagReadError> {
        let Some((first, _)) = self.joints.first() else {
            let given = self.first_names.unwrap_or_default();
            return Err(BagReadError::OtherJoints {
                name,
                topic,
                given: list(given.iter()),
            });
        };
        // Stamps are the robot's. Where nobody fills them, the time of the recorder is all there is.
        let (is_stamped, first) = (first.stamp != 0, *first);
        let secs = |times: &MessageTimes| match is_stamped {
            true => times.stamp.saturating_sub(first.stamp) as f64 * 1e-9,
            false => (i128::from(times.logged) - i128::from(first.logged)) as f64 * 1e-9,
        };
        let joints = in_order(self.joints, secs);
        let mut poses = TopicSamples::new(in_order(self.poses, secs));
        let mut forces = TopicSamples::new(in_order(self.forces, secs));
        let mut trace = RunTrace::default();
        for (time, q) in joints {
            let pose = poses.at(time, |(a, from), (b, to), part| {
                let turn = from.try_slerp(to, part, 1e-9).unwrap_or(*from);
                (a.lerp(b, part), turn)
            });
            let force = forces.at(time, |a, b, part| a.lerp(b, part));
            let unknown = Vector3::repeat(f64::NAN);
            let (position, rotation) = pose.unwrap_or((unknown, UnitQuaternion::identity()));
            trace.push(TraceSample {
                time,
                q,
                position,
                rotation,
                speed: f64::NAN,
                force: force.unwrap_or(unknown),
            });
        }
        Ok(trace)
    }
}

fn decoded<M: Message>(data: &[u8]) -> Result<M, Text> {
    match data.len() <= MESSAGE_BYTES_MAX {
        true => M::from_cdr(data).map_err(|error| Text::of_library(&error)),
        false => Err(text!(
            "it has {} bytes, at most {MESSAGE_BYTES_MAX} are read",
            "有 {} 字节，最多读取 {MESSAGE_BYTES_MAX} 字节",
            data.len()
        )),
    }
}

fn times(stamp: &Time, logged: u64) -> MessageTimes {
    MessageTimes {
        stamp: stamp.to_nanos(),
        logged,
    }
}

fn in_order<T>(
    samples: Vec<(MessageTimes, T)>,
    secs: impl Fn(&MessageTimes) -> f64,
) -> Vec<(f64, T)> {
    let timed = samples
        .into_iter()
        .map(|(times, value)| (secs(&times), value));
    let mut timed: Vec<(f64, T)> = timed.collect();
    timed.sort_by(|(a, _), (b, _)| a.total_cmp(b));
    timed
}

/// Values of a topic over time, asked for moments that go forward.
struct TopicSamples<T> {
    samples: Vec<(f64, T)>,
    place: usize,
}

impl<T: Copy> TopicSamples<T> {
    const fn new(samples: Vec<(f64, T)>) -> Self {
        Self { samples, place: 0 }
    }

    /// The value at a moment, between its neighbours.
    fn at(&mut self, time: f64, mix: impl Fn(&T, &T, f64) -> T) -> Option<T> {
        let all = &self.samples;
        while all.get(self.place + 1).is_some_and(|next| next.0 <= time) {
            self.place += 1;
        }
        let (begin, before) = all.get(self.place).filter(|before| before.0 <= time)?;
        if *begin == time {
            return Some(*before);
        }
        let (end, after) = all.get(self.place + 1)?;
        (end - begin <= GAP_MAX).then(|| mix(before, after, (time - begin) / (end - begin)))
    }
}

/// Where the arm's joints are among the names of a message, base first.
#[derive(Default)]
struct JointPlaces {
    names: Vec<String>,
    places: Option<[usize; 6]>,
}

impl JointPlaces {
    fn of(&mut self, names: &[String]) -> Result<Option<[usize; 6]>, Text> {
        if self.names != names {
            self.places = joint_places(names)?;
            self.names = names.to_vec();
        }
        Ok(self.places)
    }
}

/// Places of the joints, which all may have a prefix; none where they are not there.
fn joint_places(names: &[String]) -> Result<Option<[usize; 6]>, Text> {
    if names.len() > JOINTS_MAX {
        return Err(text!(
            "it has {} joints, at most {JOINTS_MAX} are read",
            "有 {} 个关节，最多读取 {JOINTS_MAX} 个",
            names.len()
        ));
    }
    let place = |name: &str| names.iter().position(|given| given == name);
    let mut found = Vec::new();
    for prefix in names.iter().filter_map(|name| name.strip_suffix(JOINTS[0])) {
        let places = JOINTS.map(|joint| place(&format!("{prefix}{joint}")));
        if let [Some(a), Some(b), Some(c), Some(d), Some(e), Some(f)] = places {
            found.push((prefix, [a, b, c, d, e, f]));
        }
    }
    match found.as_slice() {
        [] => Ok(None),
        [(_, only)] => Ok(Some(*only)),
        [(a, first), rest @ ..] => match found.iter().find(|(prefix, _)| prefix.is_empty()) {
            Some((_, places)) => Ok(Some(*places)),
            None if rest.iter().all(|(prefix, _)| prefix == a) => Ok(Some(*first)),
            None => Err(text!(
                "it has the joints of several arms, which begin with {a} and {}",
                "含有多台机械臂的关节，名称以 {a} 和 {} 开头",
                rest[0].0
            )),
        },
    }
}

#[cfg(test)]
mod tests;
