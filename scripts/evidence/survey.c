/* Orbits of random friction laws in 80-bit arithmetic that shares nothing with the crate, for survey.py.
 *
 * The oscillator x1' = x2, x2' = -x1 - C x2 + F, F = phi(V - x2) below the belt line and -phi(x2 - V) above it, by extrapolation of
 * the midpoint rule (Gragg, Bulirsch and Stoer). Steps end where the law has a corner, and none changes the slip speed by more than
 * half of the width of a feature of the law, or of its distance. Units: eps = 1, friction at rest 1.
 *
 * Input: the law, then questions, a line each; an answer is a line.
 *   sum V TERMS, then lines `type A s w p`   |   table V ROWS, then lines `u phi slope`
 *   fate C       sticks x1 slip_time crossings | inward | crosses | leaves, of the orbit from the exit point
 *   turn C r     the next maximum of x2 of the orbit from its maximum r; `belt` where it meets the belt line
 *   rest C       the same from (1 - phi(0+) - C V, V): at rest on the belt line, with a drop
 *   loop C y     y' of the orbit from y beyond the exit point: crosses y' | sticks | inward | leaves
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef long double real;
enum { STAGES = 8, MOST = 100000, TERMS = 2000 };
static const real TOLERANCE = 5e-17L;

static int is_table, count;
static int type[TERMS];
static real A[TERMS], S[TERMS], W[TERMS], P[TERMS]; /* of a table u, phi, slope */
static real V, C;
static int knots;
static real knot[TERMS];

static real power(real x, real p) { return x <= 0 ? (p == 0) : powl(x, p); }

/* Friction on the piece of the law between two corners, continued beyond them. */
static real phi(real u, int piece) {
    if (is_table) {
        int i = piece < count - 2 ? piece : count - 2;
        real h = A[i + 1] - A[i], t = (u - A[i]) / h, q = 1 - t;
        return S[i] * (1 + 2 * t) * q * q + S[i + 1] * t * t * (3 - 2 * t) + h * (W[i] * t * q * q - W[i + 1] * t * t * q);
    }
    real sum = 0;
    for (int i = 0; i < count; i++) {
        real x = (u - S[i]) / W[i];
        switch (type[i]) {
        case 0: sum += A[i] * expl(-power(P[i] == 2 ? fabsl(x) : x, P[i])); break;
        case 1: sum += A[i] * tanhl(x); break;
        case 2: sum += A[i] / (1 + x * x); break;
        case 3: sum += A[i] * sinl(W[i] * u); break;
        case 4: sum += A[i] * (piece > 0 ? u - S[i] : S[i] - u); break;
        case 5: sum += A[i] * power(u, P[i]); break;
        case 6: sum += A[i] / (1 + x); break;
        case 7: sum += A[i] * atanl(x); break;
        }
    }
    return sum;
}

static int piece_of(real u) {
    int piece = 0;
    while (piece < knots && u >= knot[piece]) piece++;
    return piece;
}

static int below, piece;
static void field(const real *x, real *f) {
    real u = below ? V - x[1] : x[1] - V;
    f[0] = x[1];
    f[1] = -x[0] - C * x[1] + (below ? phi(u, piece) : -phi(u, piece));
}

/* A step of width h; returns the estimate of its error. */
static real step(const real *x, real h, real *out) {
    static real row[2][STAGES][2];
    real f[2], error = 0;
    field(x, f);
    for (int k = 0; k < STAGES; k++) {
        int n = 2 * (k + 1);
        real d = h / n, before[2] = { x[0], x[1] }, here[2] = { x[0] + d * f[0], x[1] + d * f[1] }, g[2];
        for (int i = 1; i < n; i++) {
            field(here, g);
            for (int j = 0; j < 2; j++) {
                real next = before[j] + 2 * d * g[j];
                before[j] = here[j], here[j] = next;
            }
        }
        field(here, g);
        real (*now)[2] = row[k & 1], (*last)[2] = row[1 - (k & 1)];
        for (int j = 0; j < 2; j++) now[0][j] = (before[j] + here[j] + d * g[j]) / 2;
        for (int m = 1; m <= k; m++) {
            real ratio = (real)(k + 1) / (k + 1 - m);
            for (int j = 0; j < 2; j++) now[m][j] = now[m - 1][j] + (now[m - 1][j] - last[m - 1][j]) / (ratio * ratio - 1);
        }
        if (k == STAGES - 1)
            for (int j = 0; j < 2; j++) {
                out[j] = now[k][j];
                error = fmaxl(error, fabsl(now[k][j] - now[k - 1][j]));
            }
    }
    return error;
}

