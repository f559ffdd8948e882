/* SPDX-License-Identifier: MIT OR Apache-2.0
 *
 * Kinematics of the loaded machine with a bounded correction: drives = nominal drives + correction.
 *
 * Within one cycle of the controller `loaded_inverse` depends on the position alone, and `loaded_forward` is its inverse: force, limits and
 * the correction that the drives already have change in `loaded_next_cycle` only. Positions of the tool tip in the base frame O, mm; forces N,
 * moments N·mm about the tool tip, base axes; drives mm, or rad where they turn.
 */
#ifndef KINETOSTAT_LOADED_KINEMATICS_H
#define KINETOSTAT_LOADED_KINEMATICS_H

#include "kinetostat_correction.h"

enum loaded_status {
    LOADED_AS_WANTED = 0,
    LOADED_LIMITED = 1,            /* size or rate takes a part of the correction away */
    LOADED_FORCE_OUT_OF_RANGE = 2, /* the nearest one in range is corrected */
    LOADED_FORCE_NOT_A_NUMBER = 3, /* the last one is kept */
    LOADED_BEYOND_BOX = 4,         /* the correction is that of the nearest place in the box */
    LOADED_NOT_SOLVED = 5,         /* the correction is held, or nothing is commanded */
    LOADED_NOT_RUNNING = 6         /* loaded_next_cycle has not been called */
};

/* What a cycle is told. */
struct loaded_input {
    int on;                         /* 0: the nominal machine */
    double wrench[6];               /* on the tool */
    double size[KINETOSTAT_DRIVES]; /* largest correction of each drive */
    double step[KINETOSTAT_DRIVES]; /* largest change of it in a cycle */
};

/* A correction as wanted and as the limits leave it. */
struct loaded_correction {
    double wanted[KINETOSTAT_DRIVES];
    double applied[KINETOSTAT_DRIVES];
    int limited; /* limits take a part of it away */
    enum loaded_status status;
};

struct loaded_kinematics {
    struct loaded_input input;      /* as it is used: in range and a number */
    double held[KINETOSTAT_DRIVES]; /* correction at the end of the cycle before */
    struct loaded_correction last;  /* of the last call of loaded_inverse in this cycle, if there was one */
    enum loaded_status status;      /* the worst of this cycle's input and the last cycle's correction */
    int is_lost;                    /* the last call of loaded_forward had no answer: loaded_inverse has none until one has */
    double inverse[3][3];           /* of the Jacobian where loaded_forward was last beyond the box, if has_inverse */
    int has_inverse;
    unsigned saturations;           /* cycles in which limits took a part of the correction away */
};

/* A machine without correction, for which no cycle has begun. */
void loaded_start(struct loaded_kinematics *machine);

/* Begins a cycle. What the last call of `loaded_inverse` gave is the correction that the drives have. */
void loaded_next_cycle(struct loaded_kinematics *machine, const struct loaded_input *input);

/* Drives for a position. Beyond the box of the generated functions those of the rigid machine with the correction of the nearest place in the
 * box. 0, or -1 if the machine does not reach there: `drives` is then left as it was. */
int loaded_inverse(struct loaded_kinematics *machine, const double position_mm[3], double drives[KINETOSTAT_DRIVES]);

/* Position for which `loaded_inverse` gives these drives, to 1e-6 mm. `position_mm` holds the last one, near which it is looked for beyond
 * the box. 0, or -1 if there is none: it is then left as it was. */
int loaded_forward(struct loaded_kinematics *machine, const double drives[KINETOSTAT_DRIVES], double position_mm[3]);

#endif
