//! The global variables of configurations: what they are now, what a task begins with, and the file that keeps them.
//!
//! A variable is neither as in its file nor as a program sets it first, but what the last run or the dashboard left.
//! Owns these values; their places in files and programs are `elite_runtime::configuration_variables`.

use std::collections::{BTreeMap, BTreeSet};

use elite_runtime::Preset;
use elite_runtime::configuration_variables::{
    Variable, configuration_of, in_program, rewritten, variables, with_values,
};
use elite_runtime::task_folder::TaskFolder;
use motion_api::ProgramId;

use crate::ready_file;

/// Configurations whose variables are kept at once.
const CONFIGURATIONS_MAX: usize = 32;

/// The variables of one configuration, or of a task that has none.
#[derive(Debug, Default)]
struct VariableSet {
    values: Vec<Variable>,
    /// The file that they are in, and its text.
    file: Option<(String, String)>,
    /// A generated program begins with all of them; one that is written by hand with those that were set at the
    /// dashboard, once.
    is_generated: bool,
    set: BTreeSet<String>,
}

/// All of them, and the program whose last values have not been taken yet.
#[derive(Debug, Default)]
pub(super) struct ConfigurationVariables {
    kept: BTreeMap<String, VariableSet>,
    /// Name of the loaded task's configuration.
    loaded: Option<String>,
    running: Option<(ProgramId, String)>,
}

/// How a task begins.
pub(super) struct TaskStart {
    /// Text of the task with the current values.
    pub text: String,
    /// Variables that the text does not set.
    pub presets: Vec<Preset>,
}

impl ConfigurationVariables {
    /// A task was loaded: its configuration's file is read, unless it is as it was. A `shipped` task of the server's
    /// own has variables as a generated one has.
    pub fn load(&mut self, folder: &TaskFolder, task: &str, shipped: Option<&str>) {
        let xml = match shipped {
            Some(_) => None,
            None => xml_of(folder, task),
        };
        let is_generated = xml.is_some() || shipped.is_some();
        let named = xml.as_deref().and_then(configuration_of);
        let file = is_generated
            .then(|| find_file(folder, task, named))
            .flatten();
        let key = file
            .as_ref()
            .map_or_else(|| task.to_owned(), |(name, _)| name.clone());
        self.loaded = Some(key.clone());
        let is_known = self.kept.get(&key).is_some_and(|kept| {
            let text =
                |file: &Option<(String, String)>| file.as_ref().map(|(_, text)| text.clone());
            kept.is_generated == is_generated && text(&kept.file) == text(&file)
        });
        if is_known {
            return;
        }
        let values = match (&file, &xml) {
            (Some((name, text)), _) => variables(text).unwrap_or_else(|error| {
                tracing::warn!("{name}: {error}");
                Vec::new()
            }),
            (None, Some(_)) => folder
                .task(task)
                .map(|task| in_program(&task.text))
                .unwrap_or_default(),
            (None, None) => shipped.map(in_program).unwrap_or_default(),
        };
        // A literal is put into programs; what is none stays out.
        let values = values
            .into_iter()
            .filter(|v| is_literal(&v.name, &v.value))
            .collect();
        while self.kept.len() >= CONFIGURATIONS_MAX {
            self.kept.pop_first();
        }
        let kept = VariableSet {
            values,
            file,
            is_generated,
            set: BTreeSet::new(),
        };
        self.kept.insert(key, kept);
    }

    fn of_loaded(&mut self) -> Option<&mut VariableSet> {
        self.kept.get_mut(self.loaded.as_ref()?)
    }

    /// The value of a variable of the loaded task.
    pub fn value(&mut self, name: &str) -> Option<String> {
        let kept = self.of_loaded()?;
        let found = kept.values.iter().find(|known| known.name == name);
        found.map(|variable| variable.value.clone())
    }

    /// Sets a variable of the loaded task, which has it, or whose last run did.
    pub fn set(
        &mut self,
        folder: &TaskFolder,
        name: &str,
        value: &str,
        was_seen: bool,
    ) -> Result<(), String> {
        let Some(kept) = self.of_loaded() else {
            return Err(format!("variable {name} is undefined: no task is loaded"));
        };
        let known = kept.values.iter_mut().find(|known| known.name == name);
        if known.is_none() && !was_seen {
            return Err(format!("variable {name} is undefined"));
        }
        if !is_literal(name, value) {
            return Err(format!("{value} is no value"));
        }
        match known {
            Some(known) => value.clone_into(&mut known.value),
            None => kept.values.push(Variable {
                name: name.to_owned(),
                value: value.to_owned(),
            }),
        }
        kept.set.insert(name.to_owned());
        kept.write(folder);
        Ok(())
    }

