//! Meshes in OBJ, PLY and STL.
