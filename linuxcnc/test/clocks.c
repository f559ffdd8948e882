/* Prints how many clocks, as LinuxCNC counts them, go into a microsecond: of the time stamp counter, or nanoseconds on other processors. */
#include <stdio.h>
#include <time.h>

#ifdef __x86_64__
static double nanoseconds(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return 1e9 * now.tv_sec + now.tv_nsec;
}

int main(void)
{
    double start = nanoseconds();
    unsigned long long clocks = __builtin_ia32_rdtsc();
    while (nanoseconds() - start < 2e8) {}
    printf("%.6f\n", 1e3 * (__builtin_ia32_rdtsc() - clocks) / (nanoseconds() - start));
    return 0;
}
#else
int main(void)
{
    puts("1000");
    return 0;
}
#endif
