/* Critical dampings of columns that are hard to solve, in 113-bit arithmetic that shares nothing with the crate.
 *
 *     cc -O2 -o columns scripts/columns.c -lquadmath
 *     ./columns 2000 20260415 > tests/data/columns.csv
 *     ./columns 10000 7 > others.csv; SLIPMAP_COLUMNS=$PWD/others.csv cargo test --test mathematics columns:: -- --ignored
 *
 * The orbit from (v, w) = (V, 0) of v' = w, w' = -v + D w, with the lower flow's D continued above the belt line, by Taylor
 * series: foci and nodes are the same to it. c* is where its first maximum of v is V: bisection and regula falsi between
 * the bounds from the even part of D. Units: v in belt speeds, C = eps c. Every tenth root is found again at another order
 * and step length. scripts/reference.py --quick recomputes rows in MPFR by a program of its own.
 */
#include <quadmath.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

typedef __float128 real;
enum { MOST = 40 };

struct groups { real a, k, b; };
struct accuracy { int order; real tolerance; };

static const struct accuracy USUAL = { 26, 1e-27Q }, OTHER = { 34, 1e-29Q };

static real divergence(const struct groups *g, real c, real v) {
    real q = 1 + g->k * (1 - v);
    return g->a / (q * q) - 2 * g->b * (1 - v) - c;
}

/* Coefficients of v and w about (v, w). */
static void series(const struct groups *g, real c, int order, real *v, real *w) {
    real p[MOST + 1], d[MOST + 1], p0 = 1 / (1 + g->k * (1 - v[0]));
    p[0] = p0;
    for (int n = 0; n < order; n++) {
        if (n) { /* p = 1 / (1 + k (1 - v)):  p_n = k p_0 sum_{i=1..n} v_i p_{n-i} */
            real sum = 0;
            for (int i = 1; i <= n; i++) sum += v[i] * p[n - i];
            p[n] = g->k * p0 * sum;
        }
        real square = 0, product = 0;
        for (int i = 0; i <= n; i++) square += p[i] * p[n - i];
        d[n] = g->a * square + 2 * g->b * v[n] - (n ? 0 : 2 * g->b + c);
        for (int i = 0; i <= n; i++) product += d[i] * w[n - i];
        w[n + 1] = (product - v[n]) / (n + 1);
        v[n + 1] = w[n] / (n + 1);
    }
}

static real at(const real *a, int order, real t) {
    real sum = a[order];
    for (int n = order - 1; n >= 0; n--) sum = sum * t + a[n];
    return sum;
}

/* The time in (0, h) at which w passes zero, with opposite signs at the ends. */
static real turning(const real *w, int order, real h, real from, real to) {
    real low = 0, high = h;
    for (int i = 0; i < 200 && high - low > 1e-32Q * h; i++) {
        real secant = low - from * (high - low) / (to - from), middle = 0.5Q * (low + high);
        real t = i % 3 != 2 && secant > low && secant < high ? secant : middle;
        if (t <= low || t >= high) break;
        real value = at(w, order, t);
        if ((value > 0) == (to > 0)) high = t, to = value;
        else low = t, from = value;
    }
    return high;
}

/* First maximum of v less 1; -1 where the orbit creeps into the equilibrium, 1 where it runs far past the belt line. */
static real margin(const struct groups *g, real c, struct accuracy accuracy) {
    real v[MOST + 2] = { 1 }, w[MOST + 2] = { 0 }, far = 1 + fminq(0.1Q, 0.5Q / g->k);
    int order = accuracy.order, minimum = 0;
    for (int step = 0; step < 100000; step++) {
        /* Where D <= -2 from here to the equilibrium the wedge between w = 0 and w = -v is never left. */
        if (v[0] * w[0] < 0 && fabsq(w[0]) < fabsq(v[0]) && divergence(g, c, v[0]) <= -2 && divergence(g, c, 0) <= -2)
            return -1;
        series(g, c, order, v, w);
        real size = fmaxq(fabsq(v[0]), fabsq(w[0])), h = 0.4Q;
        for (int n = order - 1; n <= order; n++) {
            real last = fmaxq(fabsq(v[n]), fabsq(w[n]));
            if (last > 0) h = fminq(h, powq(accuracy.tolerance * size / last, 1.0Q / n));
        }
        real next_v = at(v, order, h), next_w = at(w, order, h), before = w[0] == 0 ? -1 : w[0];
        if (minimum ? before > 0 && next_w <= 0 : before < 0 && next_w >= 0) {
            real t = turning(w, order, h, minimum ? 1 : -1, next_w);
            v[0] = at(v, order, t);
            if (minimum) return v[0] - 1;
            w[0] = 0;
            minimum = 1;
            /* On from the minimum with w = 0: the next w is positive. */
            series(g, c, order, v, w);
            real small = 1e-3Q;
            for (int n = order - 1; n <= order; n++) {
                real last = fmaxq(fabsq(v[n]), fabsq(w[n]));
                if (last > 0) small = fminq(small, powq(accuracy.tolerance * fabsq(v[0]) / last, 1.0Q / n));
            }
            next_v = at(v, order, small), next_w = at(w, order, small);
        }
        v[0] = next_v, w[0] = next_w;
        if (minimum && v[0] > far) return 1;
    }
    fprintf(stderr, "no end: A %g k %g b %g C %g\n", (double)g->a, (double)g->k, (double)g->b, (double)c);
    exit(1);
}

