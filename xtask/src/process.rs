//! Running other programs, and saying what is done.

use std::{
    env,
    ffi::OsStr,
    path::{Path, PathBuf},
    process::Command,
};

use anyhow::{Context as _, Result, bail};

/// Says in one line what is being done.
pub fn say(text: &str) {
    eprintln!("xtask: {text}");
}

/// True on a continuous-integration machine, where leaving something out is a failure.
pub fn is_ci() -> bool {
    env::var_os("CI").is_some_and(|value| !value.is_empty() && value != "false" && value != "0")
}

/// The top of the repository.
pub fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap_or(Path::new("."))
}

/// The folder cargo builds into.
pub fn target_dir() -> PathBuf {
    let set = env::var_os("CARGO_TARGET_DIR").map_or_else(|| "target".into(), PathBuf::from);
    root().join(set)
}

/// `cargo` with `arguments`, at the top of the repository.
pub fn cargo<A: AsRef<OsStr>>(arguments: impl IntoIterator<Item = A>) -> Program {
    let cargo = env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    Program::new(cargo, arguments)
}

/// A program about to be run at the top of the repository.
pub struct Program(Command);

impl Program {
    /// `program` with `arguments`.
    pub fn new<A: AsRef<OsStr>>(
        program: impl AsRef<OsStr>,
        arguments: impl IntoIterator<Item = A>,
    ) -> Self {
        let mut command = Command::new(program);
        command.args(arguments).current_dir(root());
        Self(command)
    }

    /// Sets an environment variable.
    pub fn env(mut self, name: &str, value: impl AsRef<OsStr>) -> Self {
        self.0.env(name, value);
        self
    }

    /// Adds arguments.
    pub fn args<A: AsRef<OsStr>>(mut self, arguments: impl IntoIterator<Item = A>) -> Self {
        self.0.args(arguments);
        self
    }

    /// Runs it with this terminal; an error if it cannot be started or fails.
    pub fn run(mut self) -> Result<()> {
        let status = self.0.status().with_context(|| format!("cannot start {}", self.line()))?;
        if !status.success() {
            bail!("failed ({status}): {}", self.line());
        }
        Ok(())
    }

    /// Goes on as this program, so that Ctrl-C and the exit code are its own; where that cannot be
    /// done, runs it.
    pub fn become_it(self) -> Result<()> {
        #[cfg(unix)]
        {
            let Self(mut command) = self;
            let error = std::os::unix::process::CommandExt::exec(&mut command);
            Err(error).with_context(|| format!("cannot start {}", Self(command).line()))
        }
        #[cfg(not(unix))]
        self.run()
    }

    /// Runs it silently and gives what it printed, without the last line end.
    pub fn output(mut self) -> Result<String> {
        let output = self.0.output().with_context(|| format!("cannot start {}", self.line()))?;
        if !output.status.success() {
            let reason = String::from_utf8_lossy(&output.stderr).trim().to_owned();
            bail!("failed ({}): {}\n{reason}", output.status, self.line());
        }
        Ok(String::from_utf8_lossy(&output.stdout).trim_end().to_owned())
    }

    fn line(&self) -> String {
        let words = std::iter::once(self.0.get_program()).chain(self.0.get_args());
        words.map(OsStr::to_string_lossy).collect::<Vec<_>>().join(" ")
    }
}

/// The full path of `program`, if it is on the search path.
pub fn which(program: &str) -> Option<PathBuf> {
    let paths = env::var_os("PATH")?;
    env::split_paths(&paths).map(|folder| folder.join(program)).find(|path| path.is_file())
}
