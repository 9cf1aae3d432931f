//! The attributes of the whole file: provenance of a map, and the course of its run.

use sha2::{Digest, Sha256};

use crate::{Plan, PlaneCurves, Summary};
use slipmap_column::Method;
use slipmap_machine::MOTION_ATTRIBUTE;

use super::{Auxiliary, SCHEMA, Value, auxiliary, hex};

/// Reference for the mathematics of the tests.
const REFERENCES: &str = "O. Makarenkov, A new test for stick-slip limit cycles in dry-friction \
                          oscillators with small nonlinear friction characteristics";

/// Provenance of a map, known before the run.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Provenance {
    /// The map's title.
    pub title: String,
    /// Path of the configuration.
    pub config_path: String,
    /// Text of the configuration, overrides included.
    pub config_text: String,
    /// The command that started the run.
    pub command_line: String,
    /// The commit that the program was built from.
    pub git: String,
    /// Number of threads that compute cells; 0 where none do.
    pub threads: usize,
}

/// The course of a run, known at its end.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Outcome {
    /// Attributes of the file: threads, seconds, results of the audit and others.
    pub attributes: Vec<(String, Value)>,
    /// The curves of codimension one.
    pub curves: Vec<PlaneCurves>,
    /// The variables beside those of the cells.
    pub auxiliary: Vec<Auxiliary>,
}

impl Outcome {
    /// The outcome of the run of `plan` from its `summary`.
    #[must_use]
    pub fn of(plan: &Plan, summary: &Summary) -> Self {
        let account = &summary.account;
        let mut attributes: Vec<(String, Value)> = Vec::new();
        let mut add = |name: &str, value: Value| attributes.push((name.to_owned(), value));
        add("threads", integer(summary.threads));
        add("wall_seconds", summary.seconds.into());
        for (method, found) in plan.methods.iter().zip(&account.methods) {
            add(&format!("seconds_{}", method.name()), found.seconds.into());
        }
        if plan.audit_cells > 0 {
            add("audit_cells", integer(account.audit.cells));
            add("audit_disagreements", integer(account.audit.disagreements.len()));
        }
        for (path, cells) in account.paths.named() {
            add(&format!("cells_by_{path}"), integer(cells));
        }
        add("rhs", integer(account.rhs));
        add("contradicted_cells", integer(account.contradictions.cells));
        for (stage, seconds) in account.stages.named() {
            add(&format!("{stage}_seconds"), seconds.into());
        }
        if let Some(proved) = &summary.proved {
            let shares = proved.proof.shares();
            add("proved_present", shares.present.into());
            add("proved_absent", shares.absent.into());
            add("proved_undecided_at_most", shares.undecided().into());
            add("proved_boxes", integer(proved.proof.tried));
            add("proved_seconds", proved.seconds.into());
        }
        Self { attributes, curves: summary.curves.clone(), auxiliary: auxiliary::fixed(&plan.grid) }
    }
}

/// An integer as an attribute, limited to the range of the file's integers.
fn integer(number: impl TryInto<i64>) -> Value {
    Value::Integers(vec![number.try_into().unwrap_or(i64::MAX)])
}

/// Words separated by blanks, as in `flag_meanings`.
fn words<'a>(list: impl IntoIterator<Item = &'a str>) -> Value {
    Value::Text(list.into_iter().collect::<Vec<_>>().join(" "))
}

/// The provenance attributes that all files share.
pub fn origin(provenance: &Provenance) -> Vec<(&'static str, Value)> {
    let version = env!("CARGO_PKG_VERSION");
    vec![
        ("Conventions", "CF-1.11".into()),
        ("title", provenance.title.as_str().into()),
        ("source", format!("slipmap {version}").into()),
        ("references", REFERENCES.into()),
        ("crate_version", version.into()),
        ("git", provenance.git.as_str().into()),
        ("machine", machine().into()),
        ("config", provenance.config_text.as_str().into()),
        ("config_path", provenance.config_path.as_str().into()),
        ("config_sha256", fingerprint(&provenance.config_text).into()),
    ]
}

