/* SPDX-License-Identifier: Apache-2.0 */
/* The board of process.h as functions that Python calls. */
#include "process.h"

#include "mehvar/private/app.h"

void power_on(void)
{
    ms = 0;
    sent_size = 0;
    memset(actuators, 0, sizeof actuators);
    mv_server_init();
}

/* Bytes to the board; returns how many come back. */
long exchange(const uint8_t *bytes, long count, uint8_t *to)
{
    sent_size = 0;
    for (long i = 0; i < count; i++) mv_server_byte(bytes[i]);
    memcpy(to, sent, sent_size);
    return (long)sent_size;
}

void elapse(long time) { pass((uint32_t)time); }

void outputs(mv_real *to) { memcpy(to, actuators, sizeof actuators); }

/* Memory or parameters, read past the line; returns how many numbers. */
long group(long which, mv_real *to)
{
    uint32_t count = 0;
    const mv_real *from = mv_app_group((uint32_t)which, &count);
    memcpy(to, from, count * sizeof *to);
    return (long)count;
}
