//! Fixed-size values as sequences of 64-bit words, so that the snapshot cell can hold them in atomics without unsafe
//! code.

use kinematics::{JointAccelerations, JointPositions, JointSpeeds, JointTorques, Payload, RpyPose};

use crate::{CommandId, IoConfig, MotionMode, RobotMode, SafetyMode};

/// Takes words one after the other.
pub trait WordSink {
    /// The next word.
    fn put(&mut self, word: u64);
    /// The next words: the bits of these numbers.
    fn put_numbers(&mut self, numbers: &[f64]) {
        numbers.iter().for_each(|x| self.put(x.to_bits()));
    }
}

/// Gives words one after the other.
pub trait WordSource {
    /// The next word; 0 past the end.
    fn take(&mut self) -> u64;
}

/// A value made of a fixed number of words.
pub trait FixedWords: Sized {
    /// How many.
    const COUNT: usize;
    /// Writes exactly `COUNT` words.
    fn put(&self, sink: &mut impl WordSink);
    /// Reads exactly `COUNT` words.
    fn take(source: &mut impl WordSource) -> Self;
    /// Writes several, one after the other.
    #[inline]
    fn put_all(values: &[Self], sink: &mut impl WordSink) {
        values.iter().for_each(|x| x.put(sink));
    }
}

impl FixedWords for u64 {
    const COUNT: usize = 1;
    #[inline]
    fn put(&self, sink: &mut impl WordSink) {
        sink.put(*self);
    }
    fn take(source: &mut impl WordSource) -> Self {
        source.take()
    }
}

impl FixedWords for f64 {
    const COUNT: usize = 1;
    #[inline]
    fn put(&self, sink: &mut impl WordSink) {
        sink.put(self.to_bits());
    }
    #[inline]
    fn put_all(values: &[Self], sink: &mut impl WordSink) {
        sink.put_numbers(values);
    }
    fn take(source: &mut impl WordSource) -> Self {
        f64::from_bits(source.take())
    }
}

impl<T: FixedWords + Copy + Default, const N: usize> FixedWords for [T; N] {
    const COUNT: usize = N * T::COUNT;
    #[inline]
    fn put(&self, sink: &mut impl WordSink) {
        T::put_all(self, sink);
    }
    fn take(source: &mut impl WordSource) -> Self {
        let mut out = [T::default(); N];
        out.iter_mut().for_each(|x| *x = T::take(source));
        out
    }
}

macro_rules! words_through {
    ($($type:ty as $repr:ty: $into:expr, $from:expr;)+) => {$(
        impl FixedWords for $type {
            const COUNT: usize = <$repr as FixedWords>::COUNT;
            #[inline]
            fn put(&self, sink: &mut impl WordSink) {
                let into: fn(&$type) -> $repr = $into;
                into(self).put(sink);
            }
            fn take(source: &mut impl WordSource) -> Self {
                let from: fn($repr) -> $type = $from;
                from(<$repr as FixedWords>::take(source))
            }
        }
    )+};
}

words_through! {
    bool as u64: |x| u64::from(*x), |w| w != 0;
    CommandId as u64: |x| x.0, CommandId;
    IoConfig as u64: |x| x.to_bits(), IoConfig::from_bits;
    RobotMode as u64: |x| i64::from(x.number()) as u64, |w| RobotMode::from_number(w as i32);
    SafetyMode as u64: |x| i64::from(x.number()) as u64, |w| SafetyMode::from_number(w as i32);
    MotionMode as u64: |x| i64::from(x.number()) as u64, |w| MotionMode::from_number(w as i32);
    JointPositions as [f64; 6]: |x| x.0, JointPositions;
    JointSpeeds as [f64; 6]: |x| x.0, JointSpeeds;
    JointAccelerations as [f64; 6]: |x| x.0, JointAccelerations;
    JointTorques as [f64; 6]: |x| x.0, JointTorques;
    RpyPose as [f64; 6]: |x| x.to_array(), RpyPose::from_array;
    Payload as [f64; 10]: |x| {
        let (c, i) = (x.cog, x.inertia);
        [x.mass, c[0], c[1], c[2], i[0], i[1], i[2], i[3], i[4], i[5]]
    }, |v| Payload { mass: v[0], cog: [v[1], v[2], v[3]].into(), inertia: [v[4], v[5], v[6], v[7], v[8], v[9]] };
}
