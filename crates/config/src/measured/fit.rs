//! Measured friction as readings for a fit, and a fit as the table `[friction]` of a configuration.

use std::fmt::Write as _;

use super::{Measured, MeasuredReading};
use slipmap_fit::{Fit, Form, NoFit, Reading, Reduced, fits};
use slipmap_machine::{AREA, Coefficients, Dimension, NORMAL_FORCE, PRESSURE, RADIUS};
use slipmap_numbers::text::{known_part, rounded, short, with_error};
use toml_edit::{DocumentMut, Item, TomlError};

/// A law fitted to measured friction, in SI units.
#[derive(Clone, Debug, serde::Serialize, schemars::JsonSchema)]
pub struct FittedLaw {
    /// Its name in the table of laws.
    law: String,
    /// Friction as a formula in the slip speed u.
    formula: String,
    /// Akaike's criterion for small samples: only differences between laws fitted to the same readings mean anything.
    aicc: f64,
    /// Root mean square of the residuals in slip.
    residual: f64,
    /// The sum of the squares of the residuals in units of the standard errors, divided by the degrees of freedom;
    /// `None` for readings without standard errors.
    reduced_chi_squared: Option<f64>,
    /// The parameters.
    names: Vec<String>,
    values: Vec<f64>,
    standard_errors: Vec<f64>,
    /// Their units; empty for a pure number.
    units: Vec<String>,
    covariance: Vec<Vec<f64>>,
    /// Friction at rest, where it drops as slip begins.
    #[serde(rename = "static")]
    at_rest: Option<f64>,
    /// `None` of a single reading, which does not say.
    static_standard_error: Option<f64>,
}

/// Standard errors from which friction rises.
const SURE: f64 = 2.0;
/// Difference of Akaike's criterion up to which a law is about as good as the best one.
const AS_GOOD: f64 = 4.0;

/// What is said of the error of a single reading at rest.
pub const ONE_AT_REST: &str = "by one reading, which does not say its error";

/// Laws fitted to measured friction: what `slipmap fit --json` prints.
#[derive(Clone, Debug, serde::Serialize, schemars::JsonSchema)]
pub struct Fitted {
    /// The file.
    data: String,
    /// What has been understood of it, one phrase each.
    read: Vec<String>,
    /// "force" (of a rotation a torque) or "coefficient".
    quantity: &'static str,
    speed_unit: &'static str,
    /// Empty for a coefficient.
    friction_unit: &'static str,
    /// Largest slip speed of the readings.
    fastest: Option<f64>,
    /// The best law, or the one that was asked for.
    fit: FittedLaw,
    /// All laws, the best one first.
    fits: Vec<FittedLaw>,
    /// The number of laws that are about as good as the best one.
    about_as_good: usize,
    /// That there is no stick-slip, and why; `None` for friction that falls or drops.
    no_stick_slip: Option<String>,
    /// Slip speeds of the residuals: those of the readings, of a record over time those of its means.
    slip_speeds: Vec<f64>,
    /// Readings less the law.
    residuals: Vec<f64>,
    /// How much more the residuals follow smooth curves than by chance, in standard deviations: far above 0 where the law does
    /// not follow the readings.
    lack_of_fit: f64,
}

/// Largest number of independent readings that are fitted themselves.
const MOST_READINGS: usize = 2000;

/// Readings in slip and at rest, and the curve whose errors those in slip have.
type Readings = ([Vec<Reading>; 2], Option<Reduced>);

/// The fits to measured friction.
#[derive(Clone, Debug)]
pub struct Fits {
    /// All laws, the best one first.
    pub all: Vec<Fit>,
    chosen: usize,
    slip_speeds: Vec<f64>,
}

impl Fits {
    /// The best fit, or the one that was asked for.
    pub fn chosen(&self) -> &Fit {
        &self.all[self.chosen]
    }

    /// The number of laws that are about as good as the best one, which is not counted.
    pub fn about_as_good(&self) -> usize {
        self.all[1..].iter().filter(|fit| fit.aicc - self.all[0].aicc <= AS_GOOD).count()
    }
}

