//! Small damage to bytes that are nearly right: what gets past the first check of a decoder.

use fastrand::Rng;

/// Numbers that lengths, counts and offsets are set to.
const EXTREMES: [u64; 12] = [
    0,
    1,
    2,
    0x7f,
    0x80,
    0xff,
    0x7fff,
    0xffff,
    0x7fff_ffff,
    0xffff_ffff,
    0x7fff_ffff_ffff_ffff,
    u64::MAX,
];

/// Numbers as text.
const NUMBERS: [&str; 12] = [
    "0",
    "-1",
    "1e308",
    "1e999",
    "nan",
    "-inf",
    "99999999999999999999",
    "0x10",
    "1_0",
    "-0.0",
    "1e-320",
    ".",
];

/// One of the seeds with a few changes, or bytes from nowhere.
pub fn mutate(rng: &mut Rng, seeds: &[Vec<u8>], words: &[&[u8]], bytes_max: usize) -> Vec<u8> {
    let seed = match rng.choice(seeds) {
        Some(seed) if rng.u8(..16) > 0 => seed.as_slice(),
        // A generator makes as much of any bytes as of any others.
        None => {
            return (0..rng.usize(bytes_max / 2..=bytes_max))
                .map(|_| rng.u8(..))
                .collect();
        }
        Some(_) => return (0..rng.usize(..64)).map(|_| rng.u8(..)).collect(),
    };
    // Of a long seed a part will do.
    let mut bytes = if seed.len() > bytes_max {
        let start = rng.usize(0..seed.len() - bytes_max);
        seed[start..start + bytes_max].to_vec()
    } else {
        seed.to_vec()
    };
    // The seed as it is comes up, too.
    for _ in 0..rng.usize(0..6) {
        change(rng, &mut bytes, seeds, words);
    }
    bytes.truncate(bytes_max);
    bytes
}

fn change(rng: &mut Rng, bytes: &mut Vec<u8>, seeds: &[Vec<u8>], words: &[&[u8]]) {
    let length = bytes.len();
    let at = rng.usize(0..=length);
    let room = length - at;
    let some = rng.usize(0..=room.min(32));
    match rng.u8(..12) {
        0 if room > 0 => bytes[at] ^= 1 << rng.u8(..8),
        1 if room > 0 => bytes[at] = rng.u8(..),
        2 => drop(bytes.drain(at..at + some)),
        3 => {
            let again = bytes[at..at + some].to_vec();
            for _ in 0..rng.usize(1..40) {
                bytes.splice(at..at, again.iter().copied());
            }
        }
        4 => bytes.truncate(at),
        5 | 6 => {
            let width = [1, 2, 4, 8][rng.usize(..4)];
            let number = EXTREMES[rng.usize(..EXTREMES.len())].wrapping_add(u64::from(rng.u8(..3)));
            let big = number.to_be_bytes();
            let little = number.to_le_bytes();
            let new = if rng.bool() {
                &big[8 - width..]
            } else {
                &little[..width]
            };
            for (old, new) in bytes[at..].iter_mut().zip(new) {
                *old = *new;
            }
        }
        7 | 8 if !words.is_empty() => {
            let word = words[rng.usize(..words.len())];
            bytes.splice(at..at, word.iter().copied());
        }
        9 => {
            if let Some(other) = rng.choice(seeds).filter(|other| !other.is_empty()) {
                let from = rng.usize(0..other.len());
                let to = rng.usize(from..=other.len());
                bytes.truncate(at);
                bytes.extend_from_slice(&other[from..to]);
            }
        }
        10 => {
            // A number of a text becomes another.
            let start = bytes[at..]
                .iter()
                .position(u8::is_ascii_digit)
                .map(|found| at + found);
            if let Some(start) = start {
                let digits = bytes[start..]
                    .iter()
                    .take_while(|byte| byte.is_ascii_digit());
                let end = start + digits.count();
                let number = NUMBERS[rng.usize(..NUMBERS.len())];
                bytes.splice(start..end, number.bytes());
            }
        }
        _ => {
            let new: Vec<u8> = (0..rng.usize(1..8)).map(|_| rng.u8(..)).collect();
            bytes.splice(at..at, new);
        }
    }
}
