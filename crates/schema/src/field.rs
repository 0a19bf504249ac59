//! Types that a parameter's field may have.

use crate::Value;

/// A type that a parameter's field may have.
pub trait Field: Sized {
    /// The field as a value.
    fn to_value(&self) -> Value;

    /// The field of a value that [`crate::ParameterInfo::read`] has passed; `None` where it is of another kind.
    fn from_value(value: &Value) -> Option<Self>;
}

impl Field for f64 {
    fn to_value(&self) -> Value {
        Value::Number(*self)
    }

    fn from_value(value: &Value) -> Option<Self> {
        match value {
            Value::Number(x) => Some(*x),
            _ => None,
        }
    }
}

impl Field for bool {
    fn to_value(&self) -> Value {
        Value::Flag(*self)
    }

    fn from_value(value: &Value) -> Option<Self> {
        match value {
            Value::Flag(b) => Some(*b),
            _ => None,
        }
    }
}

impl Field for String {
    fn to_value(&self) -> Value {
        Value::Text(self.clone())
    }

    fn from_value(value: &Value) -> Option<Self> {
        match value {
            Value::Text(t) => Some(t.clone()),
            _ => None,
        }
    }
}

macro_rules! whole_numbers {
    ($($type:ty)+) => {
        $(impl Field for $type {
            fn to_value(&self) -> Value {
                Value::Integer(*self as i128)
            }

            fn from_value(value: &Value) -> Option<Self> {
                match value {
                    Value::Integer(n) => <$type>::try_from(*n).ok(),
                    _ => None,
                }
            }
        })+
    };
}
whole_numbers! { u8 u16 u32 u64 usize i64 }

impl<T: Field> Field for Option<T> {
    fn to_value(&self) -> Value {
        self.as_ref().map_or(Value::Auto, T::to_value)
    }

    fn from_value(value: &Value) -> Option<Self> {
        match value {
            Value::Auto => Some(None),
            value => T::from_value(value).map(Some),
        }
    }
}

impl<T: Field> Field for Vec<T> {
    fn to_value(&self) -> Value {
        Value::List(self.iter().map(T::to_value).collect())
    }

    fn from_value(value: &Value) -> Option<Self> {
        match value {
            Value::List(list) => list.iter().map(T::from_value).collect(),
            _ => None,
        }
    }
}

impl<T: Field, const N: usize> Field for [T; N] {
    fn to_value(&self) -> Value {
        Value::List(self.iter().map(T::to_value).collect())
    }

    fn from_value(value: &Value) -> Option<Self> {
        Vec::from_value(value)?.try_into().ok()
    }
}
