//! Values of parameters.

use serde::{Serialize, Serializer};
use std::fmt;

/// The value of some parameter.
#[derive(Debug, Clone, PartialEq)]
pub enum Value {
    /// A value that is worked out, written "auto".
    Auto,
    /// True or false.
    Flag(bool),
    /// A whole number.
    Integer(i128),
    /// A real number in the parameter's unit.
    Number(f64),
    /// A choice, a text, or something that is still to be read from a text.
    Text(String),
    /// Several values.
    List(Vec<Value>),
}

/// The word for [`Value::Auto`].
pub(crate) const AUTO: &str = "auto";

impl fmt::Display for Value {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Value::Auto => f.write_str(AUTO),
            Value::Flag(b) => write!(f, "{b}"),
            Value::Integer(n) => write!(f, "{n}"),
            Value::Number(x) => write!(f, "{x}"),
            Value::Text(t) => f.write_str(t),
            Value::List(list) => {
                for (i, value) in list.iter().enumerate() {
                    write!(f, "{}{value}", if i == 0 { "" } else { ", " })?;
                }
                Ok(())
            }
        }
    }
}

impl Serialize for Value {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        match self {
            Value::Auto => to.serialize_str(AUTO),
            Value::Flag(b) => to.serialize_bool(*b),
            Value::Integer(n) => match (u64::try_from(*n), i64::try_from(*n)) {
                (Ok(n), _) => to.serialize_u64(n),
                (_, Ok(n)) => to.serialize_i64(n),
                _ => to.serialize_i128(*n),
            },
            Value::Number(x) => to.serialize_f64(*x),
            Value::Text(t) => to.serialize_str(t),
            Value::List(list) => list.serialize(to),
        }
    }
}
