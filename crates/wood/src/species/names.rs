//! The names of a species: aliases, the ways to write a common name, and the error for a name that is none.

use greenstick_schema::{did_you_mean, normalise};

/// Other names that people use: (alias, name in the table).
///
/// Older and variant scientific names, and the two names of the first row of Yang's table, which is
/// printed "Juniperus viginiana L." there and *Juniperus rigida* elsewhere in the paper. *Juniperus
/// virginiana* therefore means that row; eastern redcedar of the Wood Handbook is found by its
/// common name.
pub(super) const ALIASES: &[(&str, &str)] = &[
    ("Juniperus virginiana", "Juniper, temple"),
    ("Juniperus viginiana", "Juniper, temple"),
    ("needle juniper", "Juniper, temple"),
    ("Sabina chinensis", "Juniper, Chinese"),
    ("ailanthus", "Tree-of-heaven"),
    ("Quercus prinus", "Oak, chestnut"),
    ("Cupressus nootkatensis", "Cedar, yellow"),
    ("Chamaecyparis nootkatensis", "Cedar, yellow"),
    ("Xanthocyparis nootkatensis", "Cedar, yellow"),
    ("Carya alba", "Hickory (true), mockernut"),
    ("Carya illinoensis", "Hickory (pecan), pecan"),
    ("Libocedrus decurrens", "Cedar, incense"),
    ("Populus balsamifera ssp. trichocarpa", "Cottonwood, black"),
    ("balsam poplar", "Cottonwood, balsam poplar"),
    ("eastern redcedar", "Cedar, eastern redcedar"),
    ("western redcedar", "Cedar, western redcedar"),
    ("pecan", "Hickory (pecan), pecan"),
    ("cucumbertree", "Magnolia, cucumbertree"),
    ("Douglas-fir", "Douglas-fir, coast"),
    ("redwood", "Redwood, old-growth"),
    // European species in English, German and French.
    ("common ash", "Ash, European"),
    ("Esche", "Ash, European"),
    ("Gemeine Esche", "Ash, European"),
    ("frêne", "Ash, European"),
    ("common beech", "Beech, European"),
    ("Buche", "Beech, European"),
    ("Rotbuche", "Beech, European"),
    ("hêtre", "Beech, European"),
    ("Betula verrucosa", "Birch, silver"),
    ("Birke", "Birch, silver"),
    ("Hängebirke", "Birch, silver"),
    ("Sandbirke", "Birch, silver"),
    ("bouleau", "Birch, silver"),
    ("European sycamore", "Maple, sycamore"),
    ("Bergahorn", "Maple, sycamore"),
    ("érable sycomore", "Maple, sycamore"),
    ("European oak", "Oak, English"),
    ("pedunculate oak", "Oak, English"),
    ("sessile oak", "Oak, English"),
    ("Quercus petraea", "Oak, English"),
    ("Eiche", "Oak, English"),
    ("Stieleiche", "Oak, English"),
    ("Traubeneiche", "Oak, English"),
    ("chêne", "Oak, English"),
    ("European silver fir", "Fir, silver"),
    ("Abies pectinata", "Fir, silver"),
    ("Tanne", "Fir, silver"),
    ("Weißtanne", "Fir, silver"),
    ("sapin", "Fir, silver"),
    ("Lärche", "Larch, European"),
    ("mélèze", "Larch, European"),
    ("Scotch pine", "Pine, Scots"),
    ("Kiefer", "Pine, Scots"),
    ("Waldkiefer", "Pine, Scots"),
    ("Föhre", "Pine, Scots"),
    ("pin sylvestre", "Pine, Scots"),
    ("European spruce", "Spruce, Norway"),
    ("Picea excelsa", "Spruce, Norway"),
    ("Fichte", "Spruce, Norway"),
    ("Rotfichte", "Spruce, Norway"),
    ("épicéa", "Spruce, Norway"),
];

/// A name that is no species.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("unknown species \"{name}\"{}", did_you_mean(nearest))]
pub struct UnknownSpecies {
    /// The name that was looked up.
    pub name: String,
    /// Up to three similar names, the most similar first.
    pub nearest: Vec<String>,
}

/// The ways to write a common name: "Alder, red" and "red alder"; "Hickory (true), pignut", "pignut
/// hickory".
pub(super) fn common_names(name: &str) -> Vec<String> {
    let mut all = vec![normalise(name)];
    if let Some((kind, which)) = name.split_once(',') {
        let kind = kind.split('(').next().unwrap_or(kind).trim();
        all.push(normalise(&format!("{which} {kind}")));
        all.push(normalise(&format!("{kind}, {which}")));
    }
    all
}
