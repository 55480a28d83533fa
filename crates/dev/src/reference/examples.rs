//! Examples of the reference: the bodies of the tests in `examples/reference`.
//!
//! A test `test_movej` is the example of `movej`; a function without a test of its own is shown in the first one that
//! calls it. Readers see what a program would have: lines for the object `test` are left out, `assert x == y` and
//! `test.near(x, y, …)` become `x  # y`, a text in three quotes stands alone. `test.raises("ValueError", lambda: call)`
//! says which calls fail, and how.

use std::path::Path;

use super::ReferenceError;

/// A test, as an example.
#[derive(Debug, PartialEq, Eq)]
pub struct Example {
    /// Name of the example: that of its test without `test_`.
    pub name: String,
    /// What readers see.
    pub shown: String,
    /// Calls that fail, with the type of the exception.
    pub errors: Vec<(String, String)>,
}

/// All of them, in the order of the names of their files.
#[derive(Debug)]
pub struct Examples(Vec<Example>);

impl Examples {
    /// Reads the `*.script` files of a folder.
    ///
    /// # Errors
    /// A file or folder that cannot be read.
    pub fn read(folder: &Path) -> Result<Self, ReferenceError> {
        let failed = |path: &Path| {
            let path = path.to_owned();
            move |source| ReferenceError::Examples { path, source }
        };
        let mut paths = Vec::new();
        for entry in std::fs::read_dir(folder).map_err(failed(folder))? {
            let path = entry.map_err(failed(folder))?.path();
            if path.extension().is_some_and(|ending| ending == "script") {
                paths.push(path);
            }
        }
        paths.sort();
        let mut found = Vec::new();
        for path in paths {
            let text = std::fs::read_to_string(&path).map_err(failed(&path))?;
            found.extend(parse(&text));
        }
        Ok(Self(found))
    }

    /// The example of a function.
    pub fn of(&self, function: &str) -> Option<&Example> {
        let own = function.replace('.', "_");
        let named = self.0.iter().find(|example| example.name == own);
        named.or_else(|| self.0.iter().find(|e| calls(&e.shown, function)))
    }

    /// The calls of a function that fail.
    pub fn errors_of<'e>(
        &'e self,
        function: &'e str,
    ) -> impl Iterator<Item = &'e (String, String)> {
        self.0
            .iter()
            .flat_map(|example| &example.errors)
            .filter(move |(call, _)| call.split('(').next() == Some(function))
    }
}

/// Whether a text calls a function, and not one whose name ends the same.
fn calls(text: &str, function: &str) -> bool {
    text.match_indices(function).any(|(at, _)| {
        let is_end = |c: char| c.is_alphanumeric() || c == '_' || c == '.';
        !text[..at].ends_with(is_end) && text[at + function.len()..].starts_with('(')
    })
}

fn parse(text: &str) -> Vec<Example> {
    let mut found: Vec<Example> = Vec::new();
    let mut is_inside = false;
    let mut is_quoted = false;
    for line in text.lines() {
        if let Some(rest) = line.strip_prefix("def test_") {
            let name = rest.split('(').next().unwrap_or("").to_owned();
            found.push(Example {
                name,
                shown: String::new(),
                errors: Vec::new(),
            });
            (is_inside, is_quoted) = (true, false);
        } else if let Some(example) = found.last_mut().filter(|_| is_inside) {
            if is_quoted {
                is_quoted = !line.contains("\"\"\"");
                if is_quoted {
                    example.show(line);
                }
            } else if line == "end" {
                is_inside = false;
            } else if line.ends_with("\"\"\"") {
                is_quoted = true;
            } else {
                example.take(line.strip_prefix("    ").unwrap_or(line));
            }
        }
    }
    found
}

impl Example {
    fn show(&mut self, line: &str) {
        self.shown.push_str(line);
        self.shown.push('\n');
    }

    /// A line of the body.
    fn take(&mut self, line: &str) {
        if let Some(rest) = line.strip_prefix("test.raises(\"") {
            if let Some((kind, call)) = rest.split_once("\", lambda: ") {
                let call = call.strip_suffix(')').unwrap_or(call);
                self.errors.push((call.to_owned(), kind.to_owned()));
            }
        } else if let Some(rest) = line.strip_prefix("test.near(") {
            let parts = arguments(rest.strip_suffix(')').unwrap_or(rest));
            if let [what, value, ..] = &parts[..] {
                self.show(&format!("{what}  # {value}"));
            }
        } else if let Some(rest) = line.strip_prefix("assert ") {
            if rest.starts_with("result.") {
                return;
            }
            match rest.split_once(" == ") {
                Some((what, value)) => self.show(&format!("{what}  # {value}")),
                None => self.show(&format!("{rest}  # True")),
            }
        } else if !line.contains("test.") {
            self.show(line);
        }
    }
}

/// The parts between commas that stand in no brackets.
fn arguments(text: &str) -> Vec<String> {
    let mut parts = vec![String::new()];
    let mut depth = 0;
    for c in text.chars() {
        match c {
            '(' | '[' | '{' => depth += 1,
            ')' | ']' | '}' => depth -= 1,
            _ => {}
        }
        if c == ',' && depth == 0 {
            parts.push(String::new());
        } else if let Some(part) = parts.last_mut() {
            part.push(c);
        }
    }
    parts.iter().map(|part| part.trim().to_owned()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_test_becomes_an_example() {
        let text = "x = 1\ndef test_movej():\n    test.set(\"a\", 1)\n    movej(q)\
            \n    test.near(f([1, 2])[0], 3, 0.1)\n    assert g(1) == True\
            \n    test.raises(\"ValueError\", lambda: movej([1]))\nend\n\ndef test_halt():\
            \n    r = test.run(\"\"\"\nhalt()\n\"\"\")\n    assert result.prints == []\nend\n";
        let [movej, halt] = &parse(text)[..] else {
            panic!("two tests")
        };
        assert_eq!(movej.shown, "movej(q)\nf([1, 2])[0]  # 3\ng(1)  # True\n");
        let error = ("movej([1])".to_owned(), "ValueError".to_owned());
        assert_eq!(movej.errors, [error]);
        assert_eq!((&*halt.name, &*halt.shown), ("halt", "halt()\n"));
        assert!(calls("x = force()", "force") && !calls("x = tcp_force()", "force"));
    }
}
