//! From what the drivers say along each sensor's own axes to Body.
//!
//! | module | from | to |
//! |---|---|---|
//! | [`frozen`] | what a driver said of late | whether it still measures |
//! | [`triad`] | three axes of magnetometer or gyro | field, rate |
//! | [`sun_face`] | four currents of one Sun sensor | a spot of light: its direction and brightness |
//! | [`sun_faces`] | the spots of six | one direction of the Sun, or why there is none |

pub mod frozen;
pub mod sun_face;
pub mod sun_faces;
pub mod triad;

pub use frozen::Frozen;
pub use sun_face::{SunFace, SunFaceError, SunFaceParameters};
pub use sun_faces::{
    EarthDisc, Expected, FaceVerdict, SunDirection, SunFaces, SunFacesError, SunFacesParameters,
    SunPrediction, SunSighting,
};
pub use triad::{Triad, TriadError, TriadParameters};
