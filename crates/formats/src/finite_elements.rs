//! Orthotropic solids as the input of CalculiX, whose keywords are those of Abaqus (Dhondt, *CalculiX CrunchiX User's
//! Manual*, chapter 7).

use crate::companions::Encoded;
use crate::error::{FormatError, InFile};
use crate::text::push_integer;
use glam::DVec3;
use greenstick_geometry::{ElementSet, SolidModel};

/// Numbers on a line of a set.
const NUMBERS_PER_LINE: usize = 12;

/// Writes a solid as an `.inp` file without supports, loads and steps.
///
/// # Errors
/// [`FormatError::Unwritable`] if an element has a node that does not exist, a set has an element or node that does not
/// exist, elements have no axes, or a number is not finite.
pub fn write_solid_model(model: &SolidModel, name: &str) -> Result<Encoded, FormatError> {
    check(model, InFile(name))?;
    let mut out = head(model).into_bytes();
    out.extend_from_slice(b"*NODE, NSET=NALL\n");
    for (k, node) in model.nodes.iter().enumerate() {
        push_integer(&mut out, k as u64 + 1);
        push_vector(&mut out, *node);
        out.push(b'\n');
    }
    out.extend_from_slice(b"*ELEMENT, TYPE=C3D8, ELSET=EALL\n");
    for (k, corners) in model.hexahedra.iter().enumerate() {
        push_integer(&mut out, k as u64 + 1);
        for &corner in corners {
            out.push(b',');
            push_integer(&mut out, u64::from(corner) + 1);
        }
        out.push(b'\n');
    }
    for set in &model.node_sets {
        out.extend_from_slice(format!("*NSET, NSET={}\n", set.name).as_bytes());
        push_numbers(&mut out, &set.nodes);
    }
    out.extend_from_slice(b"*DISTRIBUTION, NAME=GRAIN\n,1.,0.,0.,0.,1.,0.\n");
    for (k, [first, second]) in model.axes.iter().enumerate() {
        push_integer(&mut out, k as u64 + 1);
        push_vector(&mut out, *first);
        push_vector(&mut out, *second);
        out.push(b'\n');
    }
    out.extend_from_slice(b"*ORIENTATION, NAME=AXES, SYSTEM=RECTANGULAR\nGRAIN\n");
    for part in &model.parts {
        push_part(&mut out, part);
    }
    Ok(Encoded {
        name: name.to_owned(),
        bytes: out,
    })
}

/// Remarks: where the model comes from, its units, and what Abaqus wants otherwise.
fn head(model: &SolidModel) -> String {
    let mut text = String::from("** Orthotropic solid by Greenstick, for CalculiX\n");
    for line in model.metadata.lines() {
        text += &format!("** {line}\n");
    }
    text + "** units: m, N, kg, s, Pa\n\
        ** axes 1, 2, 3 of every element: L along the grain, R across the rings, T along them\n\
        ** Abaqus wants *DISTRIBUTION TABLE, NAME=COORD and the line COORD3D, COORD3D before *DISTRIBUTION,\n\
        ** and there the parameters LOCATION=ELEMENT, TABLE=COORD\n\
        ** supports, loads and steps follow below the last line, on sets of nodes such as BUTT and TOP\n"
}

fn push_part(out: &mut Vec<u8>, part: &ElementSet) {
    let name = &part.name;
    out.extend_from_slice(format!("*ELSET, ELSET={name}\n").as_bytes());
    push_numbers(out, &part.elements);
    let m = &part.material;
    let [e1, e2, e3] = m.moduli.map(number);
    let [n12, n13, n23] = m.poisson.map(number);
    let [g12, g13, g23] = m.shear.map(number);
    let density = number(m.density);
    let text = format!(
        "*MATERIAL, NAME={name}\n*ELASTIC, TYPE=ENGINEERING CONSTANTS\n{e1},{e2},{e3},{n12},{n13},{n23},{g12},{g13},\n{g23}\n\
         *DENSITY\n{density}\n*SOLID SECTION, ELSET={name}, MATERIAL={name}, ORIENTATION=AXES\n"
    );
    out.extend_from_slice(text.as_bytes());
}

/// A number with a point or an exponent, as it is to be a real one.
fn number(x: f64) -> String {
    if x.abs() >= 1e5 {
        format!("{x:.6e}")
    } else {
        format!("{x:.6}")
    }
}

fn push_vector(out: &mut Vec<u8>, v: DVec3) {
    let [x, y, z] = v.to_array();
    out.extend_from_slice(format!(",{x:.9},{y:.9},{z:.9}").as_bytes());
}

fn push_numbers(out: &mut Vec<u8>, numbers: &[u32]) {
    for line in numbers.chunks(NUMBERS_PER_LINE) {
        for &n in line {
            push_integer(out, u64::from(n) + 1);
            out.push(b',');
        }
        out.push(b'\n');
    }
}

fn check(model: &SolidModel, file: InFile) -> Result<(), FormatError> {
    let (nodes, elements) = (model.nodes.len(), model.hexahedra.len());
    let missing =
        |numbers: &[u32], count: usize| numbers.iter().copied().find(|&n| n as usize >= count);
    if let Some(n) = missing(model.hexahedra.as_flattened(), nodes) {
        return Err(file.unwritable(
            format!("an element has the node {n}"),
            format!("below {nodes}"),
        ));
    }
    if model.axes.len() != elements {
        let found = format!("axes of {} elements", model.axes.len());
        return Err(file.unwritable(found, format!("those of {elements}")));
    }
    for set in &model.parts {
        if let Some(n) = missing(&set.elements, elements) {
            let found = format!("set {} has the element {n}", set.name);
            return Err(file.unwritable(found, format!("below {elements}")));
        }
    }
    for set in &model.node_sets {
        if let Some(n) = missing(&set.nodes, nodes) {
            let found = format!("set {} has the node {n}", set.name);
            return Err(file.unwritable(found, format!("below {nodes}")));
        }
    }
    let vectors = model.nodes.iter().chain(model.axes.as_flattened());
    if let Some(v) = vectors.into_iter().find(|v| !v.is_finite()) {
        return Err(file.unwritable(format!("the vector {v}"), "finite numbers"));
    }
    Ok(())
}
