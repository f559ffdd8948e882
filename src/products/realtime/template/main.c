/* {MARK}
 *
 * Drives and positions beside those that the program answers (points.h); returns 0 if they agree to 1e-6 mm. */
#include <math.h>
#include <stdio.h>

#include "kinetostat_correction.h"
#include "points.h"

static double distance(const double a[3], const double b[3])
{
    return sqrt((a[0] - b[0]) * (a[0] - b[0]) + (a[1] - b[1]) * (a[1] - b[1]) + (a[2] - b[2]) * (a[2] - b[2]));
}

int main(void)
{
    const int count = (int)(sizeof points / sizeof points[0]);
    double drives[KINETOSTAT_DRIVES], nominal[KINETOSTAT_DRIVES], position[3], largest_drives = 0.0, largest_position = 0.0, largest_nominal = 0.0;
    int i, status = 0;
    for (i = 0; i < count; i++) {
        const struct point *p = &points[i];
        status |= kinetostat_correct(p->position_mm, p->wrench, drives);
        status |= kinetostat_where(p->drives, p->wrench, position);
        status |= kinetostat_nominal(p->position_mm, nominal);
        printf("(%.3f, %.3f, %.3f) mm: drives %.7f, %.7f, %.7f\n", p->position_mm[0], p->position_mm[1], p->position_mm[2],
               drives[0], drives[1], drives[2]);
        largest_drives = fmax(largest_drives, distance(drives, p->drives));
        largest_nominal = fmax(largest_nominal, distance(nominal, p->nominal));
        largest_position = fmax(largest_position, distance(position, p->position_mm));
    }
    printf("%d points, status %d; farthest from what the program answers: drives %.2e, positions %.2e mm, nominal drives %.2e\n", count, status,
           largest_drives, largest_position, largest_nominal);
    {
        /* Outside of the box: the drives of its nearest point. */
        const double outside[3] = {KINETOSTAT_X_MAX_MM + 1.0, KINETOSTAT_Y_MAX_MM, KINETOSTAT_Z_MAX_MM};
        const double corner[3] = {KINETOSTAT_X_MAX_MM, KINETOSTAT_Y_MAX_MM, KINETOSTAT_Z_MAX_MM};
        const double nothing[6] = {0.0, 0.0, 0.0, 0.0, 0.0, 0.0};
        double at_corner[KINETOSTAT_DRIVES];
        if (kinetostat_correct(outside, nothing, drives) != 1 || kinetostat_correct(corner, nothing, at_corner) != 0
            || distance(drives, at_corner) != 0.0)
            return 1;
        /* The rigid machine is led there. */
        if (kinetostat_nominal(outside, drives) != 1 || kinetostat_nominal(corner, at_corner) != 0 || !(distance(drives, at_corner) > 0.0)
            || !(distance(drives, at_corner) < 10.0))
            return 1;
    }
    {
        /* What is no number is not answered, and nothing is written. */
        const double inside[3] = {KINETOSTAT_X_MAX_MM, KINETOSTAT_Y_MAX_MM, KINETOSTAT_Z_MAX_MM};
        const double nothing[6] = {0.0, 0.0, 0.0, 0.0, 0.0, 0.0}, none = NAN;
        for (i = 0; i < 6; i++) {
            double place[3] = {inside[0], inside[1], inside[2]}, wrench[6] = {0.0, 0.0, 0.0, 0.0, 0.0, 0.0}, kept[3] = {1.0, 2.0, 3.0};
            const double as_before[3] = {1.0, 2.0, 3.0};
            wrench[i] = i % 2 ? none : INFINITY;
            place[i % 3] = i < 3 ? none : -INFINITY;
            if (kinetostat_correct(inside, wrench, kept) != 2 || kinetostat_correct(place, nothing, kept) != 2
                || kinetostat_where(inside, wrench, kept) != 2 || kinetostat_where(place, nothing, kept) != 2
                || kinetostat_nominal(place, kept) != 2 || distance(kept, as_before) != 0.0)
                return 1;
        }
    }
    return status != 0 || !(largest_drives <= 1e-6) || !(largest_position <= 1e-6) || !(largest_nominal <= 1e-6);
}
