//! The order in which a sort compares: scripts see it where a comparison has effects or fails, so it is CPython's. That
//! is Tim Peters' merge sort of natural runs with galloping (CPython's `listsort.txt`), merged in the order that Munro
//! and Wild's powersort gives (2018, "Nearly-optimal mergesorts").
//!
//! Comparisons may fail or contradict themselves: then the items are in some order, and all there.

use std::marker::PhantomData;

use crate::value::R;

/// Lengths from which on runs are shorter than the whole.
const MIN_RUN_LIMIT: usize = 64;
/// How often one side has to win before a merge gallops, at first, and how much galloping has to find to go on.
const MIN_GALLOP: usize = 7;

/// Sorts by `less`. After an error the items stand where they had come to.
pub(super) fn sort<T: Copy>(items: &mut [T], less: impl FnMut(&T, &T) -> R<bool>) -> R<()> {
    let mut merges = MergeState {
        less,
        pending: Vec::new(),
        gallop: MIN_GALLOP,
        items: PhantomData,
    };
    let (length, least) = (items.len(), least_run(items.len()));
    let mut start = 0;
    while start < length && length > 1 {
        let count = merges.run(&mut items[start..], least)?;
        merges.push_run(items, start, count)?;
        start += count;
    }
    merges.finish(items)
}

/// How long runs are made at least: for longer lists 32 to 64, so that their number is little less than a power of two.
fn least_run(mut length: usize) -> usize {
    let mut odd = 0;
    while length >= MIN_RUN_LIMIT {
        odd |= length & 1;
        length >>= 1;
    }
    length + odd
}

/// A run that waits to be merged.
struct Run {
    start: usize,
    count: usize,
    /// How deep the border to the next one lies in the tree of merges.
    power: u32,
}

struct MergeState<T, L> {
    less: L,
    pending: Vec<Run>,
    /// How often one side has to win now before a merge gallops.
    gallop: usize,
    items: PhantomData<T>,
}

impl<T: Copy, L: FnMut(&T, &T) -> R<bool>> MergeState<T, L> {
    /// Makes a run at the start of these items; its length.
    fn run(&mut self, items: &mut [T], least: usize) -> R<usize> {
        let mut count = items.len().min(2);
        if count == 2 {
            let falls = (self.less)(&items[1], &items[0])?;
            while count < items.len() && (self.less)(&items[count], &items[count - 1])? == falls {
                count += 1;
            }
            if falls {
                // Strictly falling, so turning it around keeps equal items in order.
                items[..count].reverse();
            }
        }
        let wanted = least.min(items.len());
        for next in count..wanted {
            let (mut low, mut high) = (0, next);
            while low < high {
                let middle = usize::midpoint(low, high);
                match (self.less)(&items[next], &items[middle])? {
                    true => high = middle,
                    false => low = middle + 1,
                }
            }
            items[low..=next].rotate_right(1);
        }
        Ok(count.max(wanted))
    }

    /// Takes in a new run, after the merges that come before it.
    fn push_run(&mut self, items: &mut [T], start: usize, count: usize) -> R<()> {
        if let Some(last) = self.pending.last() {
            let power = power(last.start, last.count, count, items.len());
            while let [.., before, _] = &self.pending[..]
                && before.power > power
            {
                self.merge_at(items, self.pending.len() - 2)?;
            }
            if let Some(last) = self.pending.last_mut() {
                last.power = power;
            }
        }
        self.pending.push(Run {
            start,
            count,
            power: 0,
        });
        Ok(())
    }

    fn finish(&mut self, items: &mut [T]) -> R<()> {
        while self.pending.len() > 1 {
            let mut at = self.pending.len() - 2;
            if at > 0 && self.pending[at - 1].count < self.pending[at + 1].count {
                at -= 1;
            }
            self.merge_at(items, at)?;
        }
        Ok(())
    }

    /// Merges a pending run with the next one.
    fn merge_at(&mut self, items: &mut [T], at: usize) -> R<()> {
        let next = self.pending.remove(at + 1);
        let run = &mut self.pending[at];
        let (start, border, end) = (run.start, next.start, next.start + next.count);
        run.count += next.count;
        let (first, second) = (&items[start..border], &items[border..end]);
        // What is in its place already.
        let start = start + self.place_behind(&second[0], first, 0)?;
        let Some(last) = items[start..border].last() else {
            return Ok(());
        };
        let end = border + self.place_before(last, second, second.len() - 1)?;
        if end == border {
            return Ok(());
        }
        let mut merge = Merge::new(&items[start..border], &items[border..end]);
        let result = self.merge(&mut merge);
        merge.put_into(&mut items[start..end]);
        result
    }

