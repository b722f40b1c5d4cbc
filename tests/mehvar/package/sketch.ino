/* SPDX-License-Identifier: Apache-2.0 */
/* Prints command and memory of a law at each sample, a word a line, and sleeps for ever. */
#include <name.h>

#include "samples.h"

static name_state law;

static void show(const mv_real *values, int n)
{
    for (int k = 0; k < n; k++) {
        uint32_t bits;
        memcpy(&bits, values + k, sizeof bits);
        for (int digit = 28; digit >= 0; digit -= 4) Serial.print((unsigned)(bits >> digit & 15), HEX);
        Serial.println();
    }
}

void setup()
{
    mv_real command[NAME_NCOMMAND];
    Serial.begin(115200);
    if (name_init(&law, &name_defaults) != MV_LAW_ACCEPTED) Serial.println("refused");
    for (int k = 0; k < SAMPLES; k++) {
        memcpy(law.applied, applied[k], sizeof law.applied);
        name_step(&law, measured[k], reference[k], command);
        show(command, NAME_NCOMMAND);
        show(name_memory(&law), NAME_NMEMORY);
    }
    Serial.flush();
    cli();
    asm volatile("sleep");
}

void loop() {}
