//! Changes of very long lists and bytearrays: the new content is made beside the old one, with safepoints, and put in
//! its place at once, so that nobody sees it half done.
//!
//! Owns how long that is worth it for, and what happens if somebody else changes the container meanwhile: it is made
//! again, and after a few times the change is done in place, in one piece. Moving items in place is faster by far, so
//! shorter containers are always changed there.

use std::ops::Range;

use super::Evaluator;
use super::bulk::{BULK_CHUNK, CHUNK, WORK_PER_BYTE, bulk_work};
use super::pace::WORK_PER_VALUE;
use crate::builtins::types::insertion_place;
use crate::ops::item::slice::{SliceArgs, SliceBounds};
use crate::value::{ByteArray, List, R, Value, ValueVec, trash};

/// Items that are moved in place.
const IN_PLACE_MOVE_MAX: usize = if cfg!(debug_assertions) {
    1 << 17
} else {
    1 << 19
};
/// Items that are looked at one by one in place.
const IN_PLACE_TOUCH_MAX: usize = IN_PLACE_MOVE_MAX / 8;
/// Bytes that are moved in place.
const BYTES_MAX: usize = 16 * IN_PLACE_MOVE_MAX;
/// Items that are copied between two safepoints.
const COPIED: usize = 4096;
/// How often the content is made again when somebody changes it meanwhile.
const TRIES: usize = 3;

/// A new content that is being made.
pub struct ListRebuild<'e, 'y> {
    ev: &'e Evaluator<'y>,
    list: &'e List,
    out: ValueVec,
}

impl ListRebuild<'_, '_> {
    /// Appends items of the old content, as far as they are there.
    fn copy(&mut self, range: Range<usize>) -> R<()> {
        let mut from = range.start;
        while from < range.end {
            let end = range.end.min(from + COPIED);
            let some = {
                let items = self.list.borrow();
                let some = items.get(from..end.min(items.len())).unwrap_or_default();
                self.out.extend_from_slice(some);
                some.len()
            };
            self.ev.charge((some + 1) * WORK_PER_VALUE)?;
            if some < end - from {
                break;
            }
            from = end;
        }
        Ok(())
    }

    fn push(&mut self, items: &[Value]) -> R<()> {
        self.ev.copy_values(items, &mut self.out)
    }
}

