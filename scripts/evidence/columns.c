/* Critical dampings of columns that are hard to solve, in 113-bit arithmetic that shares nothing with the crate.
 *
 *     cc -O2 -o columns scripts/evidence/columns.c -lquadmath -lm
 *     ./columns 1200 20260415 > tests/data/columns.csv
 *     ./columns 10000 7 > others.csv; SLIPMAP_COLUMNS=$PWD/others.csv cargo test --test mathematics columns:: -- --ignored
 *
 * The orbit from (v, w) = (V, 0) of v' = w, w' = -v + D w, with the lower flow's D continued above the belt line, by Taylor
 * series: foci and nodes are the same to it. c* is where its first maximum of v is V. It is sought in 80-bit arithmetic, by
 * bisection and regula falsi between the bounds from the even part of D; 113-bit arithmetic then shows the opposite signs
 * of the maximum less V on both sides of it, and ends with regula falsi between them. Units: v in belt speeds, C = eps c.
 * Every tenth root is found again at another order and step length. scripts/evidence/reference.py --quick recomputes rows in MPFR by
 * a program of its own.
 */
#include <math.h>
#include <quadmath.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

enum { MOST = 40 };
struct accuracy { int order; double tolerance; };

#define MAX(x, y) ((x) > (y) ? (x) : (y))
#define MIN(x, y) ((x) < (y) ? (x) : (y))

#define real long double
#define FN(name) name##_80
#define ABS fabsl
#define POW powl
#include "columns_flow.h"
#undef real
#undef FN
#undef ABS
#undef POW

typedef __float128 real;
#define FN(name) name##_113
#define ABS fabsq
#define POW powq
#include "columns_flow.h"

static const struct accuracy ROUGH = { 18, 1e-19 }, USUAL = { 22, 1e-22 }, OTHER = { 34, 1e-29 };

/* The zero of the margin between the bounds from the even part, to some 17 digits of A. */
static long double sought(const struct groups_80 *g) {
    long double k1 = 1 + g->k, k2 = 1 + 2 * g->k;
    long double low = g->a / (k1 * k1) - 2 * g->b, high = 0.5L * g->a * (1 + 1 / (k2 * k2)) - 2 * g->b;
    long double at_low = margin_80(g, low, ROUGH), at_high = margin_80(g, high, ROUGH);
    int kept = 0; /* Which end the last trials kept, and how often: Illinois's rule halves the value there. */
    for (int i = 0; i < 300 && high - low > 1e-17L * g->a; i++) {
        long double secant = low - at_low * (high - low) / (at_high - at_low), middle = 0.5L * (low + high);
        long double edge = 4e-18L * g->a, c = secant > low + edge ? MIN(secant, high - edge) : low + edge;
        if (abs(kept) > 3 || i < 3) c = middle;
        long double value = margin_80(g, c, ROUGH);
        if (value > 0) {
            kept = kept < 0 ? kept - 1 : -1;
            if (kept < -1) at_high *= 0.5L;
            low = c, at_low = value;
        } else {
            kept = kept > 0 ? kept + 1 : 1;
            if (kept > 1) at_low *= 0.5L;
            high = c, at_high = value;
        }
    }
    return 0.5L * (low + high);
}

/* The critical C: a zero between two opposite signs. */
static real critical(const struct groups_113 *g, struct accuracy accuracy) {
    struct groups_80 near = { g->a, g->k, g->b };
    real c = sought(&near), apart = 1e-16Q * g->a;
    real low = c - apart, high = c + apart;
    real at_low = margin_113(g, low, accuracy), at_high = margin_113(g, high, accuracy);
    while (at_low <= 0) apart *= 8, low = c - apart, at_low = margin_113(g, low, accuracy);
    while (at_high >= 0) apart *= 8, high = c + apart, at_high = margin_113(g, high, accuracy);
    /* So near to it the margin is linear, with a slope of order one. */
    if (at_low - at_high < 1e-9Q) return low - at_low * (high - low) / (at_high - at_low);
    /* Not so beyond some nodes. */
    while (high - low > 1e-20Q * g->a) {
        real middle = 0.5Q * (low + high);
        if (margin_113(g, middle, accuracy) > 0) low = middle;
        else high = middle;
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
           "# Made by scripts/evidence/columns.c %d %llu; each parameter is the f64 nearest to its decimals.\n"
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
        struct groups_113 g = { rate * (1 - (real)alpha), rate * belt, (real)epsilon * beta * belt };
        real c = critical(&g, USUAL);
        if (c <= 0) continue;
        if (row % 10 == 0) worst = fmaxq(worst, fabsq(critical(&g, OTHER) - c) / g.a);
        char text[64];
        quadmath_snprintf(text, sizeof text, "%.17Qe", c / epsilon);
        printf("%.6g,%.6g,%.6g,%.6g,%.6g,%s\n", epsilon, alpha, beta, gamma, belt, text);
        row++;
    }
    fprintf(stderr, "largest disagreement of two accuracies in every tenth row, in units of A: %.1e\n", (double)worst);
    return !(worst < 1e-19Q);
}
