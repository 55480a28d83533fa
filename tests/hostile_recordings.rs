//! Files that are no recordings, or want to be the reader's ruin: every question of `replay` answers with one sentence,
//! in bounded memory and time.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    reason = "a test fails by panicking"
)]

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::io::Read;
use std::path::Path;
use std::process::{Command, Stdio};
use std::sync::OnceLock;
use std::time::{Duration, Instant};

use crate::common::{eliteserver, run_script};

/// Address space of a reader, KiB. The program itself, its threads and the largest chunk fit; the file does not.
const MEMORY_KIB: u64 = 1_200_000;
/// Longest answer; a debug build on a machine with much else to do.
const TIME_MAX: Duration = Duration::from_secs(100);
const MAGIC: &[u8] = b"\x89MCAP0\r\n";

/// Questions, and what each needs beside the file. `OUT` is a file of the test.
const QUESTIONS: [&[&str]; 13] = [
    &[],
    &["--at", "0.1"],
    &["--csv", "/cycle"],
    &["--csv", "/log"],
    &["--csv", "/command"],
    &["--csv", "/script"],
    &["--csv", "/foreign"],
    &["--plot", "OUT.png"],
    &["--find", "norm(tcp_force[0:3]) > 1000"],
    &["--script"],
    &["--rerun"],
    &["--diff", "GOOD"],
    &[
        "--serve",
        "--rate",
        "100",
        "--primary-port",
        "0",
        "--rtsi-port",
        "0",
        "--http-port",
        "0",
    ],
];

/// What a file is answered with.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Answer {
    /// Exit status 2, whatever the question.
    Refused,
    /// What can be read, and a sentence: status 0, or 1 where recordings are compared.
    Cut,
    /// A question may be answered or not; what holds is that it ends, and says why if not.
    Any,
}
use Answer::{Any, Cut, Refused};

// ---- making files

fn text(content: &[u8]) -> Vec<u8> {
    [&(content.len() as u32).to_le_bytes()[..], content].concat()
}

fn record(opcode: u8, content: &[u8]) -> Vec<u8> {
    long_record(opcode, content.len() as u64, content)
}

/// A record that claims another length than it has.
fn long_record(opcode: u8, length: u64, content: &[u8]) -> Vec<u8> {
    [&[opcode][..], &length.to_le_bytes(), content].concat()
}

fn schema(id: u16, name: &[u8], encoding: &[u8], data: &[u8]) -> Vec<u8> {
    let content = [
        &id.to_le_bytes()[..],
        &text(name),
        &text(encoding),
        &text(data),
    ]
    .concat();
    record(3, &content)
}

fn channel(id: u16, schema: u16, topic: &[u8], encoding: &[u8]) -> Vec<u8> {
    let (id, schema) = (id.to_le_bytes(), schema.to_le_bytes());
    let content = [&id[..], &schema, &text(topic), &text(encoding), &text(b"")].concat();
    record(4, &content)
}

fn message(channel: u16, time: u64, data: &[u8]) -> Vec<u8> {
    let head = [
        &channel.to_le_bytes()[..],
        &0_u32.to_le_bytes(),
        &time.to_le_bytes(),
        &time.to_le_bytes(),
    ];
    record(5, &[&head.concat()[..], data].concat())
}

fn metadata(name: &str, entries: &[(&str, &str)]) -> Vec<u8> {
    let mut map = Vec::new();
    for (key, value) in entries {
        map.extend(text(key.as_bytes()));
        map.extend(text(value.as_bytes()));
    }
    record(12, &[text(name.as_bytes()), text(&map)].concat())
}

/// A chunk as its header says, true or not.
fn raw_chunk(compression: &str, size: u64, crc: u32, packed: &[u8]) -> Vec<u8> {
    let head = [
        &0_u64.to_le_bytes()[..],
        &0_u64.to_le_bytes(),
        &size.to_le_bytes(),
        &crc.to_le_bytes(),
        &text(compression.as_bytes()),
        &(packed.len() as u64).to_le_bytes(),
    ];
    record(6, &[&head.concat()[..], packed].concat())
}

fn chunk(content: &[u8]) -> Vec<u8> {
    raw_chunk("", content.len() as u64, 0, content)
}

