/* SPDX-License-Identifier: MIT OR Apache-2.0 */
#include "loaded_kinematics.h"

#include "rtapi_math.h"

#define DRIVES KINETOSTAT_DRIVES

/* `loaded_forward` ends when the drives of its position are this near, mm or rad, and gives up above the second one. In the box a pass leaves
   about a hundredth of what the one before left: the share by which a loaded machine differs from the nominal one. */
static const double CONVERGED = 1e-9;
static const double ACCEPTED = 1e-6;
static const int MOST_PASSES = 6;
/* Beyond the box, and the longest step of a coordinate there, mm; differences are taken over the second one. */
static const int MOST_PASSES_BEYOND = 40;
static const double LONGEST_STEP_MM = 40.0;
static const double DIFFERENCE_MM = 1e-3;
/* What a step leaves of the error before another Jacobian is worth its time; how far drives change between near calls, mm or rad; the determinant
   of a singular Jacobian as a share of its size. */
static const double SLOW = 0.1;
static const double NEAR = 1.0;
static const double SINGULAR = 1e-6;

/* What the generated functions return. */
static const int OUTSIDE = 1;
static const int NOTHING = 2;

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

/* The correction at a position, and the nominal drives there. Beyond the box the correction is that of its nearest point. -1: the machine does
   not reach there. */
static int correction_at(const struct loaded_kinematics *machine, const double position_mm[3], double nominal[DRIVES],
                         struct loaded_correction *correction)
{
    const struct loaded_input *input = &machine->input;
    double nearest_mm[3] = {position_mm[0], position_mm[1], position_mm[2]}, at_nearest[DRIVES], loaded[DRIVES];
    int found = kinetostat_nominal(position_mm, nominal), solved = 1;
    if (found == NOTHING) return -1;
    for (int drive = 0; drive < DRIVES; drive++) at_nearest[drive] = nominal[drive];
    if (found == OUTSIDE) {
        into_box(nearest_mm);
        solved = kinetostat_nominal(nearest_mm, at_nearest) != NOTHING;
    }
    if (input->on && solved) solved = kinetostat_correct(nearest_mm, input->wrench, loaded) != NOTHING;
    correction->status = !solved ? LOADED_NOT_SOLVED : found == OUTSIDE ? LOADED_BEYOND_BOX : LOADED_AS_WANTED;
    correction->limited = 0;
    for (int drive = 0; drive < DRIVES; drive++) {
        double held = machine->held[drive], size = input->size[drive], step = input->step[drive];
        double wanted = !solved ? held : input->on ? loaded[drive] - at_nearest[drive] : 0.0;
        double applied = between(between(wanted, -size, size), held - step, held + step);
        if (solved && applied != wanted) correction->limited = 1;
        correction->wanted[drive] = wanted;
        correction->applied[drive] = applied;
    }
    if (correction->limited && correction->status < LOADED_LIMITED) correction->status = LOADED_LIMITED;
    return 0;
}

/* The drives at a position. -1: the machine does not reach there. */
static int drives_at(const struct loaded_kinematics *machine, const double position_mm[3], double drives[DRIVES])
{
    struct loaded_correction correction;
    if (correction_at(machine, position_mm, drives, &correction) != 0) return -1;
    for (int drive = 0; drive < DRIVES; drive++) drives[drive] += correction.applied[drive];
    return 0;
}

static double largest_difference(const double a[DRIVES], const double b[DRIVES])
{
    double largest = 0.0;
    for (int drive = 0; drive < DRIVES; drive++) largest = fmax(largest, fabs(a[drive] - b[drive]));
    return largest;
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
    if (machine->is_lost) machine->status = LOADED_NOT_SOLVED;
    if (machine->last.limited) machine->saturations++;
    for (int drive = 0; drive < DRIVES; drive++) machine->held[drive] = machine->last.applied[drive];
    machine->last.status = LOADED_AS_WANTED;
    machine->last.limited = 0;
}

int loaded_inverse(struct loaded_kinematics *machine, const double position_mm[3], double drives[DRIVES])
{
    struct loaded_correction correction;
    double nominal[DRIVES];
    /* LinuxCNC goes on from its home where it does not know where it is: it is stopped instead. */
    if (machine->is_lost || correction_at(machine, position_mm, nominal, &correction) != 0) return -1;
    for (int drive = 0; drive < DRIVES; drive++) drives[drive] = nominal[drive] + correction.applied[drive];
    machine->last = correction;
    return 0;
}

/* In the box. The loaded machine differs from what `loaded_inverse` computes by about a hundredth: by what limits take away, or by the whole
   correction where it is off. So its way from drives to position serves as the inverse Jacobian of an iteration. Leaves the nearest position
   that it finds. */
static int forward_in_box(const struct loaded_kinematics *machine, const double drives[DRIVES], double place_mm[3])
{
    const double *wrench = machine->input.wrench;
    double wanted_mm[3], here_mm[3], there[DRIVES], error = 0.0;
    if (kinetostat_where(drives, wrench, wanted_mm) == NOTHING) return -1;
    for (int axis = 0; axis < 3; axis++) place_mm[axis] = wanted_mm[axis];
    for (int pass = 0; pass < MOST_PASSES; pass++) {
        into_box(place_mm);
        if (drives_at(machine, place_mm, there) != 0) return -1;
        error = largest_difference(there, drives);
        if (error <= CONVERGED) break;
        if (kinetostat_where(there, wrench, here_mm) == NOTHING) return -1;
        for (int axis = 0; axis < 3; axis++) place_mm[axis] += wanted_mm[axis] - here_mm[axis];
    }
    return error <= ACCEPTED ? 0 : -1;
}

