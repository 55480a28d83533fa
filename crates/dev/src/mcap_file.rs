//! MCAP files that are right on the outside, so that damage inside is reached: no compression, no check sums.

use std::io::Write;
use std::sync::Arc;

use kinematics::{JointPositions, RobotModel};
use motion_api::{
    Command, CommandId, CommandKind, MotionCommand, Origin, ProgramId, Record, RingCapacities,
    RobotState, ThreadNumber, motion_channel,
};
use parking_lot::Mutex;
use recorder::{LogLevel, Recorder, RecorderConfig, Recording, Rotation, Setup};

const MAGIC: [u8; 8] = [0x89, b'M', b'C', b'A', b'P', b'0', b'\r', b'\n'];

/// What stands around a chunk of these records: the file is whole if they are. Metadata and attachments at their
/// beginning stand before the chunk, since none of them may be in it.
pub fn wrap_records(records: &[u8]) -> Vec<u8> {
    let (outside, records) = records.split_at(outside_bytes(records));
    let mut chunk = Vec::new();
    chunk.extend(0_u64.to_le_bytes());
    chunk.extend(u64::MAX.to_le_bytes());
    chunk.extend((records.len() as u64).to_le_bytes());
    chunk.extend(0_u32.to_le_bytes());
    text(&mut chunk, "");
    chunk.extend((records.len() as u64).to_le_bytes());
    chunk.extend_from_slice(records);
    let mut file = MAGIC.to_vec();
    let mut header = Vec::new();
    text(&mut header, "");
    text(&mut header, "campaign");
    record(&mut file, 0x01, &header);
    file.extend_from_slice(outside);
    record(&mut file, 0x06, &chunk);
    record(&mut file, 0x0f, &[0; 4]);
    record(&mut file, 0x02, &[0; 20]);
    file.extend(MAGIC);
    file
}

/// Number of bytes at the beginning that are whole records of metadata and attachments.
fn outside_bytes(records: &[u8]) -> usize {
    let mut at = 0;
    while let Some((&[0x09 | 0x0c, ref length @ ..], rest)) = records[at..].split_first_chunk::<9>()
        && let Ok(length) = usize::try_from(u64::from_le_bytes(*length))
        && length <= rest.len()
    {
        at += 9 + length;
    }
    at
}

fn record(out: &mut Vec<u8>, kind: u8, body: &[u8]) {
    out.push(kind);
    out.extend((body.len() as u64).to_le_bytes());
    out.extend_from_slice(body);
}

fn text(out: &mut Vec<u8>, text: &str) {
    out.extend(u32::try_from(text.len()).unwrap_or(u32::MAX).to_le_bytes());
    out.extend_from_slice(text.as_bytes());
}

/// The records of a short recording: metadata, a file of its cell, then schemas, channels and messages.
pub fn seeds() -> Vec<Vec<u8>> {
    recorded().map_or_else(Vec::new, |bytes| plain(&bytes).into_iter().collect())
}

/// Bytes that the recorder writes and the seeds read.
#[derive(Clone, Default)]
struct SharedBuffer(Arc<Mutex<Vec<u8>>>);

impl Write for SharedBuffer {
    fn write(&mut self, data: &[u8]) -> std::io::Result<usize> {
        self.0.lock().extend_from_slice(data);
        Ok(data.len())
    }

    fn flush(&mut self) -> std::io::Result<()> {
        Ok(())
    }
}

