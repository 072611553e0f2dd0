//! A program in a real pseudo-terminal: keys in, screen out.

#![allow(
    dead_code,
    reason = "each test that includes this file uses a part of it"
)]

use std::fs::File;
use std::io::{Read, Write};
use std::num::NonZero;
use std::path::Path;
use std::process::Command;
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use rexpect::process::{PtyProcess, WaitStatus};

/// The `stiffbench` that was built with the tests, in a terminal of its own.
pub(crate) struct Terminal {
    process: PtyProcess,
    keys: File,
    screen: Arc<Mutex<vt100::Parser>>,
}

impl Terminal {
    /// Starts it with arguments in a folder, on a screen of so many rows and columns.
    pub(crate) fn start(folder: &Path, arguments: &[&str], (rows, columns): (u16, u16)) -> Self {
        let mut command = Command::new("sh");
        // The size is set from inside, before the program looks at it.
        command
            .args([
                "-c",
                &format!("stty rows {rows} cols {columns}; exec \"$0\" \"$@\""),
            ])
            .arg(env!("CARGO_BIN_EXE_stiffbench"))
            .args(arguments)
            .current_dir(folder)
            .env("TERM", "xterm-256color")
            .env("LC_ALL", "C.UTF-8");
        let process = PtyProcess::new(command).unwrap();
        let mut output = process.get_file_handle().unwrap();
        let keys = process.get_file_handle().unwrap();
        let screen = Arc::new(Mutex::new(vt100::Parser::new(
            NonZero::new(rows).unwrap(),
            NonZero::new(columns).unwrap(),
            0,
        )));
        let drawn = Arc::clone(&screen);
        std::thread::spawn(move || {
            let mut bytes = [0; 4096];
            // A terminal whose program has ended gives an error.
            while let Ok(count @ 1..) = output.read(&mut bytes) {
                drawn.lock().unwrap().process(&bytes[..count]);
            }
        });
        Self {
            process,
            keys,
            screen,
        }
    }

    /// Presses keys.
    pub(crate) fn press(&mut self, keys: &str) {
        self.keys.write_all(keys.as_bytes()).unwrap();
    }

    /// What stands on the screen.
    pub(crate) fn text(&self) -> String {
        self.screen.lock().unwrap().screen().contents()
    }

    /// Waits until a text stands on the screen.
    pub(crate) fn wait_for(&self, text: &str) {
        self.wait_until(&format!("{text:?} on the screen"), |screen| {
            screen.contains(text)
        });
    }

    /// Waits until the screen is as it should be.
    pub(crate) fn wait_until(&self, wanted: &str, is_so: impl Fn(&str) -> bool) {
        // Generous: what takes a second here may take ten on a machine that builds something else meanwhile.
        let last = Instant::now() + Duration::from_secs(120);
        while !is_so(&self.text()) {
            assert!(
                Instant::now() < last,
                "never came: {wanted}\nthe screen is\n{}",
                self.text()
            );
            std::thread::sleep(Duration::from_millis(10));
        }
    }

    /// Waits for the end; the exit code, if it ended by itself.
    pub(crate) fn exit_code(self) -> Option<i32> {
        match self.process.wait().unwrap() {
            WaitStatus::Exited(_, code) => Some(code),
            _ => None,
        }
    }

    /// The screen as it is, with its colours.
    pub(crate) fn screen(&self) -> vt100::Screen {
        self.screen.lock().unwrap().screen().clone()
    }
}
