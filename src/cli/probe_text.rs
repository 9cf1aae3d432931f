//! The answer about one point as text.

use std::io::{self, Write};

use super::output::{Align, TextTable, count, exact, short, signed};
use slipmap_certify::slip_count::{SlipCount, proves_absence};
use slipmap_column::critical::is_known;
use slipmap_column::crossing::CrossingCycles;
use slipmap_column::limits::{EpsilonLimit, HIGHEST, NoEpsilonLimit};
use slipmap_column::sensitivity::NoSensitivity;
use slipmap_column::{BasinBoundary, ChangeKind, Neighbour, separates};
use slipmap_machine::probe::{Answer, equilibrium_type, fate_name, regime_words};
use slipmap_model::filippov::Eigenvalues;
use slipmap_model::flow::{Fate, Flow};
use slipmap_model::friction::Range;
use slipmap_numbers::text::{known_part, rounded, with_error};
use slipmap_orbits::Cycle;

/// Prints the answer as text.
pub(super) fn write(out: &mut dyn Write, answer: &Answer, direct: &Flow) -> io::Result<()> {
    writeln!(out, "Point of the law `{}`", answer.law.name())?;
    let words: Vec<String> = answer
        .law
        .coordinates(&answer.point)
        .into_iter()
        .map(|(name, value)| format!("{name} = {}", exact(value)))
        .collect();
    writeln!(out, "  {}\n", words.join("   "))?;

    write_verdicts(out, answer)?;
    write_flows(out, answer, direct)?;
    writeln!(out)?;
    let mut facts = Facts(TextTable::new(&[("", Align::Left), ("", Align::Left)]));
    facts.critical(answer);
    facts.sensitivity(answer);
    facts.regime(answer);
    facts.equilibrium(answer);
    facts.slip_cycles(answer);
    facts.crossing_cycles(answer);
    facts.landing(answer);
    facts.attractors(answer);
    facts.0.write(out)
}

/// Prints what every method says.
fn write_verdicts(out: &mut dyn Write, answer: &Answer) -> io::Result<()> {
    use Align::{Left, Right};

    writeln!(out, "Does a stick-slip limit cycle exist?")?;
    let mut table = TextTable::new(&[
        ("method", Left),
        ("verdict", Left),
        ("margin", Right),
        ("critical c", Right),
        ("epsilon limit", Right),
        ("guarantee", Left),
        ("equation", Left),
    ]);
    let limits = answer.limits(false);
    for (method, limit) in answer.methods.iter().zip(&limits) {
        table.row([
            method.method.name().into(),
            method.verdict.name().into(),
            signed(method.margin),
            method.critical_c.map_or("-".into(), |c| match method.critical_c_error {
                Some(error) => short(known_part(c, error)[0]),
                None => short(c),
            }),
            short(limit.value()),
            method.method.guarantee().name().into(),
            method.method.equation_for(&answer.law).into_owned(),
        ]);
    }
    table.write(out)?;
    writeln!(
        out,
        "  (margin: in c to the edge of presence; positive means presence)\n  \
         (epsilon limit: says what the simulation says at every smaller epsilon; +inf: up to {} at least)",
        short(HIGHEST)
    )?;
    for method in &answer.methods {
        if let Some(reason) = &method.reason {
            writeln!(out, "  {}: {} because {reason}", method.method.name(), method.verdict.name())?;
        }
    }

    for (why, names) in unknown_limits(answer, &limits) {
        writeln!(out, "  no epsilon limit of {names}: {why}")?;
    }
    Ok(())
}

/// Prints the orbit from the exit point, as both engines have it.
fn write_flows(out: &mut dyn Write, answer: &Answer, direct: &Flow) -> io::Result<()> {
    use Align::{Left, Right};

    writeln!(out, "\nThe flow from the exit point, tolerance {}", short(answer.tolerance))?;
    let mut table = TextTable::new(&[
        ("engine", Left),
        ("fate", Left),
        ("margin m/V", Right),
        ("error", Right),
        ("right-hand sides", Right),
    ]);
    for (name, flow) in [("arcs", &answer.told), ("direct", direct)] {
        table.row([
            name.into(),
            fate_name(&flow.fate).replace('_', " "),
            signed(flow.margin),
            short(flow.margin_error),
            count(flow.rhs),
        ]);
    }
    table.write(out)
}

/// Lines of a name and words.
struct Facts(TextTable);

impl Facts {
    fn add(&mut self, name: &str, text: String) {
        self.0.row([name.to_owned(), text]);
    }

    fn critical(&mut self, answer: &Answer) {
        self.add(
            "critical damping",
            match &answer.critical {
                Ok(_) if answer.critical_is_zero() => {
                    "c* = 0 within rounding: no cycle at any damping above 0".into()
                }
                Ok(root) => match root.known() {
                    Ok(_) => format!(
                        "c* = {} ({} right-hand sides){}",
                        with_error(root.c, root.error),
                        count(root.rhs),
                        if root.c < 0.0 { ": no cycle at any damping" } else { "" }
                    ),
                    Err(why) => format!("not told: {why} ({} right-hand sides)", count(root.rhs)),
                },
                Err(why) => format!("none: {why}"),
            },
        );
    }

