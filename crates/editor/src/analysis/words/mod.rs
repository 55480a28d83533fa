//! The words around what editors show, in English and Chinese. Functions of the robot are described where they are
//! declared, Python's own names in `words/python`.

mod python;

pub use messages::Language;

/// The texts around what editors show, in the language of the person who reads them.
pub trait LanguageWords {
    /// What a function, type or exception of Python's own is, in one sentence.
    fn python(self, name: &str) -> Option<&'static str>;

    /// A unit as people write it.
    fn unit(self, unit: &str) -> String;
}

impl LanguageWords for Language {
    fn python(self, name: &str) -> Option<&'static str> {
        let (english, chinese) = python::sentence(name)?;
        Some(self.pick(english, chinese))
    }

    fn unit(self, unit: &str) -> String {
        unit.replace("^2", "²").replace("^3", "³")
    }
}