static real critical(const struct groups *g, struct accuracy accuracy) {
    real k1 = 1 + g->k, k2 = 1 + 2 * g->k;
    real low = g->a / (k1 * k1) - 2 * g->b, high = 0.5Q * g->a * (1 + 1 / (k2 * k2)) - 2 * g->b;
    real at_low = margin(g, low, accuracy), at_high = margin(g, high, accuracy);
    int kept = 0; /* Which end the last trials kept, and how often: Illinois's rule halves the value there. */
    for (int i = 0; i < 300 && high - low > 1e-24Q * g->a; i++) {
        real secant = low - at_low * (high - low) / (at_high - at_low), middle = 0.5Q * (low + high);
        real edge = 1e-26Q * g->a, c = secant > low + edge ? fminq(secant, high - edge) : low + edge;
        if (abs(kept) > 3 || i < 3) c = middle;
        real value = margin(g, c, accuracy);
        if (value > 0) {
            kept = kept < 0 ? kept - 1 : -1;
            if (kept < -1) at_high *= 0.5Q;
            low = c, at_low = value;
        } else {
            kept = kept > 0 ? kept + 1 : 1;
            if (kept > 1) at_low *= 0.5Q;
            high = c, at_high = value;
        }
    }
    return 0.5Q * (low + high);
}

static uint64_t state;
/* splitmix64 */
static double uniform(double low, double high) {
    uint64_t z = state += 0x9e3779b97f4a7c15u;
    z = (z ^ z >> 30) * 0xbf58476d1ce4e5b9u;
    z = (z ^ z >> 27) * 0x94d049bb133111ebu;
    return low + (high - low) * ((z ^ z >> 31) >> 11) * 0x1p-53;
}
static double log_uniform(double low, double high) { return (double)expq(uniform(logq(low), logq(high))); }
/* The double nearest to six significant digits. */
static double brief(double x) {
    char text[32];
    snprintf(text, sizeof text, "%.6g", x);
    return atof(text);
}

struct kind { const char *name; double a[2], k[2]; int share; };
static const struct kind KINDS[] = {
    { "strong weakening", { 1.5, 3.5 }, { 0.05, 20 }, 10 },
    { "nodes", { 3.5, 100 }, { 0.05, 100 }, 4 },
    { "large k", { 0.01, 3 }, { 20, 1e4 }, 3 },
    { "weak", { 1e-3, 1.5 }, { 1e-2, 5 }, 3 },
};

int main(int argc, char **argv) {
    int count = argc > 1 ? atoi(argv[1]) : 0;
    state = argc > 2 ? strtoull(argv[2], NULL, 10) : 0;
    printf("# Critical damping c* of columns that are hard to solve, by the (v, w) flow in 113-bit arithmetic.\n"
           "# Made by scripts/columns.c %d %llu; each parameter is the f64 nearest to its decimals.\n"
           "# Log-uniform in A = eps gamma (1-alpha) and k = eps gamma V, turn by turn:\n", count, (unsigned long long)state);
    for (int i = 0; i < 4; i++)
        printf("# %d in 20: %s, A in [%g, %g], k in [%g, %g]\n", KINDS[i].share, KINDS[i].name, KINDS[i].a[0],
               KINDS[i].a[1], KINDS[i].k[0], KINDS[i].k[1]);
    printf("epsilon,alpha,beta,gamma,V,critical_c\n");
    real worst = 0;
    for (int row = 0; row < count;) {
        int turn = row % 20, i = 0;
        while (turn >= KINDS[i].share) turn -= KINDS[i++].share;
        double a = log_uniform(KINDS[i].a[0], KINDS[i].a[1]), k = log_uniform(KINDS[i].k[0], KINDS[i].k[1]);
        double q = (double)sqrtq(1 + 2 * k), balance = a / (q * (1 + k + q));
        double b = uniform(0, 1) < 0.25 ? 0 : uniform(0, 0.9) * balance;
        double epsilon = brief(log_uniform(0.05, 2)), alpha = brief(uniform(0, 0.9));
        double gamma = brief(a / (epsilon * (1 - alpha))), belt = brief(k / (epsilon * gamma));
        double beta = brief(b / (epsilon * belt));
        real rate = (real)epsilon * gamma;
        struct groups g = { rate * (1 - (real)alpha), rate * belt, (real)epsilon * beta * belt };
        real c = critical(&g, USUAL);
        if (c <= 0) continue;
        if (row % 10 == 0) worst = fmaxq(worst, fabsq(critical(&g, OTHER) - c) / g.a);
        char text[64];
        quadmath_snprintf(text, sizeof text, "%.17Qe", c / epsilon);
        printf("%.6g,%.6g,%.6g,%.6g,%.6g,%s\n", epsilon, alpha, beta, gamma, belt, text);
        row++;
    }
    fprintf(stderr, "largest disagreement of two accuracies in every tenth row, in units of A: %.1e\n", (double)worst);
    return !(worst < 1e-21Q);
}
