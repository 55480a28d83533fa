//! `_random`: the Mersenne Twister (Matsumoto and Nishimura 1998), seeded as CPython does, so that a seeded program
//! draws the same numbers. What is made of its bits is in `draw`; the classes scripts see are a script
//! (`lib/random.py`).

mod draw;

use std::cell::RefCell;
use std::rc::Rc;

use num_bigint::{BigInt, BigUint, Sign};

use super::define::{MethodDef, ModuleBuilder, instance, with_data};
use crate::eval::Evaluator;
use crate::value::data::no_values;
use crate::value::int::Int;
use crate::value::{R, Value};

/// Words of state, and the distance of the words that are combined.
const N: usize = 624;
const M: usize = 397;

pub(super) fn fill(module: &ModuleBuilder<'_, '_>) -> R<()> {
    let constructor = |ev: &Evaluator<'_>, _: &mut [Value]| {
        let twister = Rc::new(RefCell::new(MersenneTwister::new(&[0])));
        instance(ev, "_random.Random", twister)
    };
    let own: &[MethodDef] = &[
        ("random", "", |ev, args| {
            Ok(Value::Float(with(ev, args, |twister| Ok(twister.float()))?))
        }),
        ("getrandbits", "k /", bits),
        ("_seed", "key /", |ev, args| {
            let key = ev.to_int(&args[1])?.to_big();
            let words = key.magnitude().to_u32_digits();
            let words = if words.is_empty() { vec![0] } else { words };
            with(ev, args, |twister| {
                *twister = MersenneTwister::new(&words);
                Ok(Value::None)
            })
        }),
        ("_state", "", |ev, args| {
            with(ev, args, |twister| {
                let words = twister
                    .state
                    .iter()
                    .map(|word| Value::Int(i64::from(*word)));
                let index = Value::Int(twister.index as i64);
                Ok(Value::tuple(words.chain([index]).collect()))
            })
        }),
        ("_set_state", "state /", |ev, args| {
            let words: Vec<i64> = ev
                .collect(&args[1])?
                .iter()
                .map(|word| ev.index(word))
                .collect::<R<_>>()?;
            if words.len() != N + 1 || !(0..=N as i64).contains(&words[N]) {
                return Err(ev.value_error("state vector is the wrong size"));
            }
            with(ev, args, |twister| {
                for (place, word) in twister.state.iter_mut().zip(&words) {
                    *place = *word as u32;
                }
                twister.index = words[N] as usize;
                Ok(Value::None)
            })
        }),
        ("_kept", "", |ev, args| {
            let kept = with(ev, args, |twister| Ok(twister.kept))?;
            Ok(kept.map_or(Value::None, Value::Float))
        }),
        ("_keep", "value /", |ev, args| {
            let kept = match &args[1] {
                Value::None => None,
                value => Some(ev.to_f64(value)?),
            };
            with(ev, args, |twister| {
                twister.kept = kept;
                Ok(Value::None)
            })
        }),
    ];
    let methods = [own, draw::METHODS].concat();
    module.class("Random", Some(("seed?", constructor)), &methods);
    for (name, value) in [
        ("NV_MAGICCONST", 4.0 * (-0.5f64).exp() / 2f64.sqrt()),
        ("LOG4", 4f64.ln()),
        ("SG_MAGICCONST", 1.0 + 4.5f64.ln()),
        ("TWOPI", std::f64::consts::TAU),
        ("RECIP_BPF", 2f64.powi(-53)),
    ] {
        module.value(name, Value::Float(value));
    }
    module.value("BPF", Value::Int(53));
    module.functions(&[
        ("_fresh_seed", "", |ev, _| {
            let high = BigUint::from(ev.core.host.random_u64()) << 64u8;
            let seed = high | BigUint::from(ev.core.host.random_u64());
            Ok(Value::bigint(BigInt::from_biguint(Sign::Plus, seed)))
        }),
        // The methods of one instance become functions of the module.
        ("_spread", "instance names /", |ev, args| {
            let module = ev
                .core
                .modules
                .borrow()
                .iter()
                .rev()
                .find(|module| &*module.name == "random")
                .cloned();
            for name in ev.collect(&args[1])? {
                if let (Some(module), Value::Str(text)) = (&module, &name) {
                    let symbol = ev.core.symbols.intern(text.as_str());
                    module
                        .namespace
                        .set(symbol, ev.attribute(&args[0], symbol)?);
                }
            }
            Ok(Value::None)
        }),
        ("_text_key", "data /", |ev, args| {
            let Some(data) = ev.bytes_like(&args[0]) else {
                return Err(ev.type_error("a bytes-like object is required"));
            };
            // A seed becomes a number of as many bytes.
            ev.check_bits((data.len() as u64 + 64).saturating_mul(8))?;
            let mut key = ev.copy_bytes(&data)?;
            key.extend(sha512(&data));
            Ok(Value::bigint(BigInt::from_bytes_be(Sign::Plus, &key)))
        }),
    ]);
    Ok(())
}

