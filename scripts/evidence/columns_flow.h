/* The flow of columns.c and its grazing margin in the arithmetic `real`; FN(name) is the name of a function in it, and
 * ABS, MIN, MAX and POW are its elementary functions.
 */
struct FN(groups) { real a, k, b; };

static real FN(divergence)(const struct FN(groups) *g, real c, real v) {
    real q = 1 + g->k * (1 - v);
    return g->a / (q * q) - 2 * g->b * (1 - v) - c;
}

/* Coefficients of v and w about (v, w). */
static void FN(series)(const struct FN(groups) *g, real c, int order, real *v, real *w) {
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

static real FN(at)(const real *a, int order, real t) {
    real sum = a[order];
    for (int n = order - 1; n >= 0; n--) sum = sum * t + a[n];
    return sum;
}

/* The time in (0, h) at which w passes zero, with opposite signs at the ends. */
static real FN(turning)(const real *w, int order, real h, real from, real to) {
    real low = 0, high = h;
    for (int i = 0; i < 200 && high - low > (real)1e-32 * h; i++) {
        real secant = low - from * (high - low) / (to - from), middle = (real)0.5 * (low + high);
        real t = i % 3 != 2 && secant > low && secant < high ? secant : middle;
        if (t <= low || t >= high) break;
        real value = FN(at)(w, order, t);
        if ((value > 0) == (to > 0)) high = t, to = value;
        else low = t, from = value;
    }
    return high;
}

/* First maximum of v less 1; -1 where the orbit creeps into the equilibrium, 1 where it runs far past the belt line. */
static real FN(margin)(const struct FN(groups) *g, real c, struct accuracy accuracy) {
    real v[MOST + 2] = { 1 }, w[MOST + 2] = { 0 }, far = 1 + MIN((real)0.1, (real)0.5 / g->k);
    int order = accuracy.order, minimum = 0;
    for (int step = 0; step < 100000; step++) {
        /* Where D <= -2 from here to the equilibrium the wedge between w = 0 and w = -v is never left. */
        if (v[0] * w[0] < 0 && ABS(w[0]) < ABS(v[0]) && FN(divergence)(g, c, v[0]) <= -2 && FN(divergence)(g, c, 0) <= -2)
            return -1;
        FN(series)(g, c, order, v, w);
        real size = MAX(ABS(v[0]), ABS(w[0])), h = (real)0.4;
        for (int n = order - 1; n <= order; n++) {
            real last = MAX(ABS(v[n]), ABS(w[n]));
            if (last > 0) h = MIN(h, POW(accuracy.tolerance * size / last, (real)1.0 / n));
        }
        real next_v = FN(at)(v, order, h), next_w = FN(at)(w, order, h), before = w[0] == 0 ? -1 : w[0];
        if (minimum ? before > 0 && next_w <= 0 : before < 0 && next_w >= 0) {
            real t = FN(turning)(w, order, h, minimum ? 1 : -1, next_w);
            v[0] = FN(at)(v, order, t);
            if (minimum) return v[0] - 1;
            w[0] = 0;
            minimum = 1;
            /* On from the minimum with w = 0: the next w is positive. */
            FN(series)(g, c, order, v, w);
            real small = (real)1e-3;
            for (int n = order - 1; n <= order; n++) {
                real last = MAX(ABS(v[n]), ABS(w[n]));
                if (last > 0) small = MIN(small, POW(accuracy.tolerance * ABS(v[0]) / last, (real)1.0 / n));
            }
            next_v = FN(at)(v, order, small), next_w = FN(at)(w, order, small);
        }
        v[0] = next_v, w[0] = next_w;
        if (minimum && v[0] > far) return 1;
    }
    fprintf(stderr, "no end: A %g k %g b %g C %g\n", (double)g->a, (double)g->k, (double)g->b, (double)c);
    exit(1);
}
