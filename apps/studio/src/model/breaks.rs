//! The breaks of a project: one, or several with parameters of their own, one of which may be selected.

use super::project::Project;
use super::randomise::randomise;
use super::tilt::Tilt;
use greenstick::RequestFile;
use greenstick::fracture::recipe::apply_preset;
use greenstick::schema::{ParameterError, ParameterInfo, Parameters, Value};
use greenstick::wood::stem::StemLocation;

/// The key of a break's place.
pub const PLACE: &str = "at";

fn has_key(parameters: &impl Parameters, key: &str) -> bool {
    parameters.list().iter().any(|p| p.key == key)
}

impl Project {
    /// Number of breaks.
    pub fn break_count(&self) -> usize {
        self.file.breaks.len().max(1)
    }

    /// The number of the selected break, from 0; none where changes apply to all breaks, or where there is only one.
    pub fn selected(&self) -> Option<usize> {
        self.selection.filter(|i| *i < self.file.breaks.len())
    }

    /// Selects one of several breaks, or all.
    pub fn select(&mut self, selection: Option<usize>) {
        self.selection = selection;
        self.history.rest();
    }

    /// All parameters with their values; those that breaks have are the selected one's, or, where all are, the first one's.
    pub fn parameters(&self) -> Vec<ParameterInfo> {
        let mut list = self.file.list();
        list.retain(|p| !p.key.contains('['));
        if let Some(one) = self.file.breaks.get(self.selected().unwrap_or(0)) {
            let own = one.list();
            for p in &mut list {
                if let Some(known) = own.iter().find(|o| o.key == p.key) {
                    p.value = known.value.clone();
                }
            }
        }
        list
    }

    /// Sets one parameter: of the selected break, or of all.
    ///
    /// # Errors
    /// As [`Project::change`].
    pub fn set(&mut self, key: &str, value: &Value, drag: bool) -> Result<bool, String> {
        let selected = self.selected();
        self.change(key, drag, |file| {
            if let Some(i) = selected
                && has_key(&file.breaks[i], key)
            {
                return file.breaks[i].set(key, value);
            }
            file.set(key, value)?;
            for one in &mut file.breaks {
                if has_key(one, key) {
                    one.set(key, value)?;
                }
            }
            Ok::<(), ParameterError>(())
        })
    }

    /// Adds a break like the selected one, or the last, at a place, and selects it.
    ///
    /// # Errors
    /// As [`Project::change`].
    pub fn add_break(&mut self, place: StemLocation) -> Result<bool, String> {
        let like = self.selected().unwrap_or(self.break_count() - 1);
        let added = self.change("another place", false, |file| {
            // At every so many centimetres there is no single place.
            file.every = None;
            if file.breaks.is_empty() {
                file.breaks.push(file.common.clone());
            }
            let mut one = file.breaks[like].clone();
            one.place = place;
            file.breaks.push(one);
            Ok::<(), String>(())
        })?;
        self.selection = Some(self.file.breaks.len() - 1);
        Ok(added)
    }

    /// Takes one of several breaks away.
    ///
    /// # Errors
    /// As [`Project::change`].
    pub fn remove_break(&mut self, number: usize) -> Result<bool, String> {
        let removed = self.change("break taken away", false, |file| {
            if number < file.breaks.len() {
                file.breaks.remove(number);
            }
            if let [only] = &file.breaks[..] {
                file.common = only.clone();
                file.breaks.clear();
            }
            Ok::<(), String>(())
        })?;
        self.selection = match self.file.breaks.len() {
            0 => None,
            count => Some(number.min(count - 1)),
        };
        Ok(removed)
    }

    /// Moves the selected break to a place; where all of several are selected, the first.
    ///
    /// # Errors
    /// As [`Project::change`].
    pub fn move_break(&mut self, place: StemLocation) -> Result<bool, String> {
        let selected = self.selected().unwrap_or(0);
        self.change("place of the break", false, |file| {
            match file.breaks.get_mut(selected) {
                Some(one) => one.place = place,
                None => file.common.place = place,
            }
            Ok::<(), String>(())
        })
    }

    /// Tilts the plane of the selected break, or of all.
    ///
    /// # Errors
    /// As [`Project::change`].
    pub fn tilt(&mut self, tilt: Tilt, drag: bool) -> Result<bool, String> {
        let selected = self.selected();
        self.change("inclination", drag, |file| {
            let breaks = file.breaks.iter_mut().enumerate();
            let own = breaks.filter(|(i, _)| selected.is_none_or(|s| s == *i));
            let common = selected.is_none().then_some(&mut file.common);
            for one in own.map(|(_, one)| one).chain(common) {
                let face = &mut one.recipe.face;
                face.inclination = tilt.inclination;
                face.inclination_direction = tilt.direction;
            }
            Ok::<(), String>(())
        })
    }

