"""The reduction of measured friction in numpy, and its numbers that the tests of `crates/fit/src/reduction.rs` compare.

    python3 scripts/evidence/reduction.py > crates/fit/src/reduction/expected.txt
"""

import numpy as np
K, ELL, TAU0, NL, NVS, REF, KEEP, KNOTS = 20, 1.5, 0.1, 8, 20, 24, 11.0, 24
SHAPES = [lambda z: 1 / (1 + z), lambda z: 1 / (1 + z * z), lambda z: (1 + z) ** -2.0] + [lambda z, k=k: np.exp(-np.minimum(z, 1e3) ** k) for k in .5 * 2 ** (np.arange(17) / 8)]
LOG_SHARE = [0.0] * 3 + [np.log(.25)] * 17  # of the exponents, of which there are many
FLOOR = 3e-4  # of the range: what 20 splines and 24 knots leave
RHOS = (0, .3, .5, .7, .8, .87, .92, .96, .985); RHOS_AFTER = (-.3, -.15, 0, .15, .3, .5); RATIOS = (.3, 1, 4, 16, 64, 256, 2000)

def splines(x, xm):
    m = K - 3; z = np.clip(x / xm * m, 0, m - 1e-12); i = z.astype(int); t = z - i; r = np.arange(len(x)); B = np.zeros((len(x), K))
    for j, b in enumerate(((1 - t) ** 3, 3 * t**3 - 6 * t * t + 4, -3 * t**3 + 3 * t * t + 3 * t + 1, t**3)): B[r, i + j] = b / 6
    return B

def grams(Z, visits, rhos):
    """(whether visits have an error of their own, gram, log determinant): white or AR(1) rows, with or without that error"""
    if visits is None: yield False, Z.T @ Z, 0.0; return
    st = np.r_[True, np.diff(visits) != 0]; en = np.r_[st[1:], True]; first = np.nonzero(st)[0]; m = np.diff(np.r_[first, len(Z)])
    F, L, T = Z[st], Z[en], np.add.reduceat(Z, first, axis=0); A = Z.T @ Z
    C = Z[1:].T @ Z[:-1]; D = A - np.outer(Z[0], Z[0]) - np.outer(Z[-1], Z[-1])                   # one run over the record
    same = ~st[1:]; Cv = Z[1:][same].T @ Z[:-1][same]; both = st & en; Dv = A - F.T @ F - L.T @ L + Z[both].T @ Z[both]  # cut at visits
    for rho in rhos:
        yield False, A - rho * (C + C.T) + rho**2 * D, .5 * np.log(1 - rho**2)
        G = A - rho * (Cv + Cv.T) + rho**2 * Dv; det = .5 * len(m) * np.log(1 - rho**2)
        if len(m) >= 4:
            cc = (1 - rho**2) + (m - 1) * (1 - rho) ** 2; s = (1 - rho**2) * F + (1 - rho) * (T - F - rho * (T - L))
            for r in RATIOS:
                r = r / cc.mean(); yield True, G - (s.T * (r / (1 + r * cc))) @ s, det - .5 * np.log1p(r * cc).sum() - np.log(len(RATIOS))

