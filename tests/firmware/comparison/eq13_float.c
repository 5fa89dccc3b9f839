#include "alternatives.h"

#include <math.h>

static const float A[] = {
#include "coefficients_f32.inc"
};

float eq13_float(float s_mm)
{
    const float range = (float)RANGE_MM, d = (float)DISTANCE_MM;
    const float s = (s_mm < -range) ? -range : ((s_mm > range) ? range : s_mm);
    float sum = A[9];

    for (int i = 8; i >= 0; i--) {
        sum = sum * s + A[i];
    }
    return atanf(s / d) - d / (s * s + d * d) * sum;
}
