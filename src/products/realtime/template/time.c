/* {MARK}
 *
 * time [COUNT [ROUNDS]]: how long calls take at COUNT random states (1000000 if none is said), in ns by CLOCK_MONOTONIC: median, 99.9 %,
 * longest. Each state is called ROUNDS times (once if none is said), one after the other, of which the shortest counts: where other programs
 * run beside, what interrupts one call does not interrupt all. With COUNT below 1000 nothing is printed: for instruction counters. */
#define _POSIX_C_SOURCE 199309L
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#include "kinetostat_correction.h"

static uint64_t seed = 88172645463325252u;

/* From -1 to 1 (G. Marsaglia, Xorshift RNGs, 2003). */
static double random_number(void)
{
    seed ^= seed << 13;
    seed ^= seed >> 7;
    seed ^= seed << 17;
    return (double)(seed >> 11) / 4503599627370496.0 - 1.0;
}

static double between(double low, double high)
{
    return low + 0.5 * (random_number() + 1.0) * (high - low);
}

static int64_t now(void)
{
    struct timespec time;
    clock_gettime(CLOCK_MONOTONIC, &time);
    return (int64_t)time.tv_sec * 1000000000 + time.tv_nsec;
}

static void keep_shorter(int64_t *kept, int64_t time)
{
    if (time < *kept)
        *kept = time;
}

static int ascending(const void *a, const void *b)
{
    const int64_t x = *(const int64_t *)a, y = *(const int64_t *)b;
    return (x > y) - (x < y);
}

static void report(const char *name, int64_t *times, long count)
{
    qsort(times, (size_t)count, sizeof *times, ascending);
    printf("%s: median %lld ns, 99.9 %% %lld ns, longest %lld ns (%.1f times the median) of %ld calls\n", name,
           (long long)times[count / 2], (long long)times[(count - 1) - count / 1000], (long long)times[count - 1],
           (double)times[count - 1] / (double)times[count / 2], count);
}

int main(int argc, char **argv)
{
    const long count = argc > 1 ? atol(argv[1]) : 1000000;
    int64_t *correct, *whereabouts;
    double drives[KINETOSTAT_DRIVES], position[3], wrench[6];
    long i, round;
    const long rounds = argc > 2 ? atol(argv[2]) : 1;
    int k, status = 0;
    if (count < 1 || rounds < 1)
        return 2;
    correct = calloc((size_t)count, sizeof *correct);
    whereabouts = calloc((size_t)count, sizeof *whereabouts);
    if (!correct || !whereabouts)
        return 2;
    for (i = 0; i < count; i++) {
        int64_t begun;
        position[0] = between(KINETOSTAT_X_MIN_MM, KINETOSTAT_X_MAX_MM);
        position[1] = between(KINETOSTAT_Y_MIN_MM, KINETOSTAT_Y_MAX_MM);
        position[2] = between(KINETOSTAT_Z_MIN_MM, KINETOSTAT_Z_MAX_MM);
        for (k = 0; k < 6; k++)
            wrench[k] = random_number() * (k < 3 ? KINETOSTAT_FORCE_N : KINETOSTAT_MOMENT_NMM);
        correct[i] = whereabouts[i] = INT64_MAX;
        for (round = 0; round < rounds; round++) {
            begun = now();
            status |= kinetostat_correct(position, wrench, drives);
            keep_shorter(&correct[i], now() - begun);
        }
        for (round = 0; round < rounds; round++) {
            begun = now();
            status |= kinetostat_where(drives, wrench, position);
            keep_shorter(&whereabouts[i], now() - begun);
        }
    }
    if (count >= 1000) {
        report("kinetostat_correct", correct, count);
        report("kinetostat_where", whereabouts, count);
    }
    free(correct);
    free(whereabouts);
    return status != 0;
}