    /// Takes from the shorter side's end of two runs, item by item or, while one side wins again and again, by
    /// searches.
    fn merge(&mut self, merge: &mut Merge<T>) -> R<()> {
        // Whose it is has been found out before.
        merge.take(merge.backwards, 1);
        while !merge.is_over() {
            let (mut winner, mut wins) = (None, 0);
            while wins < self.gallop {
                let (first, second) = merge.heads();
                let is_less = (self.less)(second, first)?;
                let of_first = is_less == merge.backwards;
                wins = if winner == Some(of_first) {
                    wins + 1
                } else {
                    1
                };
                winner = Some(of_first);
                if merge.take(of_first, 1) {
                    return Ok(());
                }
            }
            self.gallop += 1;
            loop {
                self.gallop -= usize::from(self.gallop > 1);
                let (_, head) = merge.heads();
                let side = merge.first.left();
                let of_first = match merge.backwards {
                    false => self.place_behind(head, side, 0)?,
                    true => side.len() - self.place_behind(head, side, side.len() - 1)?,
                };
                if merge.take(true, of_first) || merge.take(false, 1) {
                    return Ok(());
                }
                let (head, _) = merge.heads();
                let side = merge.second.left();
                let of_second = match merge.backwards {
                    false => self.place_before(head, side, 0)?,
                    true => side.len() - self.place_before(head, side, side.len() - 1)?,
                };
                if merge.take(false, of_second) || merge.take(true, 1) {
                    return Ok(());
                }
                if of_first < MIN_GALLOP && of_second < MIN_GALLOP {
                    break;
                }
            }
            self.gallop += 1;
        }
        Ok(())
    }

    /// Where `key` belongs among sorted items, before those equal to it, searched from place `hint` on in steps that
    /// double.
    fn place_before(&mut self, key: &T, items: &[T], hint: usize) -> R<usize> {
        let less = &mut self.less;
        place(items.len(), hint, |at| less(&items[at], key))
    }

    /// Where `key` belongs among sorted items, behind those equal to it, searched from place `hint` on in steps that
    /// double.
    fn place_behind(&mut self, key: &T, items: &[T], hint: usize) -> R<usize> {
        let less = &mut self.less;
        place(items.len(), hint, |at| Ok(!less(key, &items[at])?))
    }
}

/// How many of `count` places pass, which are the first ones: from `hint` on in steps that double, then by halves.
fn place(count: usize, hint: usize, mut passes: impl FnMut(usize) -> R<bool>) -> R<usize> {
    // All before `low` pass, none from `high` on.
    let (mut low, mut high) = (0, count);
    let mut step = 1;
    if passes(hint)? {
        low = hint + 1;
        while hint + step < count {
            if !passes(hint + step)? {
                high = hint + step;
                break;
            }
            low = hint + step + 1;
            step = 2 * step + 1;
        }
    } else {
        high = hint;
        while step <= hint {
            if passes(hint - step)? {
                low = hint - step + 1;
                break;
            }
            high = hint - step;
            step = 2 * step + 1;
        }
    }
    while low < high {
        let middle = usize::midpoint(low, high);
        match passes(middle)? {
            true => low = middle + 1,
            false => high = middle,
        }
    }
    Ok(low)
}

/// How deep the border between two runs lies in a tree over all items whose borders lie as near to halves, quarters and
/// so on as they can: the first binary digit in which the middles of both runs, as parts of the whole, differ.
fn power(start: usize, first: usize, second: usize, length: usize) -> u32 {
    // Twice the middles, in 128 bits for what the doubling adds.
    let (mut a, length) = ((2 * start + first) as u128, length as u128);
    let mut b = a + (first + second) as u128;
    let mut power = 1;
    loop {
        if a >= length {
            a -= length;
            b -= length;
        } else if b >= length {
            return power;
        }
        (a, b, power) = (2 * a, 2 * b, power + 1);
    }
}

/// One of two runs that are merged: what is left of it.
struct MergeSide<T> {
    items: Vec<T>,
    from: usize,
    to: usize,
}