/* The longest step that resolves the features of the law. */
static real longest(const real *x) {
    real f[2], u = below ? V - x[1] : x[1] - V, most = 0.3L;
    field(x, f);
    for (int i = 0; i < (is_table ? 0 : count); i++) {
        if (type[i] == 3 || type[i] == 5 || type[i] == 4) continue;
        /* A power that is not whole has no series at rest. */
        real width = P[i] == floorl(P[i]) ? W[i] : 1e-15L;
        real allowed = 0.5L * fmaxl(width, fabsl(u - S[i]));
        /* |f1| h + h^2 / 2 (1 + |x|) <= allowed, about. */
        real a = fabsl(f[1]), b = 1 + fabsl(x[0]) + fabsl(x[1]);
        most = fminl(most, 2 * allowed / (a + sqrtl(a * a + 2 * b * allowed)));
    }
    return most;
}

/* The share of a step at which g(x) passes zero. */
static real crossing(const real *x, real h, real (*g)(const real *), real *at) {
    real low = 0, high = h, value = g(x);
    int positive = value > 0;
    for (int i = 0; i < 200; i++) {
        real middle = 0.5L * (low + high);
        if (middle == low || middle == high) break;
        step(x, middle, at);
        if ((g(at) > 0) == positive) low = middle; else high = middle;
    }
    step(x, high, at);
    return high;
}

static real goal;
static real of_belt(const real *x) { return x[1] - V; }
static real of_slope(const real *x) { real f[2]; field(x, f); return f[1]; }
static real of_goal(const real *x) { return x[1] - goal; }

enum end { BELT, TURNS, LEAVES, FAILS };
static real elapsed;

/* Follows the orbit on its side of the belt line to the line, or to a maximum of x2 below it. */
static enum end follow(real *x) {
    int turned = 0;
    real h = 1e-3L, scale = V + fabsl(x[0]) + fabsl(x[1]);
    elapsed = 0;
    {
        real u = below ? V - x[1] : x[1] - V, f[2];
        field(x, f);
        piece = piece_of(u);
        /* At a corner: the piece that it enters. */
        real pace = below ? -f[1] : f[1];
        if (piece > 0 && u == knot[piece - 1] && pace < 0) piece--;
    }
    for (int i = 0; i < MOST; i++) {
        if (is_table && piece >= knots) return LEAVES;
        real next[2], f[2], g[2], error;
        h = fminl(h, longest(x));
        field(x, f);
        for (;;) {
            error = step(x, h, next);
            real slowest = is_table ? fminl(h, 1) : h;
            if (error <= TOLERANCE * scale || h < 1e-17L) break;
            h = slowest * fmaxl(0.2L, 0.8L * powl(TOLERANCE * scale / error, 1.0L / (2 * STAGES - 1)));
        }
        real grow = error > 0 ? 0.8L * powl(TOLERANCE * scale / error, 1.0L / (2 * STAGES - 1)) : 3;
        field(next, g);
        /* What comes first within the step: the corner, the turn, or the belt line. */
        real u = below ? V - next[1] : next[1] - V, when = h, at[2] = { next[0], next[1] };
        int corner = 0, belt = 0, turn = 0;
        real slope[2] = { f[1], g[1] };
        if (i > 0 && slope[0] != 0 && (slope[0] > 0) != (slope[1] > 0)) when = crossing(x, h, of_slope, at), turn = 1;
        real u_at = below ? V - at[1] : at[1] - V;
        for (int side = -1; side <= 0; side++) {
            int k = piece + side;
            if (k < 0 || k >= knots) continue;
            if ((side < 0 && u_at < knot[k]) || (side == 0 && u_at > knot[k])) {
                goal = below ? V - knot[k] : V + knot[k];
                when = crossing(x, when, of_goal, at), corner = side < 0 ? -1 : 1, turn = 0;
                u_at = knot[k];
            }
        }
        if (u_at <= 0 && i > 0) when = crossing(x, when, of_belt, at), belt = 1, turn = corner = 0;
        (void)u;
        x[0] = at[0], x[1] = at[1], elapsed += when;
        if (belt) { x[1] = V; return BELT; }
        if (corner) {
            x[1] = goal, piece += corner;
            if (is_table && piece >= knots) return LEAVES;
        }
        if (turn) {
            if (below && slope[0] > 0) return TURNS;
            turned++;
        }
        if (!corner) h = (turn ? when : h) * fminl(3, fmaxl(grow, 0.2L)); else h = fminl(h, 1e-2L);
        if (h < 1e-16L) h = 1e-16L;
        if (fabsl(x[0]) + fabsl(x[1]) > 1e8L * (1 + V)) return LEAVES;
    }
    return FAILS;
}