/// A zstd frame of bytes as they are and runs of one byte, in a few bytes a run.
fn zstd_frame(parts: &[(&[u8], usize)], window: u8) -> Vec<u8> {
    let mut out = vec![0x28, 0xb5, 0x2f, 0xfd, 0x00, window];
    let mut block = |kind: u32, size: usize, data: &[u8]| {
        out.extend(&(kind << 1 | (size as u32) << 3).to_le_bytes()[..3]);
        out.extend(data);
    };
    for (bytes, zeros) in parts {
        block(0, bytes.len(), bytes);
        let mut left = *zeros;
        while left > 0 {
            let run = left.min(1 << 17);
            block(1, run, b"\0");
            left -= run;
        }
    }
    out.extend([1, 0, 0]);
    out
}

/// A record of `zeros` zero bytes behind a beginning, in a chunk of some kilobytes.
fn bomb(opcode: u8, beginning: &[u8], zeros: usize) -> Vec<u8> {
    let length = (beginning.len() + zeros) as u64;
    let head = [&[opcode][..], &length.to_le_bytes(), beginning].concat();
    let packed = zstd_frame(&[(&head, zeros)], 0x38);
    raw_chunk("zstd", 9 + length, 0, &packed)
}

const HEADER: &[u8] = b"\x01\x09\0\0\0\0\0\0\0\0\0\0\0\x01\0\0\0x";

fn file(parts: &[Vec<u8>]) -> Vec<u8> {
    let end = [record(15, &[0; 4]), record(2, &[0; 20])].concat();
    [MAGIC, HEADER, &parts.concat(), &end, MAGIC].concat()
}

/// A good recording of a short run.
fn good() -> &'static [u8] {
    static GOOD: OnceLock<Vec<u8>> = OnceLock::new();
    GOOD.get_or_init(|| {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("good.mcap");
        let script = "global n\nn = 1\nprint('hello')\nmovej([0.1, -1.5, 1.5, -1.5, -1.5, 0], a=3, v=2)\nn = 2\n";
        let options = ["--plant", "ideal", "--record", path.to_str().unwrap()];
        let output = run_script(folder.path(), script, &options);
        assert!(output.status.success(), "{output:?}");
        std::fs::read(&path).unwrap()
    })
}

/// The declarations of a good recording, and the numbers of its channels by topic.
fn declarations() -> (Vec<u8>, BTreeMap<String, u16>) {
    let bytes = good();
    let (mut all, mut channels) = (Vec::new(), BTreeMap::new());
    let mut at = MAGIC.len();
    let mut take = |data: &[u8]| {
        let id = |data: &[u8]| u16::from_le_bytes(data[..2].try_into().unwrap());
        if data[0] == 4 {
            let length = u32::from_le_bytes(data[13..17].try_into().unwrap()) as usize;
            let topic = String::from_utf8(data[17..17 + length].to_vec()).unwrap();
            channels.insert(topic, id(&data[9..]));
        }
        all.extend(data);
    };
    while at + 9 <= bytes.len() && bytes[at] != 15 {
        let length = u64::from_le_bytes(bytes[at + 1..at + 9].try_into().unwrap()) as usize;
        match bytes[at] {
            3 | 4 | 12 => take(&bytes[at..at + 9 + length]),
            6 if channels_in_chunk(&bytes[at + 9..at + 9 + length], &mut take) => {}
            _ => {}
        }
        at += 9 + length;
    }
    (all, channels)
}

/// Gives schemas and channels of a packed chunk to `take`.
fn channels_in_chunk(data: &[u8], take: &mut impl FnMut(&[u8])) -> bool {
    let name = u32::from_le_bytes(data[28..32].try_into().unwrap()) as usize;
    let packed = &data[32 + name + 8..];
    let content = zstd::decode_all(packed).unwrap();
    let mut at = 0;
    while at < content.len() {
        let length = u64::from_le_bytes(content[at + 1..at + 9].try_into().unwrap()) as usize;
        if matches!(content[at], 3 | 4) {
            take(&content[at..at + 9 + length]);
        }
        at += 9 + length;
    }
    true
}

/// A recording with the right declarations and these messages.
fn with(messages: &[(&str, u64, Vec<u8>)]) -> Vec<u8> {
    let (declared, channels) = declarations();
    let all: Vec<u8> = messages
        .iter()
        .flat_map(|(topic, time, data)| message(channels[*topic], *time, data))
        .collect();
    file(&[declared, chunk(&all)])
}