impl Measured {
    /// Fits all laws; `law` is the one that is asked for in place of the best one.
    ///
    /// # Errors
    /// The problem with its line, and a remedy.
    pub fn fits(&self, law: Option<Form>) -> Result<Fits, (String, String)> {
        let ([in_slip, at_rest], curve) = self.readings()?;
        let root = curve.and_then(|curve| curve.root(0));
        let all = fits(&in_slip, &at_rest, root.as_ref()).map_err(|why| {
            let (problem, remedy) = match why {
                NoFit::TooFew(fewest) => {
                    ("there are too few slip speeds", format!("give at least {fewest} readings in slip"))
                }
                NoFit::Negative => (
                    "friction is negative at every slip speed",
                    "check the sign, and the zero of the measurement".into(),
                ),
                NoFit::None => (
                    "no law follows from the readings",
                    "take the readings as they are: law = \"table\"".into(),
                ),
            };
            (format!("{}: {problem}", self.name), remedy)
        })?;
        let chosen = match law {
            None => 0,
            Some(law) => all.iter().position(|fit| fit.form == law).ok_or_else(|| {
                let problem = format!("the readings have no fit of this law: {}", words_of(law));
                (problem, format!("choose from: {}", all_words(all.iter().map(|fit| fit.form))))
            })?,
        };
        Ok(Fits { all, chosen, slip_speeds: in_slip.iter().map(|reading| reading.speed).collect() })
    }

    /// The fits as they are told to programs.
    pub fn fitted(&self, fits: &Fits) -> Fitted {
        let law = |fit: &Fit| FittedLaw {
            law: words_of(fit.form),
            formula: self.named(&fit.form.formula()),
            aicc: fit.aicc,
            residual: fit.residual,
            reduced_chi_squared: fit.reduced,
            names: fit.form.names().into_iter().map(|name| self.named(name)).collect(),
            values: fit.values.clone(),
            standard_errors: fit.errors(),
            units: fit.form.names().into_iter().map(|name| self.unit_of(name).to_owned()).collect(),
            covariance: fit.covariance.row_iter().map(|row| row.iter().copied().collect()).collect(),
            at_rest: fit.at_rest.map(|[level, _]| level),
            static_standard_error: self.error_at_rest(fit),
        };
        let chosen = fits.chosen();
        Fitted {
            data: self.name.clone(),
            read: self.said.clone(),
            quantity: if self.holds_forces() { "force" } else { "coefficient" },
            speed_unit: self.speed_unit(),
            friction_unit: self.friction_unit(),
            fastest: self.in_slip.last().map(|row| row.speed),
            fit: law(chosen),
            fits: fits.all.iter().map(law).collect(),
            about_as_good: fits.about_as_good(),
            no_stick_slip: self.no_stick_slip(chosen),
            slip_speeds: fits.slip_speeds.clone(),
            residuals: chosen.residuals.clone(),
            lack_of_fit: chosen.lack,
        }
    }

    /// The readings for a fit, in slip and at rest: those of a record over time, which are not independent, and of two
    /// directions, which differ, or very many, as the curve to which they are reduced, which has correlated errors.
    ///
    /// # Errors
    /// The problem with its line, and a remedy.
    pub fn readings(&self) -> Result<Readings, (String, String)> {
        let of = |readings: &[MeasuredReading]| -> Vec<Reading> {
            let of = |&MeasuredReading { speed, friction, error, .. }: &MeasuredReading| Reading {
                speed,
                friction,
                error,
            };
            readings.iter().map(of).collect()
        };
        let exact = |row: &&MeasuredReading| row.error == 0.0;
        if let Some(row) = self.at_rest.iter().chain(&self.in_slip).find(exact) {
            let problem = format!("{}:{}: the standard error is 0", self.name, row.line);
            return Err((problem, "write the error that the reading has, or leave all of them out".into()));
        }
        let has = |backward: bool| self.in_slip.iter().any(|row| row.backward == backward);
        let is_reduced = self.is_record || has(true) && has(false) || self.in_slip.len() > MOST_READINGS;
        let curve = if is_reduced { self.reduced() } else { None };
        let Some(mut curve) = curve else { return Ok(([of(&self.in_slip), of(&self.at_rest)], None)) };
        (curve.speeds, curve.friction, curve.covariance) = curve.by_rows.clone();
        let knots = curve.speeds.iter().zip(curve.friction.iter()).zip(curve.errors());
        let knots = knots.map(|((&speed, &friction), error)| Reading { speed, friction, error });
        let rest = self.at_breakaway(&self.at_rest, curve.scatter);
        let rest = rest.map(|[friction, error]| Reading { speed: 0.0, friction, error });
        Ok(([knots.collect(), rest.into_iter().collect()], Some(curve)))
    }

