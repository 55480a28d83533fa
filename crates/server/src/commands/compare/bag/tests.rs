//! Bags as the driver writes them, and bags that are none.

use std::fs::File;
use std::io::BufWriter;

use mcap::WriteOptions;
use mcap::records::MessageHeader;
use ros2::messages::{Header, Point, RosPose, RosWrench};

use super::*;

/// What is written into a file of a bag.
struct BagFile {
    writer: mcap::Writer<BufWriter<File>>,
}

impl BagFile {
    fn new(path: &Path) -> Self {
        let file = BufWriter::new(File::create(path).unwrap());
        let writer = WriteOptions::new().profile("ros2").create(file).unwrap();
        Self { writer }
    }

    fn put_bytes(&mut self, kind: &str, topic: &str, encoding: &str, time: u64, data: &[u8]) {
        let schema = self.writer.add_schema(kind, "ros2msg", b"").unwrap();
        let none = BTreeMap::new();
        let channel = self
            .writer
            .add_channel(schema, topic, encoding, &none)
            .unwrap();
        let header = MessageHeader {
            channel_id: channel,
            sequence: 0,
            log_time: time,
            publish_time: time,
        };
        self.writer.write_to_known_channel(&header, data).unwrap();
    }

    fn put<M: Message>(&mut self, topic: &str, time: u64, message: &M) {
        let bytes = message.to_cdr().unwrap();
        self.put_bytes(&M::type_name(), topic, "cdr", time, &bytes);
    }

    fn end(mut self) {
        self.writer.finish().unwrap();
    }
}

fn header(nanos: i64, frame: &str) -> Header {
    Header {
        stamp: Time::from_nanos(nanos),
        frame_id: frame.to_owned(),
    }
}

/// Joint k is at `k + by`.
fn state(nanos: i64, prefix: &str, by: f64) -> JointState {
    let mut joints: Vec<(String, f64)> = JOINTS
        .iter()
        .zip(0..)
        .map(|(name, k)| (format!("{prefix}{name}"), f64::from(k) + by))
        .collect();
    // As the broadcaster of the driver has them.
    joints.sort_by(|(a, _), (b, _)| a.cmp(b));
    let (name, position) = joints.into_iter().unzip();
    JointState {
        header: header(nanos, ""),
        name,
        position,
        velocity: vec![],
        effort: vec![],
    }
}

fn folder() -> tempfile::TempDir {
    tempfile::tempdir().unwrap()
}

fn said(path: &Path) -> String {
    read_bag(path).unwrap_err().to_string()
}

#[test]
fn joints_are_found_by_name_and_times_are_those_of_the_stamps() {
    let folder = folder();
    let begin = 1_700_000_000_000_000_000;
    // Ten comes after two, whatever the names say.
    for (file, at) in [("bag_10.mcap", 2), ("bag_2.mcap", 1), ("bag_0.mcap", 0)] {
        let mut bag = BagFile::new(&folder.path().join(file));
        let nanos = begin + at * 4_000_000;
        let late = nanos as u64 + 3_000_000;
        let gripper = JointState {
            name: vec!["finger".to_owned()],
            position: vec![0.5],
            ..JointState::default()
        };
        bag.put("/joint_states", late, &gripper);
        bag.put("/joint_states", late, &state(nanos, "left_", at as f64));
        let pose = RosPose {
            position: Point {
                x: at as f64,
                y: 2.0,
                z: 3.0,
            },
            orientation: ros2::messages::Quaternion {
                w: 1.0,
                ..Default::default()
            },
        };
        let stamped = PoseStamped {
            header: header(nanos, "left_base"),
            pose: pose.clone(),
        };
        bag.put("/tcp_pose_broadcaster/pose", late, &stamped);
        let mut wrench = RosWrench::default();
        wrench.force.z = 7.0;
        let stamped = WrenchStamped {
            header: header(nanos, "left_tool0"),
            wrench,
        };
        let topic = "/force_torque_sensor_broadcaster/wrench";
        bag.put(topic, late, &stamped);
        bag.end();
    }
    let trace = read_bag(folder.path()).unwrap();
    let samples: Vec<_> = trace.samples().collect();
    assert_eq!(samples.len(), 3);
    for (at, sample) in samples.iter().enumerate() {
        let at = at as f64;
        assert!((sample.time - 0.004 * at).abs() < 1e-12);
        assert_eq!(sample.q, [0.0, 1.0, 2.0, 3.0, 4.0, 5.0].map(|q| q + at));
        assert_eq!(sample.position, Vector3::new(at, 2.0, 3.0));
        assert_eq!(sample.force, Vector3::new(0.0, 0.0, 7.0));
        assert!(sample.speed.is_nan());
    }
}

#[test]
fn without_stamps_the_time_of_the_recorder_counts_and_other_frames_are_left_out() {
    let folder = folder();
    let path = folder.path().join("x.mcap");
    let mut bag = BagFile::new(&path);
    for k in 0..3_u64 {
        let time = 10_000_000_000 + k * 8_000_000;
        bag.put("/cell/joint_states", time, &state(0, "", k as f64));
        let mut pose = PoseStamped {
            header: header(0, "world"),
            ..Default::default()
        };
        pose.pose.orientation.w = 1.0;
        bag.put("/cell/tcp_pose_broadcaster/pose", time, &pose);
    }
    bag.end();
    let trace = read_bag(&path).unwrap();
    let samples: Vec<_> = trace.samples().collect();
    assert_eq!(samples.len(), 3);
    assert!((samples[2].time - 0.016).abs() < 1e-12);
    assert!(samples[0].position.x.is_nan() && samples[0].force.x.is_nan());
}

