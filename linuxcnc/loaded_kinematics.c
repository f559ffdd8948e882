/* SPDX-License-Identifier: MIT OR Apache-2.0 */
#include "loaded_kinematics.h"

#include "rtapi_math.h"

#define DRIVES KINETOSTAT_DRIVES

/* `loaded_forward` ends when the drives of its position are this near, mm or rad, and gives up above the second one. A pass leaves
   about a hundredth of what the one before left: the share by which a loaded machine differs from the nominal one. */
static const double CONVERGED = 1e-9;
static const double ACCEPTED = 1e-6;
static const int MOST_PASSES = 6;

/* What the generated functions return where they write no answer. */
static const int NOT_CONVERGED = 2;

static double between(double value, double low, double high)
{
    return value < low ? low : value > high ? high : value;
}

static void into_box(double position_mm[3])
{
    position_mm[0] = between(position_mm[0], KINETOSTAT_X_MIN_MM, KINETOSTAT_X_MAX_MM);
    position_mm[1] = between(position_mm[1], KINETOSTAT_Y_MIN_MM, KINETOSTAT_Y_MAX_MM);
    position_mm[2] = between(position_mm[2], KINETOSTAT_Z_MIN_MM, KINETOSTAT_Z_MAX_MM);
}

/* Shortens a vector so that no component is larger than `largest`. Whether one was. */
static int shorten(double vector[3], double largest)
{
    double found = fmax(fmax(fabs(vector[0]), fabs(vector[1])), fabs(vector[2]));
    if (found <= largest) return 0;
    for (int axis = 0; axis < 3; axis++) vector[axis] *= largest / found;
    return 1;
}

/* The correction at a position, and the nominal drives there. -1: outside of the box. */
static int correction_at(const struct loaded_kinematics *machine, const double position_mm[3], double nominal[DRIVES],
                         struct loaded_correction *correction)
{
    const struct loaded_input *input = &machine->input;
    double loaded[DRIVES];
    int solved = 1;
    if (kinetostat_nominal(position_mm, nominal) != 0) return -1;
    if (input->on) solved = kinetostat_correct(position_mm, input->wrench, loaded) != NOT_CONVERGED;
    correction->status = solved ? LOADED_AS_WANTED : LOADED_NOT_SOLVED;
    for (int drive = 0; drive < DRIVES; drive++) {
        double held = machine->held[drive], size = input->size[drive], step = input->step[drive];
        double wanted = !solved ? held : input->on ? loaded[drive] - nominal[drive] : 0.0;
        double applied = between(between(wanted, -size, size), held - step, held + step);
        if (solved && applied != wanted) correction->status = LOADED_LIMITED;
        correction->wanted[drive] = wanted;
        correction->applied[drive] = applied;
    }
    return 0;
}

void loaded_start(struct loaded_kinematics *machine)
{
    *machine = (struct loaded_kinematics){.status = LOADED_NOT_RUNNING};
}

void loaded_next_cycle(struct loaded_kinematics *machine, const struct loaded_input *input)
{
    struct loaded_input next = *input;
    int is_number = 1;
    for (int i = 0; i < 6; i++) is_number = is_number && isfinite(input->wrench[i]);
    for (int i = 0; i < 6 && !is_number; i++) next.wrench[i] = machine->input.wrench[i];
    int shortened = shorten(next.wrench, KINETOSTAT_FORCE_N);
    shortened |= shorten(next.wrench + 3, KINETOSTAT_MOMENT_NMM);

    enum loaded_status input_status = !is_number  ? LOADED_FORCE_NOT_A_NUMBER
                                      : shortened ? LOADED_FORCE_OUT_OF_RANGE
                                                  : LOADED_AS_WANTED;

    machine->input = next;
    machine->status = input_status > machine->last.status ? input_status : machine->last.status;
    if (machine->last.status == LOADED_LIMITED) machine->saturations++;
    for (int drive = 0; drive < DRIVES; drive++) machine->held[drive] = machine->last.applied[drive];
    machine->last.status = LOADED_AS_WANTED;
}

int loaded_inverse(struct loaded_kinematics *machine, const double position_mm[3], double drives[DRIVES])
{
    struct loaded_correction correction;
    double nominal[DRIVES];
    if (correction_at(machine, position_mm, nominal, &correction) != 0) return -1;
    for (int drive = 0; drive < DRIVES; drive++) drives[drive] = nominal[drive] + correction.applied[drive];
    machine->last = correction;
    return 0;
}

/* The loaded machine differs from what `loaded_inverse` computes by about a hundredth: by what limits take away, or by the whole
   correction where it is off. So its way from drives to position serves as the inverse Jacobian of an iteration. */
int loaded_forward(const struct loaded_kinematics *machine, const double drives[DRIVES], double position_mm[3])
{
    const double *wrench = machine->input.wrench;
    double wanted_mm[3], here_mm[3], there[DRIVES], place_mm[3];
    struct loaded_correction correction;
    double error = 0.0;
    if (kinetostat_where(drives, wrench, wanted_mm) == NOT_CONVERGED) return -1;
    for (int axis = 0; axis < 3; axis++) place_mm[axis] = wanted_mm[axis];
    for (int pass = 0; pass < MOST_PASSES; pass++) {
        into_box(place_mm);
        if (correction_at(machine, place_mm, there, &correction) != 0) return -1;
        error = 0.0;
        for (int drive = 0; drive < DRIVES; drive++) {
            there[drive] += correction.applied[drive];
            error = fmax(error, fabs(there[drive] - drives[drive]));
        }
        if (error <= CONVERGED) break;
        if (kinetostat_where(there, wrench, here_mm) == NOT_CONVERGED) return -1;
        for (int axis = 0; axis < 3; axis++) place_mm[axis] += wanted_mm[axis] - here_mm[axis];
    }
    if (!(error <= ACCEPTED)) return -1;
    for (int axis = 0; axis < 3; axis++) position_mm[axis] = place_mm[axis];
    return 0;
}
