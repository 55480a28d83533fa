//! Values that a native holds while it works: many of them are dropped bit by bit, also where the native ends early.
//!
//! Owns nothing but the drop: a plain `Vec` of millions of values takes many milliseconds to drop, in which no other
//! script thread has a turn.

use std::ops::{Deref, DerefMut};

use crate::limits::deferred_drop;
use crate::value::{Symbol, Value};

/// What a native holds many of: values, or values with what belongs to each.
pub trait DropItem: Sized + 'static {
    /// Whether dropping it may run code of the script.
    fn may_run_script(&self) -> bool;

    /// Whether nothing goes with it.
    fn is_immediate(&self) -> bool;

    /// Drops the item.
    #[inline(always)]
    fn drop_fast(self) {
        drop(self);
    }

    /// Drops many of them, or leaves them to be dropped bit by bit.
    fn drop_all(parts: &mut Vec<Self>) {
        deferred_drop::defer_if_large(parts, Self::may_run_script);
        drop(std::mem::take(parts));
    }
}

impl DropItem for Value {
    fn may_run_script(&self) -> bool {
        deferred_drop::may_run_script(self)
    }

    #[inline(always)]
    fn is_immediate(&self) -> bool {
        self.ref_counts().is_none()
    }

    #[inline(always)]
    fn drop_fast(self) {
        self.drop_inline();
    }

    #[inline]
    fn drop_all(parts: &mut Vec<Self>) {
        deferred_drop::drop_values(parts);
    }
}

impl DropItem for u64 {
    fn may_run_script(&self) -> bool {
        false
    }

    fn is_immediate(&self) -> bool {
        true
    }
}

impl DropItem for Symbol {
    fn may_run_script(&self) -> bool {
        false
    }

    fn is_immediate(&self) -> bool {
        true
    }
}

impl<A: DropItem, B: DropItem> DropItem for (A, B) {
    fn may_run_script(&self) -> bool {
        self.0.may_run_script() || self.1.may_run_script()
    }

    fn is_immediate(&self) -> bool {
        self.0.is_immediate() && self.1.is_immediate()
    }
}

impl<A: DropItem, B: DropItem, C: DropItem> DropItem for (A, B, C) {
    fn may_run_script(&self) -> bool {
        self.0.may_run_script() || self.1.may_run_script() || self.2.may_run_script()
    }

    fn is_immediate(&self) -> bool {
        self.0.is_immediate() && self.1.is_immediate() && self.2.is_immediate()
    }
}

/// A vector of values with a drop that gives way.
#[derive(Clone, Debug)]
pub struct ValueVec<T: DropItem = Value>(Vec<T>);

impl<T: DropItem> Default for ValueVec<T> {
    #[inline]
    fn default() -> Self {
        ValueVec(Vec::new())
    }
}

impl<T: DropItem> From<Vec<T>> for ValueVec<T> {
    #[inline]
    fn from(values: Vec<T>) -> Self {
        ValueVec(values)
    }
}

impl<T: DropItem> From<ValueVec<T>> for Vec<T> {
    #[inline]
    fn from(mut values: ValueVec<T>) -> Self {
        std::mem::take(&mut values.0)
    }
}

impl ValueVec {
    /// Makes a list of the script.
    pub fn into_list(self) -> Value {
        Value::list(self.into())
    }

    /// Makes a tuple of the script.
    pub fn into_tuple(self) -> Value {
        Value::tuple(self.into())
    }
}

impl<T: DropItem> Deref for ValueVec<T> {
    type Target = Vec<T>;

    #[inline]
    fn deref(&self) -> &Vec<T> {
        &self.0
    }
}

impl<T: DropItem> DerefMut for ValueVec<T> {
    #[inline]
    fn deref_mut(&mut self) -> &mut Vec<T> {
        &mut self.0
    }
}

impl<T: DropItem> Drop for ValueVec<T> {
    #[inline]
    fn drop(&mut self) {
        if !self.0.is_empty() {
            T::drop_all(&mut self.0);
        }
    }
}

/// The values one after the other; those that nobody has taken are dropped as `ValueVec` are.
pub struct ValuesIntoIter<T: DropItem>(std::vec::IntoIter<T>);

impl<T: DropItem> IntoIterator for ValueVec<T> {
    type Item = T;
    type IntoIter = ValuesIntoIter<T>;

    #[inline]
    fn into_iter(self) -> ValuesIntoIter<T> {
        ValuesIntoIter(Vec::from(self).into_iter())
    }
}

impl<T: DropItem> Iterator for ValuesIntoIter<T> {
    type Item = T;

    #[inline]
    fn next(&mut self) -> Option<T> {
        self.0.next()
    }

    #[inline]
    fn size_hint(&self) -> (usize, Option<usize>) {
        self.0.size_hint()
    }
}

impl<T: DropItem> DoubleEndedIterator for ValuesIntoIter<T> {
    #[inline]
    fn next_back(&mut self) -> Option<T> {
        self.0.next_back()
    }
}

impl<T: DropItem> ExactSizeIterator for ValuesIntoIter<T> {}

impl<T: DropItem> Drop for ValuesIntoIter<T> {
    #[inline]
    fn drop(&mut self) {
        if self.0.len() > 0 {
            deferred_drop::defer_rest_if_large(std::mem::take(&mut self.0), T::may_run_script);
        }
    }
}

impl<'v, T: DropItem> IntoIterator for &'v ValueVec<T> {
    type Item = &'v T;
    type IntoIter = std::slice::Iter<'v, T>;

    fn into_iter(self) -> Self::IntoIter {
        self.0.iter()
    }
}
