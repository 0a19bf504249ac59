//! A project: the whole request and what it is about.

use super::history::History;
use super::input::Input;
use greenstick::RequestFile;
use std::collections::BTreeSet;

/// A project.
#[derive(Debug)]
pub struct Project {
    /// What is broken.
    pub input: Input,
    /// The whole request; its key `input` is set only as it is saved.
    pub file: RequestFile,
    /// Its past and future.
    pub history: History,
    /// The break that changes apply to, where there are several; see [`Project::selected`].
    pub(super) selection: Option<usize>,
    /// Keys that randomising leaves alone.
    pub locked: BTreeSet<String>,
    /// Where it was saved.
    pub path: Option<String>,
    /// The request as it was saved last, to know what would be lost.
    pub saved: RequestFile,
}

impl Project {
    /// A project of an input and a request.
    pub fn new(input: Input, mut file: RequestFile) -> Self {
        file.input = None;
        Project {
            saved: file.clone(),
            input,
            file,
            history: History::default(),
            selection: None,
            locked: BTreeSet::new(),
            path: None,
        }
    }

    /// Whether there is something that was not saved.
    pub fn is_changed(&self) -> bool {
        self.file != self.saved
    }

    /// Changes the request by `change` as one step, or, during a drag, as part of one. Where the result is not valid, nothing
    /// changes.
    ///
    /// # Errors
    /// Why the request would not be valid.
    pub fn change<E: ToString>(
        &mut self,
        label: &str,
        drag: bool,
        change: impl FnOnce(&mut RequestFile) -> Result<(), E>,
    ) -> Result<bool, String> {
        let mut next = self.file.clone();
        change(&mut next).map_err(|e| e.to_string())?;
        next.complete().map_err(|e| e.to_string())?;
        if next == self.file {
            return Ok(false);
        }
        self.history.note(label, &self.file, drag);
        self.file = next;
        Ok(true)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use greenstick::schema::Value;

    #[test]
    fn what_is_not_valid_changes_nothing() {
        let mut project = Project::new(Input::built_in(), RequestFile::default());
        let key = "break.pith_proportion";
        let message = project.set(key, &Value::Number(0.99), false).unwrap_err();
        assert!(message.contains("more than 1"), "{message}");
        assert!(!project.is_changed() && project.history.undo_label().is_none());
        assert_eq!(project.set(key, &Value::Number(0.1), false), Ok(true));
        assert!(project.is_changed());
        project.history.undo(&mut project.file);
        assert!(!project.is_changed());
    }
}
