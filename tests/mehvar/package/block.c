/* Blocks of parameters, and inputs that are out of range, as a caller of satellite_mrac meets them. */
#include <math.h>
#include <stdio.h>

#include "satellite_mrac.h"

#define CHECK(claim) (claim) ? (void)0 : (void)(printf("line %d: %s\n", __LINE__, #claim), wrong = 1)

static satellite_mrac_parameters own;
static satellite_mrac_state law;
static int wrong;

static uint32_t step(mv_real roll, mv_real *command)
{
    const mv_real measured[SATELLITE_MRAC_NMEASURED] = {roll, 0.01f, 0.02f};
    const mv_real reference[SATELLITE_MRAC_NREFERENCE] = {0.1f, 0, 0};
    return satellite_mrac_step(&law, measured, reference, command);
}

static int start(uint32_t reaction)
{
    own.reaction = reaction;
    satellite_mrac_seal(&own);
    return satellite_mrac_init(&law, &own);
}

int main(void)
{
    mv_real command[SATELLITE_MRAC_NCOMMAND] = {1, 1, 1}, good[SATELLITE_MRAC_NCOMMAND];

    CHECK(step(0, command) == MV_LAW_SAFE && command[0] == 0); /* a state that was never initialized */

    own = satellite_mrac_defaults;
    satellite_mrac_seal(&own);
    CHECK(own.checksum == satellite_mrac_defaults.checksum);
    CHECK(satellite_mrac_check(&own) == MV_LAW_ACCEPTED);
    own.law[SATELLITE_MRAC_LAW_FORGETTING] = 2;
    CHECK(satellite_mrac_init(&law, &own) == MV_LAW_DAMAGED && law.parameters == 0);
    satellite_mrac_seal(&own);
    const int place = satellite_mrac_check(&own) - 1;
    CHECK(place == SATELLITE_MRAC_NPLANT + SATELLITE_MRAC_LAW_FORGETTING);
    CHECK(satellite_mrac_table[place].name[0] == 'f' && satellite_mrac_table[place].most == 1);
    own.law[SATELLITE_MRAC_LAW_FORGETTING] = NAN;
    satellite_mrac_seal(&own);
    CHECK(satellite_mrac_check(&own) == place + 1);
    own = satellite_mrac_defaults;
    own.layout++;
    CHECK(satellite_mrac_check(&own) == MV_LAW_OTHER_LAYOUT);

    own = satellite_mrac_defaults; /* emitted with --range roll=-0.5:0.5 */
    CHECK(own.least[SATELLITE_MRAC_MEASURED_ROLL] == -0.5f && own.most[SATELLITE_MRAC_MEASURED_ROLL] == 0.5f);
    CHECK(start(3) == MV_LAW_DAMAGED);

    CHECK(start(MV_LAW_REPORT) == MV_LAW_ACCEPTED);
    CHECK(step(0.7f, command) == MV_LAW_RANGE && command[0] != 0);
    CHECK(step(NAN, command) == (MV_LAW_NOT_FINITE | MV_LAW_SAFE) && command[0] == 0 && command[2] == 0);

    start(MV_LAW_SATURATE);
    CHECK(step(0.5f, good) == 0);
    start(MV_LAW_SATURATE);
    CHECK(step(0.7f, command) == MV_LAW_RANGE && command[0] == good[0]);
    CHECK(step(INFINITY, command) == (MV_LAW_NOT_FINITE | MV_LAW_SAFE));

    start(MV_LAW_HOLD);
    CHECK(step(0.7f, command) == (MV_LAW_RANGE | MV_LAW_SAFE) && !law.started); /* nothing to hold yet */
    CHECK(step(0.3f, command) == 0);
    CHECK(step(0.3f, good) == 0);
    start(MV_LAW_HOLD);
    CHECK(step(0.3f, command) == 0);
    CHECK(step(NAN, command) == MV_LAW_NOT_FINITE && command[0] == good[0]);
    const mv_real estimate = satellite_mrac_memory(&law)[SATELLITE_MRAC_MEMORY_B0_ROLL];
    CHECK(satellite_mrac_set(&law, &satellite_mrac_defaults) == MV_LAW_ACCEPTED);
    CHECK(satellite_mrac_memory(&law)[SATELLITE_MRAC_MEMORY_B0_ROLL] == estimate && estimate != 0);
    law.applied[0] = NAN; /* what the actuators are said to have done */
    CHECK(step(0.3f, command) == (MV_LAW_NOT_FINITE | MV_LAW_SAFE) && command[0] == 0);
    return wrong;
}
