//! exp
use slipmap::filippov::*;
use slipmap::friction::*;
use slipmap::point::*;
use slipmap::simulate::*;
struct R(u64);
impl R {
    fn f(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }
    fn r(&mut self, a: f64, b: f64) -> f64 {
        a + (b - a) * self.f()
    }
}
fn main() {
    let mut r = R(88172645463325252);
    let n = 1 << 13;
    for (e, vm) in [(0.05, 1.5), (0.2, 1.5), (0.4, 1.5)] {
        let cols: Vec<_> = (0..n)
            .map(|_| {
                let p = Point {
                    epsilon: e,
                    law: LawParameters::new(&[r.r(0., 1.), r.r(0., 0.5), r.r(0., 4.)]),
                    damping: 0.,
                    belt_speed: r.r(0.2, vm),
                };
                Law::Stribeck.column(&p)
            })
            .collect();
        for tol in [1e-6, 1e-9, 1e-12, 1e-15] {
            let t = std::time::Instant::now();
            let a = critical::critical_dampings(&cols, tol);
            let dt = t.elapsed().as_secs_f64() / n as f64 * 1e9;
            let ok = a.iter().flatten().count();
            let rhs = a.iter().flatten().map(|x| x.rhs as f64).sum::<f64>() / ok as f64;
            let mut bad = 0;
            let mut close = 0;
            let mut tot = 0;
            for (x, c) in a.iter().zip(&cols) {
                if let Ok(x) = x {
                    if x.c > 1e-3 {
                        tot += 1;
                        for s in [-1.0, 1.0] {
                            let d = (2.0 * x.error).max(1e-12 * x.c);
                            let f = flow(&Oscillator::in_column(c, x.c + s * d), 1e-12);
                            match f.fate {
                                Fate::TooCloseToCall => close += 1,
                                Fate::SpiralsInward => {
                                    if s < 0. {
                                        bad += 1;
                                        println!(
                                            "{x:?} k {:.3} A {:.3} m {:e} d {d:e}",
                                            c.belt_speed * e * 0.0,
                                            c.curve.weakening(0.0),
                                            f.margin
                                        )
                                    }
                                }
                                Fate::Sticks(_) | Fate::CrossesForever => {
                                    if s > 0. {
                                        bad += 1;
                                        println!(
                                            "{x:?} A {:.3} m {:e} d {d:e}",
                                            c.curve.weakening(0.0),
                                            f.margin
                                        )
                                    }
                                }
                                _ => {}
                            }
                        }
                    }
                }
            }
            println!(
                "eps {e} tol {tol:e} ok {ok} ns/col {dt:.0} rhs {rhs:.0} wrong {bad} close {close} of {}",
                2 * tot
            );
        }
    }
}