impl<T: Copy> MergeSide<T> {
    fn new(items: &[T]) -> Self {
        MergeSide {
            items: items.to_vec(),
            from: 0,
            to: items.len(),
        }
    }

    fn left(&self) -> &[T] {
        &self.items[self.from..self.to]
    }

    fn head(&self, backwards: bool) -> &T {
        match backwards {
            true => &self.items[self.to - 1],
            false => &self.items[self.from],
        }
    }
}

/// Two runs that are being merged, the shorter one of which is used up last but one: from its end on.
struct Merge<T> {
    first: MergeSide<T>,
    second: MergeSide<T>,
    /// What has been taken, backwards from the end on.
    out: Vec<T>,
    backwards: bool,
}

impl<T: Copy> Merge<T> {
    fn new(first: &[T], second: &[T]) -> Self {
        Merge {
            backwards: first.len() > second.len(),
            out: Vec::with_capacity(first.len() + second.len()),
            first: MergeSide::new(first),
            second: MergeSide::new(second),
        }
    }

    fn heads(&self) -> (&T, &T) {
        let of = |side| MergeSide::head(side, self.backwards);
        (of(&self.first), of(&self.second))
    }

    /// Takes some items from the end of one side; whether the merge is over.
    fn take(&mut self, of_first: bool, count: usize) -> bool {
        let side = match of_first {
            true => &mut self.first,
            false => &mut self.second,
        };
        if self.backwards {
            let taken = &side.items[side.to - count..side.to];
            self.out.extend(taken.iter().rev());
            side.to -= count;
        } else {
            let taken = &side.items[side.from..side.from + count];
            self.out.extend(taken);
            side.from += count;
        }
        self.is_over()
    }

    /// Whether where the rest belongs is known: the side that is not copied in CPython is used up, or the other one but
    /// for an item, the last of all.
    fn is_over(&self) -> bool {
        let (first, second) = (self.first.left().len(), self.second.left().len());
        match self.backwards {
            true => first == 0 || second <= 1,
            false => second == 0 || first <= 1,
        }
    }

    /// Puts everything into the place of both runs; where a comparison has failed, what is left of them as it stood.
    fn put_into(mut self, whole: &mut [T]) {
        let (first, second) = (self.first.left(), self.second.left());
        let rest = match self.is_over() {
            true => [second, first],
            false => [first, second],
        };
        if self.backwards {
            self.out.reverse();
        }
        let parts = match self.backwards {
            true => [rest[0], rest[1], &self.out],
            false => [&self.out, rest[0], rest[1]],
        };
        for (place, item) in whole.iter_mut().zip(parts.into_iter().flatten()) {
            *place = *item;
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)] // a test

    use super::*;

    #[test]
    fn sorts_as_the_standard_library_does() {
        let mut state = 1u64;
        for length in (0..200).chain([1000, 5000]) {
            for spread in [2, 10, 1 << 30] {
                let items: Vec<(u64, usize)> = (0..length)
                    .map(|place| {
                        state = state.wrapping_mul(6364136223846793005).wrapping_add(1);
                        // Parts that are sorted already.
                        let drawn = (state >> 33) % spread;
                        (if place % 97 > 50 { place as u64 } else { drawn }, place)
                    })
                    .collect();
                let mut expected = items.clone();
                expected.sort_by_key(|item| item.0);
                let mut sorted = items;
                sort(&mut sorted, |a, b| Ok(a.0 < b.0)).unwrap();
                assert_eq!(sorted, expected, "{length} {spread}");
            }
        }
    }

    #[test]
    fn nothing_is_lost_by_comparisons_that_fail_or_lie() {
        for length in [0, 1, 2, 63, 64, 65, 200, 1000] {
            for rule in 0..6usize {
                let mut items: Vec<usize> = (0..length).map(|i| i * 7919 % 1013).collect();
                let mut expected = items.clone();
                expected.sort_unstable();
                let mut count = 0;
                let result = sort(&mut items, |a, b| {
                    count += 1;
                    match rule {
                        0 => Ok(true),
                        1 => Ok(false),
                        2 => Ok(count % 3 == 0),
                        3 => Ok(a % 5 < b % 7),
                        _ if count > length * rule / 2 => Err(crate::value::Unwind::Stop),
                        _ => Ok(a < b),
                    }
                });
                assert!(rule > 3 || result.is_ok());
                items.sort_unstable();
                assert_eq!(items, expected, "{length} {rule}");
            }
        }
    }
}
