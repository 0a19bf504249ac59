//! Sets of declared parameters.

use crate::{ListInfo, ParameterError, ParameterInfo, Value, closest_names};

/// A set of declared parameters, with tables of them inside and lists of such tables.
pub trait Parameters {
    /// Appends every parameter with its present value, those of tables inside too. `prefix` is put before each key, with a
    /// dot unless it is empty.
    fn describe(&self, prefix: &str, list: &mut Vec<ParameterInfo>);

    /// Puts a value that [`ParameterInfo::read`] has passed; false where there is no such key or the value is of another
    /// kind.
    fn assign(&mut self, key: &str, value: &Value) -> bool;

    /// What holds between parameters, beyond each one's range.
    ///
    /// # Errors
    /// The first condition that does not hold.
    fn consistent(&self) -> Result<(), ParameterError> {
        Ok(())
    }

    /// A key that a file must give, as it decides which others there are.
    fn tag(&self) -> Option<&'static str> {
        None
    }

    /// The lists of tables in it, those of tables inside left out.
    fn lists(&self) -> Vec<ListInfo> {
        Vec::new()
    }

    /// The entries of a list.
    fn entries(&self, _list: &str) -> Vec<&dyn Parameters> {
        Vec::new()
    }

    /// Appends an entry with its defaults to a list; `None` where there is no such list.
    fn add_entry(&mut self, _list: &str) -> Option<&mut dyn Parameters> {
        None
    }

    /// Empties a list.
    fn clear_entries(&mut self, _list: &str) {}

    /// The tables of parameters in it, with their names.
    fn tables(&self) -> Vec<(&'static str, &dyn Parameters)> {
        Vec::new()
    }

    /// A table of parameters in it, by its name.
    fn table_mut(&mut self, _name: &str) -> Option<&mut dyn Parameters> {
        None
    }

    /// Sets with the defaults of every kind that this one may be, where its tag decides between kinds.
    fn variants(&self) -> Vec<Box<dyn Parameters>> {
        Vec::new()
    }

    /// A set of the same type with its defaults.
    fn defaults(&self) -> Box<dyn Parameters>;

    /// Every parameter with its present value, in the order of declaration.
    fn list(&self) -> Vec<ParameterInfo> {
        let mut list = Vec::new();
        self.describe("", &mut list);
        let mut defaults = Vec::new();
        self.defaults().describe("", &mut defaults);
        for (info, default) in list.iter_mut().zip(defaults) {
            info.default = default.value;
        }
        list
    }

    /// Every parameter with its default, in the order of declaration.
    fn table() -> Vec<ParameterInfo>
    where
        Self: Default + Sized,
    {
        Self::default().list()
    }

    /// Every parameter that is not at its default, in the order of declaration; those of the entries of a list after its name
    /// and their number, from 0: `breaks[1].fray`.
    fn changed(&self) -> Vec<ParameterInfo> {
        let changed = |list: Vec<ParameterInfo>| list.into_iter().filter(|p| p.value != p.default);
        let mut all: Vec<ParameterInfo> = changed(self.list()).collect();
        for list in self.lists() {
            for (number, entry) in self.entries(list.key).into_iter().enumerate() {
                all.extend(changed(entry.list()).map(|p| ParameterInfo {
                    key: format!("{}[{number}].{}", list.key, p.key),
                    ..p
                }));
            }
        }
        all
    }

    /// Sets one parameter. The set is unchanged where this fails.
    ///
    /// # Errors
    /// An unknown key, with the nearest ones; a value of the wrong kind or out of range.
    fn set(&mut self, key: &str, value: &Value) -> Result<(), ParameterError> {
        let table = self.list();
        let unknown = || ParameterError::UnknownKey {
            key: key.to_owned(),
            nearest: closest_names(key, table.iter().map(|p| p.key.as_str())),
        };
        let info = table.iter().find(|p| p.key == key).ok_or_else(unknown)?;
        let read = info.read(value)?;
        if self.assign(key, &read) {
            Ok(())
        } else {
            Err(ParameterError::Kind {
                key: key.to_owned(),
                found: value.to_string(),
                expected: info.kind.range(),
            })
        }
    }

    /// Sets one parameter from text, where numbers may carry a unit: "12 mm", "0.5 rad", "30 %".
    ///
    /// # Errors
    /// As [`Parameters::set`].
    fn set_text(&mut self, key: &str, text: &str) -> Result<(), ParameterError> {
        self.set(key, &Value::Text(text.to_owned()))
    }

    /// Checks every range, and what holds between parameters. Needed after fields were written directly.
    ///
    /// # Errors
    /// The first parameter that is out of range, or the first condition that does not hold.
    fn check(&self) -> Result<(), ParameterError> {
        for parameter in self.list() {
            parameter.read(&parameter.value)?;
        }
        self.check_inside()
    }

    /// Checks the entries of lists, those of tables inside too, and what holds between parameters.
    ///
    /// # Errors
    /// As [`Parameters::check`].
    fn check_inside(&self) -> Result<(), ParameterError> {
        for list in self.lists() {
            for (i, entry) in self.entries(list.key).into_iter().enumerate() {
                let place = format!("{}[{i}]", list.key);
                entry.check().map_err(|error| error.within(&place))?;
            }
        }
        for (name, table) in self.tables() {
            table.check_inside().map_err(|error| error.within(name))?;
        }
        self.consistent()
    }
}