static const char *names[] = { "belt", "turns", "leaves", "fails" };

/* From y beyond the exit point: 's' sticks, 'i' inward, 'c' crosses with y' in x[0]. */
static char loop(real y, real *x, real *slip) {
    x[0] = 1 - C * V + y, x[1] = V, below = 1;
    enum end end = follow(x);
    *slip = elapsed;
    if (end == TURNS) return 'i';
    if (end != BELT) return 'l';
    if (x[0] > -1 - C * V) return 's';
    below = 0;
    end = follow(x);
    *slip += elapsed;
    if (end != BELT) return 'l';
    if (x[0] < 1 - C * V) return 'S';
    x[0] -= 1 - C * V;
    return 'c';
}

int main(void) {
    char word[16];
    double number;
    if (scanf("%15s %lf %d", word, &number, &count) != 3) return 1;
    V = number, is_table = !strcmp(word, "table");
    for (int i = 0; i < count; i++) {
        if (is_table) {
            if (scanf("%Lf %Lf %Lf", &A[i], &S[i], &W[i]) != 3) return 1;
            if (i > 0) knot[knots++] = A[i];
        } else {
            double a[4];
            if (scanf("%d %lf %lf %lf %lf", &type[i], a, a + 1, a + 2, a + 3) != 5) return 1;
            A[i] = a[0], S[i] = a[1], W[i] = a[2], P[i] = a[3];
            if (type[i] == 4) knot[knots++] = S[i];
        }
    }
    while (scanf("%15s %lf", word, &number) == 2) {
        real x[2], slip;
        C = number;
        if (!strcmp(word, "fate")) {
            char end = loop(0, x, &slip);
            if (end == 's' || end == 'S') printf("sticks %.18Lg %.18Lg %d\n", x[0], slip, end == 'S');
            else printf("%s\n", end == 'i' ? "inward" : end == 'c' ? "crosses" : "leaves");
        } else if (!strcmp(word, "rest")) {
            x[0] = phi(0, 0) - C * V, x[1] = V, below = 1;
            printf("%s\n", names[follow(x)]);
        } else {
            if (scanf("%lf", &number) != 1) return 1;
            if (!strcmp(word, "turn")) {
                x[1] = number, below = 1, piece = piece_of(V - x[1]);
                x[0] = phi(V - x[1], piece) - C * x[1];
                enum end end = follow(x);
                if (end == TURNS) printf("%.18Lg\n", x[1]);
                else printf("%s\n", names[end]);
            } else {
                char end = loop(number, x, &slip);
                if (end == 'c') printf("crosses %.18Lg\n", x[0]);
                else printf("%s\n", end == 'i' ? "inward" : end == 'l' ? "leaves" : "sticks");
            }
        }
        fflush(stdout);
    }
    return 0;
}
