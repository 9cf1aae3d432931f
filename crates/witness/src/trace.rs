//! Sampled orbits, for phase portraits and basins of attraction.

use super::orbit::{Contact, Event, Rest};
use super::slip::Slip;
use super::{Failure, SLIDING_WIDTH};
use slipmap_model::filippov::{BeltRegion, Oscillator, Side};

/// Largest angle, in radians, by which an orbit turns between two samples: a polyline through them differs
/// from the orbit by about 1/800 of its radius.
const SAMPLE_ANGLE: f64 = 0.1;

/// Largest number of steps of an orbit; a turn takes some 100. Every step is a sample, and a figure of more
/// would be illegible.
const MOST_STEPS: u32 = 200_000;

/// An orbit has settled once it is trapped within this fraction of the belt speed of the equilibrium.
const SETTLED_RADIUS: f64 = 1e-3;

/// The start of an orbit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Start {
    /// The exit point, through which every sticking orbit leaves the belt.
    ExitPoint,
    /// Any state; on the belt line it sticks or crosses, as the fields there determine.
    State {
        /// Position x1.
        x1: f64,
        /// Velocity x2.
        x2: f64,
    },
}

/// The motion of the mass.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Phase {
    /// It slips, slower or faster than the belt.
    Slip(Side),
    /// It moves with the belt.
    Stick,
}

/// A state on a traced orbit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// Time since the start.
    pub t: f64,
    /// Position x1.
    pub x1: f64,
    /// Velocity x2; exactly V where the orbit meets, follows or leaves the belt line.
    pub x2: f64,
    /// The motion from here on.
    pub phase: Phase,
}

/// Reason why a trace ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Ending {
    /// The orbit left the exit point and returned to it by sticking: the stick-slip cycle is complete.
    Closes {
        /// Its period.
        period: f64,
    },
    /// The orbit is within V / 1000 of the equilibrium, in a disc that no orbit leaves; or it tends to the
    /// equilibrium too slowly to be followed, but provably without meeting the belt line again.
    Settles,
    /// The time limit was reached.
    OutOfTime,
    /// The integration failed.
    Failed(Failure),
}

/// A sampled orbit.
#[derive(Clone, Debug, PartialEq)]
pub struct Trace {
    /// Samples in order of time, at most 0.1 rad of the (x2, x2') plane apart while slipping; the ends
    /// of every stick and every crossing of the belt line are among them.
    pub samples: Vec<Sample>,
    /// Reason why it ends.
    pub ending: Ending,
}

/// Follows an orbit through slipping, crossing and sticking until it closes at the exit point (for an
/// orbit that starts elsewhere: the second time it gets there), settles, or `max_time` is over.
///
/// `tolerance` is that of [`super::flow`]. Contacts with the belt line that are too close to call are decided
/// as computed.
#[must_use]
pub fn trace(oscillator: &Oscillator, start: Start, tolerance: f64, max_time: f64) -> Trace {
    let mut tracer = Tracer {
        oscillator,
        slip: Slip::from_exit(oscillator, tolerance).sampled(SAMPLE_ANGLE, MOST_STEPS),
        samples: Vec::new(),
        last_exit: None,
        max_time,
    };
    let ending = match tracer.run(start) {
        Ok(ending) | Err(ending) => ending,
    };
    Trace { samples: tracer.samples, ending }
}

struct Tracer<'a> {
    oscillator: &'a Oscillator,
    slip: Slip<'a>,
    samples: Vec<Sample>,
    /// Time at which the orbit last left the exit point.
    last_exit: Option<f64>,
    max_time: f64,
}

impl Tracer<'_> {
    /// Follows the orbit to its end; `Err` is an end within one of its parts.
    fn run(&mut self, start: Start) -> Result<Ending, Ending> {
        self.begin(start)?;
        loop {
            if self.slip.here.time >= self.max_time {
                return Ok(Ending::OutOfTime);
            }
            match self.slip.advance(self.max_time) {
                Ok(Event::Landed(contact)) => self.meet_line(&contact)?,
                Ok(Event::Moved | Event::NearMiss(_)) => {
                    self.sample_here();
                    let radius = SETTLED_RADIUS * self.oscillator.belt_speed;
                    if let Some(Rest::Trapped { .. }) = self.slip.rest(radius) {
                        return Ok(Ending::Settles);
                    }
                }
                Err(Failure::StepBudget) if self.slip.rest(0.0).is_some() => return Ok(Ending::Settles),
                Err(failure) => return Ok(Ending::Failed(failure)),
            }
        }
    }

    fn begin(&mut self, start: Start) -> Result<(), Ending> {
        let Start::State { x1, x2 } = start else {
            self.leave_exit(0.0);
            return Ok(());
        };
        let belt_speed = self.oscillator.belt_speed;
        if x2 == belt_speed {
            match self.oscillator.belt_region(x1) {
                BeltRegion::Sliding | BeltRegion::UpperTangency => {
                    return self.stick(x1 - self.oscillator.exit_x1(), 0.0);
                }
                BeltRegion::ExitPoint => return self.begin(Start::ExitPoint),
                BeltRegion::CrossingDown => self.slip.place(x1, x2, Side::Below, 0.0),
                BeltRegion::CrossingUp => self.slip.place(x1, x2, Side::Above, 0.0),
            }
        } else {
            let side = if x2 > belt_speed { Side::Above } else { Side::Below };
            self.slip.place(x1, x2, side, 0.0);
        }
        self.sample_here();
        Ok(())
    }

    /// Handles an arrival at the belt line: the orbit sticks or crosses.
    fn meet_line(&mut self, contact: &Contact) -> Result<(), Ending> {
        let x1_offset = contact.at.x1_offset();
        let crosses = match self.slip.side {
            Side::Below => x1_offset < -SLIDING_WIDTH,
            Side::Above => x1_offset > 0.0,
        };
        if crosses {
            self.slip.cross(&contact.at);
            self.sample_here();
            Ok(())
        } else {
            self.stick(x1_offset, contact.at.time)
        }
    }

    /// The mass moves with the belt from `x1_offset` <= 0 to the exit point.
    fn stick(&mut self, x1_offset: f64, time: f64) -> Result<(), Ending> {
        self.sample(time, x1_offset, 0.0, Phase::Stick);
        let belt_speed = self.oscillator.belt_speed;
        let leaves = time - x1_offset / belt_speed;
        if leaves > self.max_time {
            let moved = (self.max_time - time) * belt_speed;
            self.sample(self.max_time, x1_offset + moved, 0.0, Phase::Stick);
            return Err(Ending::OutOfTime);
        }
        let period = self.last_exit.map(|left| leaves - left);
        self.leave_exit(leaves);
        period.map_or(Ok(()), |period| Err(Ending::Closes { period }))
    }

    fn leave_exit(&mut self, time: f64) {
        self.slip.leave_exit(time);
        self.last_exit = Some(time);
        self.sample_here();
    }

    fn sample_here(&mut self) {
        let here = self.slip.here;
        self.sample(here.time, here.x1_offset(), here.x2_offset(), Phase::Slip(self.slip.side));
    }

    fn sample(&mut self, t: f64, x1_offset: f64, x2_offset: f64, phase: Phase) {
        let x1 = self.oscillator.exit_x1() + x1_offset;
        let x2 = self.oscillator.belt_speed + x2_offset;
        self.samples.push(Sample { t, x1, x2, phase });
    }
}