    fn sensitivity(&mut self, answer: &Answer) {
        match answer.sensitivity() {
            Ok(found) => {
                let derivatives = found.named(&answer.law);
                let derivatives = derivatives.map(|(name, by)| match by.value.is_nan() {
                    true => {
                        format!(
                            "an amount that is not known by {name} (its error is {})",
                            rounded(by.error, 2)
                        )
                    }
                    false => format!("{} by {name}", with_error(by.value, by.error)),
                });
                self.add("c* moves by", derivatives.collect::<Vec<_>>().join(", "));
                if let Some(standard) = found.standard_error {
                    self.add(
                        "standard error of c*",
                        format!("{}, from those of the data, at this V", short(standard.value)),
                    );
                }
            }
            // A missing critical damping was reported above.
            Err(NoSensitivity::Critical(_) | NoSensitivity::Negative) => {}
            Err(why) => self.add("c* moves by", format!("not known: {why}")),
        }
    }

    fn regime(&mut self, answer: &Answer) {
        self.add("regime", format!("{}: {}", answer.regime.name(), regime_words(answer.regime)));
        if let Some(known) = answer.known_of_regime() {
            self.add("what is known of it", known);
        }
    }

    fn equilibrium(&mut self, answer: &Answer) {
        let oscillator = &answer.oscillator;
        let belt = short(oscillator.belt_speed);
        let eigenvalues = match oscillator.eigenvalues() {
            Eigenvalues::Complex { re, im } => format!("{} +- {} i", short(re), short(im)),
            Eigenvalues::Real { slow, fast } => format!("{} and {}", short(slow), short(fast)),
        };
        self.add(
            "equilibrium",
            format!(
                "({}, 0), {}, eigenvalues {eigenvalues}",
                short(oscillator.equilibrium_x1()),
                equilibrium_type(oscillator)
            ),
        );
        self.add(
            "stick segment",
            format!(
                "{} < x1 < {}, x2 = {belt}",
                short(oscillator.upper_tangency_x1()),
                short(oscillator.exit_x1())
            ),
        );
        self.add("exit point", format!("({}, {belt})", short(oscillator.exit_x1())));
    }

    fn slip_cycles(&mut self, answer: &Answer) {
        match &answer.slip {
            Err(why) => self.add("slip cycles", format!("not determined: {}", answer.why_unknown(*why))),
            Ok(cycles) => {
                let count = answer.slip_count();
                let absent = match proves_absence(&answer.oscillator, count) {
                    true => "; since the equilibrium is stable, that proves that no stick-slip cycle exists",
                    false => "",
                };
                self.add("slip cycles", format!("{}{absent}", slip_count_words(cycles.len(), count)));
                for (i, cycle) in cycles.iter().enumerate() {
                    let parts = separates(i, cycles.len(), &answer.flow.fate).map(neighbour_words);
                    let (kind, sides) = if cycle.is_stable() {
                        ("attracts", String::new())
                    } else {
                        (
                            "repels",
                            format!(": inside it orbits tend to {}, outside it to {}", parts[0], parts[1]),
                        )
                    };
                    let shape = cycle_words(cycle);
                    self.add("slip cycle", format!("{kind}, {shape}{sides}"));
                }
            }
        }
        if let Some(left_out) = answer.left_out() {
            self.add("left out", left_out);
        }
    }

    fn crossing_cycles(&mut self, answer: &Answer) {
        let CrossingCycles { cycles, unknown } = answer.crossing_cycles();
        for cycle in &cycles {
            let kind = if cycle.is_stable() { "attracts" } else { "repels" };
            let shape = cycle_words(cycle);
            self.add("crossing cycle", format!("{kind}, {shape}"));
        }
        if let Some(why) = unknown {
            let which = if cycles.is_empty() { "crossing cycles" } else { "other crossing cycles" };
            self.add(which, format!("not determined: {}", answer.why_unknown(why)));
        }
    }

    fn landing(&mut self, answer: &Answer) {
        let belt = short(answer.oscillator.belt_speed);
        match answer.flow.landing() {
            None => self.add(
                "landing",
                match answer.flow.fate {
                    Fate::SpiralsInward | Fate::CrossesForever => {
                        "none: the orbit from the exit point never sticks"
                    }
                    Fate::Sticks(_) | Fate::TooCloseToCall | Fate::Failed(_) => "not determined",
                }
                .into(),
            ),
            Some(landing) => {
                let after = match landing.crossings {
                    Some(crossings) => format!("after {crossings} crossings"),
                    None => "within its error of the end of the stick segment: after 0 or 1 crossings".into(),
                };
                self.add("landing", format!("({}, {belt}), {after}", short(landing.x1)));
                self.add("slip time", short(landing.slip_time));
                self.add("stick time", short(landing.stick_time));
            }
        }
    }

