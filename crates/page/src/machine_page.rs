//! The engineer's page: an assessment of a machine at its working point, on one page as a figure or as HTML.

mod answer;
mod figures;
mod intervals;
mod lines;
mod units;

use super::html;
use figures::FIGURE;
use lines::Section;
pub use lines::percent;
pub(crate) use lines::{known_in_words, why_no_critical, why_no_kick};
use slipmap_figure::axis::{AXIS, SMALL_TEXT, TEXT};
use slipmap_figure::paragraph::paragraph;
use slipmap_figure::scene::{Anchor, Scene, text_width};
use slipmap_figure::text::{Rich, join, rich};
use slipmap_machine::assessment::Assessment;
use slipmap_machine::risk::{Risk, Uncertain};
pub use units::Written;

/// A question and its answer.
pub(crate) type Line = (Rich, Rich);

/// Size of the page: A4, in points.
const PAGE: (f64, f64) = (595.0, 842.0);
const MARGIN: f64 = 42.0;
const WIDTH: f64 = PAGE.0 - 2.0 * MARGIN;
const TITLE: f64 = 12.0;
/// Distance of the answers from the left margin.
const ANSWERS: f64 = 250.0;
/// Distance of two lines.
const LINE: f64 = TEXT + 2.6;
/// Largest number of lines of a title and of the answer to a question. HTML has no such limit.
const MOST_LINES: usize = 4;
/// Largest number of lines of the answer in a sentence, and of a warning.
const MOST_LINES_OF_ANSWER: usize = 6;
/// Heights of the panels, in points; the smaller one is used beside more lines than `MOST_ROWS`.
const PANEL: [f64; 2] = [150.0, 110.0];
const MOST_ROWS: usize = 30;
/// Extra height of the friction panels over the regime panel, which has its legend below it.
const HIGHER: f64 = 24.0;

/// What a page is about, beside its assessment.
pub struct Subject<'a> {
    pub title: &'a str,
    pub uncertain: &'a [Uncertain],
    /// The units of the configuration, in which the page tells speeds and draws its figures.
    pub units: &'a Written,
    /// The belt speeds that it is about, in SI units: the least and the largest.
    pub speeds: Option<[f64; 2]>,
    /// The resulting risk; also `None` where no critical damping was found for any draw.
    pub risk: Option<&'a Risk>,
    /// Program, day and configuration.
    pub source: &'a str,
}

/// The page. Its figures are computed when it is drawn.
#[derive(Debug)]
pub struct MachinePage<'a> {
    /// Questions and answers, section by section.
    pub sections: Vec<Section>,
    /// The answer: what it does here, over the belt speeds, and by the uncertain quantities.
    pub answers: Vec<Rich>,
    /// Doubts about the numbers of the machine.
    pub warnings: Vec<Rich>,
    all: &'a Assessment,
    units: &'a Written,
    title: Rich,
    source: Rich,
}

impl<'a> MachinePage<'a> {
    /// The page of a machine; `all.machine` is its working point.
    pub fn new(all: &'a Assessment, subject: &Subject<'a>) -> Self {
        let doubts = all.machine.doubts();
        Self {
            sections: lines::sections(all, subject.units, subject.uncertain, subject.risk),
            answers: [
                answer::in_words(all, subject.units),
                answer::over_speeds(all, subject.units, subject.speeds),
                answer::uncertainty(all, subject.units, subject.risk),
            ]
            .into_iter()
            .filter(|answer| !answer.pieces.is_empty())
            .collect(),
            warnings: doubts.iter().map(|doubt| Rich::foreign(&format!("Warning: {doubt}."))).collect(),
            all,
            units: subject.units,
            title: Rich::foreign(subject.title),
            source: Rich::foreign(subject.source),
        }
    }

    /// Draws pages beside each other.
    pub fn scene(pages: &[Self]) -> Scene {
        let drawn: Vec<Scene> = pages.iter().map(Self::drawn).collect();
        let height = drawn.iter().map(|page| page.height).fold(0.0, f64::max);
        let mut scene = Scene::new(PAGE.0 * pages.len() as f64, height);
        for (i, page) in drawn.iter().enumerate() {
            scene.place((PAGE.0 * i as f64, 0.0), page);
        }
        scene
    }