/// `elite.CycleMessage` in protobuf: number, time and step, then more fields.
fn cycle(number: u64, time: f64, more: &[u8]) -> Vec<u8> {
    let mut data = vec![0x08];
    let mut rest = number;
    while rest >= 0x80 {
        data.push(rest as u8 | 0x80);
        rest >>= 7;
    }
    data.push(rest as u8);
    data.push(0x11);
    data.extend(time.to_le_bytes());
    data.extend(more);
    data
}

/// A vector of numbers as field `number` below 16.
fn vector(number: u8, values: &[f64]) -> Vec<u8> {
    let bytes: Vec<u8> = values.iter().flat_map(|x| x.to_le_bytes()).collect();
    [&[number << 3 | 2, bytes.len() as u8][..], &bytes].concat()
}

/// As [`with`], in several chunks, so that the file may be much larger than what may be held.
fn many(topic: &str, chunks: usize, of_chunk: impl Fn(usize, u16) -> Vec<u8>) -> Vec<u8> {
    let (declared, channels) = declarations();
    let id = channels[topic];
    let mut parts = vec![declared];
    parts.extend((0..chunks).map(|i| {
        let content = of_chunk(i, id);
        let packed = zstd::bulk::compress(&content, 1).unwrap();
        raw_chunk("zstd", content.len() as u64, 0, &packed)
    }));
    file(&parts)
}

fn cycles(numbers: impl IntoIterator<Item = (u64, f64)>) -> Vec<u8> {
    let all: Vec<_> = numbers
        .into_iter()
        .map(|(number, time)| {
            let nanos = (time.max(0.0) * 1e9) as u64;
            ("/cycle", nanos, cycle(number, time, &vector(3, &[0.1; 6])))
        })
        .collect();
    with(&all)
}

