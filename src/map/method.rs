//! The methods a map can compare: the closed-form tests, and the simulated flow.

use crate::certify::{Guarantee, TESTS, Test};

/// One method of a map.
#[derive(Clone, Copy, Debug)]
pub enum Method {
    /// A closed-form test.
    Test(&'static Test),
    /// The simulated Filippov flow.
    Simulation,
}

impl PartialEq for Method {
    fn eq(&self, other: &Self) -> bool {
        self.name() == other.name()
    }
}

impl Method {
    /// Every method, in the order in which maps and tables list them.
    pub fn all() -> impl Iterator<Item = Method> {
        TESTS.iter().map(Method::Test).chain([Method::Simulation])
    }

    /// The method of this name.
    #[must_use]
    pub fn by_name(name: &str) -> Option<Method> {
        Self::all().find(|method| method.name() == name)
    }

    /// Name in configurations and map files.
    #[must_use]
    pub fn name(&self) -> &'static str {
        match self {
            Method::Test(test) => test.name,
            Method::Simulation => "simulation",
        }
    }

    /// One phrase for legends and `long_name`.
    #[must_use]
    pub fn long_name(&self) -> &'static str {
        match self {
            Method::Test(test) => test.long_name,
            Method::Simulation => "simulated Filippov flow from the exit point",
        }
    }

    /// Where the method stands in the paper or in the crate's theory pages.
    #[must_use]
    pub fn equation(&self) -> &'static str {
        match self {
            Method::Test(test) => test.equation,
            Method::Simulation => "paper, Proposition 1: the orbit from the exit point sticks again",
        }
    }

    /// What a verdict is worth.
    #[must_use]
    pub fn guarantee(&self) -> Guarantee {
        match self {
            Method::Test(test) => test.guarantee,
            Method::Simulation => Guarantee::Numerical,
        }
    }
}