    /// Draws the page: A4, or longer if the text does not fit.
    fn drawn(&self) -> Scene {
        let mut scene = Scene::new(PAGE.0, PAGE.1);
        let mut y = MARGIN - TITLE + 3.0;
        for line in paragraph(&self.title, TITLE, WIDTH, MOST_LINES) {
            y += TITLE + 3.0;
            scene.text((MARGIN, y), &line, TITLE, Anchor::Start);
        }
        y += 2.0;
        for text in self.answers.iter().chain(&self.warnings) {
            y += 2.0;
            for line in paragraph(text, TEXT, WIDTH, MOST_LINES_OF_ANSWER) {
                y += TEXT + 3.0;
                scene.text((MARGIN, y), &line, TEXT, Anchor::Start);
            }
        }
        y += 14.0;
        // What the lines take decides on the height of the figures.
        let rows: usize = self.sections.iter().map(|(_, lines)| lines.len()).sum();
        let height = PANEL[usize::from(rows > MOST_ROWS)];
        let regimes = figures::regimes(self.all, self.units, height);
        let friction = figures::friction(self.all, self.units, height + HIGHER);
        scene.place((MARGIN, y), &regimes);
        scene.place((PAGE.0 - MARGIN - FIGURE, y), &friction);
        y += regimes.height.max(friction.height);
        for (heading, lines) in &self.sections {
            y += 17.0;
            scene.text((MARGIN, y), &rich(heading), TEXT + 1.0, Anchor::Start);
            scene.line(&[(MARGIN, y + 3.0), (PAGE.0 - MARGIN, y + 3.0)], &AXIS);
            y = write_lines(&mut scene, y + 4.0, lines);
        }
        y += 3.0 * SMALL_TEXT;
        scene.height = PAGE.1.max(y + 6.0);
        let foot = scene.height - 18.0;
        for line in paragraph(&self.source, SMALL_TEXT, WIDTH, 1) {
            scene.text((MARGIN, foot), &line, SMALL_TEXT, Anchor::Start);
        }
        scene
    }

    /// The title of the pages, with their subjects.
    pub fn caption(pages: &[Self]) -> Rich {
        let begins = if pages.len() > 1 { "Assessment of machines: " } else { "Assessment of a machine: " };
        rich(begins).then(join(pages.iter().map(|page| page.title.clone())))
    }

    /// Pages beside each other as self-contained HTML.
    pub fn html(pages: &[Self]) -> String {
        let title = join(pages.iter().map(|page| page.title.clone()));
        let bodies = pages.iter().enumerate().map(|(i, page)| page.body(i + 1));
        match pages {
            [_] => html::page(&title, &bodies.collect::<String>()),
            several => {
                let of = |(page, body): (&Self, String)| {
                    let heading = page.title.html();
                    format!("<section style=\"flex: 1 1 30em\">\n<h1>{heading}</h1>\n{body}</section>\n")
                };
                let beside: String = several.iter().zip(bodies).map(of).collect();
                let body =
                    format!("<div style=\"display: flex; flex-wrap: wrap; gap: 2em\">\n{beside}</div>\n");
                html::page(&title, &body)
            }
        }
    }

    /// The body of the HTML of the page of this number.
    fn body(&self, number: usize) -> String {
        let texts = self.answers.iter().chain(&self.warnings);
        let mut body: String =
            texts.map(|text| format!("<p class=\"answer\">{}</p>\n", text.html())).collect();
        self.write_figures(number, &mut body);
        for (heading, lines) in &self.sections {
            body.push_str(&format!("<h2>{heading}</h2>\n<dl class=\"summary\">\n"));
            for (name, value) in lines {
                body.push_str(&format!("<dt>{}</dt><dd>{}</dd>\n", name.html(), value.html()));
            }
            body.push_str("</dl>\n");
        }
        body.push_str(&format!("<p class=\"note\">{}</p>\n", self.source.html()));
        body
    }

