//! Where in parameter space a dry-friction oscillator on a moving belt stick-slips, which mathematical
//! test proves it, where each test fails, and what each answer costs.
//!
//! A mass on a spring rides on a belt of speed V. Friction that weakens with the slip speed can drive it
//! into a cycle of sticking and slipping. Six numbers decide: eps, the alpha, beta and gamma of the
//! friction law, V, and the damping c. This crate answers the question "does a stick-slip cycle exist?" by
//! closed-form tests ([`certify`]) and by the simulated flow ([`orbits`], [`mod@column`]), at one point or at every cell
//! of a grid ([`map`]). The mathematics is in [`theory`].
//!
//! # One point
//! ```
//! use slipmap::certify::{self, Decision, Guarantee};
//! use slipmap::filippov::Oscillator;
//! use slipmap::friction::Law;
//! use slipmap::column::critical_damping;
//! use slipmap::flow::Fate;
//! use slipmap::orbits::flow;
//!
//! // eps; alpha, beta, gamma; V; c.
//! let point = Law::Stribeck.point(0.1, &[0.4, 0.2, 2.0], 1.0, 0.6)?;
//!
//! // The simulated flow: the orbit that leaves the belt spirals inward, so there is no cycle.
//! let answer = flow(&Oscillator::new(&Law::Stribeck, &point), 1e-9);
//! assert_eq!(answer.fate, Fate::SpiralsInward);
//! assert!(answer.margin < -answer.margin_error);
//!
//! // The paper's first-order test claims one; the test that is a theorem at every eps denies it.
//! let column = Law::Stribeck.column(&point);
//! let decide = |test: &slipmap_certify::Test| test.claim(&column).decide(point.damping);
//! assert_eq!(decide(&slipmap_certify::perturbation::TEST), Decision::Present);
//! assert_eq!(decide(&slipmap_certify::symmetric::TEST), Decision::Absent);
//! assert_eq!(slipmap_certify::symmetric::TEST.guarantee, Guarantee::FiniteEpsilon);
//!
//! // All dampings at once: the cycle exists below the critical damping and not above it.
//! let critical = critical_damping(&column, 1e-12)?;
//! assert!(slipmap_certify::instability::TEST.claim(&column).present_below < critical.c);
//! assert!(critical.c < slipmap_certify::symmetric::TEST.claim(&column).absent_above);
//! let slower = Law::Stribeck.point(0.1, &[0.4, 0.2, 2.0], 1.0, 0.9 * critical.c)?;
//! match flow(&Oscillator::new(&Law::Stribeck, &slower), 1e-9).fate {
//!     Fate::Sticks(landing) => {
//!         let period = landing.slip_time + landing.stick_time;
//!         assert!((period - 2.0 * std::f64::consts::PI).abs() < 0.1);
//!     }
//!     other => panic!("{other:?}"),
//! }
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Features
//! `store` (the map file, with the HDF5 library), `report` (tables and figures), `config` (configuration
//! files), `cli` (the program) and `explore` (its web page) are on by default; `static` builds HDF5 into the
//! program. With none of them, or only `config`, the crate is pure Rust.
//!
//! This crate only shows what the inner crates of its workspace do. What is hidden here (`assessment`, `cli`,
//! `explore`, `report`, `study`) belongs to the program: it is public for the program's tests, and may change
//! at any time.

pub use slipmap_certify as certify;
pub use slipmap_machine::{behaviour, probe, risk};
pub use slipmap_map::dataset;
pub use slipmap_model::{filippov, flow, point};
pub use slipmap_witness as witness;

#[cfg(feature = "config")]
pub use slipmap_config as config;
#[cfg(feature = "store")]
pub use slipmap_files as files;
#[cfg(feature = "config")]
pub use slipmap_fit as fit;
#[cfg(feature = "store")]
pub use slipmap_format as store;

#[cfg(feature = "explore")]
#[doc(hidden)]
pub use slipmap_explore as explore;
#[doc(hidden)]
pub use slipmap_machine::assessment;
#[cfg(feature = "report")]
#[doc(hidden)]
pub use {slipmap_report as report, slipmap_study as study};

