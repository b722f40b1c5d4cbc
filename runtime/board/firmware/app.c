/* SPDX-License-Identifier: Apache-2.0 */
#include "app.h"

#include <string.h>

#include "board.h"

/* Added to the bits of a number without its sign: reaches the sign bit if and only if it is infinite or NaN. */
#define EXPONENT_UNIT ((mv_bits)1 << MV_DIGITS)
#define AT_LEAST_ONE(n) ((n) > 0 ? (n) : 1)

static const real default_p[AT_LEAST_ONE(BOARD_NP)] = BOARD_DEFAULT_P;
static const real default_c[AT_LEAST_ONE(BOARD_NC)] = BOARD_DEFAULT_C;
static const real default_s[AT_LEAST_ONE(BOARD_NS)] = BOARD_DEFAULT_S;

/* The law reads one half of `memory` and writes the other. */
static real memory[2][AT_LEAST_ONE(BOARD_NZ)];
static uint8_t now;
static real p[AT_LEAST_ONE(BOARD_NP)], c[AT_LEAST_ONE(BOARD_NC)], s[AT_LEAST_ONE(BOARD_NS)];

void app_defaults(void)
{
    memcpy(p, default_p, sizeof p);
    memcpy(c, default_c, sizeof c);
    memcpy(s, default_s, sizeof s);
    memset(memory, 0, sizeof memory);
    now = 0;
}

void app_start(const real in[BOARD_IN]) { board_start(in, in + BOARD_NX, p, c, memory[now]); }

real *app_group(uint32_t group, uint32_t *count)
{
    static const uint16_t sizes[APP_GROUPS] = {BOARD_NZ, BOARD_NP, BOARD_NC, BOARD_NS};
    if (group >= APP_GROUPS) return 0;
    *count = sizes[group];
    real *const groups[APP_GROUPS] = {memory[now], p, c, s};
    return groups[group];
}

/* Whether all are finite. */
static int finite_all(const real *v, uint32_t n)
{
    mv_bits above = 0;
    for (uint32_t i = 0; i < n; i++) above |= (mv_to_bits(v[i]) & ~MV_SIGN_BITS) + EXPONENT_UNIT;
    return !(above & MV_SIGN_BITS);
}

/* The same; and numbers smaller than any normal one, which are no measurements, become zero. */
static int admit(real *v, uint32_t n)
{
    mv_bits above = 0;
    for (uint32_t i = 0; i < n; i++) {
        const mv_bits size = mv_to_bits(v[i]) & ~MV_SIGN_BITS;
        if (size < EXPONENT_UNIT) v[i] = K(0);
        above |= size + EXPONENT_UNIT;
    }
    return !(above & MV_SIGN_BITS);
}

int app_step(real in[BOARD_IN], real u[BOARD_NU])
{
    const int seen = admit(in, BOARD_IN);
    real *next = memory[1 - now];
    board_law(in, in + BOARD_NX, in + BOARD_NX + BOARD_NR, memory[now], p, c, u, next);
    /* a law that bears the loss of a measurement keeps its memory finite itself */
    const int whole = finite_all(u, BOARD_NU) && (BOARD_LAW_BEARS_LOSS || finite_all(next, BOARD_NZ));
    if (whole && (seen || BOARD_LAW_BEARS_LOSS)) now = (uint8_t)(1 - now);
    if (seen && whole) return 1;
    memset(u, 0, BOARD_NU * sizeof *u);
    return 0;
}

static uint32_t crc32(uint32_t crc, const real *v, uint32_t n)
{
    for (uint32_t i = 0; i < n; i++) {
        crc ^= mv_to_bits(v[i]);
        for (int bit = 0; bit < 32; bit++) crc = (crc >> 1) ^ (crc & 1u ? 0xEDB88320u : 0u);
    }
    return crc;
}

/* One period of the plant by Runge and Kutta's method of order four, the input held. */
static void advance(real x[BOARD_NX], const real u[BOARD_NU])
{
    const real h = BOARD_PERIOD(p) / K(BOARD_SUBSTEPS);
    static const real at[4] = {K(0), K(0.5), K(0.5), K(1)}, weight[4] = {K(1), K(2), K(2), K(1)};
    real y[BOARD_NX], slope[BOARD_NX], sum[BOARD_NX];
    for (int step = 0; step < BOARD_SUBSTEPS; step++) {
        memset(slope, 0, sizeof slope);
        memset(sum, 0, sizeof sum);
        for (int stage = 0; stage < 4; stage++) {
            for (int i = 0; i < BOARD_NX; i++) y[i] = x[i] + at[stage] * h * slope[i];
            board_rhs(y, u, p, slope);
            for (int i = 0; i < BOARD_NX; i++) sum[i] += weight[stage] * slope[i];
        }
        for (int i = 0; i < BOARD_NX; i++) y[i] = x[i] + h / K(6) * sum[i];
        board_project(y, x);
    }
}

void app_selftest(uint32_t samples, app_test *result)
{
    real in[BOARD_IN], applied[BOARD_NU] = {K(0)}, before[BOARD_NU] = {K(0)};
    real *x = result->x, *u = result->u;
    memset(result, 0, sizeof *result);
    result->crc = 0xFFFFFFFFu;
    board_initial(p, s, x);
    for (uint32_t k = 0; k < samples; k++) {
        const real t = (real)k * BOARD_PERIOD(p);
        memcpy(in, x, BOARD_NX * sizeof *in);
        board_reference(&t, p, s, in + BOARD_NX);
        memcpy(in + BOARD_NX + BOARD_NR, applied, BOARD_NV * sizeof *in);
        const uint32_t begin = board_ticks();
        app_step(in, u);
        const uint32_t ticks = board_ticks() - begin;
        if (ticks > result->ticks) result->ticks = ticks;
        result->crc = crc32(result->crc, u, BOARD_NU);
        board_actuate(x, BOARD_DELAY ? before : u, p, applied);
        memcpy(before, u, sizeof before);
        advance(x, applied);
        board_ms();
    }
    result->crc = ~result->crc;
    result->samples = samples;
}
