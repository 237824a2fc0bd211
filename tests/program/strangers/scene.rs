//! Scenes, glTF, and what may be opened.