/// The commit that the library was built from.
pub const GIT: &str = env!("SLIPMAP_GIT");

#[cfg(feature = "cli")]
#[doc(hidden)]
pub mod cli;

/// Tries the code of the guide.
#[cfg(doctest)]
#[doc = include_str!("../docs/install.md")]
mod guide {}

pub mod friction {
    //! Friction laws: the force phi(u) at slip speed u >= 0 in units of the static force, phi(0) = 1.
    //!
    //! A [`Law`] is a family with named parameters, each of which becomes an axis of a map. Fixing eps and the
    //! parameters gives a [`Curve`], a function of the slip speed.
    //!
    //! A point is legal for its law, or there is none:
    //! ```
    //! use slipmap::friction::Law;
    //!
    //! let point = Law::Stribeck.point(0.1, &[0.4, 0.2, 2.0], 1.0, 0.6)?;
    //! assert_eq!(point.damping, 0.6);
    //! let backwards = Law::Stribeck.point(0.1, &[0.4, 0.2, 2.0], -1.0, 0.6);
    //! assert_eq!(backwards.unwrap_err().to_string(), "V is -1.0; it must be greater than 0");
    //! # Ok::<(), slipmap::friction::PointError>(())
    //! ```
    //!
    //! A law of your own:
    //! ```
    //! use slipmap::certify::TESTS;
    //! use slipmap::filippov::Oscillator;
    //! use slipmap::friction::{CustomLaw, Law, Parameter};
    //! use slipmap::column::critical_damping;
    //! use slipmap::flow::Fate;
    //! use slipmap::orbits::flow;
    //!
    //! /// The friction of R. I. Leine and others, 1 / (1 + a u).
    //! #[derive(Debug)]
    //! struct Hyperbola([Parameter; 1]);
    //!
    //! impl CustomLaw for Hyperbola {
    //!     fn name(&self) -> &'static str {
    //!         "hyperbola"
    //!     }
    //!     fn parameters(&self) -> &[Parameter] {
    //!         &self.0
    //!     }
    //!     fn phi(&self, u: f64, _epsilon: f64, a: &[f64]) -> f64 {
    //!         1.0 / (1.0 + a[0] * u)
    //!     }
    //!     fn slope(&self, u: f64, _epsilon: f64, a: &[f64]) -> f64 {
    //!         -a[0] / (1.0 + a[0] * u).powi(2)
    //!     }
    //! }
    //!
    //! let a = Parameter { name: "a", long_name: "rate of weakening", min: 0.0, max: f64::INFINITY };
    //! let law = Law::custom(Hyperbola([a]))?;
    //! let point = law.point(1.0, &[3.0], 0.2, 0.0)?;
    //! let oscillator = Oscillator::new(&law, &point);
    //! assert!(matches!(flow(&oscillator, 1e-9).fate, Fate::Sticks(_)));
    //! let column = law.column(&point);
    //! let critical = critical_damping(&column, 1e-9)?;
    //! assert!((1.0..2.0).contains(&critical.c) && critical.error < 1e-8);
    //! // Of functions nothing is proved: the theorems are silent.
    //! let symmetric = TESTS.iter().find(|test| test.name == "symmetric").unwrap();
    //! assert_eq!(symmetric.claim(&column).present_below, f64::NEG_INFINITY);
    //! # Ok::<(), Box<dyn std::error::Error>>(())
    //! ```

    pub use slipmap_model::friction::{
        Accuracy, Column, Curve, Custom, CustomLaw, CustomLawError, Expression, ExpressionError, Function,
        FunctionError, Gradient, Law, Parameter, PointError, Range, Stribeck, Table, TableError, Weakening,
    };
}