    /// Both figures beside each other.
    fn write_figures(&self, number: usize, body: &mut String) {
        let figures = [
            (
                "regimes",
                figures::regimes(self.all, self.units, PANEL[0]),
                "Long-run behaviour over speed and damping; mark: the working point.",
            ),
            (
                "friction",
                figures::friction(self.all, self.units, PANEL[0] + HIGHER),
                "Friction, and the weight of its slope at each slip speed for the critical damping where it is known.",
            ),
        ];
        body.push_str("<div class=\"beside\">\n");
        for (name, figure, words) in figures {
            let svg = figure.svg(&format!("{name}-{number}"), &rich(words));
            body.push_str(&format!("<figure>\n{svg}<figcaption>{words}</figcaption>\n</figure>\n"));
        }
        body.push_str("</div>\n");
    }
}

/// Writes questions and answers, in two columns where all of them are short; returns their lower end.
fn write_lines(scene: &mut Scene, y: f64, lines: &[Line]) -> f64 {
    const GAP: f64 = 10.0;
    let widest = |of: fn(&Line) -> &Rich| {
        lines.iter().map(|line| text_width(of(line), TEXT)).fold(0.0, f64::max) + GAP
    };
    let names = widest(|(name, _)| name);
    if lines.len() > 2 && names + widest(|(_, value)| value) <= ANSWERS {
        let rows = lines.len().div_ceil(2);
        for (i, (name, value)) in lines.iter().enumerate() {
            let (left, y) = (MARGIN + (i / rows) as f64 * ANSWERS, y + ((i % rows) + 1) as f64 * LINE);
            scene.text((left, y), name, TEXT, Anchor::Start);
            scene.text((left + names, y), value, TEXT, Anchor::Start);
        }
        return y + rows as f64 * LINE;
    }
    let mut y = y;
    for (name, value) in lines {
        scene.text((MARGIN, y + LINE), name, TEXT, Anchor::Start);
        for line in paragraph(value, TEXT, WIDTH - ANSWERS, MOST_LINES) {
            y += LINE;
            scene.text((MARGIN + ANSWERS, y), &line, TEXT, Anchor::Start);
        }
    }
    y
}

#[cfg(test)]
mod tests {
    use super::answer::{in_words, uncertainty};
    use super::*;
    use lines::{percentage, regime_lines, sections};
    use slipmap_column::Regime;
    use slipmap_machine::assessment::{Undetermined, assess};
    use slipmap_machine::risk::{Spread, WithLimits, risk};
    use slipmap_machine::{Friction, Machine, Motion};
    use slipmap_model::filippov::Stability;
    use slipmap_model::friction::{Expression, Law, Table};
    use slipmap_model::point::LawParameters;

    pub(super) fn example(law: Law) -> Machine {
        Machine::from_array(Motion::Translation, law, [2.0, 800.0, 4.0, 50.0, 0.4, 0.3, 0.25, 0.02, 0.1])
    }

    #[test]
    fn a_critical_damping_that_was_not_found_is_not_told_as_none() {
        let mut all = assess(&example(Law::Exponential)).unwrap();
        let words = |all: &Assessment| {
            let all_lines = sections(all, &[], &[], None).into_iter().flat_map(|(_, lines)| lines);
            let mut values = all_lines.filter(|(name, _)| name.plain() == "may stick-slip below damping");
            values.next().unwrap().1.plain()
        };
        assert!(words(&all).contains("N s/m"));
        // An error that reaches the digits is told with them, in the headline too.
        let critical = all.behaviour.critical_damping.unwrap();
        all.behaviour.critical_damping_error = Some(5e-3 * critical);
        let headline = in_words(&all, &[]).plain();
        assert!(words(&all).contains(" ± ") && headline.contains(" ± "), "{} {headline}", words(&all));
        all.behaviour.critical_damping = None;
        (all.behaviour.critical_damping_error, all.behaviour.critical_damping_is_known) = (None, true);
        assert_eq!(words(&all), "none: it needs no damping");
        all.behaviour.critical_damping_is_known = false;
        assert_eq!(words(&all), "not determined");
        all.behaviour.critical_damping_error = Some(2000.0);
        assert_eq!(words(&all), "not determined: its error, 2000 N s/m, is more than 1 % of it");
    }

