//! The keys of the window.

use winit::keyboard::{Key, NamedKey};

/// The action of a key press.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Action {
    /// Classic viewpoint 1 to 6 of a scene, or one of the six sides of a mesh.
    View(u32),
    /// Return to the starting camera.
    Home,
    /// Frame the object under the mouse, or everything except the ground.
    Frame,
    /// Turn a mesh so that another axis points up.
    TurnUp,
    /// Toggle the preview.
    Preview,
    /// Toggle anti-aliasing.
    Antialias,
    /// Toggle brute force.
    Brute,
    /// Toggle the boxes of the leaves.
    Leaves,
    /// Show the boxes one level closer to the root.
    LevelUp,
    /// Show the boxes one level closer to the leaves.
    LevelDown,
    /// Toggle normals as colours.
    Normals,
    /// Toggle cost as colours.
    Cost,
    /// Print the camera.
    PrintCamera,
    /// Save the picture.
    Save,
    /// Play the frames of an animated scene, or stop.
    Play,
    /// Stop, and move on by this many frames.
    Step(i64),
    /// Toggle the description of the pixel under the mouse.
    Probe,
    /// Switch between packets and single rays.
    Mode,
    /// Toggle the figures.
    Figures,
    /// Toggle the help.
    Help,
    /// Close the window.
    Quit,
    /// Start or stop flying in one of [`DIRECTIONS`].
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

/// The help. Its lines are short enough for letters of 16 pixels in a window of 512 x 512.
pub const HELP: [&str; 21] = [
    "1-6    viewpoints; mesh: sides",
    "Home   starting camera",
    "f      frame what is at mouse",
    "u      mesh: turn up axis",
    "drag   orbit",
    "wheel  zoom; or right drag",
    "arrows fly; also PgUp, PgDn",
    "r      quick preview",
    "n h    normals; cost of pixels",
    "a      anti-aliasing at rest",
    "b      brute force, no BVH",
    "B [ ]  boxes: leaves; a level",
    "p      packets or single rays",
    "m      what is under the mouse",
    "i      figures",
    "c      print the camera",
    "s      save the picture",
    "space  play a scene that moves",
    ", .    step frame by frame",
    "?      this help",
    "q Esc  quit",
];

/// Returns the action of a key.
#[must_use]
pub fn action(key: &Key) -> Option<Action> {
    Some(match key {
        Key::Named(NamedKey::Escape) => Action::Quit,
        Key::Named(NamedKey::Space) => Action::Play,
        Key::Named(NamedKey::Home) => Action::Home,
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
            "f" => Action::Frame,
            "u" => Action::TurnUp,
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
            " " => Action::Play,
            "," => Action::Step(-1),
            "." => Action::Step(1),
            "m" => Action::Probe,
            "p" => Action::Mode,
            "i" => Action::Figures,
            "?" => Action::Help,
            "q" => Action::Quit,
            _ => return None,
        },
        _ => return None,
    })
}

#[cfg(test)]
mod tests;
