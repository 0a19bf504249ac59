//! Keys of a recipe as people write them: those of the table `break` may stand alone, as in settings.

use greenstick::RequestFile;
use greenstick::schema::{ParameterError, ParameterInfo, Parameters, Value, closest_names};

/// What the keys of the broken face begin with.
const BREAK: &str = "break.";

/// Returns the parameter that `key` means in a set: the one of that key, or of that key in the table `break`.
///
/// # Errors
/// [`ParameterError::UnknownKey`] with the nearest keys.
///
/// ```
/// use greenstick::RequestFile;
/// use greenstick_sweep::keys::find;
///
/// let file = RequestFile::default();
/// assert_eq!(find(&file, "slab_height")?.key, "break.slab_height");
/// assert_eq!(find(&file, "annual_rings")?.key, "annual_rings");
/// let error = find(&file, "slab_hight").unwrap_err();
/// assert_eq!(error.to_string(), "unknown parameter \"slab_hight\"; did you mean \"slab_height\", \"step_height\" or \"sliver_height\"?");
/// # Ok::<(), greenstick::schema::ParameterError>(())
/// ```
pub fn find(set: &dyn Parameters, key: &str) -> Result<ParameterInfo, ParameterError> {
    let list = set.list();
    let named = |wanted: &str| list.iter().find(|p| p.key == wanted).cloned();
    named(key)
        .or_else(|| named(&format!("{BREAK}{key}")))
        .ok_or_else(|| ParameterError::UnknownKey {
            key: key.to_owned(),
            nearest: closest_names(
                key,
                list.iter()
                    .map(|p| p.key.strip_prefix(BREAK).unwrap_or(&p.key)),
            ),
        })
}

/// Sets a parameter of a recipe, and that of every break that has a table of its own.
///
/// # Errors
/// An unknown key, with the nearest ones; a value of the wrong kind or out of range.
pub fn set(file: &mut RequestFile, key: &str, value: &Value) -> Result<(), ParameterError> {
    let key = find(file, key)?.key;
    file.set(&key, value)?;
    for one in &mut file.breaks {
        match one.set(&key, value) {
            // Keys of the file that breaks do not have were set above.
            Ok(()) | Err(ParameterError::UnknownKey { .. }) => {}
            Err(error) => return Err(error),
        }
    }
    Ok(())
}
