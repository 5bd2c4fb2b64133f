//! The other side of the scanner: recordings, scenes, replay, scores, pictures.