/// A recording of a few cycles with a file, a command and a log line.
fn recorded() -> Option<Vec<u8>> {
    let first = RobotState::at_start(JointPositions::ZERO, 0.004);
    let sizes = RingCapacities {
        records: Some(64),
        ..RingCapacities::default()
    };
    let (mut motion, mut script) = motion_channel(sizes, &first);
    let config = RecorderConfig {
        path: "seed.mcap".into(),
        setup: Setup {
            model: "cs66".to_owned(),
            plant: "ideal".to_owned(),
            step_time: 0.004,
            files: [("part.stl".to_owned(), Arc::from(&b"solid\nendsolid"[..]))].into(),
            ..Setup::default()
        },
        model: RobotModel::built_in("cs66").ok()?,
        obstacles: Vec::new(),
        extra: Vec::new(),
        rotation: Rotation::default(),
        notes_wait: true,
        patience: std::time::Duration::from_secs(60),
        on_failure: Box::new(|_| ()),
    };
    let out = SharedBuffer::default();
    let (recorder, handle) =
        Recorder::start_on(out.clone(), config, script.records.take()?).ok()?;
    let origin = Origin {
        program: ProgramId(1),
        thread: ThreadNumber(0),
        line: 7,
    };
    let kind = CommandKind::Motion(MotionCommand::MoveJ {
        target: JointPositions([0.01; 6]),
        acceleration: 1.4,
        speed: 1.05,
        duration: 0.0,
        radius: 0.0,
    });
    let command = Command {
        id: CommandId(1),
        origin,
        kind,
    };
    let ring = motion.records.as_mut()?;
    ring.push(Record::Command { cycle: 1, command }).ok()?;
    for cycle in 1..=5 {
        let state = RobotState {
            cycle,
            time: cycle as f64 * 0.004,
            ..first
        };
        ring.push(Record::Cycle(state)).ok()?;
    }
    handle.log(
        0.004,
        LogLevel::Info,
        "seed",
        &messages::Text::verbatim("a line"),
    );
    drop(motion);
    recorder.finish().ok()?;
    let bytes = out.0.lock().clone();
    Some(bytes)
}

/// A copy of a recording whose records are not compressed.
fn plain(file: &[u8]) -> Option<Vec<u8>> {
    let recording = Recording::from_bytes(file, "seed").ok()?;
    let mut out = Vec::new();
    // Metadata and attachments as they are: records outside of chunks are not compressed.
    let mut at = MAGIC.len();
    while let Some((&[kind, ref length @ ..], _)) = file.get(at..)?.split_first_chunk::<9>() {
        let end = at + 9 + usize::try_from(u64::from_le_bytes(*length)).ok()?;
        if matches!(kind, 0x09 | 0x0c) {
            out.extend_from_slice(file.get(at..end)?);
        }
        at = end;
    }
    let mut known = Vec::new();
    for message in recording.messages().ok()? {
        let id = message.channel.id;
        if !known.contains(&id) {
            known.push(id);
            let mut schema_id = 0;
            if let Some(schema) = &message.channel.schema {
                schema_id = schema.id;
                let mut body = schema.id.to_le_bytes().to_vec();
                text(&mut body, &schema.name);
                text(&mut body, &schema.encoding);
                body.extend(u32::try_from(schema.data.len()).ok()?.to_le_bytes());
                body.extend_from_slice(&schema.data);
                record(&mut out, 0x03, &body);
            }
            let mut body = id.to_le_bytes().to_vec();
            body.extend(schema_id.to_le_bytes());
            text(&mut body, &message.channel.topic);
            text(&mut body, &message.channel.message_encoding);
            body.extend(0_u32.to_le_bytes());
            record(&mut out, 0x04, &body);
        }
        let mut body = id.to_le_bytes().to_vec();
        body.extend(0_u32.to_le_bytes());
        body.extend(message.log_time_ns.to_le_bytes());
        body.extend(message.log_time_ns.to_le_bytes());
        body.extend_from_slice(&message.data);
        record(&mut out, 0x05, &body);
    }
    Some(out)
}

#[cfg(test)]
mod tests {
    use super::*;
    use recorder::{FileEnd, Topic};

    #[test]
    fn a_seed_without_damage_is_a_recording_with_its_setup_and_everything_in_it() {
        let file = wrap_records(&seeds()[0]);
        let recording = Recording::from_bytes(file, "seed").unwrap();
        assert_eq!(recording.setup().unwrap().model, "cs66");
        recording.check_files().unwrap();
        assert_eq!(recording.setup().unwrap().files.len(), 1);
        let mut entries = recording.entries(&Topic::ALL).unwrap();
        assert!(entries.by_ref().map(Result::unwrap).count() >= 7);
        assert_eq!(entries.ending(), Some(&FileEnd::Complete));
    }
}