#[expect(clippy::too_many_lines, reason = "a list of files")]
fn files() -> Vec<(&'static str, Answer, Vec<u8>)> {
    let whole = good().to_vec();
    let middle = whole.len() / 2;
    let flipped = |at: usize| {
        let mut bytes = whole.clone();
        bytes[at] ^= 0x40;
        bytes
    };
    let json = |topic: &'static str, text: &str| {
        with(&[
            ("/cycle", 0, cycle(1, 0.004, &[])),
            (topic, 0, text.as_bytes().to_vec()),
            ("/cycle", 0, cycle(2, 0.008, &[])),
        ])
    };
    let foreign = |schema_data: &[u8], data: &[u8]| {
        let (declared, channels) = declarations();
        let more = [
            schema(900, b"x.M", b"protobuf", schema_data),
            channel(900, 900, b"/foreign", b"protobuf"),
        ];
        let messages = [
            message(channels["/cycle"], 0, &cycle(1, 0.004, &[])),
            message(900, 0, data),
        ];
        file(&[declared, more.concat(), chunk(&messages.concat())])
    };
    let deep_xml = format!("<robot name='r'>{}", "<link>".repeat(200_000));
    let deep_toml = format!("x = {}", "[".repeat(200_000));
    let setup = |key: &str, value: &str| {
        let mut entries = vec![
            ("format", "1"),
            ("model", "cs66"),
            ("plant", "ideal"),
            ("step_time", "0.004"),
        ];
        entries.retain(|(name, _)| *name != key);
        entries.push((key, value));
        let (declared, channels) = declarations();
        let without: Vec<u8> = records_of(&declared)
            .filter(|r| r[0] != 12)
            .flatten()
            .copied()
            .collect();
        let messages: Vec<u8> = (1..=3)
            .flat_map(|n| {
                message(
                    channels["/cycle"],
                    n * 4_000_000,
                    &cycle(n, n as f64 * 0.004, &[]),
                )
            })
            .collect();
        file(&[metadata("eliteserver", &entries), without, chunk(&messages)])
    };
    let mut lying_footer = whole.clone();
    let footer = lying_footer.len() - MAGIC.len() - 20;
    lying_footer[footer..footer + 16].fill(0xff);
    let good_chunk = chunk(&message(1, 0, b"x"));
    vec![
        ("empty", Refused, vec![]),
        ("one byte", Refused, vec![0x89]),
        ("only the magic", Refused, MAGIC.to_vec()),
        ("text", Refused, b"time,q\n0,1\n".to_vec()),
        ("zeros", Refused, vec![0; 1 << 20]),
        (
            "wrong magic",
            Refused,
            [b"\x89MCAP9\r\n", &whole[8..]].concat(),
        ),
        ("nothing in it", Refused, file(&[])),
        ("cut in the header", Refused, whole[..20].to_vec()),
        ("cut in the middle", Cut, whole[..middle].to_vec()),
        (
            "cut before the end",
            Cut,
            whole[..whole.len() - 30].to_vec(),
        ),
        (
            "cut in the last magic",
            Cut,
            whole[..whole.len() - 1].to_vec(),
        ),
        ("a flipped bit in a chunk", Refused, flipped(middle / 2)),
        ("an index that lies", Any, flipped(whole.len() - 60)),
        ("a footer that lies", Any, lying_footer),
        (
            "garbage behind the end",
            Any,
            [&whole[..], &[0xff; 5000]].concat(),
        ),
        (
            "twice the same file",
            Any,
            [&whole[..], &whole[..]].concat(),
        ),
        (
            "a record that claims everything",
            Refused,
            [MAGIC, HEADER, &long_record(5, u64::MAX, b"x")].concat(),
        ),
        (
            "a record that claims a gigabyte",
            Refused,
            [MAGIC, HEADER, &long_record(3, 1 << 30, b"x")].concat(),
        ),
        (
            "a chunk that claims everything",
            Refused,
            file(&[raw_chunk("zstd", u64::MAX, 0, b"x")]),
        ),
        (
            "a chunk that claims a gigabyte",
            Refused,
            file(&[raw_chunk(
                "zstd",
                1 << 30,
                0,
                &zstd_frame(&[(b"", 1 << 30)], 0x38),
            )]),
        ),
        (
            "a record in a chunk that claims everything",
            Refused,
            file(&[chunk(&long_record(5, u64::MAX - 8, b"x"))]),
        ),
        (
            "a record in a packed chunk that is longer than it",
            Refused,
            file(&[raw_chunk(
                "zstd",
                12,
                0,
                &zstd_frame(&[(&long_record(3, 1 << 40, b"abc"), 0)], 0x38),
            )]),
        ),
        (
            "a chunk that is shorter than it says",
            Refused,
            file(&[raw_chunk("", 100, 0, b"x")]),
        ),
        (
            "a chunk with more than it says",
            Refused,
            file(&[raw_chunk(
                "zstd",
                10,
                0,
                &zstd_frame(&[(b"", 60 << 20)], 0x38),
            )]),
        ),
        (
            "a wrong checksum",
            Refused,
            file(&[raw_chunk("", 9, 1, &record(5, b""))]),
        ),
        ("a chunk in a chunk", Refused, file(&[chunk(&good_chunk)])),
        (
            "a footer in a chunk",
            Refused,
            file(&[chunk(&record(2, &[0; 20]))]),
        ),
        (
            "an unknown compression",
            Refused,
            file(&[raw_chunk("bz2\n\x1b[31m", 9, 0, b"x")]),
        ),
        (
            "a long name of a compression",
            Refused,
            file(&[raw_chunk(&"z".repeat(1 << 20), 9, 0, b"x")]),
        ),
        (
            "no zstd in a zstd chunk",
            Refused,
            file(&[raw_chunk("zstd", 9, 0, b"not zstd")]),
        ),
        (
            "no lz4 in an lz4 chunk",
            Refused,
            file(&[raw_chunk("lz4", 9, 0, b"not lz4")]),
        ),
        (
            "a zstd window of two gigabytes",
            Refused,
            file(&[raw_chunk("zstd", 100, 0, &zstd_frame(&[(b"", 100)], 0xa8))]),
        ),
        (
            "twenty schemas of 60 MiB",
            Refused,
            file(
                &(1..=20_u16)
                    .map(|i| {
                        bomb(
                            3,
                            &[
                                &i.to_le_bytes()[..],
                                &text(b"n"),
                                &text(b"protobuf"),
                                &(60_u32 << 20).to_le_bytes(),
                            ]
                            .concat(),
                            60 << 20,
                        )
                    })
                    .collect::<Vec<_>>(),
            ),
        ),
        (
            "sixty thousand schemas of a kilobyte",
            Refused,
            file(
                &(1..=60_000_u16)
                    .map(|i| schema(i, b"n", b"protobuf", &[0; 1000]))
                    .collect::<Vec<_>>(),
            ),
        ),
        (
            "sixty thousand channels",
            Refused,
            file(
                &(1..=60_000_u16)
                    .map(|i| channel(i, 0, format!("/{i}").as_bytes(), b"json"))
                    .collect::<Vec<_>>(),
            ),
        ),
        (
            "a channel with a name of 60 MiB",
            Refused,
            file(&[bomb(
                4,
                &[&[1, 0, 0, 0][..], &(60_u32 << 20).to_le_bytes()].concat(),
                60 << 20,
            )]),
        ),
        (
            "metadata of 60 MiB",
            Refused,
            file(&[bomb(12, &text(b"eliteserver"), 60 << 20)]),
        ),
        (
            "an attachment of 60 MiB",
            Refused,
            [MAGIC, HEADER, &long_record(9, 60 << 20, b"x")].concat(),
        ),
        (
            "a schema that lies about its length",
            Refused,
            file(&[record(
                3,
                &[
                    &[1, 0][..],
                    &text(b"n"),
                    &text(b"p"),
                    &u32::MAX.to_le_bytes(),
                ]
                .concat(),
            )]),
        ),
        (
            "a string that lies about its length",
            Refused,
            file(&[record(
                4,
                &[&[1, 0, 0, 0][..], &u32::MAX.to_le_bytes()].concat(),
            )]),
        ),
        (
            "a channel without its schema",
            Refused,
            file(&[channel(1, 77, b"/cycle", b"protobuf")]),
        ),
        (
            "a message without its channel",
            Refused,
            file(&[message(99, 0, b"x")]),
        ),
        (
            "the same channel twice, differing",
            Refused,
            file(&[
                channel(1, 0, b"/a", b"json"),
                channel(1, 0, b"/cycle", b"json"),
            ]),
        ),
        (
            "the same schema twice, differing",
            Refused,
            file(&[schema(1, b"a", b"x", b"1"), schema(1, b"a", b"x", b"2")]),
        ),
        (
            "a schema of number 0",
            Refused,
            file(&[schema(0, b"a", b"x", b"1")]),
        ),
        (
            "a name that is no text",
            Refused,
            file(&[channel(1, 0, b"/\xff\xfe", b"json")]),
        ),
        (
            "records of unknown kinds",
            Any,
            file(&[record(0x77, b"x"), record(0xff, b"y"), declarations().0]),
        ),
        ("records of kind 0", Refused, file(&[record(0, b"")])),
        ("no cycles", Any, file(&[declarations().0])),
        (
            "cycles without a schema",
            Any,
            file(&[
                channel(1, 0, b"/cycle", b"protobuf"),
                message(1, 0, &cycle(1, 0.004, &[])),
            ]),
        ),
        (
            "cycles in JSON",
            Any,
            file(&[channel(1, 0, b"/cycle", b"json"), message(1, 0, b"{}")]),
        ),
        ("an empty cycle", Any, with(&[("/cycle", 0, vec![])])),
        (
            "a cycle that is cut",
            Any,
            with(&[("/cycle", 0, vec![0x1a, 0xff, 0xff, 0xff, 0xff, 0x0f])]),
        ),
        (
            "a cycle nested in itself",
            Any,
            with(&[("/cycle", 0, vec![0x0b; 60_000])]),
        ),
        (
            "a cycle of a megabyte",
            Any,
            with(&[(
                "/cycle",
                0,
                [vec![0x1a, 0x80, 0x80, 0x40], vec![0; 1 << 20]].concat(),
            )]),
        ),
        (
            "cycles that count to the end",
            Any,
            cycles([(1, 0.004), (u64::MAX, 0.008), (u64::MAX, 0.012), (0, 0.016)]),
        ),
        (
            "cycles backwards",
            Any,
            cycles((1..200).rev().map(|n| (n, n as f64 * 0.004))),
        ),
        (
            "times that are none",
            Any,
            cycles([(1, f64::NAN), (2, f64::INFINITY), (3, -1e300), (4, 1e300)]),
        ),
        (
            "times beyond all reason",
            Any,
            cycles([(1, 0.0), (2, 1e17), (3, 1e300), (4, f64::MAX)]),
        ),
        (
            "times a breath apart",
            Any,
            cycles([
                (1, 1.0),
                (2, 1.0 + f64::EPSILON),
                (3, 1.0 + 2.0 * f64::EPSILON),
            ]),
        ),
        (
            "values that are none",
            Any,
            with(
                &(1..50_u64)
                    .map(|n| {
                        let wild = [
                            f64::NAN,
                            f64::INFINITY,
                            f64::MAX,
                            f64::MIN_POSITIVE,
                            -f64::MAX,
                            0.0,
                        ];
                        (
                            "/cycle",
                            n * 4_000_000,
                            cycle(
                                n,
                                n as f64 * 0.004,
                                &(3..8).flat_map(|f| vector(f, &wild)).collect::<Vec<_>>(),
                            ),
                        )
                    })
                    .collect::<Vec<_>>(),
            ),
        ),
        (
            "jumps of a million cycles",
            Any,
            cycles((0..400).map(|n| (n * 999_999, n as f64))),
        ),
        (
            "a time stamp at the end of time",
            Any,
            with(&[
                ("/cycle", u64::MAX, cycle(1, 0.004, &[])),
                ("/log", u64::MAX, vec![]),
            ]),
        ),
        (
            "a command that is no JSON",
            Any,
            json("/command", "{\"id\": "),
        ),
        (
            "a command of another shape",
            Any,
            json("/command", "{\"id\": \"x\", \"name\": 3}"),
        ),
        (
            "a command nobody knows",
            Any,
            json(
                "/command",
                "{\"id\":1,\"cycle\":1,\"name\":\"dance\",\"arguments\":{},\"program\":\"\",\"line\":1}",
            ),
        ),
        (
            "arguments beyond all reason",
            Any,
            json(
                "/command",
                concat!(
                    r#"{"id":1,"cycle":1,"name":"movej","arguments":{"#,
                    r#""target":[1e308,1e308,1e308,1e308,1e308,1e308],"acceleration":-1,"#,
                    r#""speed":1e999,"duration":-5,"radius":1e300},"program":"","line":1}"#
                ),
            ),
        ),
        ("deep JSON", Any, json("/command", &"[".repeat(60_000))),
        (
            "wide JSON",
            Any,
            json(
                "/script",
                &format!("{{\"program\":\"x\",\"more\":[{}0]}}", "0,".repeat(5 << 20)),
            ),
        ),
        (
            "JSON that is no text",
            Any,
            with(&[
                ("/cycle", 0, cycle(1, 0.004, &[])),
                ("/script", 0, b"\"\xff\xff\"".to_vec()),
            ]),
        ),
        (
            "a log that is none",
            Any,
            with(&[
                ("/cycle", 0, cycle(1, 0.004, &[])),
                ("/log", 0, vec![0xff; 100]),
            ]),
        ),
        ("a schema that is none", Any, foreign(&[0xff; 100], b"x")),
        ("a schema without the message", Any, foreign(b"", b"x")),
        (
            "a schema with itself inside",
            Any,
            foreign(&recursive_schema(), &[0x0a, 0x02].repeat(200)),
        ),
        (
            "a message of empty messages",
            Any,
            foreign(&recursive_schema(), &[0x0a, 0x00].repeat(8 << 20)),
        ),
        ("a setup without an arm", Any, setup("model", "no such arm")),
        ("a setup of a later version", Refused, setup("format", "9")),
        (
            "a setup with a step of nothing",
            Any,
            setup("step_time", "0"),
        ),
        (
            "a setup with a step that is none",
            Any,
            setup("step_time", "NaN"),
        ),
        (
            "a setup with a step of years",
            Any,
            setup("step_time", "1e300"),
        ),
        (
            "a setup with a wild home",
            Any,
            setup("home", "1e300,NaN,inf,-inf,0,0"),
        ),
        ("a deep URDF", Any, setup("urdf", &deep_xml)),
        ("a deep cell file", Any, setup("cell", &deep_toml)),
        (
            "programs that never end",
            Any,
            many("/script", 100, |i, id| {
                let text = "x = 1\n".repeat(10_000);
                let json = format!("{{\"program\":\"p{i}\",\"program_id\":{i},\"text\":{text:?}}}");
                message(id, i as u64, json.as_bytes())
            }),
        ),
        (
            "commands without cycles",
            Any,
            many("/command", 5, |i, id| {
                (0..300).flat_map(|n| {
                    let json = format!("{{\"id\":{},\"cycle\":9,\"name\":\"n{n}\",\"arguments\":{{\"x\":[{}1]}},\
                                        \"program\":\"{}\",\"line\":1}}", i * 300 + n, "1,".repeat(2000),
                                        "p".repeat(20_000));
                    message(id, 0, json.as_bytes())
                }).collect()
            }),
        ),
        (
            "a gigabyte of log",
            Any,
            many("/log", 40, |_, id| {
                let log = [&[0x1a, 0x80, 0x80, 0x80, 0x04][..], &vec![b'x'; 8 << 20]].concat();
                [message(id, 0, &log), message(id, 0, &log)].concat()
            }),
        ),
        (
            "columns without end",
            Any,
            many("/command", 120, |i, id| {
                let fields: Vec<String> = (0..100)
                    .map(|n| format!("\"k{}{i}_{n}\":1", "k".repeat(400)))
                    .collect();
                message(id, 0, format!("{{{}}}", fields.join(",")).as_bytes())
            }),
        ),
    ]
}

