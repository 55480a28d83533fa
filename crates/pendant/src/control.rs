//! Who may give orders: the token that proves that somebody was let in, and the one page that has control.
//!
//! Owns the rules and nothing else. Stopping needs no control: whoever may give orders at all may stop the arm.

use std::io;

use messages::Localized;
use thiserror::Error;

/// Bytes of a token.
const TOKEN_BYTES: usize = 16;

/// What orders must carry: made anew at every start.
#[derive(Clone, PartialEq, Eq)]
pub struct Token(String);

impl Token {
    /// A token that nobody can guess.
    ///
    /// # Errors
    /// The operating system gives no random numbers.
    pub fn random() -> io::Result<Self> {
        let mut bytes = [0; TOKEN_BYTES];
        getrandom::fill(&mut bytes)?;
        Ok(Self(
            bytes.iter().map(|byte| format!("{byte:02x}")).collect(),
        ))
    }

    /// The text, to be shown to whoever may have it.
    pub fn reveal(&self) -> &str {
        &self.0
    }

    /// Whether somebody has it. Takes the same time for every wrong one.
    pub fn is(&self, given: &str) -> bool {
        let (own, given) = (self.0.as_bytes(), given.as_bytes());
        own.len() == given.len() && own.iter().zip(given).fold(0, |d, (a, b)| d | (a ^ b)) == 0
    }
}

impl core::fmt::Debug for Token {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str("Token(…)")
    }
}

/// Number of a page, from 1 in the order in which they came.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct PageId(pub u64);

/// A reason why an order is not taken, told in a sentence.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error, Localized)]
pub enum ControlError {
    /// No token, or a wrong one.
    #[error("the token is missing or wrong; the server prints it when it starts with --bind")]
    #[zh("令牌缺失或错误；服务器以 --bind 启动时会打印令牌")]
    Token,
    /// Another page has control.
    #[error("page {} has control; take control first", .0.0)]
    #[zh("页面 {} 拥有控制权；请先取得控制权", .0.0)]
    Taken(PageId),
    /// Nobody has control.
    #[error("this page has no control; take control first")]
    #[zh("此页面没有控制权；请先取得控制权")]
    NotTaken,
}

/// The desk at which one may sit.
#[derive(Debug, Default)]
pub struct ControlLock {
    last: u64,
    holder: Option<PageId>,
}

impl ControlLock {
    /// A new page.
    pub fn enter(&mut self) -> PageId {
        self.last += 1;
        PageId(self.last)
    }

    /// Who has control.
    pub const fn holder(&self) -> Option<PageId> {
        self.holder
    }

    /// A page takes control, from whoever has it. Who had it, if somebody else did.
    pub fn take(&mut self, page: PageId) -> Option<PageId> {
        self.holder.replace(page).filter(|holder| *holder != page)
    }

    /// A page gives control up, or is gone. True when it had it.
    pub fn leave(&mut self, page: PageId) -> bool {
        let had = self.holder == Some(page);
        if had {
            self.holder = None;
        }
        had
    }

    /// Whether a page may give orders.
    ///
    /// # Errors
    /// [`ControlError`] says who may.
    pub fn check(&self, page: PageId) -> Result<(), ControlError> {
        match self.holder {
            Some(holder) if holder == page => Ok(()),
            Some(holder) => Err(ControlError::Taken(holder)),
            None => Err(ControlError::NotTaken),
        }
    }

    /// Whether a program that has no page may give orders: while no page has control.
    ///
    /// # Errors
    /// [`ControlError`] says who has.
    pub fn check_visitor(&self) -> Result<(), ControlError> {
        self.holder
            .map_or(Ok(()), |holder| Err(ControlError::Taken(holder)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_page_has_control_at_a_time() {
        let mut desk = ControlLock::default();
        let (a, b) = (desk.enter(), desk.enter());
        assert_eq!(desk.check(a), Err(ControlError::NotTaken));
        assert_eq!(desk.check_visitor(), Ok(()));
        assert_eq!(desk.take(a), None);
        assert_eq!(desk.take(a), None);
        assert_eq!(
            (desk.check(a), desk.check(b)),
            (Ok(()), Err(ControlError::Taken(a)))
        );
        assert_eq!(desk.check_visitor(), Err(ControlError::Taken(a)));
        assert_eq!(desk.take(b), Some(a));
        assert!(!desk.leave(a));
        assert_eq!(desk.holder(), Some(b));
        assert!(desk.leave(b));
        assert_eq!(desk.check(b), Err(ControlError::NotTaken));
    }

    #[test]
    fn a_token_is_long_differs_every_time_and_is_not_shown_by_accident() {
        let (a, b) = (Token::random().unwrap(), Token::random().unwrap());
        assert_ne!(a, b);
        assert_eq!(a.reveal().len(), 32);
        assert!(a.is(a.reveal()) && !a.is(b.reveal()) && !a.is("") && !a.is(&a.reveal()[1..]));
        assert!(!format!("{a:?}").contains(a.reveal()));
    }
}