fn with<O>(
    ev: &Evaluator<'_>,
    args: &[Value],
    act: impl FnOnce(&mut MersenneTwister) -> R<O>,
) -> R<O> {
    with_data(ev, &args[0], |twister: &Rc<RefCell<MersenneTwister>>| {
        act(&mut twister.borrow_mut())
    })
}

fn bits(ev: &Evaluator<'_>, args: &mut [Value]) -> R {
    let Int::Small(count) = ev.to_int(&args[1])? else {
        return Err(ev.value_error("number of bits is too large"));
    };
    if count < 0 {
        return Err(ev.value_error("number of bits must be non-negative"));
    }
    ev.check_bits(count as u64)?;
    with(ev, args, |twister| {
        if count == 0 {
            return Ok(Value::Int(0));
        }
        if count <= 32 {
            return Ok(Value::Int(i64::from(twister.word() >> (32 - count))));
        }
        let mut left = count;
        let mut words = Vec::new();
        while left > 0 {
            let word = twister.word();
            words.push(if left < 32 { word >> (32 - left) } else { word });
            left -= 32;
        }
        Ok(Value::bigint(BigInt::from_slice(Sign::Plus, &words)))
    })
}

struct MersenneTwister {
    state: [u32; N],
    index: usize,
    /// A number of the normal distribution that has been drawn with another one.
    kept: Option<f64>,
}

no_values!(RefCell<MersenneTwister>);

impl MersenneTwister {
    /// Seeded with a key (`init_by_array` of the reference implementation).
    fn new(key: &[u32]) -> Self {
        let mut state = [0u32; N];
        state[0] = 19_650_218;
        for i in 1..N {
            let previous = state[i - 1] ^ (state[i - 1] >> 30);
            state[i] = previous.wrapping_mul(1_812_433_253).wrapping_add(i as u32);
        }
        let (mut i, mut j) = (1, 0);
        for _ in 0..N.max(key.len()) {
            let previous = (state[i - 1] ^ (state[i - 1] >> 30)).wrapping_mul(1_664_525);
            state[i] = (state[i] ^ previous)
                .wrapping_add(key[j])
                .wrapping_add(j as u32);
            i += 1;
            j = (j + 1) % key.len();
            if i >= N {
                state[0] = state[N - 1];
                i = 1;
            }
        }
        for _ in 0..N - 1 {
            let previous = (state[i - 1] ^ (state[i - 1] >> 30)).wrapping_mul(1_566_083_941);
            state[i] = (state[i] ^ previous).wrapping_sub(i as u32);
            i += 1;
            if i >= N {
                state[0] = state[N - 1];
                i = 1;
            }
        }
        state[0] = 0x8000_0000;
        MersenneTwister {
            state,
            index: N,
            kept: None,
        }
    }

