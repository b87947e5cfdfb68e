//! What a record says of the satellite itself.

mod tensor;

pub use tensor::Tensor;
