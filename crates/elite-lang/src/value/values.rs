//! Values that a native holds while it works: many of them are dropped bit by bit, also where the native ends early.
//!
//! Owns nothing but the drop: a plain `Vec` of millions of values takes many milliseconds to drop, in which no other script
//! thread has a turn.

use std::ops::{Deref, DerefMut};

use super::{Value, trash};

/// A vector of values with a drop that gives way.
#[derive(Clone, Debug, Default)]
pub struct Values(Vec<Value>);

impl From<Vec<Value>> for Values {
    #[inline]
    fn from(values: Vec<Value>) -> Self {
        Values(values)
    }
}

impl From<Values> for Vec<Value> {
    #[inline]
    fn from(mut values: Values) -> Self {
        std::mem::take(&mut values.0)
    }
}

impl Values {
    /// As a list of the script.
    pub fn into_list(self) -> Value {
        Value::list(self.into())
    }

    /// As a tuple of the script.
    pub fn into_tuple(self) -> Value {
        Value::tuple(self.into())
    }
}

impl IntoIterator for Values {
    type Item = Value;
    type IntoIter = std::vec::IntoIter<Value>;

    fn into_iter(self) -> Self::IntoIter {
        Vec::from(self).into_iter()
    }
}

impl Deref for Values {
    type Target = Vec<Value>;

    #[inline]
    fn deref(&self) -> &Vec<Value> {
        &self.0
    }
}

impl DerefMut for Values {
    #[inline]
    fn deref_mut(&mut self) -> &mut Vec<Value> {
        &mut self.0
    }
}

impl<'v> IntoIterator for &'v Values {
    type Item = &'v Value;
    type IntoIter = std::slice::Iter<'v, Value>;

    fn into_iter(self) -> Self::IntoIter {
        self.0.iter()
    }
}

impl Drop for Values {
    #[inline]
    fn drop(&mut self) {
        if !self.0.is_empty() {
            trash::dismantle(&mut self.0);
        }
    }
}
