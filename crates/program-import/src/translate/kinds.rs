//! What kinds of values an expression or a variable can have, as far as the text tells.
//!
//! Poses and joint positions are both lists of six numbers here, so the difference must be found before the program
//! runs.

/// Kinds of values, as a set.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Kinds(u8);

impl Kinds {
    /// A number.
    pub const NUMBER: Self = Self(1);
    /// A truth value.
    pub const BOOL: Self = Self(2);
    /// A text.
    pub const TEXT: Self = Self(4);
    /// A list, joint positions among them.
    pub const LIST: Self = Self(8);
    /// A pose.
    pub const POSE: Self = Self(16);
    /// A structure with fields.
    pub const STRUCT: Self = Self(32);
    /// A handle for remote calls.
    pub const HANDLE: Self = Self(64);

    /// Both sets.
    pub const fn or(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }

    /// Whether a member of the other set is in this one.
    pub const fn has(self, other: Self) -> bool {
        self.0 & other.0 != 0
    }

    /// Whether nothing is known.
    pub const fn is_unknown(self) -> bool {
        self.0 == 0
    }
}

/// Kinds of a value, of its items, and of the items of those.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Type {
    /// Of the value.
    pub own: Kinds,
    /// Of its items.
    items: Kinds,
    /// Of the items of its items.
    inner: Kinds,
}

impl Type {
    /// A value without items.
    pub const fn of(own: Kinds) -> Self {
        Self {
            own,
            items: Kinds(0),
            inner: Kinds(0),
        }
    }

    /// A list of such items.
    pub const fn list(item: Self) -> Self {
        Self {
            own: Kinds::LIST,
            items: item.own,
            inner: item.items,
        }
    }

    /// An item of it.
    pub const fn item(self) -> Self {
        // A pose has numbers.
        let numbers = match self.own.has(Kinds::POSE) {
            true => Kinds::NUMBER,
            false => Kinds(0),
        };
        Self {
            own: self.items.or(numbers),
            items: self.inner,
            inner: Kinds(0),
        }
    }

    /// Values of either type.
    pub const fn or(self, other: Self) -> Self {
        Self {
            own: self.own.or(other.own),
            items: self.items.or(other.items),
            inner: self.inner.or(other.inner),
        }
    }

    /// Whether it is a pose and nothing else.
    pub const fn is_pose(self) -> bool {
        self.own.0 == Kinds::POSE.0
    }

    /// Whether it is a list and nothing else.
    pub const fn is_list(self) -> bool {
        self.own.0 == Kinds::LIST.0
    }

    /// Whether it may be a pose and may be something else.
    pub const fn is_mixed(self) -> bool {
        self.own.has(Kinds::POSE) && !self.is_pose()
    }

    /// Whether a copy of it can be changed without the original: numbers, texts and truth values cannot be changed at
    /// all.
    pub const fn is_shared(self) -> bool {
        self.own.is_unknown() || self.own.has(Kinds(8 | 16 | 32))
    }

    /// Whether its items can be changed.
    pub const fn has_shared_items(self) -> bool {
        self.items.has(Kinds(8 | 16 | 32)) || self.own.has(Kinds::STRUCT) || self.own.is_unknown()
    }
}
