//! The statement `environment`.

use super::{QUOTES_HINT, Reader, Seen, arguments::Arguments, nearest::nearest};
use crate::{
    error::LoadError,
    format::{
        environment::{decode, odd_note},
        files::load_error,
        reason::Reason,
    },
    scene::{Environment, EnvironmentPicture},
};

impl Reader<'_> {
    /// `environment PATH [rotate DEG] [intensity k]` or `environment bottom r g b top r g b`
    pub(super) fn environment(&mut self, mut arguments: Arguments<'_, '_>) -> Result<(), LoadError> {
        let is_gradient = arguments
            .peek()
            .is_some_and(|word| nearest(word.text, ["bottom", "top"]).is_some());
        let environment = if is_gradient {
            Environment::Background(arguments.gradient("environment bottom r g b top r g b")?)
        } else {
            self.picture(&mut arguments)?
        };
        Seen::once(
            &mut self.seen.background,
            &arguments,
            "`background` or `environment`",
        )?;
        self.has_lights = true;
        self.has_environment = true;
        let set = self.builder.set_environment(environment);
        set.map_err(|error| arguments.refused(&error, &[]))
    }

    fn picture(&mut self, arguments: &mut Arguments<'_, '_>) -> Result<Environment, LoadError> {
        let [word] = arguments.leading()?;
        arguments.hint = QUOTES_HINT;
        let (mut degrees, mut intensity) = (0.0, 1.0);
        while let Some((key_word, key)) = arguments.key_once(&["rotate", "intensity"])? {
            if key == "rotate" {
                let [number] = arguments.take(key_word, "rotate DEG")?;
                degrees = arguments.precise(number, "rotate")?;
                continue;
            }
            let [number] = arguments.take(key_word, "intensity NUMBER")?;
            intensity = arguments.number(number, key)?;
            if intensity < 0.0 {
                let message = format!("intensity is {intensity}, expected 0 or more");
                return Err(arguments.line.error_at(&number, message));
            }
        }
        let path = self.path(arguments, word, "picture")?;
        let cannot_load = |cause: LoadError| {
            let message = format!("cannot load {}", path.display());
            arguments.line.error_at(&word, message).caused_by(cause)
        };
        let whole_file = |reason: Reason| cannot_load(reason.of_file(&path));
        self.builder.add_texture_files(vec![path.clone()]);
        let opened = self.files.mesh(&path, self.budget);
        let bytes = opened.and_then(|opened| opened.into_bytes(self.budget));
        let bytes = bytes.map_err(|error| cannot_load(load_error(&path, &error)))?;
        let decoded = decode(&bytes, &path, self.budget).map_err(whole_file)?;
        self.budget.give_back(bytes.capacity());
        if let Some(note) = odd_note(&path, &decoded) {
            self.builder.add_note(note);
        }
        let (size, texels) = decoded;
        let picture = EnvironmentPicture::new(size, texels, degrees, intensity);
        let picture = picture.map_err(|error| whole_file(error.into()))?;
        Ok(Environment::Picture(picture))
    }
}
