//! Data of the library and of embedders behind an instance: of any type, by which it is asked for.
//!
//! `Any` says its type by a call and through memory, which takes longer than most methods of a `deque` do. Here the
//! type lies beside the data.

use std::any::{Any, TypeId};
use std::rc::Rc;

use super::Value;
use crate::limits::deferred_drop;

/// Data of some type.
pub struct NativeData(Box<TypedBox<dyn Contents>>);

/// What data of the library is made of: the values in it. Every type says so, those without values by `no_values!`;
/// what is not said does not compile. The search for cycles, and the queue that takes deep chains apart, learn it from
/// here.
pub trait Contents: Any {
    /// Runs `each` on the values it holds.
    fn visit(&self, each: &mut dyn FnMut(&Value));

    /// Gives those values away that a circle may go through, while others may be looking.
    fn clear(&self, held: &mut Vec<Value>);

    /// Gives all values away, at its end. Data that others have as well keeps them.
    fn take(&mut self, held: &mut Vec<Value>);
}

impl<T: Contents> Contents for Rc<T> {
    fn visit(&self, each: &mut dyn FnMut(&Value)) {
        // Where others have it as well, what it holds is not only its own.
        if Rc::strong_count(self) == 1 {
            (**self).visit(each);
        }
    }

    fn clear(&self, held: &mut Vec<Value>) {
        (**self).clear(held);
    }

    fn take(&mut self, held: &mut Vec<Value>) {
        if let Some(own) = Rc::get_mut(self) {
            own.take(held);
        }
    }
}

/// Types of data without values.
macro_rules! no_values {
    ($($data:ty),+) => {
        $(impl $crate::value::data::Contents for $data {
            fn visit(&self, _: &mut dyn FnMut(&$crate::value::Value)) {}

            fn clear(&self, _: &mut Vec<$crate::value::Value>) {}

            fn take(&mut self, _: &mut Vec<$crate::value::Value>) {}
        })+
    };
}
pub(crate) use no_values;

/// Data beside its type.
#[repr(C)]
struct TypedBox<T: ?Sized> {
    id: TypeId,
    data: T,
}

impl Drop for NativeData {
    fn drop(&mut self) {
        let mut held = Vec::new();
        self.0.data.take(&mut held);
        deferred_drop::drop_values(&mut held);
    }
}

impl NativeData {
    /// Runs `each` on the values it holds.
    pub fn visit(&self, each: &mut dyn FnMut(&Value)) {
        self.0.data.visit(each);
    }

    /// Lets go of them, to break circles.
    pub fn clear(&self) {
        let mut held = Vec::new();
        self.0.data.clear(&mut held);
        deferred_drop::drop_values(&mut held);
    }

    /// Takes data of type `T`.
    pub fn new<T: Contents>(data: T) -> Self {
        let id = TypeId::of::<T>();
        NativeData(Box::new(TypedBox { id, data }))
    }

    /// The data, if it is of type `T`.
    #[inline(always)]
    pub fn get<T: Any>(&self) -> Option<&T> {
        if self.0.id != TypeId::of::<T>() {
            return None;
        }
        let typed: *const TypedBox<T> = std::ptr::from_ref(&*self.0).cast();
        // SAFETY: only `new` makes one, with the type of the data beside it.
        #[allow(unsafe_code)]
        let typed = unsafe { &*typed };
        Some(&typed.data)
    }
}

#[cfg(test)]
mod tests {
    use super::NativeData;

    no_values!(String, &'static str, u8, Wide, ());

    #[test]
    fn data_is_of_its_own_type_only() {
        let text = NativeData::new(String::from("elbow"));
        assert_eq!(text.get::<String>().map(String::as_str), Some("elbow"));
        assert!(text.get::<&str>().is_none());
        assert!(text.get::<u8>().is_none());

        // Alignments other than that of the type's number.
        assert_eq!(NativeData::new(7_u8).get(), Some(&7_u8));
        assert_eq!(NativeData::new(Wide(3)).get(), Some(&Wide(3)));
        assert_eq!(NativeData::new(()).get(), Some(&()));
    }

    #[derive(Debug, PartialEq)]
    #[repr(align(64))]
    struct Wide(u32);
}
