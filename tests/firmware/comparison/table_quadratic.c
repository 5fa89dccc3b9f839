#include "alternatives.h"

#include <math.h>

enum { SEGMENTS = 64 };

/* What the angle is more than SLOPE * s: c0, c1, c2 in the distance from the middle of the segment, in mm. */
static const float TABLE[SEGMENTS][3] = {
#include "quadratic.inc"
};

float table_quadratic(float s_mm)
{
    const float range = (float)RANGE_MM;
    const float s = (s_mm < -range) ? -range : ((s_mm > range) ? range : s_mm);
    const int32_t i = (int32_t)(s * (1.0f / QUADRATIC_SPACING_MM) + (float)(SEGMENTS / 2));
    /* Exact, as the middles are. */
    const float place = s - (float)(2 * i - (SEGMENTS - 1)) * (0.5f * QUADRATIC_SPACING_MM);

    return fmaf(SLOPE, s, TABLE[i][0] + place * (TABLE[i][1] + place * TABLE[i][2]));
}
