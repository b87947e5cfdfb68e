//! What is wrong with a mission file, and where, in words.

use std::fmt;
use std::path::{Path, PathBuf};

/// Some bytes of one of the files of a mission.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Place {
    /// Number of the file in [`Sources`]; 0 is the mission itself, 1 its base, and so on.
    pub file: usize,
    /// First byte.
    pub start: usize,
    /// Byte after the last.
    pub end: usize,
}

/// The files that a mission was read from.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub(super) struct Sources {
    pub files: Vec<(PathBuf, String)>,
}

impl Sources {
    /// The path of file number `file`.
    pub fn path(&self, file: usize) -> &Path {
        self.files.get(file).map_or(Path::new(""), |(path, _)| path)
    }

    /// Line, column (both from 1, in characters) and text of the line in which `place` begins.
    fn locate(&self, place: Place) -> (usize, usize, &str) {
        let text = self.files.get(place.file).map_or("", |(_, text)| text);
        let before = text.get(..place.start.min(text.len())).unwrap_or(text);
        let line_start = before.rfind('\n').map_or(0, |newline| newline + 1);
        let line = text.get(line_start..).and_then(|rest| rest.lines().next()).unwrap_or("");
        let column = before.get(line_start..).unwrap_or("").chars().count() + 1;
        (before.matches('\n').count() + 1, column, line)
    }
}

/// One thing that is wrong with a mission.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Problem {
    /// The file.
    pub path: PathBuf,
    /// Line in it, from 1; 0 when the file as a whole is meant.
    pub line: usize,
    /// Column in that line, in characters from 1.
    pub column: usize,
    /// The key it is about, with its sections: `satellite.mass_kg`. May be empty.
    pub key: String,
    /// What is wrong.
    pub reason: String,
    /// What to do about it. May be empty.
    pub advice: String,
    /// The line itself and how many of its characters are meant.
    excerpt: Option<(String, usize)>,
}

impl Problem {
    /// Something wrong at a place; an empty one at the top means the file as a whole.
    pub(super) fn at(
        sources: &Sources,
        place: Place,
        key: impl Into<String>,
        fault: Fault,
    ) -> Self {
        if place.end == 0 {
            let key = key.into();
            return Self { key, ..Self::of_file(sources.path(place.file), fault) };
        }
        let (line, column, text) = sources.locate(place);
        let room = text.chars().count().saturating_sub(column - 1);
        let length = match place.end.saturating_sub(place.start) {
            // It goes on in the next line: only its beginning is marked.
            length if length > room => 1,
            length => length.max(1),
        };
        Self {
            path: sources.path(place.file).to_owned(),
            line,
            column,
            key: key.into(),
            reason: fault.reason,
            advice: fault.advice,
            excerpt: Some((text.to_owned(), length)),
        }
    }

    /// Something wrong with a file as a whole.
    pub(super) fn of_file(path: &Path, fault: Fault) -> Self {
        Self {
            path: path.to_owned(),
            line: 0,
            column: 0,
            key: String::new(),
            reason: fault.reason,
            advice: fault.advice,
            excerpt: None,
        }
    }
}

/// `missions/x.toml:12:1: satellite.mass_g: …`, the line, and what to do.
impl fmt::Display for Problem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:", self.path.display())?;
        if self.line > 0 {
            write!(f, "{}:{}:", self.line, self.column)?;
        }
        if !self.key.is_empty() {
            write!(f, " {}:", self.key)?;
        }
        write!(f, " {}", self.reason)?;
        if let Some((text, length)) = &self.excerpt {
            let number = self.line.to_string();
            let margin = " ".repeat(number.len());
            let indent = " ".repeat(self.column - 1);
            write!(f, "\n  {number} | {}", text.replace('\t', " "))?;
            write!(f, "\n  {margin} | {indent}{}", "^".repeat(*length))?;
        }
        if !self.advice.is_empty() {
            write!(f, "\n  {}", self.advice)?;
        }
        Ok(())
    }
}

/// What is wrong and what to do, before it is known where.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub(super) struct Fault {
    pub reason: String,
    pub advice: String,
}

impl Fault {
    pub fn new(reason: impl Into<String>) -> Self {
        Self { reason: reason.into(), advice: String::new() }
    }

    pub fn advising(reason: impl Into<String>, advice: impl Into<String>) -> Self {
        Self { reason: reason.into(), advice: advice.into() }
    }
}

/// Why a mission cannot be flown: everything that was found wrong with its files.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct MissionError {
    /// At least one, in the order of the file.
    pub problems: Vec<Problem>,
}

impl From<Problem> for MissionError {
    fn from(problem: Problem) -> Self {
        Self { problems: vec![problem] }
    }
}

impl fmt::Display for MissionError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (index, problem) in self.problems.iter().enumerate() {
            if index > 0 {
                f.write_str("\n\n")?;
            }
            write!(f, "{problem}")?;
        }
        Ok(())
    }
}

impl std::error::Error for MissionError {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_problem_shows_file_line_column_key_the_line_itself_and_advice() {
        let text = "a = 1\n  mass_g = 7100 # µ\n".to_owned();
        let sources = Sources { files: vec![("x.toml".into(), text)] };
        let place = Place { file: 0, start: 8, end: 14 };
        let fault = Fault::advising("wrong unit", "write mass_kg");
        let problem = Problem::at(&sources, place, "satellite.mass_g", fault);
        assert_eq!(
            problem.to_string(),
            "x.toml:2:3: satellite.mass_g: wrong unit\n  \
             2 |   mass_g = 7100 # µ\n    \
             |   ^^^^^^\n  write mass_kg"
        );
    }

    #[test]
    fn a_place_beyond_the_end_is_shown_at_the_end() {
        let sources = Sources { files: vec![("x.toml".into(), "a =".to_owned())] };
        let place = Place { file: 0, start: 9, end: 12 };
        let problem = Problem::at(&sources, place, "", Fault::new("cut off"));
        assert_eq!((problem.line, problem.column), (1, 4));
    }
}