    /// What the loaded task begins with.
    pub fn beginning(&mut self, text: String) -> TaskStart {
        let Some(kept) = self.of_loaded() else {
            return TaskStart {
                text,
                presets: Vec::new(),
            };
        };
        let set = core::mem::take(&mut kept.set);
        let acts = |variable: &&Variable| kept.is_generated || set.contains(&variable.name);
        let values: BTreeMap<String, String> = kept
            .values
            .iter()
            .filter(acts)
            .map(|variable| (variable.name.clone(), variable.value.clone()))
            .collect();
        let in_text = in_program(&text);
        let is_missing = |name: &str| !in_text.iter().any(|known| known.name == name);
        let missing = values.iter().filter(|(name, _)| is_missing(name));
        let presets = missing.filter_map(|(name, value)| Preset::new(name, value).ok());
        TaskStart {
            presets: presets.collect(),
            text: with_values(&text, &values),
        }
    }

    /// The loaded task runs as this program.
    pub fn runs(&mut self, program: ProgramId) {
        self.running = self.loaded.clone().map(|key| (program, key));
    }

    /// The program whose last values are to be taken.
    pub fn running(&self) -> Option<ProgramId> {
        self.running.as_ref().map(|(program, _)| *program)
    }

    /// The program has ended with these values.
    pub fn take(&mut self, folder: &TaskFolder, last: &BTreeMap<String, String>) {
        let Some((_, key)) = self.running.take() else {
            return;
        };
        let Some(kept) = self.kept.get_mut(&key).filter(|kept| kept.is_generated) else {
            return;
        };
        let mut has_changed = false;
        for variable in &mut kept.values {
            if let Some(value) = last.get(&variable.name)
                && normal(value) != normal(&variable.value)
            {
                if is_literal(&variable.name, value) {
                    variable.value.clone_from(value);
                    has_changed = true;
                } else {
                    tracing::warn!(
                        "the variable {} has ended with a value that no file can keep; it stays {}",
                        variable.name,
                        variable.value
                    );
                }
            }
        }
        if has_changed {
            kept.write(folder);
        }
    }
}

impl VariableSet {
    /// Writes the values into their file. Where it cannot be written they are kept in memory.
    fn write(&mut self, folder: &TaskFolder) {
        let Some((name, text)) = &mut self.file else {
            return;
        };
        let pairs = self.values.iter();
        let values = pairs
            .map(|variable| (variable.name.clone(), variable.value.clone()))
            .collect();
        let changed = match rewritten(text, &values) {
            Ok(changed) if changed == *text => return,
            Ok(changed) => changed,
            Err(error) => return tracing::warn!("{name} is not written: {error}"),
        };
        match ready_file::replace(&folder.root().join(&*name), &changed) {
            Ok(()) => *text = changed,
            Err(error) => tracing::warn!("{name} is not written: {error}"),
        }
    }
}

/// The XML of a task; `None` for one that is a text.
fn xml_of(folder: &TaskFolder, task: &str) -> Option<String> {
    let names = [task.to_owned(), format!("{task}.task")];
    let mut texts = names.iter().filter_map(|name| folder.file(name).ok());
    let text = texts.next()?;
    text.trim_start_matches('\u{FEFF}')
        .trim_start()
        .starts_with('<')
        .then_some(text)
}

/// The file of variables: of the configuration that the task names, in the folder that it names or beside the task,
/// else the one that is called as the task is.
fn find_file(
    folder: &TaskFolder,
    task: &str,
    named: Option<(String, String)>,
) -> Option<(String, String)> {
    let (beside, stem) = match task.rsplit_once('/') {
        Some((beside, stem)) => (format!("{beside}/"), stem),
        None => (String::new(), task),
    };
    let stem = stem.strip_suffix(".task").unwrap_or(stem);
    let mut names = Vec::new();
    if let Some((name, directory)) = &named {
        let directory = directory.trim_matches('/');
        if !directory.is_empty() {
            names.push(format!("{directory}/{name}"));
        }
        names.push(format!("{beside}{name}"));
    }
    names.push(format!("{beside}{stem}"));
    names.into_iter().find_map(|name| {
        let name = format!("{name}.configuration.variables");
        folder.file(&name).ok().map(|text| (name, text))
    })
}

/// A literal in one way of writing it, so that a value that nobody has changed keeps the text that somebody typed.
fn normal(value: &str) -> String {
    let mut out = String::new();
    let mut word = String::new();
    let mut quote = None;
    let finish = |word: &mut String, out: &mut String| {
        let is_float = word.contains(['.', 'e', 'E']) && !word.starts_with("0x");
        match word.parse::<f64>() {
            Ok(number) if is_float => out.push_str(&format!("{number:?}")),
            _ => out.push_str(word),
        }
        word.clear();
    };
    for c in value.chars() {
        match quote {
            Some(open) if c == open => {
                quote = None;
                out.push('"');
            }
            Some(_) => out.push(c),
            None if c == '"' || c == '\'' => {
                quote = Some(c);
                out.push('"');
            }
            None if c.is_alphanumeric() || c == '.' || c == '_' => word.push(c),
            None => {
                finish(&mut word, &mut out);
                if !c.is_whitespace() {
                    out.push(c);
                }
            }
        }
    }
    finish(&mut word, &mut out);
    out
}

