#include "alternatives.h"

#include <math.h>

enum { ENTRIES = 1024, MIDDLE = 511 };

/*
 * What the angle is more than SLOPE * s, at -511 ... 512 times SPACING, each moved by half of what a chord
 * departs from the curve. The nodes, and with them the distance from one, are exact in single precision; the
 * result is rounded once.
 */
static const float TABLE[ENTRIES] = {
#include "linear.inc"
};

float table_linear(float s_mm)
{
    const float range = (float)RANGE_MM;
    const float s = (s_mm < -range) ? -range : ((s_mm > range) ? range : s_mm);
    const int32_t i = (int32_t)(s * (1.0f / LINEAR_SPACING_MM) + (float)MIDDLE);
    const float place = (s - (float)(i - MIDDLE) * LINEAR_SPACING_MM) * (1.0f / LINEAR_SPACING_MM);

    return fmaf(SLOPE, s, TABLE[i] + place * (TABLE[i + 1] - TABLE[i]));
}
