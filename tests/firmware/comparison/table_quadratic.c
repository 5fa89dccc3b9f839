#include "alternatives.h"

enum { SEGMENTS = 64 };

/* c0, c1, c2 in the place inside the segment, 0 ... 1. */
static const float TABLE[SEGMENTS][3] = {
#include "quadratic.inc"
};

float table_quadratic(float s_mm)
{
    const float range = (float)RANGE_MM;
    const float s = (s_mm < -range) ? -range : ((s_mm > range) ? range : s_mm);
    const float position = (s + range) * ((float)SEGMENTS / (2.0f * (float)RANGE_MM));
    const int32_t at = (int32_t)position;
    const int32_t i = (at < SEGMENTS) ? at : (SEGMENTS - 1);
    const float place = position - (float)i;

    return TABLE[i][0] + place * (TABLE[i][1] + place * TABLE[i][2]);
}
