#include "alternatives.h"

enum { ENTRIES = 1025 };

static const int32_t TABLE[ENTRIES] = {
#include "words.inc"
};

int32_t linear_interp_q31(int32_t s_q31)
{
    /* 12.20: from 0 at -0.5 mm to 1024 at 0.5 mm. */
    const uint32_t x = ((uint32_t)s_q31 + 0x80000000u) >> 2;
    const uint32_t index = x >> 20;
    /* 20 bits of fraction, as Q31. */
    const int32_t fraction = (int32_t)((x & 0xFFFFFu) << 11);
    int32_t y;

    if (index >= (uint32_t)(ENTRIES - 1)) {
        return TABLE[ENTRIES - 1];
    }
    /* Products as 2.30, so the sum is as well. */
    y = (int32_t)(((int64_t)TABLE[index] * (0x7FFFFFFF - fraction)) >> 32);
    y += (int32_t)(((int64_t)TABLE[index + 1u] * fraction) >> 32);
    return y * 2;
}
