/* SPDX-License-Identifier: Apache-2.0 */
/* A sampled loop: the plant in double precision, the law in REAL; one row of memory, state and command per `every`. */
#define NX 10
#define NU 3
#define MOST 128

typedef void (*plant_fn)(const double *, const double *, const double *, double *);
typedef void (*law_fn)(const REAL *, const REAL *, const REAL *, const REAL *, const REAL *, const REAL *, REAL *, REAL *);
typedef void (*start_fn)(const REAL *, const REAL *, const REAL *, const REAL *, REAL *);

static void advance(plant_fn rhs, const double *p, const double *u, double h, double *x)
{
    static const double at[4] = {0, 0.5, 0.5, 1}, weight[4] = {1, 2, 2, 1};
    double k[NX] = {0}, sum[NX] = {0}, y[NX];
    for (int stage = 0; stage < 4; stage++) {
        for (int i = 0; i < NX; i++) y[i] = x[i] + at[stage] * h * k[i];
        rhs(y, u, p, k);
        for (int i = 0; i < NX; i++) sum[i] += weight[stage] * k[i];
    }
    for (int i = 0; i < NX; i++) x[i] += h / 6 * sum[i];
}

void drive(plant_fn rhs, plant_fn reference, plant_fn actuate, law_fn law, start_fn start, const double *p,
           const double *s, const REAL *p_law, const REAL *c, double *x, int nz, long n, long every, int delay,
           double period, const double *noise, long nnoise, double *out)
{
    REAL z[MOST], z_next[MOST], seen[NX], r[NU], v[NU], u[NU];
    double before[NU] = {0}, applied[NU] = {0}, now[NU], wanted[NU];
    for (long k = 0; k < n; k++) {
        double t = k * period;
        reference(&t, p, s, wanted);
        for (int i = 0; i < NX; i++) seen[i] = (REAL)(i < 3 ? x[i] + noise[(3 * k + i) % nnoise] : x[i]);
        for (int i = 0; i < NU; i++) r[i] = (REAL)wanted[i], v[i] = (REAL)applied[i];
        if (k == 0) start(seen, r, p_law, c, z);
        law(seen, r, v, z, p_law, c, u, z_next);
        if (k % every == 0) {
            for (int i = 0; i < nz; i++) *out++ = z[i];
            for (int i = 0; i < NX; i++) *out++ = x[i];
            for (int i = 0; i < NU; i++) *out++ = u[i];
        }
        for (int i = 0; i < nz; i++) z[i] = z_next[i];
        for (int i = 0; i < NU; i++) now[i] = delay ? before[i] : (double)u[i], before[i] = u[i];
        actuate(x, now, p, applied);
        advance(rhs, p, applied, period, x);
    }
}
