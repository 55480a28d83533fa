//! In which order the attributes of an object were set, where that is not the order of their slots.

/// Slots of an object that has an order of its own.
const SLOTS: usize = 8;
/// Bits for a slot, whose number is counted from 1.
const BITS: u32 = 4;

/// The slots that are set, in the order in which they were; that of the slots themselves if there are none.
#[derive(Clone, Copy, Default, PartialEq, Eq, Debug)]
pub struct SlotOrder(u32);

impl SlotOrder {
    /// Whether the order is that of the slots.
    pub fn is_natural(self) -> bool {
        self.0 == 0
    }

    /// The order of these slots; None if it has no place for one of them.
    pub fn of(slots: impl IntoIterator<Item = usize>) -> Option<SlotOrder> {
        slots.into_iter().try_fold(SlotOrder(0), SlotOrder::with)
    }

    /// The order with one more slot, set last.
    pub fn with(self, slot: usize) -> Option<SlotOrder> {
        let place = BITS * self.slots().count() as u32;
        (slot < SLOTS && place < u32::BITS).then(|| SlotOrder(self.0 | (slot as u32 + 1) << place))
    }

    /// The order without a slot that is set no more.
    pub fn without(self, slot: usize) -> SlotOrder {
        // There is a place for each that was there.
        SlotOrder::of(self.slots().filter(|other| *other != slot)).unwrap_or_default()
    }

    /// The slots.
    pub fn slots(self) -> impl Iterator<Item = usize> {
        let places = (0..u32::BITS).step_by(BITS as usize);
        let numbers = places.map(move |place| self.0 >> place & ((1 << BITS) - 1));
        numbers
            .take_while(|number| *number > 0)
            .map(|number| number as usize - 1)
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)] // a test

    use super::*;

    #[test]
    fn slots_stand_as_they_were_set() {
        let order = SlotOrder::of([3, 0, 7, 1]).unwrap();
        assert!(!order.is_natural());
        assert_eq!(order.without(0).slots().collect::<Vec<_>>(), [3, 7, 1]);
        let all = SlotOrder::of([7, 6, 5, 4, 3, 2, 1, 0]).unwrap();
        assert_eq!(all.slots().collect::<Vec<_>>(), [7, 6, 5, 4, 3, 2, 1, 0]);
        assert_eq!(all.with(0), None);
        assert_eq!(order.with(8), None);
        assert!(SlotOrder::of([2]).unwrap().without(2).is_natural());
    }
}
