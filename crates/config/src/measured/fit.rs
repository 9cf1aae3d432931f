//! Measured friction as readings for a fit, and a fit as the table `[friction]` of a configuration.

use std::fmt::Write as _;

use super::Measured;
use slipmap_fit::{Fit, Form, Reading};
use slipmap_map::machine::{Dimension, Motion};
use slipmap_numbers::text::{rounded, short};

impl Measured {
    /// The readings for a fit, in slip and at rest: those of a record over time, which are not independent, as the
    /// means of its segments.
    ///
    /// # Errors
    /// The problem with its line, and a remedy.
    pub fn readings(&self) -> Result<[Vec<Reading>; 2], (String, String)> {
        let of = |readings: &[super::Reading]| -> Vec<Reading> {
            let of =
                |row: &super::Reading| Reading { speed: row.speed, friction: row.friction, error: row.error };
            readings.iter().map(of).collect()
        };
        let exact = |row: &&super::Reading| row.error == 0.0;
        if let Some(row) = self.at_rest.iter().chain(&self.in_slip).find(exact) {
            let problem = format!("{}:{}: the standard error is 0", self.name, row.line);
            return Err((problem, "write the error that the reading has, or leave all of them out".into()));
        }
        if !self.is_record {
            return Ok([of(&self.in_slip), of(&self.at_rest)]);
        }
        let (knots, spread) = self.segments();
        let knots = knots.iter().map(|knot| Reading {
            speed: knot.speed,
            friction: knot.friction,
            error: knot.error,
        });
        let at_rest = of(&self.at_rest).into_iter().map(|reading| Reading { error: spread, ..reading });
        Ok([knots.collect(), at_rest.collect()])
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
    pub fn unit_of(&self, parameter: &str) -> String {
        let (speed, friction) = (self.speed_unit(), self.friction_unit());
        match (parameter, self.holds_forces()) {
            ("v_s", _) => speed.into(),
            ("B", true) => self.motion.unit(Dimension::Damping).into(),
            ("B", false) if self.motion == Motion::Rotation => "s/rad".into(),
            ("B", false) => "s/m".into(),
            ("delta", _) => String::new(),
            _ => friction.into(),
        }
    }

    /// A fit as the table `[friction]` of a configuration, complete in SI units.
    pub fn to_toml(&self, fit: &Fit) -> String {
        let names = fit.form.names();
        let mut text = String::new();
        // Writing to a string never fails.
        let mut line = |words: std::fmt::Arguments| {
            let _ = text.write_fmt(words);
            text.push('\n');
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
        if let Some([level, error]) = fit.at_rest {
            line(format_args!("static = {level:?} # +- {}", rounded(error, 2)));
        }
        line(format_args!("\n[friction.fit]"));
        for ((name, value), error) in names.iter().zip(&fit.values).zip(fit.errors()) {
            let unit = self.unit_of(name);
            line(format_args!("{} = {value:?} # +- {} {unit}", self.named(name), rounded(error, 2)));
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

/// The words for a law that is fitted.
pub fn words_of(form: Form) -> String {
    use slipmap_fit::{Drop, Shape, Viscous};
    let fall = match form.shape {
        Shape::None => "two coefficients",
        Shape::Exponential => "exponential",
        Shape::Gaussian => "gaussian",
        Shape::Stretched => "stretched",
        Shape::Lorentzian => "lorentzian",
        Shape::Hyperbolic => "hyperbolic",
    };
    let rise = if form.viscous == Viscous::Free { ", viscous" } else { "" };
    let drop = if form.drop == Drop::Free && form.shape != Shape::None { ", drop" } else { "" };
    format!("{fall}{rise}{drop}")
}