    fn attractors(&mut self, answer: &Answer) {
        let range = |range: Range| format!("{} to {}", short(range.lo), short(range.hi));
        if let Some(cycle) = &answer.cycle {
            let shape = format!("x1 from {}, x2 from {}", range(cycle.displacement), range(cycle.velocity));
            let multiplier = short(cycle.multiplier);
            self.add(
                "attracting cycle",
                format!("period {}, {shape}, multiplier {multiplier}", short(cycle.period)),
            );
        }
        let epsilon = answer.point.epsilon;
        let changes = answer.changes().iter().filter_map(|change| {
            let [low, high] = change.between.map(|viscous| viscous / epsilon);
            let (middle, error) = (change.viscous / epsilon, 0.5 * (high - low));
            let place = match is_known(middle, error) {
                // The error of a change beside it.
                true if change.kind == ChangeKind::Unresolved => return None,
                true => with_error(middle, error),
                false if high < f64::INFINITY => {
                    format!("between {} and {}, not known closer", short(low), short(high))
                }
                false => format!("from {} on, not known where", short(low)),
            };
            Some(format!("{place} ({})", change.kind.name()))
        });
        self.add("it changes at c", changes.collect::<Vec<_>>().join(", "));
        if let Some(band) = answer.bistable_band() {
            let to = with_error(band.to_c, band.error);
            let [low, high] = band.from_c_between;
            let words = match band.from_c_reason {
                None => format!("{} to {to}", exact(high)),
                Some(why) => format!(
                    "from between {} and {} to {to}; where it begins is not known closer: {why}",
                    short(low),
                    short(high)
                ),
            };
            self.add("both attract for c", words);
        }
        if let Some(BasinBoundary { kick, cycle, separates: [_, outside], .. }) = &answer.basin {
            let edge = match cycle {
                Some(_) => "the outermost slip cycle that repels",
                None => "the orbit that grazes the belt line",
            };
            self.add(
            "kick that starts it",
            format!(
                "of velocity {} with the belt, or {} against it, from steady slip onto {edge}; a slightly larger one leads to {}",
                short(kick.forward),
                short(kick.backward),
                neighbour_words(*outside)
            ),
        );
        }
    }
}

/// Describes an attractor.
fn neighbour_words(neighbour: Neighbour) -> &'static str {
    match neighbour {
        Neighbour::Equilibrium => "the equilibrium",
        Neighbour::SlipCycle => "the next slip cycle",
        Neighbour::StickSlip => "stick-slip",
        Neighbour::Crossing => "crossing for ever",
        Neighbour::Unknown => "an attractor that is not known",
    }
}

fn cycle_words(Cycle { displacement, velocity, multiplier, period, .. }: &Cycle) -> String {
    format!(
        "amplitude {}, {} <= x2 <= {}, multiplier {}, period {}",
        short(0.5 * (displacement.hi - displacement.lo)),
        short(velocity.lo),
        short(velocity.hi),
        short(*multiplier),
        short(*period)
    )
}

/// Describes the number of slip cycles found, and the bounds that are proved for it.
fn slip_count_words(found: usize, count: &SlipCount) -> String {
    let number = |n: u32| if n == 0 { "none".to_owned() } else { n.to_string() };
    if let Some(exact) = count.exact() {
        return match usize::try_from(exact) {
            Ok(exact) if exact == found => format!("{}, count proved", number(count.at_least)),
            _ => format!("{found} found, but {} proved: try a smaller tolerance", number(count.at_least)),
        };
    }
    let open = count.open.iter().map(|open| format!("{} to {}", short(open.lo), short(open.hi)));
    let open: Vec<String> = open.collect();
    let mut words = format!("{found} found, count not proved");
    if !open.is_empty() {
        words.push_str(&format!(": nothing is proved where the maximum of x2 is in {}", open.join(", ")));
    } else if let Some(most) = count.at_most {
        words.push_str(&format!(": {} to {most} are possible", count.at_least));
    }
    words
}

/// Reasons why limits in eps are unknown, each with the names of its methods.
fn unknown_limits(answer: &Answer, limits: &[EpsilonLimit]) -> Vec<(NoEpsilonLimit, String)> {
    let of = |why: NoEpsilonLimit| {
        let methods = answer.methods.iter().zip(limits).filter(|(_, limit)| limit.unknown() == Some(why));
        let names: Vec<&str> = methods.map(|(answer, _)| answer.method.name()).collect();
        (!names.is_empty()).then(|| (why, names.join(", ")))
    };
    [NoEpsilonLimit::NoFlow, NoEpsilonLimit::GivenUp, NoEpsilonLimit::NotSought]
        .into_iter()
        .filter_map(of)
        .collect()
}
