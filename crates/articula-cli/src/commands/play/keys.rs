//! Keys of a terminal, as they are pressed.

use super::event::{Event, Key};
use std::sync::mpsc::Sender;

/// A terminal that hands over each key; it is as before when this is dropped.
pub(super) struct Keys {
    #[cfg(unix)]
    before: rustix::termios::Termios,
}

impl Keys {
    /// Reads keys of standard input on a thread; `None` if it is no terminal.
    #[cfg(unix)]
    pub(super) fn start(events: &Sender<Event>) -> Option<Self> {
        use rustix::termios::{LocalModes, OptionalActions, tcgetattr, tcsetattr};
        let before = tcgetattr(std::io::stdin()).ok()?;
        let mut single = before.clone();
        // Ctrl-C still ends the program.
        single
            .local_modes
            .remove(LocalModes::ICANON | LocalModes::ECHO);
        tcsetattr(std::io::stdin(), OptionalActions::Now, &single).ok()?;
        let events = events.clone();
        std::thread::spawn(move || read(std::io::stdin(), &events));
        Some(Self { before })
    }

    /// Keys are read where terminals are those of Unix.
    #[cfg(not(unix))]
    pub(super) fn start(_events: &Sender<Event>) -> Option<Self> {
        None
    }
}

#[cfg(unix)]
impl Drop for Keys {
    fn drop(&mut self) {
        use rustix::termios::{OptionalActions, tcsetattr};
        // A terminal that is gone needs nothing.
        let _ = tcsetattr(std::io::stdin(), OptionalActions::Now, &self.before);
    }
}

/// Reads keys until nobody listens.
#[cfg(any(unix, test))]
fn read(mut input: impl std::io::Read, events: &Sender<Event>) {
    let mut bytes = [0; 16];
    while let Ok(count @ 1..) = input.read(&mut bytes) {
        if let Some(key) = key(&bytes[..count])
            && events.send(Event::Key(key)).is_err()
        {
            return;
        }
    }
}

/// The key of the bytes that a terminal sends for it.
#[cfg(any(unix, test))]
fn key(bytes: &[u8]) -> Option<Key> {
    match bytes {
        b"\x1b[C" | b"+" => Some(Key::Bandwidth(true)),
        b"\x1b[D" | b"-" => Some(Key::Bandwidth(false)),
        b"\x1b[A" => Some(Key::Distance(true)),
        b"\x1b[B" => Some(Key::Distance(false)),
        [digit @ b'1'..=b'9'] => Some(Key::Clip(usize::from(digit - b'1'))),
        b"m" => Some(Key::Monitor),
        b"q" => Some(Key::Quit),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arrows_are_sliders() {
        let (sender, events) = std::sync::mpsc::channel();
        for bytes in [&b"\x1b[C"[..], b"x", b"q"] {
            read(bytes, &sender);
        }
        let keys: Vec<Key> = events
            .try_iter()
            .map(|event| match event {
                Event::Key(key) => key,
                other => panic!("{other:?}"),
            })
            .collect();
        assert_eq!(keys, [Key::Bandwidth(true), Key::Quit]);
        assert_eq!(key(b"\x1b[B"), Some(Key::Distance(false)));
        assert_eq!((key(b"1"), key(b"0")), (Some(Key::Clip(0)), None));
    }
}