/// Name of the attribute, in the journal and in the map, with the fingerprint [`plan_digest`]. Other parts of
/// the configuration (comments, the title, output paths) may differ between two runs that make the same map.
pub const PLAN: &str = "plan_sha256";

/// Fingerprint of everything that a map depends on: the plan and the version of the program, built from the
/// commit `git`.
pub fn plan_digest(plan: &Plan, git: &str) -> String {
    let Plan { grid, methods, fields, tolerance, audit_cells, proof_boxes, planes, tile_shape, compression } =
        plan;
    let methods: Vec<String> = methods
        .iter()
        .map(|method| match method {
            Method::Test(_) | Method::Simulation | Method::Direct => method.name().to_owned(),
            Method::Naive(naive, knobs) => format!("{naive:?} {knobs:?}"),
        })
        .collect();
    // Rust's text of a number is parsed to the same number, so equal texts mean equal plans.
    fingerprint(&format!(
        "{} {} {grid:?} {methods:?} {fields:?} {tolerance:?} {audit_cells} {proof_boxes} {planes:?} {tile_shape:?} {compression}",
        env!("CARGO_PKG_VERSION"),
        git
    ))
}

/// The root attributes known before the run.
#[must_use]
pub fn opening(plan: &Plan, provenance: &Provenance) -> Vec<(String, Value)> {
    let machine = plan.grid.machine();
    let mut of_maps: Vec<(&str, Value)> = vec![
        ("schema", SCHEMA.into()),
        ("law", plan.grid.law().name().into()),
        ("law_definition", plan.grid.law().definition().into()),
        ("methods", words(plan.methods.iter().map(Method::name))),
        ("fields", words(plan.fields.iter().map(|field| field.name_for(machine.is_some())))),
        ("tolerance", plan.tolerance.into()),
        ("tile_shape", Value::Integers(plan.tile_shape.iter().map(|&len| len as i64).collect())),
        ("compression", integer(plan.compression)),
        (PLAN, plan_digest(plan, &provenance.git).into()),
    ];
    of_maps.extend(machine.map(|machine| (MOTION_ATTRIBUTE, machine.motion.name().into())));
    let attributes = origin(provenance).into_iter().chain(of_maps);
    attributes.map(|(name, value)| (name.to_owned(), value)).collect()
}

/// One line of the attribute `history`: date, version and command.
#[must_use]
pub fn history(provenance: &Provenance) -> String {
    let date = humantime::format_rfc3339_millis(std::time::SystemTime::now());
    format!("{date} slipmap {}: {}", env!("CARGO_PKG_VERSION"), provenance.command_line)
}

/// The root attributes known at the end.
#[must_use]
pub fn closing(outcome: &Outcome) -> Vec<(String, Value)> {
    let complete = ("complete".to_owned(), Value::from(1));
    outcome.attributes.iter().cloned().chain([complete]).collect()
}

/// SHA-256 of a text, in hexadecimal digits.
#[must_use]
pub fn fingerprint(text: &str) -> String {
    hex(&Sha256::digest(text.as_bytes()))
}

/// Host name, processor and number of usable cores; "unknown" where the system does not report them.
fn machine() -> String {
    let read = |path: &str| std::fs::read_to_string(path).ok().filter(|text| !text.trim().is_empty());
    let host = read("/proc/sys/kernel/hostname")
        .map(|name| name.trim().to_owned())
        .or_else(|| std::env::var("HOSTNAME").ok())
        .or_else(|| std::env::var("COMPUTERNAME").ok());
    let processor = read("/proc/cpuinfo").and_then(|text| {
        let line = text.lines().find(|line| line.starts_with("model name"))?;
        Some(line.split_once(':')?.1.trim().to_owned())
    });
    let unknown = || "unknown".to_owned();
    let cores = std::thread::available_parallelism().map_or_else(|_| unknown(), |cores| cores.to_string());
    format!(
        "host {}, processor {}, {cores} cores",
        host.unwrap_or_else(unknown),
        processor.unwrap_or_else(unknown)
    )
}
