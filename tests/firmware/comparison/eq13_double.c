#include "alternatives.h"

#include <math.h>

static const double A[] = {
#include "coefficients.inc"
};

double eq13_double(double s_mm)
{
    const double s = (s_mm < -RANGE_MM) ? -RANGE_MM : ((s_mm > RANGE_MM) ? RANGE_MM : s_mm);
    double sum = A[9];

    for (int i = 8; i >= 0; i--) {
        sum = sum * s + A[i];
    }
    return atan(s / DISTANCE_MM) - DISTANCE_MM / (s * s + DISTANCE_MM * DISTANCE_MM) * sum;
}