    fn refill(&mut self) {
        for i in 0..N {
            let y = (self.state[i] & 0x8000_0000) | (self.state[(i + 1) % N] & 0x7fff_ffff);
            let twist = if y & 1 == 1 { 0x9908_b0df } else { 0 };
            self.state[i] = self.state[(i + M) % N] ^ (y >> 1) ^ twist;
        }
        self.index = 0;
    }

    fn word(&mut self) -> u32 {
        if self.index >= N {
            self.refill();
        }
        let mut y = self.state[self.index];
        self.index += 1;
        y ^= y >> 11;
        y ^= (y << 7) & 0x9d2c_5680;
        y ^= (y << 15) & 0xefc6_0000;
        y ^ (y >> 18)
    }

    /// 53 random bits as a float from 0 up to 1.
    fn float(&mut self) -> f64 {
        let (a, b) = (self.word() >> 5, self.word() >> 6);
        (f64::from(a) * 67_108_864.0 + f64::from(b)) / 9_007_199_254_740_992.0
    }
}

/// SHA-512 (FIPS 180-4), which CPython mixes into seeds that are text.
fn sha512(data: &[u8]) -> [u8; 64] {
    let constants = sha512_constants();
    let mut hash: [u64; 8] = [2, 3, 5, 7, 11, 13, 17, 19].map(|prime| root_fraction(prime, 2));
    let mut message = data.to_vec();
    message.push(0x80);
    while message.len() % 128 != 112 {
        message.push(0);
    }
    message.extend((data.len() as u128 * 8).to_be_bytes());
    for block in message.chunks(128) {
        let mut w = [0u64; 80];
        for (word, bytes) in w.iter_mut().zip(block.chunks(8)) {
            *word = bytes
                .iter()
                .fold(0, |word, byte| word << 8 | u64::from(*byte));
        }
        for t in 16..80 {
            let (a, b) = (w[t - 15], w[t - 2]);
            let s0 = a.rotate_right(1) ^ a.rotate_right(8) ^ (a >> 7);
            let s1 = b.rotate_right(19) ^ b.rotate_right(61) ^ (b >> 6);
            w[t] = s1
                .wrapping_add(w[t - 7])
                .wrapping_add(s0)
                .wrapping_add(w[t - 16]);
        }
        let mut v = hash;
        for t in 0..80 {
            let [a, b, c, d, e, f, g, h] = v;
            let s1 = e.rotate_right(14) ^ e.rotate_right(18) ^ e.rotate_right(41);
            let choice = (e & f) ^ (!e & g);
            let t1 = [s1, choice, constants[t], w[t]]
                .iter()
                .fold(h, |sum, x| sum.wrapping_add(*x));
            let s0 = a.rotate_right(28) ^ a.rotate_right(34) ^ a.rotate_right(39);
            let majority = (a & b) ^ (a & c) ^ (b & c);
            let t2 = s0.wrapping_add(majority);
            v = [t1.wrapping_add(t2), a, b, c, d.wrapping_add(t1), e, f, g];
        }
        for (word, value) in hash.iter_mut().zip(v) {
            *word = word.wrapping_add(value);
        }
    }
    let mut out = [0; 64];
    for (bytes, word) in out.chunks_mut(8).zip(hash) {
        bytes.copy_from_slice(&word.to_be_bytes());
    }
    out
}

/// The round constants: fractions of the cube roots of the first 80 primes.
fn sha512_constants() -> Vec<u64> {
    let is_prime = |n: &u32| {
        (2..*n)
            .take_while(|d| d * d <= *n)
            .all(|d| !n.is_multiple_of(d))
    };
    (2..)
        .filter(is_prime)
        .take(80)
        .map(|prime| root_fraction(prime, 3))
        .collect()
}

/// The first 64 bits of the fraction of a root of a small number.
fn root_fraction(number: u32, degree: u32) -> u64 {
    let root = (BigUint::from(number) << (64 * degree)).nth_root(degree);
    root.iter_u64_digits().next().unwrap_or(0)
}
