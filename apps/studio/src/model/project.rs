//! A project: the whole request and what it is about.

use super::history::History;
use super::input::Input;
use super::photograph::Overlay;
use super::project_file::ProjectFile;
use greenstick::RequestFile;
use std::collections::BTreeSet;

/// What of a project can be changed, undone and saved.
#[derive(Debug, Clone, PartialEq)]
pub struct Content {
    /// The whole request.
    pub file: RequestFile,
    /// The photograph of a real break.
    pub photograph: Overlay,
    /// Rings, from 0, that were dragged to where they are.
    pub pinned: BTreeSet<usize>,
}

/// A project.
#[derive(Debug)]
pub struct Project {
    /// What is broken.
    pub input: Input,
    /// The whole request; its key `input` is set only as it is saved.
    pub file: RequestFile,
    /// The photograph of a real break, which the picture shows too.
    pub photograph: Overlay,
    /// Rings, from 0, that were dragged to where they are: they stay while others are dragged.
    pub pinned: BTreeSet<usize>,
    /// Its past and future.
    pub history: History<Content>,
    /// The break that changes apply to, where there are several; see [`Project::selected`].
    pub(super) selection: Option<usize>,
    /// Keys that randomising leaves alone.
    pub locked: BTreeSet<String>,
    /// Where it was saved.
    pub path: Option<String>,
    /// What was saved last, to know what would be lost.
    saved: Content,
}

impl Project {
    /// A project of an input and a request.
    pub fn new(input: Input, file: impl Into<ProjectFile>) -> Self {
        let ProjectFile {
            request: mut file,
            studio,
            ..
        } = file.into();
        file.input = None;
        let photograph = studio.photograph;
        let pinned = studio.rings.pins();
        Project {
            saved: Content {
                file: file.clone(),
                photograph: photograph.clone(),
                pinned: pinned.clone(),
            },
            input,
            file,
            photograph,
            pinned,
            history: History::default(),
            selection: None,
            locked: BTreeSet::new(),
            path: None,
        }
    }

    /// Whether there is something that was not saved.
    pub fn is_changed(&self) -> bool {
        self.file != self.saved.file
            || self.photograph != self.saved.photograph
            || self.input.made.is_some()
    }

    /// What can be changed, as it is now.
    fn content(&self) -> Content {
        Content {
            file: self.file.clone(),
            photograph: self.photograph.clone(),
            pinned: self.pinned.clone(),
        }
    }

    fn restore(&mut self, content: Content) {
        (self.file, self.photograph) = (content.file, content.photograph);
        self.pinned = content.pinned;
    }

    /// Notes that everything is saved as the project at `path`.
    pub fn mark_saved(&mut self, path: &str) {
        if self.input.made.take().is_some() {
            self.input.path = Some(ProjectFile::stem_path(path));
        }
        self.note_saved();
    }

    /// Notes that what there is now would not be lost.
    pub(crate) fn note_saved(&mut self) {
        self.saved = self.content();
    }

    /// Goes one step back; returns what it was.
    pub fn undo(&mut self) -> Option<String> {
        let mut content = self.content();
        let label = self.history.undo(&mut content)?;
        self.restore(content);
        Some(label)
    }

    /// Goes one step forward; returns what it is.
    pub fn redo(&mut self) -> Option<String> {
        let mut content = self.content();
        let label = self.history.redo(&mut content)?;
        self.restore(content);
        Some(label)
    }

    /// Lays the photograph otherwise, as one step, or, during a drag, as part of one. Returns whether anything changed.
    pub fn lay_photograph(&mut self, label: &str, next: Overlay, drag: bool) -> bool {
        if next == self.photograph {
            return false;
        }
        self.history.note(label, &self.content(), drag);
        self.photograph = next;
        true
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
        self.history.note(label, &self.content(), drag);
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
        project.undo();
        assert!(!project.is_changed());
    }
}