#[test]
fn between_messages_a_pose_is_interpolated_but_not_across_a_gap() {
    let mut values = TopicSamples::new(vec![(0.0, 0.0), (0.02, 2.0), (1.0, 100.0)]);
    let mix = |a: &f64, b: &f64, part: f64| a + (b - a) * part;
    assert_eq!(values.at(-0.1, mix), None);
    assert_eq!(values.at(0.01, mix), Some(1.0));
    assert_eq!(values.at(0.02, mix), Some(2.0));
    assert_eq!(values.at(0.5, mix), None);
    assert_eq!(values.at(1.0, mix), Some(100.0));
    assert_eq!(values.at(1.1, mix), None);
}

#[test]
fn a_folder_without_mcap_says_what_it_needs() {
    let folder = folder();
    assert!(said(folder.path()).contains("no file in that folder ends in .mcap"));
    std::fs::write(folder.path().join("b_0.db3"), "SQLite format 3").unwrap();
    let sentence = said(folder.path());
    assert!(sentence.contains("b_0.db3") && sentence.contains("ros2 bag convert"));
}

#[test]
fn topics_that_do_not_tell_one_arm_are_named() {
    let folder = folder();
    let path = folder.path().join("x.mcap");
    let mut bag = BagFile::new(&path);
    bag.put("/chatter", 1, &ros2::messages::Text::default());
    bag.put_bytes(
        "sensor_msgs/msg/JointState",
        "/joint_states",
        "json",
        1,
        b"{}",
    );
    bag.end();
    let sentence = said(&path);
    assert!(
        sentence.contains("no joint states") && sentence.contains("/chatter"),
        "{sentence}"
    );

    let mut bag = BagFile::new(&path);
    bag.put("/a/joint_states", 1, &state(1, "", 0.0));
    bag.put("/b/joint_states", 1, &state(1, "", 0.0));
    bag.end();
    let sentence = said(&path);
    assert!(
        sentence.ends_with("/a/joint_states, /b/joint_states"),
        "{sentence}"
    );

    let mut bag = BagFile::new(&path);
    let mut other = state(1, "", 0.0);
    other.name[0] = "elbow".to_owned();
    bag.put("/joint_states", 1, &other);
    bag.end();
    let sentence = said(&path);
    assert!(
        sentence.contains("has not the joints of the arm"),
        "{sentence}"
    );

    let mut both = state(1, "left_", 0.0);
    let right = state(1, "right_", 0.0);
    both.name.extend(right.name);
    both.position.extend(right.position);
    let mut bag = BagFile::new(&path);
    bag.put("/joint_states", 1, &both);
    bag.end();
    assert!(said(&path).contains("begin with left_ and right_"));
}

#[test]
fn messages_that_are_none_are_named_with_their_number() {
    let kind = JointState::type_name();
    let good = state(1, "", 0.0).to_cdr().unwrap();
    let mut short = state(1, "", 0.0);
    short.position.pop();
    // A list of names that claims four thousand million of them.
    let mut huge = good.clone();
    huge[20..24].copy_from_slice(&u32::MAX.to_le_bytes());
    let many = JointState {
        name: vec!["a".to_owned(); 300],
        position: vec![0.0; 300],
        ..JointState::default()
    };
    for (wrong, reason) in [
        (good[..40].to_vec(), ""),
        (huge, ""),
        (vec![], ""),
        (short.to_cdr().unwrap(), "6 joints and 5 positions"),
        (vec![0; 70_000], "at most 65536"),
        (many.to_cdr().unwrap(), "300 joints"),
    ] {
        let folder = folder();
        let path = folder.path().join("x.mcap");
        let mut bag = BagFile::new(&path);
        bag.put_bytes(&kind, "/joint_states", "cdr", 1, &good);
        bag.put_bytes(&kind, "/joint_states", "cdr", 2, &wrong);
        bag.end();
        let sentence = said(&path);
        assert!(
            sentence.starts_with("message 2 of /joint_states"),
            "{sentence}"
        );
        assert!(sentence.contains(reason), "{sentence}");
    }
}

#[test]
fn a_bag_that_was_cut_off_counts_as_far_as_it_goes_and_a_damaged_one_is_refused() {
    let folder = folder();
    let path = folder.path().join("x.mcap");
    let file = BufWriter::new(File::create(&path).unwrap());
    // Every message is there as it is written.
    let options = WriteOptions::new().profile("ros2").use_chunks(false);
    let mut bag = BagFile {
        writer: options.create(file).unwrap(),
    };
    for k in 0..10 {
        bag.put("/joint_states", k, &state(k as i64 + 1, "", 0.0));
    }
    bag.end();
    let whole = std::fs::read(&path).unwrap();
    std::fs::write(&path, &whole[..whole.len() / 2]).unwrap();
    let samples = read_bag(&path).unwrap().samples().len();
    assert!((1..10).contains(&samples), "{samples}");

    std::fs::write(&path, b"no MCAP at all, but some text").unwrap();
    assert!(said(&path).contains("is damaged"), "{}", said(&path));
}
