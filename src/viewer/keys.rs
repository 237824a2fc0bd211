//! The keys of the window.

use winit::keyboard::{Key, NamedKey, PhysicalKey};

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
    /// Toggle the edges of triangles.
    Edges,
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
    /// Fly in one of [`DIRECTIONS`] as long as the key is held.
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

/// The keys that are held to fly.
#[derive(Debug, Default)]
pub struct Held(Vec<(PhysicalKey, usize)>);

impl Held {
    /// Begins to fly in one of [`DIRECTIONS`].
    pub fn press(&mut self, key: PhysicalKey, direction: usize) {
        self.release(key);
        self.0.push((key, direction));
    }

    /// Stops what this key began, whatever it means by now: the release of a keypad's arrow is one of a digit if Shift or
    /// NumLock was pressed meanwhile. Returns false if it began nothing.
    pub fn release(&mut self, key: PhysicalKey) -> bool {
        let before = self.0.len();
        self.0.retain(|(held, _)| *held != key);
        self.0.len() < before
    }

    /// Stops.
    pub fn clear(&mut self) {
        self.0.clear();
    }

    /// Whether there are any.
    #[must_use]
    pub fn flies(&self) -> bool {
        !self.0.is_empty()
    }

    /// Returns the flight to the right, upwards and forwards. Two keys of the same direction count as one.
    #[must_use]
    pub fn flight(&self) -> [f64; 3] {
        let is_held = |direction: usize| self.0.iter().any(|held| held.1 == direction);
        let mut sum = [0.0; 3];
        for (_, part) in DIRECTIONS.iter().enumerate().filter(|(i, _)| is_held(*i)) {
            sum = std::array::from_fn(|axis| sum[axis] + part[axis]);
        }
        sum
    }
}

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
    "n h e  normals; cost; edges",
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
            "e" => Action::Edges,
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
