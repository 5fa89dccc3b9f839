#include "alternatives.h"

enum { ENTRIES = 1024 };

static const float TABLE[ENTRIES] = {
#include "linear.inc"
};

float table_linear(float s_mm)
{
    const float range = (float)RANGE_MM;
    const float s = (s_mm < -range) ? -range : ((s_mm > range) ? range : s_mm);
    const float position = (s + range) * ((float)(ENTRIES - 1) / (2.0f * (float)RANGE_MM));
    const int32_t at = (int32_t)position;
    /* The last entry has no neighbour. */
    const int32_t i = (at < ENTRIES - 1) ? at : (ENTRIES - 2);

    return TABLE[i] + (position - (float)i) * (TABLE[i + 1] - TABLE[i]);
}