fn records_of(mut data: &[u8]) -> impl Iterator<Item = &[u8]> {
    std::iter::from_fn(move || {
        let length = u64::from_le_bytes(data.get(1..9)?.try_into().unwrap()) as usize;
        let (record, rest) = data.split_at(9 + length);
        data = rest;
        Some(record)
    })
}

/// `message M { repeated M m = 1; }` in a FileDescriptorSet, by hand.
fn recursive_schema() -> Vec<u8> {
    fn field(tag: u8, data: &[u8]) -> Vec<u8> {
        [&[tag << 3 | 2, data.len() as u8][..], data].concat()
    }
    // name m, number 1, repeated, of type message, .x.M
    let m = [
        &field(1, b"m")[..],
        &[0x18, 1, 0x20, 3, 0x28, 11],
        &field(6, b".x.M"),
    ]
    .concat();
    let message = [field(1, b"M"), field(2, &m)].concat();
    let file = [
        field(1, b"x.proto"),
        field(2, b"x"),
        field(4, &message),
        field(12, b"proto3"),
    ];
    field(1, &file.concat())
}

// ---- asking

struct Outcome {
    status: Option<i32>,
    errors: String,
    took: Duration,
}

/// Asks a question in bounded memory, and gives up after a while.
fn ask(path: &Path, question: &[&str], folder: &Path) -> Outcome {
    let (picture, other) = (folder.join("out.png"), folder.join("good.mcap"));
    if question.contains(&"GOOD") && !other.exists() {
        std::fs::write(&other, good()).unwrap();
    }
    let errors = folder.join("stderr");
    let mut command = format!("ulimit -v {MEMORY_KIB}; exec \"$@\"");
    command.insert_str(0, "ulimit -c 0; ");
    let mut child = Command::new("sh")
        .args(["-c", &command, "sh"])
        .arg(eliteserver().get_program())
        .arg("replay")
        .arg(path)
        .args(question.iter().map(|word| match *word {
            "OUT.png" => picture.to_str().unwrap(),
            "GOOD" => other.to_str().unwrap(),
            word => word,
        }))
        .env("RUST_BACKTRACE", "0")
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(std::fs::File::create(&errors).unwrap())
        .spawn()
        .unwrap();
    let begin = Instant::now();
    let status = loop {
        if let Some(status) = child.try_wait().unwrap() {
            break status.code();
        }
        if begin.elapsed() > TIME_MAX {
            child.kill().unwrap();
            child.wait().unwrap();
            break None;
        }
        std::thread::sleep(Duration::from_millis(5));
    };
    let mut text = String::new();
    let _ = std::fs::File::open(&errors)
        .unwrap()
        .take(100_000)
        .read_to_string(&mut text);
    Outcome {
        status,
        errors: text,
        took: begin.elapsed(),
    }
}

