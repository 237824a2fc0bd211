//! Which key does what.

use winit::keyboard::{Key, NamedKey};

/// What a key press asks for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Action {
    /// One of the six viewpoints.
    View(u32),
    /// Preview or ray-traced picture.
    Preview,
    /// Anti-aliasing on or off.
    Antialias,
    /// BVH or brute force.
    Brute,
    /// Boxes of the leaves.
    Leaves,
    /// Boxes of one level higher.
    LevelUp,
    /// Boxes of one level lower.
    LevelDown,
    /// Normals as colours.
    Normals,
    /// Cost as colours.
    Cost,
    /// Print the camera.
    PrintCamera,
    /// Save the picture.
    Save,
    /// Tell about the pixel under the mouse.
    Probe,
    /// Look at the whole object.
    Frame,
    /// Packets or single rays.
    Mode,
    /// Figures on the screen.
    Figures,
    /// These keys on the screen.
    Help,
    /// End.
    Quit,
    /// Begin or end flying: direction of [`DIRECTIONS`].
    Fly(usize),
}

/// Flight to the right, upwards and forwards of each [`Action::Fly`].
pub const DIRECTIONS: [[f64; 3]; 6] = [
    [0.0, 0.0, 1.0],
    [0.0, 0.0, -1.0],
    [-1.0, 0.0, 0.0],
    [1.0, 0.0, 0.0],
    [0.0, 1.0, 0.0],
    [0.0, -1.0, 0.0],
];

/// What the help shows.
pub const HELP: [&str; 21] = [
    "1-6         viewpoints",
    "left drag   around the object",
    "right drag  nearer, farther; or the wheel",
    "arrows      fly; Page Up, Page Down: up, down",
    "f           look at the whole object",
    "",
    "r           quick preview",
    "n           normals",
    "h           cost of each pixel",
    "a           anti-aliasing at rest",
    "b           brute force, without the BVH",
    "B           boxes of the BVH's leaves",
    "[ ]         boxes of one level",
    "p           packets or single rays",
    "",
    "m           what is under the mouse",
    "i           figures",
    "c           print the camera",
    "s           save the picture",
    "?           these keys",
    "q, Esc      quit",
];

/// The action of a key, if it has one.
#[must_use]
pub fn action(key: &Key) -> Option<Action> {
    Some(match key {
        Key::Named(NamedKey::Escape) => Action::Quit,
        Key::Named(NamedKey::ArrowUp) => Action::Fly(0),
        Key::Named(NamedKey::ArrowDown) => Action::Fly(1),
        Key::Named(NamedKey::ArrowLeft) => Action::Fly(2),
        Key::Named(NamedKey::ArrowRight) => Action::Fly(3),
        Key::Named(NamedKey::PageUp) => Action::Fly(4),
        Key::Named(NamedKey::PageDown) => Action::Fly(5),
        Key::Character(text) => match text.as_str() {
            "1" => Action::View(1),
            "2" => Action::View(2),
            "3" => Action::View(3),
            "4" => Action::View(4),
            "5" => Action::View(5),
            "6" => Action::View(6),
            "r" => Action::Preview,
            "a" => Action::Antialias,
            "b" => Action::Brute,
            "B" => Action::Leaves,
            "[" => Action::LevelUp,
            "]" => Action::LevelDown,
            "n" => Action::Normals,
            "h" => Action::Cost,
            "c" => Action::PrintCamera,
            "s" => Action::Save,
            "m" => Action::Probe,
            "f" => Action::Frame,
            "p" => Action::Mode,
            "i" => Action::Figures,
            "?" => Action::Help,
            "q" => Action::Quit,
            _ => return None,
        },
        _ => return None,
    })
}
