/* Joints without a position, without LinuxCNC: nothing is commanded from there until joints have one again. Returns 0 if so. */
#include <stdio.h>

#include "loaded_kinematics.h"

static struct loaded_kinematics machine;

static int says(const char *what, int good)
{
    printf("  %s %s\n", good ? "ok    " : "FAILED", what);
    return good ? 0 : 1;
}

int main(void)
{
    const struct loaded_input input = {.on = 1, .size = {100.0, 100.0, 100.0}, .step = {1e6, 1e6, 1e6}};
    const double home_mm[3] = {0.0, 0.0, 100.0}, nowhere[3] = {-500.0, -500.0, -500.0};
    double joints[3], position_mm[3] = {1.0, 2.0, 3.0}, commanded[3] = {4.0, 5.0, 6.0};
    int failed = 0;
    puts("Joints without a position:");
    loaded_start(&machine);
    loaded_next_cycle(&machine, &input);
    failed |= says("at home there are joints", loaded_inverse(&machine, home_mm, joints) == 0);
    loaded_next_cycle(&machine, &input);
    failed |= says("they have no position", loaded_forward(&machine, nowhere, position_mm) == -1 && position_mm[0] == 1.0 && position_mm[2] == 3.0);
    failed |= says("home, which LinuxCNC takes for it, is not commanded", loaded_inverse(&machine, home_mm, commanded) == -1 && commanded[0] == 4.0);
    loaded_next_cycle(&machine, &input);
    failed |= says("told by the status", machine.status == LOADED_NOT_SOLVED);
    failed |= says("joints that have one end it", loaded_forward(&machine, joints, position_mm) == 0 && loaded_inverse(&machine, home_mm, commanded) == 0);
    failed |= says("at the same joints", commanded[0] == joints[0] && commanded[1] == joints[1] && commanded[2] == joints[2]);
    loaded_next_cycle(&machine, &input);
    return failed | says("and the status is 0", machine.status == LOADED_AS_WANTED);
}