    /// That there is no stick-slip, and why; `None` for friction that falls or drops, or may fall.
    pub fn no_stick_slip(&self, fit: &Fit) -> Option<String> {
        let [.., rise] = fit.values[..] else { return None };
        let error = fit.errors().last().copied()?;
        match (fit.form.falls(), fit.form.viscous) {
            (true, _) => None,
            (false, false) => Some(
                "friction neither falls nor drops within its errors: no stick-slip at any damping above 0"
                    .into(),
            ),
            (false, true) if rise > SURE * error => Some(format!(
                "friction rises with the slip speed by {} {}: no stick-slip at any damping",
                with_error(rise, error),
                self.unit_of("B")
            )),
            (false, true) => None,
        }
    }

    /// The standard error of the friction at rest of a fit with a drop; `None` of a single reading without one, which does not say.
    pub fn error_at_rest(&self, fit: &Fit) -> Option<f64> {
        fit.at_rest.map(|[_, error]| error).filter(|_| self.say_their_error(&self.at_rest))
    }

    /// Whether the friction is a force; where nothing says so it is a coefficient.
    pub fn holds_forces(&self) -> bool {
        self.forces == Some(true)
    }

    /// The unit of the slip speeds.
    pub fn speed_unit(&self) -> &'static str {
        self.motion.unit(Dimension::Velocity)
    }

    /// The unit of the friction; empty for a coefficient.
    pub fn friction_unit(&self) -> &'static str {
        if self.holds_forces() { self.motion.unit(Dimension::Force) } else { "" }
    }

    /// The name of a parameter of a fit, or a formula with such names: F for forces, mu for coefficients.
    pub fn named(&self, text: &str) -> String {
        if self.holds_forces() { text.to_owned() } else { text.replace("F_", "mu_") }
    }

    /// The unit of a parameter of a fit.
    pub fn unit_of(&self, parameter: &str) -> &'static str {
        self.motion.unit_of_fitted(parameter, self.holds_forces())
    }

    /// A configuration of a machine with a fit in place of its friction: without `[friction]`, coefficients, and of
    /// forces without a normal force. What is left out of a normal force is the second one; of coefficients at a normal force
    /// that of the measurement stands where the machine has none.
    ///
    /// # Errors
    /// What is no configuration of a machine, or one with several normal forces for a fit of forces, and a remedy.
    pub fn into_configuration(&self, fit: &Fit, text: &str) -> Result<(String, String), (String, String)> {
        let no_machine = |problem: String| {
            (
                problem,
                "name a configuration with a table [machine]; slipmap init machine writes one".to_owned(),
            )
        };
        let mut document: DocumentMut =
            text.parse().map_err(|why: TomlError| no_machine(why.to_string().trim().to_owned()))?;
        let machine = document.get_mut("machine").and_then(Item::as_table_like_mut);
        let machine = machine.ok_or_else(|| no_machine("it has no table [machine]".into()))?;
        for name in Coefficients::NAMES {
            machine.remove(name);
        }
        let mut left_out = Vec::new();
        for name in [NORMAL_FORCE, PRESSURE, AREA, RADIUS].into_iter().filter(|_| self.holds_forces()) {
            let Some(value) = machine.remove(name) else { continue };
            if value.is_array() || value.is_table_like() {
                let problem =
                    format!("{name} is more than one number, and the fit is a force at one normal force");
                let remedy = "give that of the measurement: --normal-force \"5 kN\" makes coefficients";
                return Err((problem, remedy.into()));
            }
            left_out.push(format!("{name} = {}", value.to_string().trim()));
        }
        let has = |name: &str| machine.contains_key(name);
        if let Some(normal_force) = self.normal_force.filter(|_| !has(NORMAL_FORCE) && !has(PRESSURE)) {
            machine.insert(NORMAL_FORCE, toml_edit::value(normal_force));
        }
        document.remove("friction");
        let text = format!("{}\n{}", document.to_string().trim_end(), self.to_toml(fit));
        Ok((text, left_out.join(", ")))
    }

    /// A fit as the table `[friction]` of a configuration, complete in SI units.
    pub fn to_toml(&self, fit: &Fit) -> String {
        let names = fit.form.names();
        let mut text = String::new();
        // Writing to a string never fails.
        let mut line = |words: std::fmt::Arguments| {
            let _ = writeln!(text, "{words}");
        };
        let (slip, rest) = (self.in_slip.len(), self.at_rest.len());
        line(format_args!("# Fitted by slipmap to {}: {slip} readings in slip, {rest} at rest.", self.name));
        let fastest = self.in_slip.last().map_or(0.0, |row| row.speed);
        line(format_args!(
            "# Measured up to {} {}; residuals {} {}",
            short(fastest),
            self.speed_unit(),
            rounded(fit.residual, 3),
            self.friction_unit()
        ));
        line(format_args!("[friction]"));
        line(format_args!("law = \"expression\""));
        line(format_args!("phi = \"{}\"", self.named(&fit.form.formula())));
        if self.holds_forces() {
            line(format_args!("quantity = \"force\""));
        }
        if let Some([level, _]) = fit.at_rest {
            let error = self.error_at_rest(fit).map(|error| short(known_part(level, error)[1]));
            let told = error.map_or_else(|| ONE_AT_REST.to_owned(), |error| format!("+- {error}"));
            line(format_args!("static = {level:?} # {told}"));
        }
        line(format_args!("\n[friction.fit]"));
        for ((name, value), error) in names.iter().zip(&fit.values).zip(fit.errors()) {
            let unit = self.unit_of(name);
            let error = short(known_part(*value, error)[1]);
            line(format_args!("{} = {value:?} # +- {error} {unit}", self.named(name)));
        }
        line(format_args!("covariance = ["));
        for row in 0..names.len() {
            let numbers: Vec<String> =
                fit.covariance.row(row).iter().map(|value| format!("{value:?}")).collect();
            line(format_args!("    [{}],", numbers.join(", ")));
        }
        line(format_args!("]"));
        text
    }
}

/// The law of this name.
///
/// # Errors
/// That there is none, and which there are.
pub fn law_of(name: &str) -> Result<Form, (String, String)> {
    Form::all().find(|form| words_of(*form) == name).ok_or_else(|| {
        (format!("there is no such law: {name}"), format!("choose from: {}", all_words(Form::all())))
    })
}

fn all_words(forms: impl Iterator<Item = Form>) -> String {
    forms.map(words_of).collect::<Vec<_>>().join("; ")
}

/// The words for a law that is fitted.
pub fn words_of(form: Form) -> String {
    use slipmap_fit::Shape;
    let fall = match form.shape {
        Shape::None if form.drop => "two coefficients",
        Shape::None => "constant",
        Shape::Exponential => "exponential",
        Shape::Gaussian => "gaussian",
        Shape::Stretched => "stretched",
        Shape::Lorentzian => "lorentzian",
        Shape::Hyperbolic => "hyperbolic",
    };
    let rise = if form.viscous { ", viscous" } else { "" };
    let drop = if form.drop && form.shape != Shape::None { ", drop" } else { "" };
    format!("{fall}{rise}{drop}")
}