    #[test]
    fn what_is_known_of_an_undetermined_regime_is_told() {
        let row = |i: i32| (0.01 * f64::from(i), 0.4 - 0.002 * f64::from(i) + 0.005 * f64::from(i % 2));
        let table = Table::new("a rig", &(0..60).map(row).collect::<Vec<_>>(), 0.4).unwrap();
        let mut all = assess(&example(Law::Exponential)).unwrap();
        all.machine.friction = Friction::Measured(table);
        all.behaviour.regime = Regime::Failed;
        let reasons = vec!["slip cycles: the step budget ran out".to_owned()];
        all.undetermined = Some(Undetermined { sticks: Some(true), stability: Stability::Repels, reasons });
        let lines = regime_lines(&all).into_iter();
        let lines: Vec<_> =
            lines.map(|(name, value)| format!("{}: {}", name.plain(), value.plain())).collect();
        let expected = [
            "regime at the working point: not determined in full",
            "what is known of it: the stick-slip cycle attracts, steady slip is unstable",
            "what is not, and why: slip cycles: the step budget ran out",
        ];
        assert_eq!(lines, expected);
        assert!(in_words(&all, &[]).plain().starts_with("Stick-slips at least from some starts at "));
    }

    #[test]
    fn the_answer_is_a_sentence() {
        let machine = |damping: f64| {
            let law = Expression::new("0.25 + 0.15*exp(-(u/0.05)^2)", 1.0).unwrap();
            let friction = Friction::Formula(law, LawParameters::new(&[]));
            let [mass, stiffness, normal_force, belt_speed] = [2.0, 5e5, 1000.0, 0.06];
            let like = example(Law::Stribeck);
            Machine { friction, mass, stiffness, normal_force, belt_speed, damping, ..like }
        };
        let words = |damping: f64| in_words(&assess(&machine(damping)).unwrap(), &[]).plain();
        let sticking = words(1000.0);
        assert!(
            sticking.starts_with("Stick-slips from every start at 0.06 m/s and 1000 N s/m ("),
            "{sticking}"
        );
        assert!(
            sticking.contains(" mm); a disturbance of steady slip grows by the factor e in 0.0")
                && sticking.contains("; more than 14")
                && sticking.contains(" ends stick-slip, more than ")
        );
        let lines = paragraph(&in_words(&assess(&machine(1000.0)).unwrap(), &[]), TEXT, WIDTH, MOST_LINES);
        let widest = lines.iter().map(|line| text_width(line, TEXT)).fold(0.0, f64::max);
        assert!(lines.len() == 2 && widest <= WIDTH + TEXT, "{widest}: {lines:?}");
        let slipping = words(1500.0);
        assert!(slipping.starts_with("Vibrates from every start, without sticking, at "), "{slipping}");
        assert!(
            slipping.contains("; more than 1") && slipping.ends_with(" ends the vibration."),
            "{slipping}"
        );
        let still = words(3000.0);
        assert!(still.starts_with("Slips steadily from every start at 0.06 m/s"), "{still}");
        assert!(still.contains("; it may vibrate below 1"), "{still}");
    }

    #[test]
    fn attractors_that_coexist_are_told_plainly() {
        let mut all = assess(&example(Law::Exponential)).unwrap();
        let mut words = |regime: Regime| {
            all.behaviour.regime = regime;
            in_words(&all, &[]).plain()
        };
        for (regime, begins) in [
            (
                Regime::Bistable,
                "Slips steadily or stick-slips, depending on the start, at 0.1 m/s and 4 N s/m",
            ),
            (
                Regime::EquilibriumPureSlipAndStickSlip,
                "Slips steadily, vibrates without sticking or stick-slips, depending on the start, at 0.1 m/s",
            ),
            (
                Regime::StickSlipAndCrossing,
                "Stick-slips or overtakes the belt at every turn, depending on the start, at 0.1 m/s",
            ),
            (Regime::Crossing, "Overtakes the belt at every turn, from every start, at 0.1 m/s"),
        ] {
            assert!(words(regime).starts_with(begins), "{}", words(regime));
        }
    }

    /// Orbits of a fast belt cross the belt line for ever: what the page says of stick-slip is about a window of dampings.
    #[test]
    fn what_overtakes_the_belt_has_no_damping_of_stick_slip() {
        let machine = example(Law::Exponential).with("kinetic_friction", 0.1).unwrap();
        let machine = machine.with("stribeck_velocity", 25.0).unwrap().with("strengthening", 0.0).unwrap();
        let machine = machine.with("belt_speed", 75.0).unwrap().with("damping", 0.02).unwrap();
        let all = assess(&machine).unwrap();
        let (text, headline) = (text_of(sections(&all, &[], &[], None)), in_words(&all, &[]).plain());
        assert!(text.contains("may stick-slip at dampings: 0.0"), "{text}");
        assert!(!text.contains("may stick-slip below damping"), "{text}");
        assert!(
            headline.starts_with("Overtakes the belt at every turn, ") && !headline.contains("stick-slip")
        );
    }

