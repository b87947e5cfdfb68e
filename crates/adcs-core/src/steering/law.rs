//! Which law flies, and with what.

use crate::control::b_dot::BDot;
use crate::control::bang_bang::BangBang;
use crate::control::cross_product::CrossProduct;
use crate::control::guidance::Guidance;
use crate::control::periodic::PeriodicLaw;

/// The law of stage III.
#[derive(Debug, Clone, Copy)]
#[allow(
    clippy::large_enum_variant,
    reason = "there is one, in static memory, and no heap to box into"
)]
pub enum Law {
    /// The torquers stay off.
    Off,
    /// Despin from rate and magnetometer.
    BDot(BDot),
    /// The same at full dipole, by sign.
    BangBang(BangBang),
    /// An attitude is taken and held.
    Pointing(Pointing),
}

impl Law {
    /// Whether it takes and holds an attitude.
    pub fn points(&self) -> bool {
        match self {
            Self::Pointing(_) => true,
            Self::Off | Self::BDot(_) | Self::BangBang(_) => false,
        }
    }
}

/// Which attitude is held, and how.
#[derive(Debug, Clone, Copy)]
pub struct Pointing {
    /// The law with its gains; beside the one that plans, what flies while there is no plan.
    pub law: CrossProduct,
    /// The law that plans with the field to come; `None` to fly the cross-product law alone.
    pub periodic: Option<PeriodicLaw>,
    /// Where to point.
    pub guidance: Guidance,
}
