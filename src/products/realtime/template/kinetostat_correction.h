/* {MARK}
 *
 * Loaded kinematics of {MACHINE}: {TITLE}.
 * {INCLUDED}
 *
 * Positions in mm in the base frame O. Wrenches: forces in N, then moments in N mm about the tool tip, along the axes of the base,
 * as they act on the tool.
 * Arrays may overlap; no pointer may be NULL. Every call in the box makes the same operations; none allocates or has a state: they may be called
 * from any thread.
 */
#ifndef KINETOSTAT_CORRECTION_H
#define KINETOSTAT_CORRECTION_H

#ifdef __cplusplus
extern "C" {
#endif

#define KINETOSTAT_DRIVES 3

/* Newton steps of each call. */
#define KINETOSTAT_STEPS {STEPS}

/* Largest distance, mm, of the tool tip from where it should be with the drives found, and of the position found from where the tool tip
 * stands: twice the largest that was found by searching box and wrenches. Of the computation, not of the model. */
#define KINETOSTAT_CORRECT_ERROR_MM {CORRECT_ERROR}
#define KINETOSTAT_WHERE_ERROR_MM {WHERE_ERROR}
#define KINETOSTAT_NOMINAL_ERROR_MM {NOMINAL_ERROR}

/* Box of the tool tip, mm. */
#define KINETOSTAT_X_MIN_MM {X_MIN}
#define KINETOSTAT_X_MAX_MM {X_MAX}
#define KINETOSTAT_Y_MIN_MM {Y_MIN}
#define KINETOSTAT_Y_MAX_MM {Y_MAX}
#define KINETOSTAT_Z_MIN_MM {Z_MIN}
#define KINETOSTAT_Z_MAX_MM {Z_MAX}

/* Largest size of each component of force, N, and of moment, N mm. */
#define KINETOSTAT_FORCE_N {FORCE}
#define KINETOSTAT_MOMENT_NMM {MOMENT}

/* Of each drive: 1 if it turns (rad), 0 if it slides (mm). */
#define KINETOSTAT_REVOLUTE { {REVOLUTE} }

/* Drive positions, in this order: {DRIVE_NAMES}; at which the loaded machine has its tool tip at position_mm under wrench.
 * 0: done.
 * 1: outside of the box or of the range of wrenches: drives are those of the nearest point of the box and the nearest wrench.
 * 2: a number that is none or infinite, or the last step was larger than it may be: drives are left as they were. */
int kinetostat_correct(const double position_mm[3], const double wrench[6], double drives[KINETOSTAT_DRIVES]);

/* Tool tip at which the loaded machine stands with these drives under wrench.
 * 0: done.
 * 1: the position is outside of the box, or the wrench of its range: position_mm is that with the nearest drives and wrench that are not,
 *    and no error is stated of it.
 * 2: as of kinetostat_correct: position_mm is left as it was. */
int kinetostat_where(const double drives[KINETOSTAT_DRIVES], const double wrench[6], double position_mm[3]);

/* Drive positions at which the rigid machine without errors has its tool tip at position_mm: what a controller without correction commands.
 * 0: done.
 * 1: outside of the box: drives are continued from its nearest point to there, and no error is stated of them.
 * 2: as of kinetostat_correct, or the machine does not reach there: drives are left as they were. */
int kinetostat_nominal(const double position_mm[3], double drives[KINETOSTAT_DRIVES]);

#ifdef __cplusplus
}
#endif

#endif
