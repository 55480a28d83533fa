//! Data of the library and of embedders behind an instance: of any type, by which it is asked for.
//!
//! `Any` says its type by a call and through memory, which takes longer than most methods of a `deque` do. Here the type lies
//! beside the data.

use std::any::{Any, TypeId};

/// Data of some type.
pub struct Data(Box<Typed<dyn Any>>);

/// Data beside its type.
#[repr(C)]
struct Typed<T: ?Sized> {
    id: TypeId,
    data: T,
}

impl Data {
    /// Takes data of type `T`.
    pub fn new<T: Any>(data: T) -> Self {
        let id = TypeId::of::<T>();
        Data(Box::new(Typed { id, data }))
    }

    /// The data, if it is of type `T`.
    #[inline(always)]
    pub fn get<T: Any>(&self) -> Option<&T> {
        if self.0.id != TypeId::of::<T>() {
            return None;
        }
        let typed: *const Typed<T> = std::ptr::from_ref(&*self.0).cast();
        // SAFETY: only `new` makes one, with the type of the data beside it.
        #[allow(unsafe_code)]
        let typed = unsafe { &*typed };
        Some(&typed.data)
    }
}

#[cfg(test)]
mod tests {
    use super::Data;

    #[test]
    fn data_is_of_its_own_type_only() {
        let text = Data::new(String::from("elbow"));
        assert_eq!(text.get::<String>().map(String::as_str), Some("elbow"));
        assert!(text.get::<&str>().is_none());
        assert!(text.get::<u8>().is_none());

        // Alignments other than that of the type's number.
        assert_eq!(Data::new(7_u8).get(), Some(&7_u8));
        assert_eq!(Data::new(Wide(3)).get(), Some(&Wide(3)));
        assert_eq!(Data::new(()).get(), Some(&()));
    }

    #[derive(Debug, PartialEq)]
    #[repr(align(64))]
    struct Wide(u32);
}
