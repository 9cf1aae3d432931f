//! The methods of a map: the closed-form tests, the simulated flow, and common simulation methods.

use std::borrow::Cow;

use slipmap_certify::{Guarantee, TESTS, Test, validated};
use slipmap_model::friction::Law;
use slipmap_orbits::naive::{NaiveKnobs, NaiveMethod};

/// One method of a map.
#[derive(Clone, Copy, Debug)]
pub enum Method {
    /// A closed-form test.
    Test(&'static Test),
    /// The simulated Filippov flow: cells by comparison with critical dampings.
    Simulation,
    /// The direct engine: every cell integrated in position and velocity.
    Direct,
    /// A common simulation method, included to be measured.
    Naive(NaiveMethod, NaiveKnobs),
}

impl PartialEq for Method {
    fn eq(&self, other: &Self) -> bool {
        self.name() == other.name()
    }
}

impl Method {
    /// Every method, in the order of maps and tables; naive ones with their default parameters.
    pub fn all() -> impl Iterator<Item = Method> {
        let naive = NaiveMethod::ALL.map(|method| Method::Naive(method, NaiveKnobs::default()));
        Self::usual().chain([Self::validated(), Method::Direct]).chain(naive)
    }

    /// The computer-assisted proofs.
    pub fn validated() -> Method {
        Method::Test(&validated::TEST)
    }

    /// The default methods: all that have a guarantee and need only microseconds per cell.
    pub fn usual() -> impl Iterator<Item = Method> {
        TESTS.iter().map(Method::Test).chain([Method::Simulation])
    }

    /// The method of this name.
    #[must_use]
    pub fn by_name(name: &str) -> Option<Method> {
        Self::all().find(|method| method.name() == name)
    }

    /// This method; a naive one with the parameters `knobs` instead of its own.
    #[must_use]
    pub fn with_knobs(self, knobs: NaiveKnobs) -> Method {
        match self {
            Method::Test(_) | Method::Simulation | Method::Direct => self,
            Method::Naive(naive, _) => Method::Naive(naive, knobs),
        }
    }

    /// Name in configurations and map files.
    #[must_use]
    pub fn name(&self) -> &'static str {
        match self {
            Method::Test(test) => test.name,
            Method::Simulation => "simulation",
            Method::Direct => "direct",
            Method::Naive(naive, _) => naive.name(),
        }
    }

    /// One phrase for legends and `long_name`.
    #[must_use]
    pub fn long_name(&self) -> &'static str {
        match self {
            Method::Test(test) => test.long_name,
            Method::Simulation => "simulated Filippov flow from the exit point",
            Method::Direct => "simulated Filippov flow, integrated in every cell",
            Method::Naive(naive, _) => naive.long_name(),
        }
    }

    /// Its equation in the paper, or its section of the crate's theory pages.
    #[must_use]
    pub fn equation(&self) -> &'static str {
        match self {
            Method::Test(test) => test.equation,
            Method::Simulation | Method::Direct => {
                "paper, Proposition 1: the orbit from the exit point sticks again"
            }
            Method::Naive(naive, _) => naive.equation(),
        }
    }

    /// [`Method::equation`], with the assumption that a first-order test makes for `law`.
    pub fn equation_for(&self, law: &Law) -> Cow<'static, str> {
        match self {
            Method::Test(test) if test.first_order && law.is_read_as_small() => {
                format!("{}; phi read as 1 + eps F(u) with F = (phi - 1) / eps", test.equation).into()
            }
            _ => self.equation().into(),
        }
    }

    /// The guarantee of its verdicts.
    #[must_use]
    pub fn guarantee(&self) -> Guarantee {
        match self {
            Method::Test(test) => test.guarantee,
            Method::Simulation | Method::Direct => Guarantee::Numerical,
            Method::Naive(..) => Guarantee::None,
        }
    }
}