def posterior(u, y, visits=None, phi=(), rhos=RHOS, targets=None):
    n, top_u = len(u), u.max(); low = max(u[u > 0].min(), top_u / 3000); models = []
    for u0 in [top_u / f for f in (1000, 100, 30, 10) if top_u / f >= low / 2] or [top_u / 3]:
        xm = np.log1p(top_u / u0); h = xm / (K - 3); D1 = np.diff(np.eye(K), axis=0); D2 = np.diff(D1, axis=0)
        xg = (np.arange(4 * K) + .5) / (4 * K) * xm; ug = u0 * np.expm1(xg); inv = np.linalg.pinv(splines(xg, xm))
        P = D2.T @ D2 / h**3 + D1.T @ D1 / h / ELL**2; g = inv @ (ug / top_u); P -= np.outer(P @ g, P @ g) / (g @ P @ g)
        Z = np.c_[splines(np.log1p(u / u0), xm), y]; v = visits
        if len(phi):
            Z, v = Z[len(phi):] - sum(f * Z[len(phi) - 1 - j:n - 1 - j] for j, f in enumerate(phi)), visits[len(phi):]
        for own, G, det in grams(Z, v, rhos):
            A, b, yy = G[:K, :K], G[:K, K], G[K, K]; mu = 1e-3 * np.trace(A) / np.trace(P)
            M = A + mu * P + 1e-11 * np.trace(A) / K * np.eye(K); Li = np.linalg.inv(np.linalg.cholesky(M))
            e, Q = np.linalg.eigh(Li @ A @ Li.T); e = np.clip(e, 0, 1); e[1 - e < 1e-7] = 1; V = Li.T @ Q; p = 1 - e; free = np.sum(e == 1)
            ng = 10.0 ** np.linspace(-8, 12, 81); ex = (e / (e + ng[:, None] * p)).sum(1) - free   # degrees of freedom of the deviation
            lo, hi = (np.interp(-d, -ex, np.log10(ng)) for d in (min(10., .5 * ex[0] + 3, .9 * ex[0]), .02))
            nu = 10.0 ** np.linspace(lo, max(hi, lo + 1), NL); a = 1 / (e + nu[:, None] * p); bt = V.T @ b
            ld = .5 * np.log(np.where((e < 1) & (e > 1e-12), np.maximum(nu[:, None] * p * a, 1e-300), 1)).sum(1)
            models.append(dict(own=own, u0=u0, xm=xm, ug=ug, c=inv.T @ (M @ V), V=V, e=e, p=p, a=a, nu=nu, bt=bt, base=ld + det + np.log(np.log(nu[-1] / nu[0])), dof=max(len(Z) - free - 1, 1), yy=yy, mu=mu))
    span = np.ptp(y) ** 2
    def weigh(q, shape, vs, lw):
        g = SHAPES[shape](q['ug'] / vs[:, None]) @ q['c']; e, p, a, nu = q['e'], q['p'], q['a'], q['nu']
        den = (g * g * p * e) @ a.T; lim = (g * g * e * (e < 1)).sum(1)[:, None]; f = nu / np.maximum(den, 1e-300); gb = (g * p * q['bt']) @ a.T
        s2 = np.maximum(q['yy'] - (a * q['bt'] ** 2).sum(1) - f * gb**2, 1e-13 * q['yy']) / q['dof']
        ll = -.5 * q['dof'] * np.log(s2 * q['dof']) + q['base'] - .5 * np.log(np.maximum(nu * den, 1e-300) / lim) - np.log1p(s2 / (nu * q['mu']) / (TAU0**2 * span)) + lw
        return ll, s2, g * p, gb, f
    grid = {s: np.linspace(np.log(max(low / 2, top_u / 1000)), np.log(top_u), NVS) for s in range(len(SHAPES))}
    for it in range(4):
        best = {s: np.full(len(x), -np.inf) for s, x in grid.items()}; tops = []
        for q in models:
            lls = {s: weigh(q, s, np.exp(x), np.log(x[1] - x[0]) + LOG_SHARE[s])[0] for s, x in grid.items()}
            tops.append(max(l.max() for l in lls.values()))
            for s in grid: best[s] = np.maximum(best[s], lls[s].max(1))
        top = max(tops); models = [q for q, t in zip(models, tops) if t > top - 14]; new, done = {}, True
        for s, x in grid.items():
            i = np.nonzero(best[s] > top - 12)[0]
            if len(i):
                a, b = x[max(i[0] - 1, 0)], x[min(i[-1] + 1, len(x) - 1)]; narrow = it == 0 or b - a < .6 * (x[-1] - x[0]); done &= not narrow
                new[s] = np.linspace(a, b, REF) if narrow else x
        if done or it == 3: break
        grid = new
    um = top_u / 30; kn = um * np.expm1(np.linspace(0, np.log1p(top_u / um), KNOTS)); out = []
    for q in models:
        w = splines(np.log1p(kn / q['u0']), q['xm']) @ q['V']; cov = [(w * a) @ w.T for a in q['a']]
        for s, x in grid.items():
            ll, s2, qg, gb, f = weigh(q, s, np.exp(x), np.log(x[1] - x[0]) + LOG_SHARE[s])
            for i, l in zip(*np.nonzero(ll > top - KEEP)):
                k = w @ (q['a'][l] * qg[i]); out.append((ll[i, l], w @ (q['a'][l] * q['bt']) + f[i, l] * gb[i, l] * k, s2[i, l] * (cov[l] + f[i, l] * np.outer(k, k)), s2[i, l], q['own']))
    ll = np.array([o[0] for o in out]); wt = np.exp(ll - ll.max()); wt /= wt.sum(); m = np.array([o[1] for o in out]); mean = wt @ m
    S = sum(w * o[2] for w, o in zip(wt, out)) + ((m - mean).T * wt) @ (m - mean) + FLOOR**2 * span * np.eye(KNOTS)
    return kn, mean, S, float(wt @ [o[3] for o in out]) ** .5, float(wt @ [o[4] for o in out])