/// What is wrong with an answer, if anything is.
fn complaint(expected: Answer, question: &[&str], outcome: &Outcome) -> Option<String> {
    let Outcome {
        status,
        errors,
        took,
    } = outcome;
    let sentences: Vec<&str> = errors
        .lines()
        .filter(|l| l.starts_with("eliteserver: "))
        .collect();
    let shown: String = errors.chars().take(600).collect();
    let wrong = |what: &str| Some(format!("{what} (status {status:?}, {took:.1?}): {shown}"));
    let compares = question.contains(&"--diff") || question.contains(&"--rerun");
    match status {
        None => return wrong("killed, or too slow"),
        Some(0..=2) => {}
        Some(_) => return wrong("another status"),
    }
    if errors.contains("panicked") || errors.contains("overflow") || errors.contains("memory alloc")
    {
        return wrong("a crash");
    }
    if sentences.len() > 1 || sentences.iter().any(|s| s.len() > 1500) {
        return wrong("more than a sentence");
    }
    if errors
        .chars()
        .any(|c| c.is_control() && c != '\n' && c != '\t')
    {
        return wrong("control characters");
    }
    match (expected, status) {
        (_, Some(2)) if sentences.is_empty() => wrong("status 2 without a sentence"),
        (Refused, Some(2)) | (Any, _) => None,
        (Refused, _) => wrong("not refused"),
        (Cut, Some(0)) if question.contains(&"--at") => None,
        (Cut, Some(0)) if sentences.len() == 1 => None,
        (Cut, Some(1)) if compares && sentences.len() == 1 => None,
        (Cut, Some(2)) if question == ["--csv", "/foreign"] => None,
        (Cut, _) => wrong("not told that it is cut"),
    }
}