/// Numbers, truth values, texts, and lists of them: what a file keeps, and what a program may begin with.
fn is_literal(name: &str, value: &str) -> bool {
    let mut quote = None;
    let mut words = String::new();
    for c in value.chars() {
        match quote {
            Some(open) if c == open => quote = None,
            Some(_) => {}
            None if c == '"' || c == '\'' => quote = Some(c),
            None => words.push(c),
        }
    }
    let is_word = |word: &str| {
        matches!(word, "" | "True" | "False" | "None")
            || (word.starts_with(|c: char| c.is_ascii_digit() || c == '.')
                && word
                    .chars()
                    .all(|c| c.is_ascii_hexdigit() || matches!(c, '.' | '_' | 'x')))
    };
    let is_between = |c: char| c.is_whitespace() || "[](){},:+-".contains(c);
    words.split(is_between).all(is_word) && Preset::new(name, value).is_ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    const TASK: &str = "<EliTask name=\"cell\" installationName=\"line\"/>";
    const FILE: &str = "<VariablesManager>\
        \n  <Variable name=\"width\" value=\"100\" remarks=\"mm\" favorite=\"true\"/>\
        \n  <Variable name=\"home\" value=\"[0, 1]\" remarks=\"\" favorite=\"false\"/>\n</VariablesManager>\n";
    const SCRIPT: &str = "def cell():\n  global width\n  width = 7\n  $ 1 \"Main\"\n  pass\nend\n";

    fn ended(variables: &mut ConfigurationVariables, folder: &TaskFolder, last: &[(&str, &str)]) {
        variables.runs(ProgramId(1));
        let last = last.iter();
        let last = last.map(|(name, value)| ((*name).to_owned(), (*value).to_owned()));
        variables.take(folder, &last.collect());
    }

    #[test]
    fn a_variable_is_what_the_last_run_or_the_dashboard_left() {
        let temporary = tempfile::tempdir().unwrap();
        let write = |name: &str, text: &str| {
            std::fs::write(temporary.path().join(name), text).unwrap();
        };
        write("cell.task", TASK);
        write("cell.task.script", SCRIPT);
        write("line.configuration.variables", FILE);
        let folder = TaskFolder::new(temporary.path());
        let mut all = ConfigurationVariables::default();
        all.load(&folder, "cell.task", None);
        assert_eq!(all.value("width").as_deref(), Some("100"));
        let beginning = all.beginning(SCRIPT.to_owned());
        assert_eq!(beginning.text, SCRIPT.replace("= 7", "= 100"));
        assert_eq!(beginning.presets[0].statement(), "home = [0, 1]");

        ended(
            &mut all,
            &folder,
            &[("width", "101.5"), ("home", "<thread>"), ("other", "1")],
        );
        assert_eq!(all.value("width").as_deref(), Some("101.5"));
        assert_eq!(all.value("home").as_deref(), Some("[0, 1]"));
        let kept = std::fs::read_to_string(temporary.path().join("line.configuration.variables"));
        assert_eq!(kept.unwrap(), FILE.replace("\"100\"", "\"101.5\""));
        all.load(&folder, "cell.task", None);
        assert_eq!(all.value("width").as_deref(), Some("101.5"));

        all.set(&folder, "home", "[2, -1e-3, 'a']", false).unwrap();
        for (name, value, part) in [
            ("none", "1", "variable none is undefined"),
            ("width", "get_tcp_pose()", "is no value"),
            ("width", "1; x = 2", "is no value"),
            ("width", "", "is no value"),
            ("width", "1 2", "is no value"),
        ] {
            let error = all.set(&folder, name, value, false).unwrap_err();
            assert!(error.contains(part), "{error}");
        }
        // Changed by somebody else: it counts when the task is loaded again.
        write("line.configuration.variables", FILE);
        all.load(&folder, "cell.task", None);
        assert_eq!(all.value("width").as_deref(), Some("100"));
    }

    #[test]
    fn a_value_that_is_the_same_is_known_however_it_is_written() {
        for (typed, shown) in [
            ("834.60", "834.6"),
            ("[0,-1.5708 , 2]", "[0, -1.5708, 2]"),
            ("\"A & B\"", "'A & B'"),
            ("1e3", "1000.0"),
        ] {
            assert_eq!(normal(typed), normal(shown));
        }
        for (one, other) in [
            ("1", "1.0"),
            ("'a b'", "'ab'"),
            ("-1.5", "1.5"),
            ("12", "1, 2"),
        ] {
            assert_ne!(normal(one), normal(other));
        }
    }

    #[test]
    fn a_task_written_by_hand_begins_as_it_says_but_for_what_was_set() {
        let temporary = tempfile::tempdir().unwrap();
        let text = "global width\nwidth = 100\n";
        std::fs::write(temporary.path().join("w.script"), text).unwrap();
        let folder = TaskFolder::new(temporary.path());
        let mut all = ConfigurationVariables::default();
        assert!(all.set(&folder, "width", "1", true).is_err());
        all.load(&folder, "w.script", None);
        ended(&mut all, &folder, &[("width", "3")]);
        assert_eq!(all.beginning(text.to_owned()).text, text);
        all.set(&folder, "width", "55", true).unwrap();
        assert_eq!(
            all.beginning(text.to_owned()).text,
            "global width\nwidth = 55\n"
        );
        assert_eq!(all.beginning(text.to_owned()).text, text);
    }
}