    fn text_of(sections: Vec<Section>) -> String {
        let lines = sections.into_iter().flat_map(|(_, lines)| lines);
        lines.map(|(name, value)| format!("{}: {}\n", name.plain(), value.plain())).collect()
    }

    #[test]
    fn what_was_uncertain_is_told_with_its_spread() {
        let formula = Expression::new("mu_k + (mus - mu_k)*exp(-u/0.08)", 1.0).unwrap();
        let friction = Friction::Formula(formula, LawParameters::new(&[0.25, 0.43]));
        let all = assess(&Machine { friction, ..example(Law::Exponential) }).unwrap();
        let uncertain = [
            ("mass", Spread::Normal { sd: 0.05 }),
            ("damping", Spread::Uniform { min: 3.0, max: 5.0 }),
            ("mu_k", Spread::Normal { sd: 0.01 }),
        ];
        let text = text_of(sections(&all, &[], &uncertain, None));
        let fitted = [("mu_k", Spread::Joint { row: [0.01, 0.0, 0.0, 0.0, 0.0, 0.0] })];
        assert!(text_of(sections(&all, &[], &fitted, None)).contains("for the fitted curve and no other"));
        for part in [
            ", for the values alone, without their spread\n",
            "mass: 2 kg ± 0.05 (sd)\nstiffness: 800 N/m\n",
            "with: mu_k = 0.25 ± 0.01 (sd), mus = 0.43\n",
            "damping: 4 N s/m, 3 to 5 (uniform) (damping ratio 0.05)\n",
        ] {
            assert!(text.contains(part), "{part} is not in\n{text}");
        }
        // Its part in the spread of the critical damping, to first order.
        let by = all.sensitivities.iter().find(|of| of.quantity == "mu_k").unwrap().critical_damping;
        let moved = Rich::number(by.abs() * all.behaviour.critical_damping.unwrap() * 0.01 / 0.25, 2).plain();
        assert!(
            text.contains(&format!(" % for 1 %; by its spread ± {moved} N s/m\nmus: ")),
            "{moved}: {text}"
        );
    }

    #[test]
    fn a_table_is_described() {
        let data = [(0.0, 0.4), (0.02, 0.35), (0.1, 0.31), (0.5, 0.3)];
        let table = Table::new("a rig", &data, 0.4).unwrap();
        let errors = table.with_standard_errors(&[0.001, 0.004, 0.008, 0.002]).unwrap();
        for (table, words) in [
            (table, "a rig, 4 rows without standard errors\n"),
            (errors, "a rig, 4 rows, standard errors (third column) 0.001 to 0.008\n"),
        ] {
            let friction = Friction::Measured(table);
            let all = assess(&Machine { friction, ..example(Law::Stribeck) }).unwrap();
            let text = text_of(sections(&all, &[], &[], None));
            assert!(text.contains(&format!("coefficient of friction: {words}")), "{text}");
            let page = MachinePage::new(
                &all,
                &Subject { title: "", uncertain: &[], units: &[], speeds: None, risk: None, source: "" },
            );
            assert!(
                MachinePage::scene(&[page]).svg("page", &rich("page")).contains("Coefficient of friction")
            );
        }
    }

