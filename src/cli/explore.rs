//! `slipmap explore`: parameter space in the browser.

use std::io::{self, Write as _};
use std::net::{Ipv4Addr, TcpListener};
use std::path::{Path, PathBuf};

use clap::Args;

use super::replace::Files;
use super::report::{existing, failure, open as open_map};
use super::{Ended, Failure, interrupt, say};
use slipmap_config::Job;
use slipmap_explore::{Engine, Start, WASM, page};
use slipmap_files::write_file;
use slipmap_model::friction::Law;
use slipmap_serve::Server;

/// The default port, so that links stay valid after the program has ended.
const USUAL_PORT: u16 = 8417;

/// Move through parameter space in the browser.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  slipmap explore
  slipmap explore configs/brake_pad.toml
  slipmap explore results/quickstart.h5 --no-browser
  slipmap explore configs/brake_pad.toml --out pad.html

The page shows any plane of parameter space, what each method claims in it, and everything about the point under the \
mouse. Its address is printed, with a secret in it: nobody else on this computer gets an answer. Ctrl-C ends it. The \
page of --out needs no program: it works in any browser, without a network.")]
pub(super) struct Arguments {
    /// A configuration or a map to begin with
    #[arg(value_name = "CONFIG.toml|MAP.h5")]
    file: Option<PathBuf>,
    /// Port of the page; default: 8417, or a free one if that is taken
    #[arg(long, value_name = "NUMBER")]
    port: Option<u16>,
    /// Only print the address
    #[arg(long)]
    no_browser: bool,
    /// Write the page into a file of its own, which computes in the browser, and end
    #[arg(long, value_name = "FILE.html", conflicts_with_all = ["port", "no_browser"])]
    out: Option<PathBuf>,
    /// Replace the file if it exists
    #[arg(long, requires = "out")]
    overwrite: bool,
}

pub(super) fn run(arguments: &Arguments) -> Result<Ended, Failure> {
    if let Some(out) = &arguments.out {
        return write(out, arguments);
    }
    let start = arguments.file.as_deref().map_or_else(|| Ok(Start::default()), start)?;
    let broken = |error: io::Error| Failure::Broken(format!("the page cannot be served: {error}"));
    let server = Server::new(listen(arguments.port)?).map_err(broken)?;
    let address = server.address();
    let mut out = io::stdout().lock();
    writeln!(out, "{address}")?;
    out.flush()?;
    drop(out);
    if !arguments.no_browser && open::that_detached(&address).is_err() {
        say("note: no browser could be started; open the address yourself");
    }
    say("Ctrl-C ends the page");
    server.run(&start, interrupt::flag()).map_err(broken)?;
    Err(Failure::Interrupted("the page has ended".into()))
}

/// Writes the page that computes in the browser.
fn write(out: &Path, arguments: &Arguments) -> Result<Ended, Failure> {
    if WASM.is_empty() {
        let problem = "--out: this program was built without its part for browsers";
        let remedy =
            "`rustup target add wasm32-unknown-unknown`, and build it by scripts/slipmap; or take a release";
        return Err(Failure::bad_input(problem, remedy));
    }
    Files::reading(&arguments.file).writing("--out", Some(out)).check(arguments.overwrite)?;
    let start = arguments.file.as_deref().map_or_else(|| Ok(Start::default()), start)?;
    write_file(page(&start, Engine::Browser).as_bytes(), out, existing(arguments.overwrite))
        .map_err(failure)?;
    Ok(Ended::Fine)
}

fn start(file: &Path) -> Result<Start, Failure> {
    if file.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("toml")) {
        let job = Job::load(file, &[])?;
        return Ok(Start::of(&job.plan.grid, &job.title, &job.units, &job.uncertain));
    }
    let map = open_map(file)?;
    // The page cannot name it.
    if let Law::Function(_) = map.grid().law().as_written() {
        let problem = "the page shows no law that is a sampled function";
        return Err(Failure::bad_input(problem, "give it as a table, or as a formula"));
    }
    Ok(Start::of(map.grid(), map.text("title").unwrap_or("A map"), &[], &[]))
}

fn listen(port: Option<u16>) -> Result<TcpListener, Failure> {
    let bind = |port: u16| TcpListener::bind((Ipv4Addr::LOCALHOST, port));
    let bound = match port {
        Some(port) => bind(port),
        None => bind(USUAL_PORT).or_else(|_| bind(0)),
    };
    bound.map_err(|error| {
        let port = port.unwrap_or(USUAL_PORT);
        Failure::bad_input(format!("--port {port}: {error}"), "choose another port, or leave it out")
    })
}