    /// Puts a preset over the selected break, or all.
    ///
    /// # Errors
    /// As [`Project::change`].
    pub fn apply_preset(&mut self, name: &str) -> Result<bool, String> {
        let selected = self.selected();
        self.change(&format!("preset {name}"), false, |file| match selected {
            Some(i) => apply_preset(&mut file.breaks[i], name),
            None => {
                for one in &mut file.breaks {
                    apply_preset(one, name)?;
                }
                apply_preset(file, name)
            }
        })
    }

    /// Draws the face of the selected break anew, or of all, but for what is locked.
    ///
    /// # Errors
    /// As [`Project::change`].
    pub fn randomise(&mut self, seed: u64) -> Result<bool, String> {
        let (selected, locked) = (self.selected(), self.locked.clone());
        self.change("random values", false, |file| {
            for (i, one) in file.breaks.iter_mut().enumerate() {
                if selected.is_none_or(|s| s == i) {
                    randomise(one, &locked, seed.wrapping_add(i as u64));
                }
            }
            if selected.is_none() {
                randomise(file, &locked, seed);
            }
            Ok::<(), String>(())
        })
    }

    /// Puts every value back to its default, and leaves one break.
    ///
    /// # Errors
    /// As [`Project::change`].
    pub fn reset(&mut self) -> Result<bool, String> {
        self.change("reset of all values", false, |file| {
            *file = RequestFile {
                unit: file.unit,
                ..RequestFile::default()
            };
            Ok::<(), String>(())
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::input::Input;

    fn project() -> Project {
        Project::new(Input::built_in(), RequestFile::default())
    }

    fn inclinations(project: &Project) -> Vec<f64> {
        let breaks = project.file.request().breaks;
        breaks.iter().map(|b| b.recipe.face.inclination).collect()
    }

    #[test]
    fn changes_reach_the_selected_break_or_all() {
        let mut project = project();
        let key = "break.inclination";
        project.add_break(StemLocation::Fraction(0.7)).unwrap();
        assert_eq!((project.break_count(), project.selected()), (2, Some(1)));
        project.set(key, &Value::Number(20.0), false).unwrap();
        let first = inclinations(&project)[0];
        assert_eq!(inclinations(&project), [first, 20.0]);
        let shown = |project: &Project| {
            let list = project.parameters();
            list.into_iter().find(|p| p.key == key).unwrap().value
        };
        assert_eq!(shown(&project), Value::Number(20.0));
        project.select(None);
        assert_eq!(shown(&project), Value::Number(first));
        project.set(key, &Value::Number(10.0), false).unwrap();
        assert_eq!(inclinations(&project), [10.0, 10.0]);
        // What breaks do not have is the file's, whatever is selected.
        project.select(Some(0));
        project
            .set("texture_size", &Value::Integer(512), false)
            .unwrap();
        assert_eq!(project.file.texture_width, 512);
    }

    #[test]
    fn a_break_that_is_taken_away_leaves_the_others_and_comes_back() {
        let mut project = project();
        for place in [0.3, 0.7] {
            project.add_break(StemLocation::Fraction(place)).unwrap();
        }
        project.move_break(StemLocation::Fraction(0.8)).unwrap();
        let places = |project: &Project| -> Vec<StemLocation> {
            let breaks = project.file.request().breaks;
            breaks.iter().map(|b| b.place).collect()
        };
        let at = |places: &[f64]| -> Vec<StemLocation> {
            places.iter().map(|p| StemLocation::Fraction(*p)).collect()
        };
        assert_eq!(places(&project), at(&[0.5, 0.3, 0.8]));
        project.remove_break(0).unwrap();
        assert_eq!(places(&project), at(&[0.3, 0.8]));
        project.remove_break(0).unwrap();
        assert_eq!(places(&project), at(&[0.8]));
        assert!(project.file.breaks.is_empty() && project.selected().is_none());
        for _ in 0..2 {
            project.undo();
        }
        assert_eq!(places(&project), at(&[0.5, 0.3, 0.8]));
    }

    #[test]
    fn random_values_differ_from_break_to_break() {
        let mut project = project();
        project.add_break(StemLocation::Fraction(0.7)).unwrap();
        project.select(None);
        project.randomise(3).unwrap();
        let faces = |project: &Project| {
            let breaks = project.file.breaks.iter();
            let faces: Vec<_> = breaks.map(|b| b.recipe.face.clone()).collect();
            faces
        };
        let before = faces(&project);
        assert!(before[0] != before[1]);
        project.select(Some(0));
        project.randomise(4).unwrap();
        let after = faces(&project);
        assert!(after[0] != before[0] && after[1] == before[1]);
    }
}
