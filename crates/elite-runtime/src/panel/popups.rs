//! The popups that are open (manual 9.3.2). Pure: who waits for one asks whether it is still open.

use std::collections::BTreeMap;

/// Most popups at once.
pub const POPUPS_MAX: usize = 64;

/// Number of a popup, from 1 in the order in which they were opened.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct PopupId(pub u64);

/// How a popup looks.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum PopupStyle {
    /// A message.
    #[default]
    Message,
    /// A warning.
    Warning,
    /// An error.
    Error,
}

/// One window.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Popup {
    /// The window's title.
    pub title: String,
    /// The text in the window.
    pub text: String,
    /// How the window looks.
    pub style: PopupStyle,
    /// A program waits until the window is closed.
    pub blocking: bool,
}

/// All open windows, oldest first.
#[derive(Debug, Default)]
pub struct Popups {
    last: u64,
    open: BTreeMap<PopupId, Popup>,
}

impl Popups {
    /// Opens a window. Beyond [`POPUPS_MAX`] the oldest that nobody waits for is closed; there is one, because a task
    /// has at most 65 threads that wait and closes their windows when they are stopped.
    pub fn open(&mut self, popup: Popup) -> PopupId {
        if self.open.len() >= POPUPS_MAX {
            let oldest = self.open.iter().find(|(_, open)| !open.blocking);
            if let Some(id) = oldest.map(|(id, _)| *id) {
                self.open.remove(&id);
            }
        }
        self.last += 1;
        let id = PopupId(self.last);
        self.open.insert(id, popup);
        id
    }

    /// Closes a window. False when it is not open.
    pub fn close(&mut self, id: PopupId) -> bool {
        self.open.remove(&id).is_some()
    }

    /// Closes the newest window.
    pub fn close_newest(&mut self) -> Option<Popup> {
        self.open.pop_last().map(|(_, popup)| popup)
    }

    /// True while the window is open.
    pub fn is_open(&self, id: PopupId) -> bool {
        self.open.contains_key(&id)
    }

    /// Every open window.
    pub fn all(&self) -> Vec<(PopupId, Popup)> {
        self.open.iter().map(|(id, p)| (*id, p.clone())).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn popup(text: &str, blocking: bool) -> Popup {
        Popup {
            text: text.to_owned(),
            blocking,
            ..Popup::default()
        }
    }

    #[test]
    fn a_window_somebody_waits_for_is_never_pushed_out() {
        let mut popups = Popups::default();
        let waited_for = popups.open(popup("first", true));
        for n in 0..3 * POPUPS_MAX {
            popups.open(popup(&n.to_string(), false));
        }
        assert_eq!(popups.all().len(), POPUPS_MAX);
        assert!(popups.is_open(waited_for));
        assert!(popups.close(waited_for));
        assert!(!popups.close(waited_for));
    }

    #[test]
    fn the_newest_window_is_on_top() {
        let mut popups = Popups::default();
        popups.open(popup("below", false));
        popups.open(popup("top", true));
        assert_eq!(popups.close_newest().unwrap().text, "top");
        assert_eq!(popups.close_newest().unwrap().text, "below");
        assert_eq!(popups.close_newest(), None);
    }
}
