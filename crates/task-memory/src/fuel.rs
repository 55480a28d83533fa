//! Fuel: safepoints that the running script thread may still pass before it suspends.
//!
//! The counter is a field of the account, because the memory alarm withholds it: the next safepoint then finds no fuel,
//! compares the account with the limit, and gives the fuel back. A loop that only counts fuel pays nothing for memory.

use crate::account::ACCOUNT;

/// Takes one unit of the running script thread's fuel; false if none is left.
#[inline(always)]
pub fn consume_fuel() -> bool {
    ACCOUNT.with(|account| {
        let fuel = account.fuel.get();
        if fuel == 0 {
            return false;
        }
        account.fuel.set(fuel - 1);
        true
    })
}

/// Fuel that is left, withheld or not.
#[inline]
pub fn fuel() -> u32 {
    ACCOUNT.with(|account| account.suspended_fuel.get().unwrap_or(account.fuel.get()))
}

/// Sets the fuel; while the alarm stands it stays withheld.
#[inline]
pub fn set_fuel(fuel: u32) {
    ACCOUNT.with(|account| match account.suspended_fuel.get() {
        Some(_) => account.suspended_fuel.set(Some(fuel)),
        None => account.fuel.set(fuel),
    });
}
