//! Software-rendered pictures.
