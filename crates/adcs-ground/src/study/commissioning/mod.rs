//! Satellites of which nobody knows anything climb the commissioning ladder: does what they report of
//! themselves hold, and do they point afterwards?
//!
//! | file | what |
//! |---|---|
//! | `satellites` | what is true of them, and what they are told |
//! | `climb` | one of them |
//! | `quantity` | what was found, beside what is true |
//! | `figures` | over all of them |

mod climb;
mod figures;
mod quantity;
mod satellites;

pub use climb::{After, Climbed, fly};
pub use figures::{Coverage, Summary};
pub use quantity::{Found, Quantity};
pub use satellites::World;