/// Asks everything about every `of`-th file from number `first` on.
fn ask_about_files(first: usize, of: usize) {
    let folder = tempfile::tempdir().unwrap();
    let files = files();
    assert!(files.len() >= 60, "{}", files.len());
    let mut complaints = String::new();
    let mut slowest = (Duration::ZERO, String::new());
    for (number, (name, expected, bytes)) in files.iter().enumerate() {
        if number % of != first {
            continue;
        }
        let path = folder.path().join(format!("{number}.mcap"));
        std::fs::write(&path, bytes).unwrap();
        for question in QUESTIONS {
            let outcome = ask(&path, question, folder.path());
            if let Some(complaint) = complaint(*expected, question, &outcome) {
                println!("{name}, {question:?}: {complaint}");
                writeln!(complaints, "{name}, {question:?}: {complaint}").unwrap();
            }
            if outcome.took > Duration::from_secs(5) {
                println!("{name}, {question:?}: {:.1?}", outcome.took);
            }
            if outcome.took > slowest.0 {
                slowest = (outcome.took, format!("{name}, {question:?}"));
            }
        }
        std::fs::remove_file(&path).unwrap();
    }
    println!("{} files, slowest {slowest:?}", files.len());
    assert_eq!(complaints, "");
}

#[test]
fn every_question_about_a_hostile_file_is_answered_with_a_sentence() {
    ask_about_files(0, 4);
}