impl Evaluator<'_> {
    /// Drops values, many of them bit by bit.
    pub fn drop_values(&self, mut values: Vec<Value>) {
        trash::drop_values(&mut values);
    }

    /// Puts what `make` makes, `length` items, in the place of a list's content, and gives back the old one. None if
    /// there is no room for it, or others keep changing the list.
    fn rebuild_list(
        &self,
        list: &List,
        length: usize,
        make: impl Fn(&mut ListRebuild<'_, '_>) -> R<()>,
    ) -> R<Option<Vec<Value>>> {
        for _ in 0..TRIES {
            let before = list.change_count();
            let Ok(out) = self.try_with_capacity(length) else {
                return Ok(None);
            };
            let mut beside = ListRebuild {
                ev: self,
                list,
                out: out.into(),
            };
            make(&mut beside)?;
            if list.change_count() == before {
                return Ok(Some(list.replace_all(beside.out.into())));
            }
        }
        Ok(None)
    }

    /// Puts an item before number `index`, which may count from the end or lie outside.
    pub fn list_insert(&self, list: &List, index: i64, item: Value) -> R<()> {
        let place = |length| insertion_place(index, length);
        let length = list.len();
        if length - place(length) > IN_PLACE_MOVE_MAX {
            let old = self.rebuild_list(list, length + 1, |beside| {
                let at = place(list.len());
                beside.copy(0..at)?;
                beside.push(std::slice::from_ref(&item))?;
                beside.copy(at..usize::MAX)
            })?;
            if let Some(old) = old {
                self.drop_values(old);
                return Ok(());
            }
        }
        self.grow_list(list, 1)?;
        list.change(|items| items.insert(place(items.len()), item));
        Ok(())
    }

    /// Takes out item number `index`, which may count from the end; None if there is none.
    pub fn list_remove(&self, list: &List, index: i64) -> R<Option<Value>> {
        let length = list.len();
        if let Some(place) = self.place(index, length)
            && length - place > IN_PLACE_MOVE_MAX
        {
            let at = || self.place(index, list.len()).unwrap_or(usize::MAX - 1);
            let old = self.rebuild_list(list, length, |beside| {
                beside.copy(0..at())?;
                beside.copy(at() + 1..usize::MAX)
            })?;
            if let Some(old) = old {
                let removed = self.place(index, old.len());
                let removed = removed.and_then(|place| old.get(place).cloned());
                self.drop_values(old);
                return Ok(removed);
            }
        }
        Ok(list.change(|items| {
            let place = self.place(index, items.len())?;
            Some(items.remove(place))
        }))
    }

    /// Turns a list around.
    pub fn list_reverse(&self, list: &List) -> R<()> {
        let length = list.len();
        if length > IN_PLACE_MOVE_MAX {
            let old = self.rebuild_list(list, length, |beside| {
                let mut end = list.len();
                while end > 0 {
                    let from = end.saturating_sub(COPIED);
                    let first = beside.out.len();
                    beside.copy(from..end)?;
                    beside.out[first..].reverse();
                    end = from;
                }
                Ok(())
            })?;
            if let Some(old) = old {
                self.drop_values(old);
                return Ok(());
            }
        }
        list.change(|items| items.reverse());
        Ok(())
    }

    /// Appends items.
    pub fn list_append_all(&self, list: &List, items: Vec<Value>) -> R<()> {
        if list.is_empty() {
            self.drop_values(list.replace_all(items));
            return Ok(());
        }
        if items.len() > IN_PLACE_MOVE_MAX {
            let length = list.len() + items.len();
            let old = self.rebuild_list(list, length, |beside| {
                beside.copy(0..usize::MAX)?;
                beside.push(&items)
            })?;
            if let Some(old) = old {
                self.drop_values(old);
                self.drop_values(items);
                return Ok(());
            }
        }
        self.grow_list(list, items.len())?;
        list.change(|old| old.extend(items));
        Ok(())
    }

    /// Puts items in the place of a long slice; whether that is done. A slice with a step and another number of items
    /// is left to be refused.
    pub fn try_set_long_slice(
        &self,
        list: &List,
        indices: SliceArgs,
        before: SliceBounds,
        new: &[Value],
    ) -> R<bool> {
        let length = list.len();
        let bounds = indices.resolve(length);
        let long = match bounds.step {
            1 => length.saturating_sub(bounds.start as usize) + new.len() > IN_PLACE_MOVE_MAX,
            _ => new.len() > IN_PLACE_TOUCH_MAX && new.len() == bounds.len(),
        };
        if !long {
            return Ok(false);
        }
        let old = self.rebuild_list(list, length + new.len(), |beside| {
            if bounds.step == 1 {
                let bounds = before.clamp_to(list.len());
                beside.copy(0..bounds.start as usize)?;
                beside.push(new)?;
                return beside.copy(bounds.stop.max(bounds.start) as usize..usize::MAX);
            }
            beside.copy(0..usize::MAX)?;
            let places = indices.resolve(list.len());
            for (place, item) in places.indices().zip(new) {
                self.charge(WORK_PER_VALUE)?;
                if let Some(old) = beside.out.get_mut(place) {
                    *old = item.clone();
                }
            }
            Ok(())
        })?;
        Ok(old.map(|old| self.drop_values(old)).is_some())
    }

    /// Takes out the items of a long slice; whether that is done.
    pub fn try_delete_long_slice(&self, list: &List, indices: SliceArgs) -> R<bool> {
        let length = list.len();
        let bounds = indices.resolve(length);
        let count = bounds.len();
        let first = || {
            let bounds = indices.resolve(list.len());
            let first = bounds.start.min(bounds.last_index()).max(0);
            (first as usize, bounds.len())
        };
        let moved = length.saturating_sub(first().0);
        let most = match bounds.step {
            1 => IN_PLACE_MOVE_MAX,
            _ => IN_PLACE_TOUCH_MAX,
        };
        if count == 0 || moved <= most {
            return Ok(false);
        }
        let stride = usize::try_from(bounds.step.unsigned_abs()).unwrap_or(usize::MAX);
        let old = self.rebuild_list(list, length - count, |beside| {
            let (first, count) = first();
            beside.copy(0..first)?;
            let end = match stride {
                1 => first + count,
                _ => {
                    let mut at = first;
                    for _ in 1..count {
                        beside.copy(at + 1..at + stride)?;
                        at += stride;
                    }
                    at + 1
                }
            };
            beside.copy(end..usize::MAX)
        })?;
        Ok(old.map(|old| self.drop_values(old)).is_some())
    }

    /// Puts `new` in the place of a range of the bytes of a bytearray; whether that is done.
    pub fn try_splice_long_bytes(
        &self,
        bytes: &ByteArray,
        range: impl Fn(usize) -> Option<Range<usize>>,
        new: &[u8],
    ) -> R<bool> {
        self.rebuild_bytes(bytes, |before| {
            let Some(range) = range(before.len()) else {
                return Ok(None);
            };
            let stays = range.len() == new.len() && new.len() <= BYTES_MAX;
            if stays || before.len() - range.start + new.len() <= BYTES_MAX {
                return Ok(None);
            }
            let mut data = Vec::new();
            let length = before.len() - range.len() + new.len();
            if self.grow(&mut data, length).is_err() {
                return Ok(None);
            }
            self.push_bytes(&mut data, &before[..range.start])?;
            self.push_bytes(&mut data, new)?;
            self.push_bytes(&mut data, &before[range.end..])?;
            Ok(Some(data))
        })
    }

    /// Puts `new` in the places of a long slice with a step, or takes the bytes there out if there is none; whether
    /// that is done. Another number of bytes is left to be refused.
    pub fn try_set_strided_bytes(
        &self,
        bytes: &ByteArray,
        indices: SliceArgs,
        new: Option<&[u8]>,
    ) -> R<bool> {
        self.rebuild_bytes(bytes, |before| {
            let bounds = indices.resolve(before.len());
            let count = bounds.len();
            let fits = new.is_none_or(|new| new.len() == count);
            if bounds.step == 1 || count <= IN_PLACE_TOUCH_MAX || !fits {
                return Ok(None);
            }
            let mut data = Vec::new();
            if self.grow(&mut data, before.len()).is_err() {
                return Ok(None);
            }
            let Some(new) = new else {
                let ends = [bounds.start, bounds.last_index()].map(|place| place.max(0) as usize);
                let places = ends[0].min(ends[1])..=ends[0].max(ends[1]);
                let stride = usize::try_from(bounds.step.unsigned_abs()).unwrap_or(usize::MAX);
                let is_gone = |at: usize| {
                    places.contains(&at) && (at - places.start()).is_multiple_of(stride)
                };
                for (number, piece) in before.chunks(CHUNK).enumerate() {
                    let placed = (number * CHUNK..).zip(piece);
                    data.extend(
                        placed
                            .filter(|(at, _)| !is_gone(*at))
                            .map(|(_, byte)| *byte),
                    );
                    self.charge(piece.len() * WORK_PER_BYTE)?;
                }
                return Ok(Some(data));
            };
            self.push_bytes(&mut data, before)?;
            // All of these lie within what was just copied.
            let mut places = bounds.indices();
            for piece in new.chunks(CHUNK) {
                for (byte, place) in piece.iter().zip(&mut places) {
                    data[place] = *byte;
                }
                self.charge(piece.len() * WORK_PER_BYTE)?;
            }
            Ok(Some(data))
        })
    }

    /// Puts what `make` makes of the bytes that are there in their place; whether that is done. It makes nothing where
    /// they are not many, or where there is no room.
    fn rebuild_bytes(
        &self,
        bytes: &ByteArray,
        make: impl Fn(&[u8]) -> R<Option<Vec<u8>>>,
    ) -> R<bool> {
        for _ in 0..TRIES {
            let before = bytes.snapshot();
            let Some(data) = make(&before)? else {
                return Ok(false);
            };
            if bytes.replace_if_unchanged(&before, data) {
                return Ok(true);
            }
        }
        Ok(false)
    }

    /// Turns the bytes of a bytearray around.
    pub fn reverse_bytes(&self, bytes: &ByteArray) -> R<()> {
        let is_done = self.rebuild_bytes(bytes, |before| {
            let mut data = Vec::new();
            if before.len() <= BYTES_MAX || self.grow(&mut data, before.len()).is_err() {
                return Ok(None);
            }
            for piece in before.rchunks(BULK_CHUNK) {
                data.extend(piece.iter().rev());
                self.charge(bulk_work(piece.len()) * 4)?;
            }
            Ok(Some(data))
        })?;
        if is_done {
            return Ok(());
        }
        self.grow_bytes(bytes, 0)?;
        bytes.change(|data| data.reverse());
        Ok(())
    }
}