def autoregression(e, visits, own):
    """coefficients of AR(p), p by BIC, from residuals, less the mean of their visit if it has an error of its own"""
    e = e - (np.bincount(visits, e) / np.bincount(visits))[visits] if own else e
    n = len(e); pmax = int(min(20, np.median(np.bincount(visits)) / 4, n / 20))
    c = np.array([np.sum((e[k:] * e[:n - k])[visits[k:] == visits[:n - k]]) / n for k in range(max(pmax, 0) + 1)])
    v, phi = c[0], np.zeros(0); best = (n * np.log(v), phi)
    for k in range(1, pmax + 1):
        a = (c[k] - phi @ c[k - 1:0:-1]) / v if k > 1 else c[1] / v; phi = np.r_[phi - a * phi[::-1], a]; v *= 1 - a * a
        if n * np.log(v) + k * np.log(n) < best[0]: best = (n * np.log(v) + k * np.log(n), phi.copy())
    return best[1]

def reduce(u, y, visits=None):
    if visits is not None and (visits.max() < 3 or visits.max() + 1 > .4 * len(u)): visits = visits * 0
    kn, mean, S, sd, own = posterior(u, y, visits)
    if visits is None: return kn, mean, S, sd
    from scipy.interpolate import CubicSpline
    phi = autoregression(y - CubicSpline(np.log1p(kn / kn[1]), mean)(np.log1p(u / kn[1])), visits, own > .5)
    return posterior(u, y, visits, phi, RHOS_AFTER)[:4] if len(phi) > 1 else (kn, mean, S, sd)


def noise(count, remembers):
    """numbers of a linear congruential generator, summed to be nearly normal; with AR coefficients"""
    state, drawn = 1, []
    for _ in range(count):
        total = 0.0
        for _ in range(12):
            state = (1103515245 * state + 12345) % 2**31
            total += state / 2**31
        e = total - 6
        drawn.append(e + sum(f * drawn[-1 - j] for j, f in enumerate(remembers) if j < len(drawn)))
    return np.array(drawn)

def cases():
    law = lambda u: 15 + 12 * np.exp(-u / .03) + 40 * u
    u = .4 * ((np.arange(40) + 1) / 40) ** 2
    yield "table", u, law(u) + .1 * noise(40, []), None
    u = np.repeat(.005 * 64 ** (np.arange(9) / 8), 12); visits = np.repeat(np.arange(9), 12)
    yield "staircase", u, law(u) + .05 * noise(108, [.6]), visits
    u = np.repeat(.005 * 64 ** (np.arange(40) / 39), 8); visits = np.repeat(np.arange(40), 8)
    yield "memory", u, law(u) + .05 * noise(320, [.9]), visits
    z = np.arange(400) / 200; u = .001 + .4 * np.minimum(z, 2 - z)
    yield "ramps", u, law(u) + .05 * noise(400, [.5, .35]), (np.arange(400) > 200).astype(int)
    u = .4 * (np.arange(25) + 1) / 25
    yield "sharp", u, 5 + 3 / (1 + (u / .05) ** 2), None

if __name__ == "__main__":
    for name, u, y, visits in cases():
        kn, mean, S, sd = reduce(u, y, visits)
        for i in (0, 6, 12, 18, 23):
            print(name, i, *(f"{x:.9g}" for x in (kn[i], mean[i], S[i, i] ** .5, S[i, 12], sd)))
