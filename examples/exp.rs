//! exp
use slipmap::point::ScaledGroups;
use slipmap::simulate::return_map::*;
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
    let n = 1 << 15;
    for e in [0.001, 0.05, 0.4, 1.0] {
        let vm = if e < 0.9 { 1.5 } else { 10.0 };
        let g: Vec<_> = (0..n)
            .map(|_| {
                let (al, be, ga, c, v) = (r.r(0., 1.), r.r(0., 0.5), r.r(0., 4.), r.r(0., 1.), r.r(0.2, vm));
                ScaledGroups { a: e * ga * (1. - al), k: e * ga * v, b: e * be * v, c: e * c }
            })
            .collect();
        let m = |t: &Turn| match *t {
            Turn::Complete { margin, error, rhs } => (margin, error, rhs),
            Turn::HandOver { rhs } => (f64::NAN, f64::NAN, rhs),
        };
        let refs: Vec<_> = turns(&g, 1e-15).iter().map(m).collect();
        println!("ref rhs {}", refs.iter().map(|x| x.2 as f64).sum::<f64>() / n as f64);
        for tol in [1e-6, 1e-9, 1e-12] {
            let t = std::time::Instant::now();
            let o: Vec<_> = turns(&g, tol).iter().map(m).collect();
            let dt = t.elapsed().as_secs_f64() / n as f64 * 1e9;
            let (mut me, mut mr) = (0f64, 0f64);
            let mut ho = 0;
            let mut bad = 0;
            for (x, y) in o.iter().zip(&refs) {
                if x.0.is_nan() {
                    ho += 1;
                    continue;
                }
                let er = (x.0 - y.0).abs();
                me = me.max(er);
                mr = mr.max(er / x.1);
                if er > x.1 {
                    bad += 1;
                }
            }
            println!(
                "eps {e} tol {tol:e} ns/cell {dt:.1} rhs {:.1} maxerr {me:.2e} max err/est {mr:.2} handed {ho} bad {bad}",
                o.iter().map(|x| x.2 as f64).sum::<f64>() / n as f64
            );
        }
    }
}