pub mod map {
    //! Maps: axes, grid, tiles, the parallel engine, and the interface of a sink of tiles.
    //!
    //! What a map computes is a [`Plan`]:
    //! ```
    //! use slipmap::friction::Law;
    //! use slipmap::column::Method;
    //! use slipmap::map::{Field, Grid, Plan};
    //!
    //! // eps, alpha, beta, gamma, V, c: two columns of three cells.
    //! let nodes = [vec![0.1], vec![0.4], vec![0.2], vec![1.0, 2.0], vec![1.0], vec![0.0, 0.3, 0.6]];
    //! let grid = Grid::new(Law::Stribeck, nodes.to_vec())?;
    //! let plan = Plan::builder(grid).methods([Method::Simulation]).fields([Field::CriticalC]).build()?;
    //! assert_eq!(plan.fields, [Field::Verdict, Field::CriticalC]);
    //! # Ok::<(), Box<dyn std::error::Error>>(())
    //! ```
    //!
    //! [`run`] computes it, and hands its tiles to a [`Sink`], such as a function of [`Each`]:
    //! ```
    //! use slipmap::friction::Law;
    //! use slipmap::column::Verdict;
    //! use slipmap::map::{self, Control, Each, Grid, Plan};
    //!
    //! let nodes = [vec![0.1], vec![0.4], vec![0.2], vec![2.0], vec![1.0], vec![0.0, 0.3, 0.9]];
    //! let plan = Plan::builder(Grid::new(Law::Stribeck, nodes.to_vec())?).build()?;
    //! // The cells are forgotten; what is counted remains.
    //! let summary = map::run(&plan, &Each(|_| {}), &Control::default())?;
    //! let simulation = summary.account.methods.last().expect("it is among the usual methods");
    //! assert_eq!(simulation.cells_with(Verdict::Present), 2);
    //! # Ok::<(), Box<dyn std::error::Error>>(())
    //! ```

    pub use slipmap_map::{
        Account, Audit, Axis, AxisRole, Chances, ComputeError, Contradiction, Contradictions, Control,
        Description, Disagreement, Each, FailedCell, Field, Grid, GridError, MethodAccount, MethodCells,
        Paths, Plan, PlanBuilder, PlanError, Plane, PlaneCurve, PlaneCurves, PlanePoint, Probabilities,
        Quantity, Queue, Runs, Shard, Shown, Sink, Stages, Summary, Tile, TileData, Unknown, compute_tiles,
        decide, run, unravel,
    };
}

pub mod column {
    //! A friction curve at a belt speed, at every damping: critical damping, cycles, regimes, curves in planes.

    pub use slipmap_column::{
        Attractors, BasinBoundary, Behaviour, Change, ChangeKind, CriticalDamping, DEFAULT_TOLERANCE, End,
        LongRun, Method, Neighbour, NoCriticalDamping, Regime, TOLERANCES, Verdict, backbone, bifurcation,
        continuation, critical, critical_damping, crossing, crossing_separates, limits, long_run, points,
        regime, sensitivity, separates, slip_cycle, slip_cycle_count, slip_cycles,
    };
}

pub mod orbits {
    //! Orbits followed at one damping, and the naive methods whose errors are measured.

    pub use slipmap_orbits::{Cycle, Effort, Piece, Work, arc, far_loops, flow, grazing, naive};
}

pub mod machine {
    //! Machines in SI units, and their dimensionless oscillators.

    pub use slipmap_machine::{
        AREA, BELT_SPEED, Coefficients, DAMPING, DAMPING_RATIO, Dimension, FREQUENCY, Friction, Given,
        INERTIA, MASS, Machine, Model, Motion, NORMAL_FORCE, Normal, PRESSURE, RADIUS, Units, requirement,
        unit,
    };
}

pub mod theory {
    //! The mathematics: `src/theory.md`, which `scripts/theory` makes a page with formulas and a PDF.
    //!
    //! Its sections: model, forms of the slip flow, scaling, monotonicity, fates of an orbit, the tests and their errors in
    //! eps, any friction law, breakaway, the backbone; with proofs, and a table from each statement to the function that
    //! uses it and the test that checks it. Documentation of items names them as (theory, "Scaling").
}
