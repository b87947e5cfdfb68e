//! What a sensor said, or why it said nothing.

use serde::{Deserialize, Serialize};

/// Why there is no value. Absence is in the type: a reading is never a made-up number.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum MissingReason {
    /// The bus reported an error, or the answer was not one that the chip can give.
    Bus,
    /// The value stood at a rail of the converter: the true one may be anywhere beyond.
    OutOfRange,
    /// The value was NaN or infinite.
    NotFinite,
    /// The torquers were on, or the field had not settled since they were switched off.
    TorquersOn,
    /// The satellite has no such sensor, or the flight software no description of it.
    NotFitted,
    /// No face of the Sun sensors has light.
    Dark,
    /// There is light, but by its brightness or place none of it is the Sun's.
    NotTheSun,
    /// What looks like the Sun is not where it was predicted.
    Unpredicted,
    /// Several things look like the Sun, in different directions.
    Disagree,
    /// The sensor repeats itself to the last bit: it has stopped measuring.
    Frozen,
}

/// One value of type `T`, fresh or missing.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Reading<T> {
    /// Measured in this cycle.
    Fresh(T),
    /// Not measured in this cycle, and why.
    Missing(MissingReason),
}

impl<T> Reading<T> {
    /// The value, when there is one.
    pub fn value(self) -> Option<T> {
        match self {
            Self::Fresh(value) => Some(value),
            Self::Missing(_) => None,
        }
    }

    /// The reason of absence, when there is no value.
    pub fn missing(&self) -> Option<MissingReason> {
        match self {
            Self::Fresh(_) => None,
            Self::Missing(reason) => Some(*reason),
        }
    }

    /// The same reading with its value transformed.
    pub fn map<U>(self, f: impl FnOnce(T) -> U) -> Reading<U> {
        match self {
            Self::Fresh(value) => Reading::Fresh(f(value)),
            Self::Missing(reason) => Reading::Missing(reason),
        }
    }
}

impl Reading<[f32; 3]> {
    /// Three single-axis readings as one; missing, with the first reason, when any of them is.
    pub fn from_axes([x, y, z]: [Reading<f32>; 3]) -> Self {
        match (x, y, z) {
            (Reading::Fresh(x), Reading::Fresh(y), Reading::Fresh(z)) => Self::Fresh([x, y, z]),
            (Reading::Missing(reason), _, _)
            | (_, Reading::Missing(reason), _)
            | (_, _, Reading::Missing(reason)) => Self::Missing(reason),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_missing_axis_makes_the_vector_missing_with_its_reason() {
        let missing = Reading::Missing(MissingReason::OutOfRange);
        let vector = Reading::from_axes([Reading::Fresh(1.0), missing, Reading::Fresh(2.0)]);
        assert_eq!(vector, Reading::Missing(MissingReason::OutOfRange));
        let whole = Reading::from_axes([1.0, 2.0, 3.0].map(Reading::Fresh));
        assert_eq!(whole.value(), Some([1.0, 2.0, 3.0]));
    }
}
