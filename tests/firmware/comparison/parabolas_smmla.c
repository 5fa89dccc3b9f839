#include "alternatives.h"

static const int32_t TABLE[32][3] = {
#include "parabolas.inc"
};

int32_t parabolas_smmla(int32_t s_q31)
{
    const int32_t below = (s_q31 > 0x3fffffff) ? 0x3fffffff : s_q31;
    const int32_t x = (below < -0x40000000) ? -0x40000000 : below;
    const int32_t *const row = TABLE[((uint32_t)x + 0x40000000u) >> 26];
    int32_t y;

    MUL_ADD_HIGH(y, row[2], x, row[1]);
    MUL_ADD_HIGH(y, y, x, row[0]);
    return y;
}
