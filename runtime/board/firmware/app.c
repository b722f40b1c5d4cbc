/* SPDX-License-Identifier: Apache-2.0 */
#include "mehvar/private/app.h"

#include <string.h>

#include "mehvar/board.h"
#include "mehvar/private/check.h"

#define AT_LEAST_ONE(n) ((n) > 0 ? (n) : 1)

static const real default_p[AT_LEAST_ONE(MV_BOARD_NP)] = MV_BOARD_DEFAULT_P;
static const real default_c[AT_LEAST_ONE(MV_BOARD_NC)] = MV_BOARD_DEFAULT_C;
static const real default_s[AT_LEAST_ONE(MV_BOARD_NS)] = MV_BOARD_DEFAULT_S;

/* The law reads one half of `memory` and writes the other. */
static real memory[2][AT_LEAST_ONE(MV_BOARD_NZ)];
static uint8_t now;
static real p[AT_LEAST_ONE(MV_BOARD_NP)], c[AT_LEAST_ONE(MV_BOARD_NC)], s[AT_LEAST_ONE(MV_BOARD_NS)];

void mv_app_defaults(void)
{
    memcpy(p, default_p, sizeof p);
    memcpy(c, default_c, sizeof c);
    memcpy(s, default_s, sizeof s);
    memset(memory, 0, sizeof memory);
    now = 0;
}

void mv_app_start(const real in[MV_BOARD_IN]) { mv_board_start(in, in + MV_BOARD_NSEEN, p, c, memory[now]); }

real *mv_app_group(uint32_t group, uint32_t *count)
{
    static const uint16_t sizes[MV_APP_GROUPS] = {MV_BOARD_NZ, MV_BOARD_NP, MV_BOARD_NC, MV_BOARD_NS};
    if (group >= MV_APP_GROUPS) return 0;
    *count = sizes[group];
    real *const groups[MV_APP_GROUPS] = {memory[now], p, c, s};
    return groups[group];
}

int mv_app_finite(const uint8_t *bytes, uint32_t count)
{
    for (uint32_t i = 0; i < count; i++) {
        real value;
        memcpy(&value, bytes + i * sizeof value, sizeof value);
        if (!mv_finite_all(&value, 1)) return 0;
    }
    return 1;
}

int mv_app_settable(uint32_t group, const uint8_t *bytes)
{
    uint32_t count = 0;
    const real *own = mv_app_group(group, &count);
    for (uint32_t i = 0; i < count; i++) {
        real value;
        memcpy(&value, bytes + i * sizeof value, sizeof value);
        if (!mv_board_tunable(group, i) && mv_to_bits(value) != mv_to_bits(own[i])) return 0;
    }
    return 1;
}

/* Check like mv_finite_all, and set subnormal numbers, which cannot be measurements, to zero. */
static int admit(real *v, uint32_t n)
{
    mv_bits above = 0;
    for (uint32_t i = 0; i < n; i++) {
        const mv_bits size = mv_to_bits(v[i]) & ~MV_SIGN_BITS;
        if (size < MV_EXPONENT_UNIT) v[i] = K(0);
        above |= size + MV_EXPONENT_UNIT;
    }
    return !(above & MV_SIGN_BITS);
}

int mv_app_step(real in[MV_BOARD_IN], real u[MV_BOARD_NU])
{
    const int seen = admit(in, MV_BOARD_IN);
    real *next = memory[1 - now];
    mv_board_law(in, in + MV_BOARD_NSEEN, in + MV_BOARD_NSEEN + MV_BOARD_NR, memory[now], p, c, u, next);
    /* a law that tolerates lost measurements keeps its own memory finite */
    const int whole = mv_finite_all(u, MV_BOARD_NU) && (MV_BOARD_LAW_TOLERATES_LOSS || mv_finite_all(next, MV_BOARD_NZ));
    if (whole && (seen || MV_BOARD_LAW_TOLERATES_LOSS)) now = (uint8_t)(1 - now);
    if (seen && whole) return 1;
    memset(u, 0, MV_BOARD_NU * sizeof *u);
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

/* Integrate the plant over one period with held input, by the classical Runge-Kutta method. */
static void advance(real x[MV_BOARD_NX], const real u[MV_BOARD_NU])
{
    const real h = MV_BOARD_PERIOD(p) / K(MV_BOARD_SUBSTEPS);
    static const real at[4] = {K(0), K(0.5), K(0.5), K(1)}, weight[4] = {K(1), K(2), K(2), K(1)};
    real y[MV_BOARD_NX], slope[MV_BOARD_NX], sum[MV_BOARD_NX];
    for (int step = 0; step < MV_BOARD_SUBSTEPS; step++) {
        memset(slope, 0, sizeof slope);
        memset(sum, 0, sizeof sum);
        for (int stage = 0; stage < 4; stage++) {
            for (int i = 0; i < MV_BOARD_NX; i++) y[i] = x[i] + at[stage] * h * slope[i];
            mv_board_rhs(y, u, p, slope);
            for (int i = 0; i < MV_BOARD_NX; i++) sum[i] += weight[stage] * slope[i];
        }
        for (int i = 0; i < MV_BOARD_NX; i++) y[i] = x[i] + h / K(6) * sum[i];
        mv_board_project(y, p, x);
    }
}

void mv_app_selftest(uint32_t samples, mv_app_test *result)
{
    real in[MV_BOARD_IN], applied[MV_BOARD_NU] = {K(0)}, before[MV_BOARD_NU] = {K(0)};
    real *x = result->x, *u = result->u;
    memset(result, 0, sizeof *result);
    result->crc = 0xFFFFFFFFu;
    mv_board_initial(p, s, x);
    for (uint32_t k = 0; k < samples && mv_board_read() < 0; k++) {
        const real t = (real)k * MV_BOARD_PERIOD(p);
        mv_board_measure(x, p, in);
        mv_board_reference(&t, p, s, in + MV_BOARD_NSEEN);
        memcpy(in + MV_BOARD_NSEEN + MV_BOARD_NR, applied, MV_BOARD_NV * sizeof *in);
        const uint32_t begin = mv_board_ticks();
        mv_app_step(in, u);
        const uint32_t ticks = mv_board_ticks() - begin;
        if (ticks > result->ticks) result->ticks = ticks;
        result->crc = crc32(result->crc, u, MV_BOARD_NU);
        mv_board_actuate(x, MV_BOARD_DELAY ? before : u, p, applied);
        memcpy(before, u, sizeof before);
        advance(x, applied);
        mv_board_ms();
        result->samples = k + 1;
    }
    result->crc = ~result->crc;
}