#[test]
fn every_question_about_a_hostile_file_is_answered_with_a_sentence_second_quarter() {
    ask_about_files(1, 4);
}

#[test]
fn every_question_about_a_hostile_file_is_answered_with_a_sentence_third_quarter() {
    ask_about_files(2, 4);
}

#[test]
fn every_question_about_a_hostile_file_is_answered_with_a_sentence_last_quarter() {
    ask_about_files(3, 4);
}

#[test]
fn what_is_no_file_is_refused_at_once() {
    let folder = tempfile::tempdir().unwrap();
    let pipe = folder.path().join("pipe");
    let made = Command::new("mkfifo").arg(&pipe).status().unwrap();
    assert!(made.success());
    let link = folder.path().join("link");
    std::os::unix::fs::symlink(folder.path().join("nowhere"), &link).unwrap();
    let round = folder.path().join("round");
    std::os::unix::fs::symlink(&round, &round).unwrap();
    let paths = [
        folder.path(),
        &pipe,
        &link,
        &round,
        Path::new("/dev/zero"),
        Path::new("/dev/full"),
        Path::new("/nowhere.mcap"),
        Path::new("/proc/self/mem"),
    ];
    for path in paths {
        for question in QUESTIONS {
            let outcome = ask(path, question, folder.path());
            assert_eq!(
                complaint(Refused, question, &outcome),
                None,
                "{path:?} {question:?}"
            );
        }
    }
}
