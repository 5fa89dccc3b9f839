/*
 * Prints the largest difference of ROUTINE from Eq. 13 over 2^20 + 1 even readings, in arcseconds.
 * FULL_SCALE: millimetres that an integer argument's 2^31 stands for; LSB: radians of one unit of the result.
 */
#include HEADER

#include <math.h>
#include <stdio.h>

#define RANGE_MM 0.38
#define DISTANCE_MM 12.0

static const long double A[] = {
#include "coefficients.inc"
};

static long double eq13(long double s)
{
    const long double d = DISTANCE_MM;
    long double sum = A[9];

    for (int i = 8; i >= 0; i--) {
        sum = sum * s + A[i];
    }
    return atanl(s / d) - d / (s * s + d * d) * sum;
}

int main(void)
{
    const long long steps = 1 << 20;
    long double worst = 0;

    for (long long i = 0; i <= steps; i++) {
        /* Just inside the ends: an argument rounded outward would be limited. */
        const double s = RANGE_MM * (1 - 1e-7) * (2.0 * (double)i / (double)steps - 1.0);
#ifdef FULL_SCALE
        const ARGUMENT argument = (ARGUMENT)llround(s * 2147483648.0 / FULL_SCALE);
        const long double reading = (long double)argument * FULL_SCALE / 2147483648.0L;
#else
        const ARGUMENT argument = (ARGUMENT)s;
        const long double reading = argument;
#endif
        const long double difference = fabsl((long double)ROUTINE(argument) * LSB - eq13(reading));
        worst = (difference > worst) ? difference : worst;
    }
    printf("%.6Le\n", worst * 648000.0L / 3.14159265358979323846L);
    return 0;
}
