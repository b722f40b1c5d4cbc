// One run of the component: steps, a parameter that is refused, one that is taken, a reset.
#include <cstdio>

#include "SatelliteMrac.hpp"

using namespace Mehvar;

static void step(SatelliteMrac &component, satellite_mrac_state &twin, float roll)
{
    SatelliteMracMeasured measured = {};
    SatelliteMracReference reference = {};
    SatelliteMracCommand command = {};
    measured[0] = roll;
    component.step(measured, reference, command);
    const mv_real in[SATELLITE_MRAC_NMEASURED] = {roll, 0, 0}, wanted[SATELLITE_MRAC_NREFERENCE] = {0, 0, 0};
    mv_real expected[SATELLITE_MRAC_NCOMMAND];
    satellite_mrac_step(&twin, in, wanted, expected);
    bool same = true;
    for (int i = 0; i < SATELLITE_MRAC_NCOMMAND; i++) same = same && command[i] == expected[i];
    std::printf("%s\n", same ? "same bits" : "other bits");
}

int main()
{
    SatelliteMrac component("law");
    satellite_mrac_state twin;
    satellite_mrac_init(&twin, &satellite_mrac_defaults);
    step(component, twin, 0.02f);
    component.set(component.value_FORGETTING, 3);
    step(component, twin, 0.03f);
    component.set(component.value_FORGETTING, 0.9f);
    static satellite_mrac_parameters other = satellite_mrac_defaults;
    other.law[SATELLITE_MRAC_LAW_FORGETTING] = 0.9f;
    satellite_mrac_seal(&other);
    satellite_mrac_set(&twin, &other);
    step(component, twin, 0.05f);
    component.reset();
    satellite_mrac_init(&twin, &other);
    step(component, twin, 0.02f);
    return 0;
}