/* Inverse of the Jacobian of drives, by differences from `place_mm`, where they are `there`. -1: it is singular, or not known. */
static int invert_jacobian(struct loaded_kinematics *machine, const double place_mm[3], const double there[DRIVES])
{
    double rows[3][3], cross[3][3], determinant = 0.0, size = 1.0;
    machine->has_inverse = 0;
    for (int axis = 0; axis < 3; axis++) {
        double beside_mm[3] = {place_mm[0], place_mm[1], place_mm[2]}, beside[DRIVES];
        beside_mm[axis] += DIFFERENCE_MM;
        if (drives_at(machine, beside_mm, beside) != 0) return -1;
        for (int drive = 0; drive < DRIVES; drive++) rows[drive][axis] = (beside[drive] - there[drive]) / DIFFERENCE_MM;
    }
    for (int i = 0; i < 3; i++) {
        const double *a = rows[(i + 1) % 3], *b = rows[(i + 2) % 3];
        for (int k = 0; k < 3; k++) cross[i][k] = a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3];
        size *= sqrt(rows[i][0] * rows[i][0] + rows[i][1] * rows[i][1] + rows[i][2] * rows[i][2]);
    }
    for (int k = 0; k < 3; k++) determinant += rows[0][k] * cross[0][k];
    if (!(fabs(determinant) > SINGULAR * size)) return -1;
    for (int i = 0; i < 3; i++)
        for (int k = 0; k < 3; k++) machine->inverse[k][i] = cross[i][k] / determinant;
    machine->has_inverse = 1;
    return 0;
}

/* Beyond the box: steps by the Jacobian of the call before, or of here where that leads on slowly, none longer than LONGEST_STEP_MM, none to
   where the machine does not reach. */
static int forward_beyond(struct loaded_kinematics *machine, const double drives[DRIVES], double place_mm[3])
{
    double there[DRIVES];
    if (drives_at(machine, place_mm, there) != 0) return -1;
    for (int pass = 0; pass < MOST_PASSES_BEYOND; pass++) {
        double step_mm[3], next_mm[3], next[DRIVES], longest = 0.0, share = 1.0, left = largest_difference(there, drives), error = left;
        int is_of_here = !machine->has_inverse;
        if (error <= CONVERGED) return 0;
        if (is_of_here && invert_jacobian(machine, place_mm, there) != 0) return -1;
        for (int axis = 0; axis < 3; axis++) {
            step_mm[axis] = 0.0;
            for (int drive = 0; drive < DRIVES; drive++) step_mm[axis] += machine->inverse[axis][drive] * (drives[drive] - there[drive]);
            longest = fmax(longest, fabs(step_mm[axis]));
        }
        if (longest > LONGEST_STEP_MM) share = LONGEST_STEP_MM / longest;
        for (; share * longest > CONVERGED && !(left < error); share *= 0.5) {
            for (int axis = 0; axis < 3; axis++) next_mm[axis] = place_mm[axis] + share * step_mm[axis];
            if (drives_at(machine, next_mm, next) == 0) left = largest_difference(next, drives);
        }
        if (!(left < error)) {
            if (is_of_here) return error <= ACCEPTED ? 0 : -1;
            machine->has_inverse = 0;
            continue;
        }
        if (left > SLOW * error) machine->has_inverse = 0;
        for (int axis = 0; axis < 3; axis++) place_mm[axis] = next_mm[axis];
        for (int drive = 0; drive < DRIVES; drive++) there[drive] = next[drive];
    }
    return largest_difference(there, drives) <= ACCEPTED ? 0 : -1;
}

static int is_in_box(const double position_mm[3])
{
    double nearest_mm[3] = {position_mm[0], position_mm[1], position_mm[2]};
    into_box(nearest_mm);
    return nearest_mm[0] == position_mm[0] && nearest_mm[1] == position_mm[1] && nearest_mm[2] == position_mm[2];
}

int loaded_forward(struct loaded_kinematics *machine, const double drives[DRIVES], double position_mm[3])
{
    double last[DRIVES], place_mm[3] = {position_mm[0], position_mm[1], position_mm[2]};
    /* A cycle later the machine is near where it was. */
    int is_near = !is_in_box(place_mm) && drives_at(machine, place_mm, last) == 0 && largest_difference(last, drives) < NEAR;
    int found = is_near ? forward_beyond(machine, drives, place_mm) : -1;
    if (found != 0) found = forward_in_box(machine, drives, place_mm);
    if (found != 0) {
        into_box(place_mm);
        machine->has_inverse = 0;
        found = forward_beyond(machine, drives, place_mm);
    }
    machine->is_lost = found != 0;
    if (found != 0) return -1;
    for (int axis = 0; axis < 3; axis++) position_mm[axis] = place_mm[axis];
    return 0;
}
