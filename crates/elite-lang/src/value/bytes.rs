//! `bytes` and `bytearray`.

use std::ops::Deref;
use std::rc::Rc;

use super::ScriptCell;
use super::held::ScriptRef;

/// Immutable bytes.
pub struct Bytes {
    data: Vec<u8>,
}

impl Bytes {
    /// Takes over `data`.
    pub fn new(data: Vec<u8>) -> Self {
        Bytes { data }
    }

    /// The bytes.
    pub fn data(&self) -> &[u8] {
        &self.data
    }
}

/// The bytes of a bytearray. What is taken away in front stays until it is more than the rest, so that a queue of bytes
/// costs what its bytes cost.
#[derive(Clone, Default)]
pub struct Buffer {
    whole: Vec<u8>,
    start: usize,
}

impl Buffer {
    /// All bytes, where they begin with the first.
    fn all(&mut self) -> &mut Vec<u8> {
        if self.start > 0 {
            self.whole.drain(..std::mem::take(&mut self.start));
        }
        &mut self.whole
    }

    fn cut_front(&mut self, count: usize) {
        self.start += count.min(self.len());
        if self.start > self.len() {
            self.all();
        }
    }
}

impl From<Vec<u8>> for Buffer {
    fn from(whole: Vec<u8>) -> Self {
        Buffer { whole, start: 0 }
    }
}

impl Deref for Buffer {
    type Target = [u8];

    #[inline]
    fn deref(&self) -> &[u8] {
        // The start never lies behind the end.
        self.whole.get(self.start..).unwrap_or_default()
    }
}

/// Mutable bytes. Who goes through them with safepoints on the way takes a snapshot; who changes them meanwhile copies.
#[derive(Default)]
pub struct ByteArray {
    data: ScriptCell<Rc<Buffer>>,
}

impl ByteArray {
    /// Takes over `data`.
    pub fn new(data: Vec<u8>) -> Self {
        ByteArray {
            data: ScriptCell::new(Rc::new(data.into())),
        }
    }

    /// A look at the bytes; no script code may run before it is over.
    #[inline]
    pub fn borrow(&self) -> ScriptRef<'_, [u8]> {
        ScriptRef::map(self.data.borrow(), |data| &***data)
    }

    /// A look at the vector they lie in, at whose end there may be room.
    #[inline]
    pub fn borrow_whole(&self) -> ScriptRef<'_, Vec<u8>> {
        ScriptRef::map(self.data.borrow(), |data| &data.whole)
    }

    /// The bytes as they are now, which stay so for whoever holds this.
    #[inline]
    pub fn snapshot(&self) -> Rc<Buffer> {
        self.data.get()
    }

    /// Whether somebody holds a snapshot, so that a change would copy the bytes.
    pub fn is_shared(&self) -> bool {
        Rc::strong_count(&*self.data.borrow()) > 1
    }

    /// Changes the bytes.
    #[inline]
    pub fn change<O>(&self, change: impl FnOnce(&mut Vec<u8>) -> O) -> O {
        self.data.with_mut(|data| change(Rc::make_mut(data).all()))
    }

    /// Appends to the vector they lie in, or makes room there; its indices are not those of the bytes.
    #[inline]
    pub fn append<O>(&self, append: impl FnOnce(&mut Vec<u8>) -> O) -> O {
        self.data
            .with_mut(|data| append(&mut Rc::make_mut(data).whole))
    }

    /// Takes so many bytes away in front.
    pub fn cut_front(&self, count: usize) {
        self.data
            .with_mut(|data| Rc::make_mut(data).cut_front(count));
    }

    /// Puts other bytes in their place.
    pub fn put(&self, data: Vec<u8>) {
        self.data.put(Rc::new(data.into()));
    }

    /// Puts other bytes in the place of `before`, unless others are there by now; whether it did.
    pub fn replace_if_unchanged(&self, before: &Rc<Buffer>, copy: Vec<u8>) -> bool {
        let is_same = Rc::ptr_eq(&*self.data.borrow(), before);
        if is_same {
            self.put(copy);
        }
        is_same
    }

    /// Number of bytes.
    pub fn len(&self) -> usize {
        self.borrow().len()
    }

    /// Whether there are no bytes.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

/// The bytes of a `bytes` or `bytearray`, which stay as they are.
#[derive(Clone)]
pub enum BytesRef {
    /// The data of a `bytes`.
    Bytes(Rc<Bytes>),
    /// The data of a `bytearray`, in the state that it had.
    Snapshot(Rc<Buffer>),
}

impl Deref for BytesRef {
    type Target = [u8];

    #[inline]
    fn deref(&self) -> &[u8] {
        match self {
            BytesRef::Bytes(bytes) => bytes.data(),
            BytesRef::Snapshot(data) => data,
        }
    }
}

impl Default for BytesRef {
    fn default() -> Self {
        BytesRef::Snapshot(Rc::default())
    }
}
