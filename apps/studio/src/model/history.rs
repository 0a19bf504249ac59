//! Undo and redo: snapshots of the whole content, one for each drag.

/// Steps that are kept.
const STEPS: usize = 500;

/// What was changed, for menus: "Undo inclination".
pub type Label = String;

/// The past and the future of what can be changed.
#[derive(Debug)]
pub struct History<T> {
    past: Vec<(Label, T)>,
    future: Vec<(Label, T)>,
    /// What the present drag changes, so that all of it is one step.
    open: Option<Label>,
}

impl<T> Default for History<T> {
    fn default() -> Self {
        History {
            past: Vec::new(),
            future: Vec::new(),
            open: None,
        }
    }
}

impl<T: Clone> History<T> {
    /// Notes a change that is about to be made to `before`. While the same `drag` goes on, it is part of the same step.
    pub fn note(&mut self, label: &str, before: &T, drag: bool) {
        let same = drag && self.open.as_deref() == Some(label);
        if !same {
            if self.past.len() == STEPS {
                self.past.remove(0);
            }
            self.past.push((label.to_owned(), before.clone()));
            self.future.clear();
        }
        self.open = drag.then(|| label.to_owned());
    }

    /// Ends the step of a drag.
    pub fn rest(&mut self) {
        self.open = None;
    }

    /// Takes the last step back as if it had never been.
    pub fn drop_step(&mut self, present: &mut T) {
        self.open = None;
        if let Some((_, before)) = self.past.pop() {
            *present = before;
        }
    }

    /// Goes one step back.
    pub fn undo(&mut self, present: &mut T) -> Option<Label> {
        self.open = None;
        let (label, before) = self.past.pop()?;
        self.future
            .push((label.clone(), std::mem::replace(present, before)));
        Some(label)
    }

    /// Goes one step forward.
    pub fn redo(&mut self, present: &mut T) -> Option<Label> {
        self.open = None;
        let (label, after) = self.future.pop()?;
        self.past
            .push((label.clone(), std::mem::replace(present, after)));
        Some(label)
    }

    /// What the next step back undoes.
    pub fn undo_label(&self) -> Option<&str> {
        self.past.last().map(|s| s.0.as_str())
    }

    /// What the next step forward does again.
    pub fn redo_label(&self) -> Option<&str> {
        self.future.last().map(|s| s.0.as_str())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use greenstick::RequestFile;

    #[test]
    fn one_drag_is_one_step() {
        let mut file = RequestFile::default();
        let start = file.clone();
        let mut history = History::default();
        for i in 1..20 {
            history.note("inclination", &file, true);
            file.common.recipe.face.inclination = f64::from(i);
        }
        history.rest();
        history.note("inclination", &file, true);
        file.common.recipe.face.inclination = 45.0;
        let end = file.clone();
        assert_eq!(history.undo(&mut file).as_deref(), Some("inclination"));
        assert_eq!(file.common.recipe.face.inclination, 19.0);
        history.undo(&mut file);
        assert_eq!((&file, history.undo_label()), (&start, None));
        assert!(history.undo(&mut file).is_none());
        history.redo(&mut file);
        history.redo(&mut file);
        assert_eq!((&file, history.redo_label()), (&end, None));
        history.note("nothing", &file, true);
        file.common.recipe.face.inclination = 1.0;
        history.drop_step(&mut file);
        assert_eq!((&file, history.redo_label()), (&end, None));
        assert_eq!(history.undo_label(), Some("inclination"));
    }
}