    /// Friction that rises by far more than its errors: no damping is needed for any probability.
    #[test]
    fn no_damping_is_needed_where_no_draw_may_stick_slip() {
        let data = [0.0, 0.05, 0.1, 0.2, 0.5, 1.2].map(|u| (u, 0.3 + 0.2 * u));
        let table = Table::new("rises", &data, 0.3).unwrap().with_standard_errors(&[1e-3; 6]).unwrap();
        let friction = Friction::Measured(table);
        let [mass, stiffness, normal_force, belt_speed] = [1.8, 4.2e5, 900.0, 0.2];
        let like = example(Law::Stribeck);
        let machine = Machine { friction, mass, stiffness, normal_force, belt_speed, damping: 0.0, ..like };
        let risk = risk(&machine, &[], Some(20_000), &[0.1, 0.01], None).unwrap();
        assert!(risk.standard_error.is_some_and(|error| error > 1.0), "{risk:?}");
        let all = assess(&machine).unwrap();
        let text = text_of(sections(&all, &[], &[], Some(&risk)));
        for share in [10, 1] {
            let line = format!(
                "damping above which that probability is below {share} %: none: it needs no damping\n"
            );
            assert!(text.contains(&line), "{text}");
        }
        assert!(uncertainty(&all, &[], Some(&risk)).plain().ends_with(" may stick-slip with one of 0 %."));
        let one = text_of(sections(&all, &[], &[], Some(&Risk { draws: 1, ..risk })));
        assert!(text.contains(", 20000 draws\n") && one.contains(", 1 draw\n"), "{one}");
    }

    #[test]
    fn a_rotation_has_its_own_words() {
        let all = assess(&Machine { motion: Motion::Rotation, ..example(Law::Exponential) }).unwrap();
        let text = text_of(sections(&all, &[], &[], None));
        for part in [
            "moment of inertia: 2 kg m²\n",
            "normal force times arm: 50 N m\n",
            "rotary speed: 0.1 rad/s\n",
            "may stick-slip below rotary speed: ",
        ] {
            assert!(text.contains(part), "{part} is not in\n{text}");
        }
        assert!(!text.contains("belt speed") && !text.contains("mass"), "{text}");
    }

    #[test]
    fn everything_lies_on_the_page() {
        let formula = format!("0.3 + 0.1*exp(-u/0.2){}", " + 0*u".repeat(60));
        let law = Expression::new(&formula, 1.0).unwrap();
        let friction = Friction::Formula(law, LawParameters::new(&[]));
        let all = assess(&Machine { friction, ..example(Law::Stribeck) }).unwrap();
        let (title, source) = ("a long title ".repeat(20), "source ".repeat(90));
        let shown = slipmap_map::Shown { unit: "km/h".into(), size: 1.0 / 3.6 };
        let units = [("belt_speed", Some(shown))];
        let subject = Subject {
            title: &title,
            uncertain: &[],
            units: &units,
            speeds: None,
            risk: None,
            source: &source,
        };
        let page = MachinePage::new(&all, &subject);
        let pages = [page];
        let scene = MachinePage::scene(&pages);
        let svg = scene.svg("page", &rich("page"));
        // Of 0.1 m/s, in text and figures.
        for words in [" at 0.36 km/h", ">0.36 km/h<", ">belt speed, km/h<", ">slip speed, km/h<"] {
            assert!(svg.contains(words), "{words}");
        }
        let svg = roxmltree::Document::parse(&svg).unwrap();
        let mut texts = 0;
        for text in svg.descendants().filter(|node| node.has_tag_name("text")) {
            // Figures are narrower than their part of the page.
            let number = |name: &str| text.attribute(name).unwrap().parse::<f64>().unwrap();
            let words = text.descendants().filter(|node| node.is_text());
            let words: String = words.filter_map(|node| node.text()).collect();
            let words = Rich::foreign(words.trim_end());
            if text.attribute("text-anchor") == Some("start") && number("font-size") >= TEXT {
                let end = number("x") + text_width(&words, number("font-size"));
                assert!(
                    end <= PAGE.0 - MARGIN + 1.0 && number("y") < scene.height,
                    "{words:?} ends at {end}"
                );
                texts += 1;
            }
        }
        assert!(texts > 40, "{texts}");
        assert!(MachinePage::html(&pages).contains(&" + 0*u".repeat(60)));
    }

    #[test]
    fn shares_are_printed_as_people_read_them() {
        let print = |value, limits| percentage(&WithLimits { value, limits });
        assert_eq!(print(1.0, [0.999_98, 1.0]), "100 (> 99.99 to 100) %");
        assert_eq!(print(1.0, [1.0, 1.0]), "100 %");
        assert_eq!(print(6.77e-15, [6.7e-15, 6.8e-15]), "< 0.01 %");
        assert_eq!(print(0.0, [0.0, 0.001_28]), "0 (0 to 0.13) %");
        assert_eq!(print(0.25, [0.231, 0.26]), "25 (23.1 to 26) %");
    }
}
